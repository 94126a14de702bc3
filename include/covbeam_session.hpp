/*
 * Sessions for C++11 and later: owners, exceptions and views over covbeam_session.h, which is the manual. Header only.
 * EXPERIMENTAL, as that is. MIT or Apache-2.0.
 *
 * As with covbeam.hpp every call that fails throws covbeam::Error, and what a poll throws stops the call and comes out of it.
 */
#ifndef COVBEAM_SESSION_HPP
#define COVBEAM_SESSION_HPP

#include "covbeam.hpp"
#include "covbeam_session.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <thread>

namespace covbeam {

/// A struct of options, all else of which is 0: `auto settings = options<covbeam_session_settings>();`.
template <class T> T options() noexcept {
    T made{};
    made.struct_size = static_cast<uint32_t>(sizeof made);
    return made;
}

/// A poll that always goes on.
struct Always {
    bool operator()() const noexcept { return true; }
};

namespace detail {
template <class Poll> using Asks = Calls<typename std::remove_reference<Poll>::type, typename std::remove_reference<Poll>::type>;
}  // namespace detail

/// Functions that call a host's methods, one question at a time, through the address that they are given. A host without a method has none: what
/// asks for it is refused by its name. C++ has no other way to ask for names than to write one for each.
namespace detail {
#define COVBEAM_HOST_METHOD(name, Question, Answer)                                                                    \
    template <class Host> auto name##_of(const Host*) noexcept -> decltype(&Host::name, covbeam_host_##name()) {       \
        return [](void* user, size_t count, const Question* questions, Answer* answers) noexcept {                     \
            for (size_t i = 0; i < count; ++i) static_cast<const Host*>(user)->name(questions[i], answers[i]);         \
        };                                                                                                             \
    }                                                                                                                  \
    inline covbeam_host_##name name##_of(const void*) noexcept { return nullptr; }
COVBEAM_HOST_METHOD(cast, covbeam_host_ray, covbeam_host_hit)
COVBEAM_HOST_METHOD(blocked, covbeam_host_ray, uint8_t)
COVBEAM_HOST_METHOD(lobes, covbeam_host_hit, covbeam_material)
COVBEAM_HOST_METHOD(scatter, covbeam_host_meeting, covbeam_host_ways)
COVBEAM_HOST_METHOD(emit, covbeam_host_draw, covbeam_host_photon)
COVBEAM_HOST_METHOD(illuminate, covbeam_host_question, covbeam_host_arrival)
COVBEAM_HOST_METHOD(eye, covbeam_host_pixel, covbeam_host_eye_ray)
#undef COVBEAM_HOST_METHOD
}  // namespace detail

/// A host's object as covbeam asks it, whose box (min, max) is to be filled in. It outlives the scenes and sessions that are made of it.
///
/// Of its methods `cast` must be there, and of the others those that the description asks for: `void cast(const covbeam_host_ray&,
/// covbeam_host_hit&) const`, `void blocked(const covbeam_host_ray&, uint8_t&) const`, `lobes`, `scatter`, `emit`, `illuminate` and `eye` alike,
/// each by the name of its field in covbeam_host, neither overloaded nor a template. What is to be filled holds the answer of a host that knows
/// nothing (of `lobes` the material as described). They are called from many threads at once; what one throws ends the program.
template <class Host> covbeam_host host(const Host& object, uint32_t version = 0) noexcept {
    covbeam_host made = options<covbeam_host>();
    made.version = version;
    made.user = const_cast<Host*>(&object);  // its methods are const
    made.cast = detail::cast_of(&object);
    made.blocked = detail::blocked_of(&object);
    made.lobes = detail::lobes_of(&object);
    made.scatter = detail::scatter_of(&object);
    made.emit = detail::emit_of(&object);
    made.illuminate = detail::illuminate_of(&object);
    made.eye = detail::eye_of(&object);
    return made;
}

/// A vector of the functions below, and of hosts that have none.
struct Vec3 {
    double x, y, z;

    Vec3 operator+(Vec3 b) const noexcept { return {x + b.x, y + b.y, z + b.z}; }
    Vec3 operator-(Vec3 b) const noexcept { return {x - b.x, y - b.y, z - b.z}; }
    Vec3 operator*(Vec3 b) const noexcept { return {x * b.x, y * b.y, z * b.z}; }
    Vec3 operator*(double s) const noexcept { return {s * x, s * y, s * z}; }
    double dot(Vec3 b) const noexcept { return x * b.x + y * b.y + z * b.z; }
    Vec3 cross(Vec3 b) const noexcept { return {y * b.z - z * b.y, z * b.x - x * b.z, x * b.y - y * b.x}; }
    double length() const noexcept { return std::sqrt(dot(*this)); }
    Vec3 unit() const noexcept { return *this * (1 / length()); }
    /// A unit vector at right angles to it.
    Vec3 aside() const noexcept { return cross(std::abs(x) < 0.7 * length() ? Vec3{1, 0, 0} : Vec3{0, 1, 0}).unit(); }
    /// Into three numbers of any kind.
    template <class T> void store(T* out) const noexcept {
        out[0] = static_cast<T>(x), out[1] = static_cast<T>(y), out[2] = static_cast<T>(z);
    }
};
/// The vector of three numbers.
template <class T> Vec3 vec(const T& v) noexcept { return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])}; }

namespace detail {
inline bool fill(const covbeam_host_ray& ray, double distance, Vec3 place, Vec3 normal, covbeam_host_hit& hit) noexcept {
    const double largest = std::max(std::max(std::abs(place.x), std::abs(place.y)), std::abs(place.z));
    hit.distance = static_cast<float>(distance);
    place.store(hit.position), normal.store(hit.geometric_normal), normal.store(hit.normal);
    hit.offset = 4 * std::numeric_limits<float>::epsilon() * static_cast<float>(largest);
    hit.along = hit.across = hit.twist = 0;
    return distance > 0 && distance < ray.reach;  // false for NaN
}
}  // namespace detail

/// Fills a hit where a ray meets the plane of a triangle, whose corners are counter-clockwise from its front: all but the numbers that a host gives it. In doubles,
/// for casters that compute in floats; false: not in (0, reach), such as on a surface that the ray has just left.
inline bool meet_triangle(const covbeam_host_ray& ray, const std::array<Vec3, 3>& corners, covbeam_host_hit& hit) noexcept {
    const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).unit(), origin = vec(ray.origin), direction = vec(ray.direction);
    const double distance = normal.dot(corners[0] - origin) / normal.dot(direction);
    return detail::fill(ray, distance, origin + direction * distance, normal, hit);
}

/// The same on a sphere, next to the distance at which it was found.
inline bool meet_sphere(const covbeam_host_ray& ray, Vec3 center, double radius, double found, covbeam_host_hit& hit) noexcept {
    const Vec3 direction = vec(ray.direction), offset = vec(ray.origin) - center;
    const double length2 = direction.dot(direction), along = offset.dot(direction), away = offset.length();
    const Vec3 aside = offset - direction * (along / length2);
    // No difference of large squares; the larger root, and the other from their product.
    const double larger = -along - std::copysign(std::sqrt(length2 * (radius * radius - aside.dot(aside))), along);
    const double roots[2] = {larger / length2, (away - radius) * (away + radius) / larger};
    const double distance = std::abs(roots[0] - found) < std::abs(roots[1] - found) ? roots[0] : roots[1];
    const Vec3 normal = (offset + direction * distance).unit();
    const bool is_met = detail::fill(ray, distance, center + normal * radius, normal, hit);
    normal.aside().store(hit.tangent);
    hit.along = hit.across = static_cast<float>(1 / radius);
    return is_met;
}

/// Shades a hit on a triangle by unit normals of its corners, at barycentric coordinates, `u` of the second and `v` of the third corner: with the
/// curvature that caustics depend on. Normals that contradict the triangle leave it flat.
inline void smooth(covbeam_host_hit& hit, const std::array<Vec3, 3>& corners, const std::array<Vec3, 3>& normals, double u, double v) noexcept {
    const Vec3 edges[2] = {corners[1] - corners[0], corners[2] - corners[0]};
    const Vec3 turns[2] = {normals[1] - normals[0], normals[2] - normals[0]};
    const Vec3 normal = normals[0] + turns[0] * u + turns[1] * v, unit = normal.unit();
    if (!(normal.dot(vec(hit.geometric_normal)) > 0)) return;
    unit.store(hit.normal);
    // S = [n1 n2] [p1 p2]^-1 in the tangent plane, made symmetric.
    const Vec3 axes[2] = {unit.aside(), unit.cross(unit.aside())};
    double p[2][2], n[2][2];
    for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j) p[i][j] = edges[i].dot(axes[j]), n[i][j] = turns[i].dot(axes[j]);
    const double area = (p[0][0] * p[1][1] - p[1][0] * p[0][1]) * normal.length();
    if (!(std::abs(area) > 0)) return;
    axes[0].store(hit.tangent);
    hit.along = static_cast<float>((n[0][0] * p[1][1] - n[1][0] * p[0][1]) / area);
    hit.across = static_cast<float>((n[1][1] * p[0][0] - n[0][1] * p[1][0]) / area);
    hit.twist = static_cast<float>((n[1][0] * p[0][0] - n[0][0] * p[1][0] + n[0][1] * p[1][1] - n[1][1] * p[0][1]) / (2 * area));
}

/// All that a scene is made of but what is hit, with arrays that grow; `fixed` has the rest: world_volume, fog_alone, camera.
struct Description {
    covbeam_description fixed = options<covbeam_description>();
    std::vector<covbeam_material> materials;
    std::vector<covbeam_object> objects;
    std::vector<covbeam_shape> shapes;
    std::vector<covbeam_volume> volumes;
    std::vector<covbeam_light> lights;

    Description() { fixed.world_volume = -1; }
    /// As the functions of C take it: for as long as nothing is added.
    operator covbeam_description() const noexcept {
        covbeam_description made = fixed;
        made.material_count = static_cast<uint32_t>(materials.size()), made.materials = materials.data();
        made.object_count = objects.size(), made.objects = objects.data();
        made.shape_count = shapes.size(), made.shapes = shapes.data();
        made.volume_count = volumes.size(), made.volumes = volumes.data();
        made.light_count = lights.size(), made.lights = lights.data();
        return made;
    }
};

/// Native threads of the host's own for a session of some settings, as many as they say. Declared before the session it joins them when that is gone.
class Threads {
public:
    explicit Threads(covbeam_session_settings& settings) noexcept {
        settings.spawn_user = this;
        settings.spawn = [](void* user, void (*body)(void*), void* argument) noexcept -> int32_t {
            try {
                static_cast<Threads*>(user)->threads_.emplace_back(body, argument);
                return 0;
            } catch (...) {
                return 1;
            }
        };
    }
    Threads(const Threads&) = delete;
    Threads& operator=(const Threads&) = delete;
    ~Threads() {
        for (std::thread& thread : threads_) thread.join();
    }
    size_t size() const noexcept { return threads_.size(); }

private:
    std::vector<std::thread> threads_;
};

/// Meshes and their instances: first added, then built, then in any number of scenes.
class Geometry {
public:
    Geometry() {
        covbeam_geometry* made = nullptr;
        check(covbeam_geometry_new(&made));
        handle_.reset(made);
    }
    covbeam_geometry* get() noexcept { return handle_.get(); }
    const covbeam_geometry* get() const noexcept { return handle_.get(); }

    /// How many triangles of no area were left out.
    size_t add(const covbeam_mesh& mesh) {
        size_t dropped = 0;
        check(covbeam_geometry_add_mesh(get(), &mesh, &dropped));
        return dropped;
    }
    void add(Strided<const covbeam_instance> instances) {
        check(covbeam_geometry_add_instances(get(), instances.count, instances.data, instances.stride));
    }
    template <class Poll = Always> void build(Poll&& go_on = Poll()) {
        detail::Asks<Poll> calls(go_on, go_on);
        calls.check(covbeam_geometry_build(get(), calls.poll, &calls));
    }
    covbeam_geometry_info info() const {
        covbeam_geometry_info found;
        check(covbeam_geometry_get_info(get(), &found));
        return found;
    }

private:
    detail::Owner<covbeam_geometry, covbeam_geometry_free> handle_;
};

/// What is rendered; it does not change.
class Scene {
public:
    /// Of shapes alone.
    explicit Scene(const covbeam_description& description) : Scene(nullptr, description) {}
    Scene(const Geometry& geometry, const covbeam_description& description) : Scene(geometry.get(), description) {}
    /// Of a host's geometry, which outlives it.
    Scene(const covbeam_host& host, const covbeam_description& description) {
        covbeam_scene* made = nullptr;
        check(covbeam_scene_new_of_host(&host, &description, &made));
        handle_.reset(made);
    }
    const covbeam_scene* get() const noexcept { return handle_.get(); }

private:
    Scene(const covbeam_geometry* geometry, const covbeam_description& description) {
        covbeam_scene* made = nullptr;
        check(covbeam_scene_new(geometry, &description, &made));
        handle_.reset(made);
    }
    detail::Owner<covbeam_scene, covbeam_scene_free> handle_;
};

/// Passes and pictures of a scene.
class Session {
public:
    template <class Poll = Always>
    explicit Session(const Scene& scene, const covbeam_session_settings& settings = options<covbeam_session_settings>(),
                     Poll&& go_on = Poll())
        : Session(std::vector<const covbeam_scene*>(1, scene.get()), settings, std::forward<Poll>(go_on)) {}
    /// At several instants while a shutter is open, a power of two of them.
    template <class Poll = Always>
    explicit Session(const std::vector<const covbeam_scene*>& instants,
                     const covbeam_session_settings& settings = options<covbeam_session_settings>(), Poll&& go_on = Poll()) {
        covbeam_session* made = nullptr;
        detail::Asks<Poll> calls(go_on, go_on);
        calls.check(covbeam_session_new(instants.size(), instants.data(), sizeof(covbeam_scene*), &settings, calls.poll, &calls, &made));
        handle_.reset(made);
    }
    const covbeam_session* get() const noexcept { return handle_.get(); }

    template <class Poll = Always> void pass(Poll&& go_on = Poll()) const {
        detail::Asks<Poll> calls(go_on, go_on);
        calls.check(covbeam_session_pass(get(), calls.poll, &calls));
    }
    template <class Poll = Always> covbeam_end until(const covbeam_goal& goal, Poll&& go_on = Poll()) const {
        detail::Asks<Poll> calls(go_on, go_on);
        uint32_t end = COVBEAM_END_REACHED;
        calls.check(covbeam_session_until(get(), &goal, calls.poll, &calls, &end));
        return static_cast<covbeam_end>(end);
    }
    /// Three floats a pixel, rows from the top; one of COVBEAM_LAYER_ERROR and those after it.
    template <class Poll = Always> std::vector<float> picture(uint32_t layer = COVBEAM_LAYER_ALL, Poll&& go_on = Poll()) const {
        detail::Asks<Poll> calls(go_on, go_on);
        const covbeam_session_info found = info();
        const size_t pixels = static_cast<size_t>(found.width) * found.height;
        std::vector<float> out(layer < COVBEAM_LAYER_ERROR ? 3 * pixels : pixels);
        calls.check(covbeam_session_picture(get(), layer, pixels, out.data(), 0, calls.poll, &calls));
        return out;
    }
    covbeam_session_info info() const {
        covbeam_session_info found;
        check(covbeam_session_get_info(get(), &found));
        return found;
    }
    void restart(uint32_t photons, bool plain = false) const { check(covbeam_session_restart(get(), photons, plain ? 1 : 0)); }

    /// The exact sums of the passes, as bytes.
    std::vector<unsigned char> save() const {
        size_t size = 0;
        check(covbeam_session_save(get(), nullptr, 0, &size));
        std::vector<unsigned char> bytes(size);
        check(covbeam_session_save(get(), bytes.data(), bytes.size(), &size));
        return bytes;
    }
    void merge(const std::vector<unsigned char>& bytes) const {
        check(covbeam_session_merge(get(), bytes.data(), bytes.size(), nullptr, nullptr));
    }

private:
    detail::Owner<covbeam_session, covbeam_session_free> handle_;
};

}  // namespace covbeam

#endif  // COVBEAM_SESSION_HPP
