/*
 * covbeam for C++11 and later: owners, exceptions and views over covbeam.h and
 * covbeam_extra.h, which are the manual. Header only.
 * MIT or Apache-2.0.
 *
 * Every call that fails throws covbeam::Error. Nothing is thrown through the library: an exception of a callback stops the
 * call, and comes out of it here. Single calls are members, calls on arrays are in namespace `many`. A `const float*` is a
 * vector of 3 floats unless its name says another number.
 */
#ifndef COVBEAM_HPP
#define COVBEAM_HPP

#include "covbeam_extra.h"

#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace covbeam {

/// A call that ended in another status than COVBEAM_OK; what() names the parameter and the remedy.
class Error : public std::runtime_error {
public:
    Error(covbeam_status status, const std::string& message)
        : std::runtime_error(std::string(covbeam_status_name(status)) + ": " + message), status_(status) {}
    covbeam_status status() const noexcept { return status_; }

private:
    covbeam_status status_;
};

/// COVBEAM_CANCELLED: the host's poll said no.
class Cancelled : public Error {
public:
    explicit Cancelled(const std::string& message) : Error(COVBEAM_CANCELLED, message) {}
};

/// Throws what a call of the C API returned.
inline void check(covbeam_status status) {
    if (status == COVBEAM_OK) return;
    if (status == COVBEAM_CANCELLED) throw Cancelled(covbeam_last_error());
    throw Error(status, covbeam_last_error());
}

/// Throws unless the library that runs is that of this header: for hosts that load it themselves; others have the SONAME.
inline void require_abi() {
    if (covbeam_abi_version() != COVBEAM_ABI_VERSION)
        throw Error(COVBEAM_MISMATCH, "the library's ABI is not that of the header");
}

/// A view of an array: elements of N Ts, `stride` bytes apart. Made from a C array or anything with data() and size(), whose
/// elements are Ts, or structs of N Ts such as the host's own vectors. The default is NULL, for functions that allow it.
template <class T, size_t N = 1>
struct Strided {
    T* data = nullptr;
    size_t stride = 0;
    size_t count = any;

    /// The count of what is as long as the other arrays of the call.
    static constexpr size_t any = static_cast<size_t>(-1);

    Strided() noexcept = default;
    Strided(T* first, size_t elements, size_t bytes = N * sizeof(T)) noexcept
        : data(first), stride(bytes), count(elements) {}
    template <class C> Strided(C& c, decltype(c.data())* = nullptr) noexcept : Strided(from(c.data(), c.size())) {}
    template <class C> Strided(const C& c, decltype(c.data())* = nullptr) noexcept : Strided(from(c.data(),
        c.size())) {}
    template <class U, size_t M> Strided(U (&array)[M]) noexcept : Strided(from(array, M)) {}

    /// One member of a struct, all along an array of them: of(&p[0].direction, p.size(), sizeof p[0]).
    template <class U> static Strided of(U* first, size_t elements, size_t bytes) noexcept {
        Strided view = from(first, elements);
        view.stride = bytes;
        return view;
    }
    /// The same value for all elements of the other arrays. It must outlive the call.
    template <class U> static Strided every(const U& value) noexcept { return of(&value, any, 0); }

private:
    template <class U> static Strided from(U* first, size_t elements) noexcept {
        using Plain = typename std::remove_const<U>::type;
        using Wanted = typename std::remove_const<T>::type;
        static_assert(sizeof(U) == N * sizeof(T) && alignof(U) % alignof(T) == 0, "elements of another size");
        static_assert(N > 1 || std::is_same<Plain, Wanted>::value || std::is_base_of<Wanted, Plain>::value,
                      "elements of another type");
        static_assert(std::is_standard_layout<U>::value, "elements whose layout C does not know");
        static_assert(std::is_const<T>::value || !std::is_const<U>::value, "elements that may not be written");
        return Strided(reinterpret_cast<T*>(first), elements, sizeof(U));
    }
};
template <class T, size_t N> constexpr size_t Strided<T, N>::any;

using Floats = Strided<const float>;
using Vectors = Strided<const float, 3>;
using FloatsOut = Strided<float>;
using VectorsOut = Strided<float, 3>;
using Flags = Strided<uint8_t>;
using Fields = Strided<covbeam_light_field>;
using FieldsIn = Strided<const covbeam_light_field>;
using Spectra = Strided<covbeam_spectrum>;
using SpectraIn = Strided<const covbeam_spectrum>;
using Beams = Strided<const covbeam_beam>;
using Curvatures = Strided<const covbeam_curvature>;
/// x and y of pixels.
using Pixels = Strided<const uint32_t, 2>;
/// Of each pixel one to the right and one down.
using Steps = Strided<const covbeam_pixel_step, 2>;
using ImageSpectra = Strided<covbeam_image_spectrum>;
using ImageSpectraIn = Strided<const covbeam_image_spectrum>;
using ImageFilters = Strided<covbeam_image_filter>;
using ImageFiltersIn = Strided<const covbeam_image_filter>;
using FilmPixels = Strided<covbeam_film_pixel>;
using FilmPixelsIn = Strided<const covbeam_film_pixel>;
using Knots = Strided<covbeam_march_knot>;
using KnotsIn = Strided<const covbeam_march_knot>;
using Samples = Strided<covbeam_march_sample>;
using SamplesIn = Strided<const covbeam_march_sample>;

namespace detail {

/// The length that all arrays of a call have.
inline size_t common(size_t count) noexcept { return count; }
template <class... Rest> size_t common(size_t a, size_t b, Rest... rest) {
    if (a != b && a != Floats::any && b != Floats::any)
        throw Error(COVBEAM_INVALID_ARRAY, "arrays of one call have different lengths");
    return common(a != Floats::any ? a : b, rest...);
}

/// An owner that ends inside a call on its object is refused (COVBEAM_BUSY), and the object leaks.
template <class T, covbeam_status (*Free)(T*)> struct Deleter {
    void operator()(T* handle) const noexcept { Free(handle); }
};
template <class T, covbeam_status (*Free)(T*)> using Owner = std::unique_ptr<T, Deleter<T, Free>>;

/// Host callables as C callbacks: their exceptions are kept until the call is over.
template <class Poll, class Shade> struct Calls {
    Poll& go_on;
    Shade& host_shade;
    std::exception_ptr thrown;

    Calls(Poll& p, Shade& s) noexcept : go_on(p), host_shade(s), thrown() {}
    static int32_t poll(void* user) noexcept {
        Calls& calls = *static_cast<Calls*>(user);
        try {
            return calls.go_on() ? 0 : 1;
        } catch (...) {
            calls.thrown = std::current_exception();
            return 1;
        }
    }
    static int32_t shade(void* user, const covbeam_contact* contacts, size_t count, float* values) noexcept {
        Calls& calls = *static_cast<Calls*>(user);
        try {
            calls.host_shade(contacts, count, values);
            return 0;
        } catch (...) {
            calls.thrown = std::current_exception();
            return 1;
        }
    }
    void check(covbeam_status status) const {
        if (thrown) std::rethrow_exception(thrown);
        covbeam::check(status);
    }
};

/// A host's caster of probe rays as a C callback.
template <class Probe> struct Probing {
    Probe& host;
    std::exception_ptr thrown;

    explicit Probing(Probe& p) noexcept : host(p), thrown() {}
    static int32_t cast(void* user, const float* direction, covbeam_probe_hit* hit) noexcept {
        Probing& probing = *static_cast<Probing*>(user);
        try {
            probing.host(direction, *hit);
            return 0;
        } catch (...) {
            probing.thrown = std::current_exception();
            return 1;
        }
    }
    void check(covbeam_status status) const {
        if (thrown) std::rethrow_exception(thrown);
        covbeam::check(status);
    }
};

} // namespace detail

/// A relative density in voxels. Media refer to it: keep it as long as they are used.
class Density {
public:
    Density(const covbeam_grid_layout& layout, Floats values) {
        covbeam_density* handle = nullptr;
        check(covbeam_density_new(&layout, values.data, values.stride, values.count, &handle));
        handle_.reset(handle);
    }
    const covbeam_density* get() const noexcept { return handle_.get(); }

private:
    detail::Owner<covbeam_density, covbeam_density_free> handle_;
};

struct Phase : covbeam_phase {
    explicit Phase(uint32_t of_kind = COVBEAM_PHASE_ISOTROPIC, float g = 0) noexcept : covbeam_phase() {
        kind = of_kind;
        asymmetry = g;
    }
    static Phase henyey_greenstein(float g) noexcept { return Phase(COVBEAM_PHASE_HENYEY_GREENSTEIN, g); }
    static Phase rayleigh() noexcept { return Phase(COVBEAM_PHASE_RAYLEIGH); }

    float evaluate(float cos_theta) const { float v; check(covbeam_phase_evaluate(this, cos_theta, &v)); return v; }
    void sample(const float* direction, const float* xi, float* scattered) const {
        check(covbeam_phase_sample(this, direction, xi, scattered));
    }
    float sample_cosine(float xi) const { float v; check(covbeam_phase_sample_cosine(this, xi, &v)); return v; }
    float angular_variance() const { float v; check(covbeam_phase_angular_variance(this, &v)); return v; }
};

/// The column along one ray; see covbeam_medium_column.
struct Column : covbeam_column {
    Column() noexcept : covbeam_column() {}
    float at(float distance) const { float v; check(covbeam_column_at(this, distance, &v)); return v; }
    float distance_at(float value) const { float v; check(covbeam_column_distance_at(this, value, &v)); return v; }
};

/// Homogeneous and isotropic unless a with_ function says otherwise.
struct Medium : covbeam_medium {
    Medium() noexcept : covbeam_medium() { struct_size = sizeof(covbeam_medium); }
    static Medium grey(float scattering, float absorption) noexcept {
        const float s[3] = {scattering, scattering, scattering}, a[3] = {absorption, absorption, absorption};
        return rgb(s, a);
    }
    static Medium rgb(const float* scattering, const float* absorption) noexcept {
        Medium m;
        for (int i = 0; i < 3; ++i) m.scattering[i] = scattering[i], m.absorption[i] = absorption[i];
        return m;
    }
    Medium& with_phase(const covbeam_phase& p) noexcept { phase = p; return *this; }
    Medium& with_exponential(const float* where_1, const float* upwards, float height) noexcept {
        density = COVBEAM_DENSITY_EXPONENTIAL;
        for (int i = 0; i < 3; ++i) origin[i] = where_1[i], up[i] = upwards[i];
        scale_height = height;
        return *this;
    }
    Medium& with_voxels(const Density& d) noexcept { density = COVBEAM_DENSITY_VOXELS; voxels = d.get(); return *this; }

    float density_at(const float* position) const {
        float v; check(covbeam_medium_density_at(this, position, &v)); return v;
    }
    covbeam_derivatives derivatives_at(const float* position) const {
        covbeam_derivatives v; check(covbeam_medium_derivatives_at(this, position, &v)); return v;
    }
    float step() const { float v; check(covbeam_medium_step(this, &v)); return v; }
    float column_at(const float* start, const float* direction, float distance) const {
        float v; check(covbeam_medium_column_at(this, start, direction, distance, &v)); return v;
    }
    float distance_at(const float* start, const float* direction, float length, float column) const {
        float v; check(covbeam_medium_distance_at(this, start, direction, length, column, &v)); return v;
    }
    void transmittance(const float* start, const float* direction, float distance, float* rgb) const {
        check(covbeam_medium_transmittance(this, start, direction, distance, rgb));
    }
    void column_transmittance(float column, float* rgb) const {
        check(covbeam_medium_column_transmittance(this, column, rgb));
    }
    float opaque_column() const { float v; check(covbeam_medium_opaque_column(this, &v)); return v; }
    float reach(const float* start, const float* direction) const {
        float v; check(covbeam_medium_reach(this, start, direction, &v)); return v;
    }
    /// Returns the number of knots; with (NULL, 0) it only counts.
    size_t knots(const float* start, const float* direction, float length, float error, float most,
                 covbeam_knot* table, size_t capacity) const {
        size_t n; check(covbeam_medium_knots(this, start, direction, length, error, most, table, capacity,
                                             &n)); return n;
    }
    size_t tabulate(const float* start, const float* direction, float length, covbeam_knot* table,
                    size_t capacity) const {
        size_t n; check(covbeam_medium_tabulate(this, start, direction, length, table, capacity, &n)); return n;
    }
    /// The table stays the caller's and must stay in place.
    Column column(const float* start, const float* direction, const covbeam_knot* table = nullptr, size_t n = 0) const {
        Column c; check(covbeam_medium_column(this, start, direction, table, n, &c)); return c;
    }
};

struct Spectrum : covbeam_spectrum {
    Spectrum() noexcept : covbeam_spectrum() {}
    Spectrum(const covbeam_spectrum& s) noexcept : covbeam_spectrum(s) {}
    float variance_along(const float* axis) const {
        float v; check(covbeam_spectrum_variance_along(this, axis, &v)); return v;
    }
    void add_along(const float* axis, float variance) { check(covbeam_spectrum_add_along(this, axis, variance)); }
};

struct LightField : covbeam_light_field {
    /// None yet: room for a maker in `many`.
    LightField() noexcept : covbeam_light_field() {}
    LightField(const covbeam_light_field& f) noexcept : covbeam_light_field(f) {}

    static LightField point(const float* direction, float angular_variance) {
        LightField f; check(covbeam_light_field_point(direction, angular_variance, &f)); return f;
    }
    static LightField disk(const float* direction, const float* normal, float radius, float angular_variance) {
        LightField f; check(covbeam_light_field_disk(direction, normal, radius, angular_variance, &f)); return f;
    }
    static LightField collimated(const float* direction, float radius) {
        LightField f; check(covbeam_light_field_collimated(direction, radius, &f)); return f;
    }
    /// The variances are two numbers each, along x_axis and across it.
    static LightField gaussian(const float* direction, const float* x_axis, const float* spatial,
                               const float* angular) {
        LightField f; check(covbeam_light_field_gaussian(direction, x_axis, spatial, angular, &f)); return f;
    }
    // Made by `cargo run -p covbeam-tests --bin header`:
    void travel(float distance) {
        check(covbeam_light_field_travel(this, distance));
    }
    void rotate(const float* new_x_axis) {
        check(covbeam_light_field_rotate(this, new_x_axis));
    }
    void reflect(const float* normal, const covbeam_curvature* curvature = nullptr) {
        check(covbeam_light_field_reflect(this, normal, curvature));
    }
    void occlude(const float* towards_edge, float distance) {
        check(covbeam_light_field_occlude(this, towards_edge, distance));
    }
    void attenuate(const float* gradient, const float* hessian) {
        check(covbeam_light_field_attenuate(this, gradient, hessian));
    }
    void narrow(const float* across, float angular_variance) {
        check(covbeam_light_field_narrow(this, across, angular_variance));
    }
    void scatter(const float* new_direction, float angular_variance) {
        check(covbeam_light_field_scatter(this, new_direction, angular_variance));
    }
    void diffuse(const float* normal, const float* new_direction) {
        check(covbeam_light_field_diffuse(this, normal, new_direction));
    }
    // As far as it is made.
    void carry(const covbeam_medium& medium, const float* origin, float distance) {
        check(covbeam_light_field_carry(this, &medium, origin, distance));
    }
    /// False on total reflection, which leaves the field as it was.
    bool refract(const float* normal, const covbeam_curvature* curvature, float eta) {
        uint8_t passed; check(covbeam_light_field_refract(this, normal, curvature, eta, &passed)); return passed != 0;
    }
    /// [xx, xy, yy].
    void slice(float* variances3) const { check(covbeam_light_field_slice(this, variances3)); }
    Spectrum fluence(float limit) const { Spectrum s; check(covbeam_light_field_fluence(this, limit, &s)); return s; }
    float variance_along_ray(float extinction) const {
        float v; check(covbeam_light_field_variance_along_ray(this, extinction, &v)); return v;
    }
};

/// All 0 but for what the host writes.
struct Segment : covbeam_segment {
    Segment() noexcept : covbeam_segment() {}

    /// Fills in the edges. `hit` is where the segment ends, NULL for nowhere; `probe` any callable
    /// (const float* direction, covbeam_probe_hit& hit) that casts a ray from the origin, and leaves hit alone where it meets
    /// nothing.
    template <class Probe> void find_edges(const covbeam_probe_hit* hit, Probe&& probe) {
        detail::Probing<Probe> probing(probe);
        probing.check(covbeam_find_edges(field.direction, hit, probing.cast, &probing, edges, &edge_count));
    }
    LightField field_at(const covbeam_medium& medium, float distance) const {
        LightField f; check(covbeam_segment_field_at(this, &medium, distance, &f)); return f;
    }
};
using Segments = Strided<const covbeam_segment>;

/// The number of one decision of one light path.
inline float path_number(uint32_t seed, uint32_t sequence, uint32_t path, uint32_t dimension) {
    float v; check(covbeam_path_number(seed, sequence, path, dimension, &v)); return v;
}

/// A grid of fluence spectra.
class Grid {
public:
    explicit Grid(const covbeam_grid_layout& layout) {
        covbeam_grid* grid = nullptr; check(covbeam_grid_new(&layout, &grid)); handle_.reset(grid);
    }
    /// In memory of the host's, which must outlive the grid.
    Grid(const covbeam_grid_layout& layout, covbeam_grid_cell* cells, size_t cell_count, covbeam_fluence_cell* means,
         size_t mean_count) {
        covbeam_grid* grid = nullptr;
        check(covbeam_grid_new_in(&layout, cells, cell_count, means, mean_count, &grid));
        handle_.reset(grid);
    }
    static Grid load(const void* bytes, size_t size) {
        Grid grid;
        covbeam_grid* loaded = nullptr;
        check(covbeam_grid_load(bytes, size, &loaded));
        grid.handle_.reset(loaded);
        return grid;
    }
    covbeam_grid* get() noexcept { return handle_.get(); }
    const covbeam_grid* get() const noexcept { return handle_.get(); }

    covbeam_grid_layout layout() const { covbeam_grid_layout l; check(covbeam_grid_get_layout(get(), &l)); return l; }
    void clear() { check(covbeam_grid_clear(get())); }
    void deposit(const covbeam_medium& medium, Segments s) {
        check(covbeam_grid_deposit(get(), &medium, s.count, s.data, s.stride, nullptr, nullptr));
    }
    /// A poll is any callable () -> bool, true to go on.
    template <class Poll> void deposit(const covbeam_medium& medium, Segments s, Poll&& go_on) {
        detail::Calls<Poll, Poll> calls(go_on, go_on);
        calls.check(covbeam_grid_deposit(get(), &medium, s.count, s.data, s.stride, calls.poll, &calls));
    }
    void deposit_spectra(Vectors at, SpectraIn s, Floats weights) {
        const size_t n = detail::common(at.count, s.count, weights.count);
        check(covbeam_grid_deposit_spectra(get(), n, at.data, at.stride, s.data, s.stride, weights.data,
                                           weights.stride));
    }
    void merge(const Grid& other) { const covbeam_grid* one = other.get(); check(covbeam_grid_merge(get(), &one, 1)); }
    void resolve() { check(covbeam_grid_resolve(get())); }
    void look_up(Vectors at, Spectra out, Flags found = Flags()) const {
        const size_t n = detail::common(at.count, out.count, found.count);
        check(covbeam_grid_look_up(get(), n, at.data, at.stride, out.data, out.stride, found.data, found.stride));
    }
    /// Valid until the grid is changed or freed; likewise means().
    Strided<const covbeam_grid_cell> cells() const {
        const covbeam_grid_cell* c; size_t n; check(covbeam_grid_get_cells(get(), &c, &n)); return {c, n};
    }
    Strided<const covbeam_fluence_cell> means() const {
        const covbeam_fluence_cell* c; size_t n; check(covbeam_grid_get_means(get(), &c, &n)); return {c, n};
    }
    std::vector<unsigned char> save() const {
        size_t size; check(covbeam_grid_get_saved_size(get(), &size));
        std::vector<unsigned char> bytes(size);
        check(covbeam_grid_save(get(), bytes.data(), size));
        return bytes;
    }

private:
    Grid() noexcept = default;
    detail::Owner<covbeam_grid, covbeam_grid_free> handle_;
};

/// NULL for no grid.
inline const covbeam_grid* handle(const Grid* grid) noexcept { return grid ? grid->get() : nullptr; }

struct Kernel : covbeam_kernel {
    Kernel(uint32_t of_shape, float radius, float largest, float accepted_error) noexcept : covbeam_kernel() {
        struct_size = sizeof(covbeam_kernel);
        shape = of_shape, min_radius = radius, max_radius = largest, error = accepted_error;
    }
    /// Returns the radius.
    float radius_at(const Grid* grid, const float* position, const float* axis, float* sigma) const {
        float r; check(covbeam_kernel_radius_at(this, handle(grid), position, axis, &r, sigma)); return r;
    }
};

struct Schedule : covbeam_schedule {
    Schedule(uint32_t of_shape, float first_radius, float falloff, float largest,
             float first_error) noexcept : covbeam_schedule() {
        struct_size = sizeof(covbeam_schedule);
        shape = of_shape, radius = first_radius, alpha = falloff, max_radius = largest, error = first_error;
    }
    /// Passes are counted from 1.
    Kernel kernel(uint32_t pass) const {
        Kernel k(shape, 0, 0, 0); check(covbeam_schedule_kernel(this, pass, &k)); return k;
    }
};

/// Memory of a thread's gathers.
class Scratch {
public:
    Scratch() { covbeam_scratch* s = nullptr; check(covbeam_scratch_new(&s)); handle_.reset(s); }
    covbeam_scratch* get() noexcept { return handle_.get(); }

private:
    detail::Owner<covbeam_scratch, covbeam_scratch_free> handle_;
};

/// The beams of one medium and one pass. A poll is any callable () -> bool, true to go on.
class BeamMap {
public:
    using Rays = Strided<const covbeam_eye_ray>;
    using Out = Strided<covbeam_gathered>;

    explicit BeamMap(const covbeam_medium& medium) {
        covbeam_beam_map* map = nullptr; check(covbeam_beam_map_new(&medium, &map)); handle_.reset(map);
    }
    covbeam_beam_map* get() noexcept { return handle_.get(); }
    const covbeam_beam_map* get() const noexcept { return handle_.get(); }

    void clear() { check(covbeam_beam_map_clear(get())); }
    void add(Beams beams) { check(covbeam_beam_map_add(get(), beams.count, beams.data, beams.stride)); }
    void commit(float max_radius) { check(covbeam_beam_map_commit(get(), max_radius, nullptr, nullptr)); }
    template <class Poll> void commit(float max_radius, Poll&& go_on) {
        detail::Calls<Poll, Poll> calls(go_on, go_on);
        calls.check(covbeam_beam_map_commit(get(), max_radius, calls.poll, &calls));
    }
    size_t count() const { size_t n; check(covbeam_beam_map_get_count(get(), &n)); return n; }
    size_t memory() const { size_t n; check(covbeam_beam_map_get_memory(get(), &n)); return n; }

    /// Without a grid every kernel has the progressive radius.
    void gather(const covbeam_kernel& kernel, const Grid* grid, Rays rays, Out out, Scratch& scratch) const {
        check(run(kernel, grid, rays, out, scratch, nullptr, nullptr));
    }
    template <class Poll>
    void gather(const covbeam_kernel& kernel, const Grid* grid, Rays rays, Out out, Scratch& scratch,
                Poll&& go_on) const {
        detail::Calls<Poll, Poll> calls(go_on, go_on);
        calls.check(run(kernel, grid, rays, out, scratch, calls.poll, &calls));
    }
    /// In a medium of the host's: shade is any callable (const covbeam_contact*, size_t count, float* values).
    template <class Shade>
    void gather_shaded(const covbeam_kernel& kernel, const Grid* grid, Rays rays, Out out, Scratch& scratch,
                       Shade&& shade) const {
        detail::Calls<Shade, Shade> calls(shade, shade);
        calls.check(run_shaded(kernel, grid, rays, out, scratch, calls.shade, nullptr, &calls));
    }
    template <class Shade, class Poll>
    void gather_shaded(const covbeam_kernel& kernel, const Grid* grid, Rays rays, Out out, Scratch& scratch,
                       Shade&& shade, Poll&& go_on) const {
        detail::Calls<Poll, Shade> calls(go_on, shade);
        calls.check(run_shaded(kernel, grid, rays, out, scratch, calls.shade, calls.poll, &calls));
    }

private:
    covbeam_status run(const covbeam_kernel& kernel, const Grid* grid, Rays rays, Out out, Scratch& scratch,
                       covbeam_poll poll, void* user) const {
        const size_t n = detail::common(rays.count, out.count);
        return covbeam_beam_map_gather(get(), &kernel, handle(grid), n, rays.data, rays.stride, out.data, out.stride,
                                       scratch.get(), poll, user);
    }
    covbeam_status run_shaded(const covbeam_kernel& kernel, const Grid* grid, Rays rays, Out out, Scratch& scratch,
                              covbeam_shade shade, covbeam_poll poll, void* user) const {
        const size_t n = detail::common(rays.count, out.count);
        return covbeam_beam_map_gather_shaded(get(), &kernel, handle(grid), n, rays.data, rays.stride, out.data,
                                              out.stride, scratch.get(), shade, poll, user);
    }
    detail::Owner<covbeam_beam_map, covbeam_beam_map_free> handle_;
};

/// Blur kernels by themselves; `shape` is a covbeam_kernel_shape.
inline float progressive_radius(float radius, float alpha, uint32_t pass) {
    float v; check(covbeam_progressive_radius(radius, alpha, pass, &v)); return v;
}
inline float error_bound(float error, uint32_t pass) { float v; check(covbeam_error_bound(error, pass, &v)); return v; }
inline float kernel_evaluate(uint32_t shape, float distance, float radius) {
    float v; check(covbeam_kernel_evaluate(shape, distance, radius, &v)); return v;
}
inline float kernel_second_moment(uint32_t shape) { float v; check(covbeam_kernel_second_moment(shape, &v)); return v; }
inline float kernel_radius_from_error(uint32_t shape, float error, float variance) {
    float v; check(covbeam_kernel_radius_from_error(shape, error, variance, &v)); return v;
}

struct ImageFilter : covbeam_image_filter {
    /// Zeros, which is no filter: a pixel keeps to its own rays.
    ImageFilter() noexcept : covbeam_image_filter() {}
    ImageFilter(const covbeam_image_filter& f) noexcept : covbeam_image_filter(f) {}
    float density() const { float v; check(covbeam_image_filter_density(this, &v)); return v; }
};

struct ImageSpectrum : covbeam_image_spectrum {
    ImageSpectrum() noexcept : covbeam_image_spectrum() {}
    ImageSpectrum(const covbeam_image_spectrum& s) noexcept : covbeam_image_spectrum(s) {}
    /// `steps` are two: to the next pixel on the right, and to the one below.
    static ImageSpectrum along(const Grid& grid, const covbeam_medium& medium, const covbeam_eye_ray& ray,
                               const covbeam_pixel_step* steps) {
        ImageSpectrum s; check(covbeam_image_spectrum_along(grid.get(), &medium, &ray, steps, &s)); return s;
    }
    ImageFilter filter(float error, float widest) const {
        ImageFilter f; check(covbeam_image_spectrum_filter(this, error, widest, &f)); return f;
    }
};

/// Whether a pixel of more than this density gets an eye ray.
inline float pixel_threshold(uint32_t pass, uint32_t seed, const uint32_t* pixel) {
    float v; check(covbeam_pixel_threshold(pass, seed, pixel, &v)); return v;
}
inline void film_regions(uint32_t width, uint32_t height, Floats depths, Strided<uint32_t> labels) {
    const size_t n = detail::common(depths.count, labels.count);
    check(covbeam_film_regions(width, height, n, depths.data, depths.stride, labels.data, labels.stride));
}

inline void film_errors(uint32_t width, uint32_t height, FilmPixelsIn pixels, FloatsOut errors) {
    const size_t n = detail::common(pixels.count, errors.count);
    check(covbeam_film_errors(width, height, n, pixels.data, pixels.stride, errors.data, errors.stride));
}

/// Few eye rays for a picture whose light is smooth: plan, density, add for each pass; verify and picture when one is wanted.
class Film {
public:
    /// Without regions the picture is one.
    Film(uint32_t width, uint32_t height, float typical_radiance,
         Strided<const uint32_t> regions = Strided<const uint32_t>()) {
        covbeam_film* f = nullptr;
        const size_t n = regions.data ? regions.count : static_cast<size_t>(width) * height;
        check(covbeam_film_new(width, height, typical_radiance, n, regions.data, regions.stride, &f));
        handle_.reset(f);
    }
    covbeam_film* get() noexcept { return handle_.get(); }
    const covbeam_film* get() const noexcept { return handle_.get(); }

    size_t memory() const { size_t v; check(covbeam_film_get_memory(get(), &v)); return v; }
    size_t node_count() const { size_t v; check(covbeam_film_get_node_count(get(), &v)); return v; }
    void nodes(Strided<uint32_t, 2> pixels) const {
        check(covbeam_film_nodes(get(), pixels.count, pixels.data, pixels.stride));
    }
    void plan(uint32_t pass, float error, uint32_t light_paths, ImageSpectraIn spectra) {
        check(covbeam_film_plan(get(), pass, error, light_paths, spectra.count, spectra.data, spectra.stride, nullptr,
                                nullptr));
    }
    template <class Poll>
    void plan(uint32_t pass, float error, uint32_t light_paths, ImageSpectraIn spectra, Poll&& go_on) {
        detail::Calls<Poll, Poll> calls(go_on, go_on);
        calls.check(covbeam_film_plan(get(), pass, error, light_paths, spectra.count, spectra.data, spectra.stride,
                                      calls.poll, &calls));
    }
    void density(FloatsOut out) const { check(covbeam_film_density(get(), out.count, out.data, out.stride)); }
    void add(Strided<const covbeam_film_ray> rays) {
        check(covbeam_film_add(get(), rays.count, rays.data, rays.stride));
    }
    void verify() { check(covbeam_film_verify(get(), nullptr, nullptr)); }
    template <class Poll> void verify(Poll&& go_on) {
        detail::Calls<Poll, Poll> calls(go_on, go_on);
        calls.check(covbeam_film_verify(get(), calls.poll, &calls));
    }
    /// Whole rows, from a multiple of 8 on.
    void picture(uint32_t first_row, FilmPixels out) const {
        check(covbeam_film_picture(get(), first_row, out.count, out.data, out.stride));
    }

private:
    detail::Owner<covbeam_film, covbeam_film_free> handle_;
};

/// Places shadow rays along eye rays: one a thread.
class March {
public:
    March() { covbeam_march* m = nullptr; check(covbeam_march_new(&m)); handle_.reset(m); }
    covbeam_march* get() noexcept { return handle_.get(); }
    const covbeam_march* get() const noexcept { return handle_.get(); }

    static void lay(const float* origin, const float* direction, float from, float to, const float* light,
                    Knots knots) {
        check(covbeam_march_lay(origin, direction, from, to, light, knots.count, knots.data, knots.stride));
    }
    void update(KnotsIn knots) { check(covbeam_march_update(get(), knots.count, knots.data, knots.stride)); }
    covbeam_march_expected expected() const {
        covbeam_march_expected v; check(covbeam_march_get_expected(get(), &v)); return v;
    }
    size_t first_round(size_t rays) const {
        size_t v; check(covbeam_march_get_first_round(get(), rays, &v)); return v;
    }
    void place(Floats jitters, Samples samples) {
        const size_t n = detail::common(jitters.count, samples.count);
        check(covbeam_march_place(get(), n, jitters.data, jitters.stride, samples.data, samples.stride));
    }
    void refine(SamplesIn firsts, Floats jitters, Samples samples) {
        const size_t n = detail::common(jitters.count, samples.count);
        check(covbeam_march_refine(get(), firsts.count, firsts.data, firsts.stride, n, jitters.data, jitters.stride,
                                   samples.data, samples.stride));
    }

private:
    detail::Owner<covbeam_march, covbeam_march_free> handle_;
};

/// Where the picture needs photons: collected from the camera, resolved, and looked up by what traces the light.
class Importance {
public:
    using Pieces = Strided<const covbeam_eye_ray>;

    explicit Importance(const covbeam_grid_layout& layout) {
        covbeam_importance* i = nullptr; check(covbeam_importance_new(&layout, &i)); handle_.reset(i);
    }
    covbeam_importance* get() noexcept { return handle_.get(); }
    const covbeam_importance* get() const noexcept { return handle_.get(); }

    void add_eye_rays(const covbeam_medium& medium, Pieces rays, Floats weights) {
        const size_t n = detail::common(rays.count, weights.count);
        check(covbeam_importance_add_eye_rays(get(), &medium, n, rays.data, rays.stride, weights.data, weights.stride));
    }
    void add_paths(const covbeam_medium& medium, Pieces paths, Floats weights) {
        const size_t n = detail::common(paths.count, weights.count);
        check(covbeam_importance_add_paths(get(), &medium, n, paths.data, paths.stride, weights.data, weights.stride));
    }
    void add_surfaces(Vectors at, Floats weights) {
        const size_t n = detail::common(at.count, weights.count);
        check(covbeam_importance_add_surfaces(get(), n, at.data, at.stride, weights.data, weights.stride));
    }
    void merge(const Importance& other) {
        const covbeam_importance* one = other.get(); check(covbeam_importance_merge(get(), &one, 1));
    }
    void resolve() { check(covbeam_importance_resolve(get())); }
    void at(Vectors positions, Strided<covbeam_importance_cell> cells) const {
        const size_t n = detail::common(positions.count, cells.count);
        check(covbeam_importance_at(get(), n, positions.data, positions.stride, cells.data, cells.stride));
    }
    void of_segments(const covbeam_medium& medium, Pieces segments, Strided<covbeam_segment_importance> worths) const {
        const size_t n = detail::common(segments.count, worths.count);
        check(covbeam_importance_of_segments(get(), &medium, n, segments.data, segments.stride, worths.data,
                                             worths.stride));
    }

private:
    detail::Owner<covbeam_importance, covbeam_importance_free> handle_;
};

/// Turns how many of each candidate should go on into the factors of their power.
inline void weight_window(FloatsOut factors, float u) {
    check(covbeam_weight_window(factors.count, factors.data, factors.stride, u));
}

/// More of a lamp's paths where they are worth more.
class EmissionGuide {
public:
    /// `weights` are side x side.
    EmissionGuide(uint32_t side, const std::vector<float>& weights, float even)
        : side_(side), numbers_(side * (size_t(side) + 1)) {
        check(covbeam_emission_guide_fill(side, weights.data(), weights.size(), even, numbers_.data(), numbers_.size()));
    }
    /// As covbeam_emission_guide_fill has written them.
    const std::vector<float>& numbers() const noexcept { return numbers_; }

    void warp(Strided<const float, 2> points, Strided<float, 2> places, FloatsOut densities) const {
        const size_t n = detail::common(points.count, places.count, densities.count);
        check(covbeam_emission_guide_warp(side_, numbers_.data(), numbers_.size(), n, points.data, points.stride,
                                          places.data, places.stride, densities.data, densities.stride));
    }

private:
    uint32_t side_;
    std::vector<float> numbers_;
};

/// One pair of eye ray and beam. False if they are nearly parallel: the crossing is then untouched.
inline bool cross(const covbeam_eye_ray& ray, const covbeam_beam& beam, covbeam_crossing& crossing) {
    uint8_t v; check(covbeam_cross(&ray, &beam, &crossing, &v)); return v != 0;
}
/// Adds the part [from, to) of a beam to `sum`, if it counts. Media of voxels need both columns.
inline bool gather_pair(const covbeam_eye_ray& ray, const covbeam_beam& beam, float from, float to,
                        const covbeam_medium& medium, const covbeam_column* ray_column,
                        const covbeam_column* beam_column, const covbeam_kernel& kernel, const Grid* grid,
                        covbeam_gathered& sum) {
    uint8_t v;
    check(covbeam_gather_pair(&ray, &beam, from, to, &medium, ray_column, beam_column, &kernel, handle(grid), &sum, &v));
    return v != 0;
}

/// The calls on arrays, all of one length or `every`.
namespace many {

namespace detail {
using covbeam::detail::common;
template <class F, class A, class B> void each(F f, A a, B b) {
    check(f(common(a.count, b.count), a.data, a.stride, b.data, b.stride));
}
template <class F, class A, class B, class C> void each(F f, A a, B b, C c) {
    check(f(common(a.count, b.count, c.count), a.data, a.stride, b.data, b.stride, c.data, c.stride));
}
template <class F, class A, class B, class C, class D> void each(F f, A a, B b, C c, D d) {
    check(f(common(a.count, b.count, c.count, d.count), a.data, a.stride, b.data, b.stride, c.data, c.stride, d.data,
            d.stride));
}
template <class F, class A, class B, class C, class D, class E> void each(F f, A a, B b, C c, D d, E e) {
    check(f(common(a.count, b.count, c.count, d.count, e.count), a.data, a.stride, b.data, b.stride, c.data, c.stride,
            d.data, d.stride, e.data, e.stride));
}

/// A function whose first parameter is given: the options that all elements share.
template <class F, class S> struct With {
    F f;
    const S* shared;
    template <class... Rest> covbeam_status operator()(Rest... rest) const { return f(shared, rest...); }
};
template <class F, class S> With<F, S> with(F f, const S* shared) { return {f, shared}; }
} // namespace detail

inline void point(Vectors directions, Floats variances, Fields out) {
    detail::each(covbeam_light_fields_point, directions, variances, out);
}
inline void disk(Vectors directions, Vectors normals, Floats radii, Floats variances, Fields out) {
    detail::each(covbeam_light_fields_disk, directions, normals, radii, variances, out);
}
inline void collimated(Vectors directions, Floats radii, Fields out) {
    detail::each(covbeam_light_fields_collimated, directions, radii, out);
}
inline void gaussian(Vectors directions, Vectors x_axes, Strided<const float, 2> spatial,
                     Strided<const float, 2> angular, Fields out) {
    detail::each(covbeam_light_fields_gaussian, directions, x_axes, spatial, angular, out);
}
// Made by `cargo run -p covbeam-tests --bin header`:
inline void travel(Fields fields, Floats distances) {
    detail::each(covbeam_light_fields_travel, fields, distances);
}
inline void rotate(Fields fields, Vectors x_axes) {
    detail::each(covbeam_light_fields_rotate, fields, x_axes);
}
inline void reflect(Fields fields, Vectors normals, Curvatures curvatures = Curvatures()) {
    detail::each(covbeam_light_fields_reflect, fields, normals, curvatures);
}
inline void occlude(Fields fields, Vectors towards_edges, Floats distances) {
    detail::each(covbeam_light_fields_occlude, fields, towards_edges, distances);
}
inline void attenuate(Fields fields, Vectors gradients, Strided<const float, 6> hessians) {
    detail::each(covbeam_light_fields_attenuate, fields, gradients, hessians);
}
inline void narrow(Fields fields, Vectors acrosses, Floats angular_variances) {
    detail::each(covbeam_light_fields_narrow, fields, acrosses, angular_variances);
}
inline void scatter(Fields fields, Vectors directions, Floats angular_variances) {
    detail::each(covbeam_light_fields_scatter, fields, directions, angular_variances);
}
inline void diffuse(Fields fields, Vectors normals, Vectors directions) {
    detail::each(covbeam_light_fields_diffuse, fields, normals, directions);
}
// As far as it is made.
inline void carry(Fields f, const covbeam_medium& medium, Vectors origins, Floats distances) {
    const size_t n = detail::common(f.count, origins.count, distances.count);
    check(covbeam_light_fields_carry(n, f.data, f.stride, &medium, origins.data, origins.stride, distances.data,
                                     distances.stride));
}
inline void field_at(Segments s, const covbeam_medium& medium, Floats distances, Fields out) {
    const size_t n = detail::common(s.count, distances.count, out.count);
    check(covbeam_segments_field_at(n, s.data, s.stride, &medium, distances.data, distances.stride, out.data,
                                    out.stride));
}
inline void path_numbers(uint32_t seed, uint32_t sequence, Strided<const uint32_t> paths, uint32_t dimension,
                         FloatsOut out) {
    const size_t n = detail::common(paths.count, out.count);
    check(covbeam_path_numbers(seed, sequence, n, paths.data, paths.stride, dimension, out.data, out.stride));
}
inline void refract(Fields f, Vectors normals, Curvatures c, Floats etas, Flags passed) {
    detail::each(covbeam_light_fields_refract, f, normals, c, etas, passed);
}
inline void slice(FieldsIn f, VectorsOut variances) { detail::each(covbeam_light_fields_slice, f, variances); }
inline void fluence(FieldsIn f, Floats limits, Spectra out) {
    detail::each(covbeam_light_fields_fluence, f, limits, out);
}
inline void variance_along_ray(FieldsIn f, Floats extinctions, FloatsOut out) {
    detail::each(covbeam_light_fields_variance_along_ray, f, extinctions, out);
}
inline void variance_along(SpectraIn s, Vectors axes, FloatsOut out) {
    detail::each(covbeam_spectra_variance_along, s, axes, out);
}
inline void add_along(Spectra s, Vectors axes, Floats variances) {
    detail::each(covbeam_spectra_add_along, s, axes, variances);
}

inline void along(const Grid& grid, const covbeam_medium& medium, BeamMap::Rays rays, Steps steps,
                  ImageSpectra out) {
    const size_t n = detail::common(rays.count, steps.count, out.count);
    check(covbeam_image_spectra_along(grid.get(), &medium, n, rays.data, rays.stride, steps.data, steps.stride,
                                      out.data, out.stride));
}
inline void filter(ImageSpectraIn s, Floats errors, Floats widests, ImageFilters out) {
    detail::each(covbeam_image_spectra_filter, s, errors, widests, out);
}
inline void density(ImageFiltersIn f, FloatsOut out) { detail::each(covbeam_image_filters_density, f, out); }
inline void pixel_threshold(uint32_t pass, uint32_t seed, Pixels pixels, FloatsOut out) {
    const size_t n = detail::common(pixels.count, out.count);
    check(covbeam_pixel_threshold_many(pass, seed, n, pixels.data, pixels.stride, out.data, out.stride));
}

inline void evaluate(const covbeam_phase& p, Floats cosines, FloatsOut out) {
    detail::each(detail::with(covbeam_phase_evaluate_many, &p), cosines, out);
}
inline void sample(const covbeam_phase& p, Vectors directions, Strided<const float, 2> xis, VectorsOut out) {
    detail::each(detail::with(covbeam_phase_sample_many, &p), directions, xis, out);
}
inline void sample_cosine(const covbeam_phase& p, Floats xis, FloatsOut out) {
    detail::each(detail::with(covbeam_phase_sample_cosine_many, &p), xis, out);
}

inline void density_at(const covbeam_medium& m, Vectors at, FloatsOut out) {
    detail::each(detail::with(covbeam_medium_density_at_many, &m), at, out);
}
inline void derivatives_at(const covbeam_medium& m, Vectors at, Strided<covbeam_derivatives> out) {
    detail::each(detail::with(covbeam_medium_derivatives_at_many, &m), at, out);
}
inline void column_at(const covbeam_medium& m, Vectors origins, Vectors directions, Floats distances, FloatsOut out) {
    detail::each(detail::with(covbeam_medium_column_at_many, &m), origins, directions, distances, out);
}
inline void distance_at(const covbeam_medium& m, Vectors origins, Vectors directions, Floats lengths, Floats columns,
                        FloatsOut out) {
    detail::each(detail::with(covbeam_medium_distance_at_many, &m), origins, directions, lengths, columns, out);
}
inline void transmittance(const covbeam_medium& m, Vectors origins, Vectors directions, Floats distances,
                          VectorsOut out) {
    detail::each(detail::with(covbeam_medium_transmittance_many, &m), origins, directions, distances, out);
}
inline void column_transmittance(const covbeam_medium& m, Floats columns, VectorsOut out) {
    detail::each(detail::with(covbeam_medium_column_transmittance_many, &m), columns, out);
}
inline void reach(const covbeam_medium& m, Vectors origins, Vectors directions, FloatsOut out) {
    detail::each(detail::with(covbeam_medium_reach_many, &m), origins, directions, out);
}
inline void at(const covbeam_column& c, Floats distances, FloatsOut out) {
    detail::each(detail::with(covbeam_column_at_many, &c), distances, out);
}
inline void distance_at(const covbeam_column& c, Floats values, FloatsOut out) {
    detail::each(detail::with(covbeam_column_distance_at_many, &c), values, out);
}
inline void radius_at(const covbeam_kernel& k, const Grid* grid, Vectors at, Vectors axes, FloatsOut radii,
                      FloatsOut sigmas) {
    const size_t n = detail::common(at.count, axes.count, radii.count, sigmas.count);
    check(covbeam_kernel_radius_at_many(&k, handle(grid), n, at.data, at.stride, axes.data, axes.stride, radii.data,
                                        radii.stride, sigmas.data, sigmas.stride));
}

inline void cross(const covbeam_eye_ray& ray, Beams beams, Strided<covbeam_crossing> out, Flags crosses) {
    detail::each(detail::with(covbeam_cross_many, &ray), beams, out, crosses);
}
inline void gather_pairs(const covbeam_eye_ray& ray, Beams beams, Floats from, Floats to, const covbeam_medium& medium,
                         const covbeam_column* ray_column, Strided<const covbeam_column> beam_columns,
                         const covbeam_kernel& kernel, const Grid* grid, covbeam_gathered& sum, Flags accepted) {
    const size_t n = detail::common(beams.count, from.count, to.count, beam_columns.count, accepted.count);
    check(covbeam_gather_pairs(&ray, n, beams.data, beams.stride, from.data, from.stride, to.data, to.stride, &medium,
                               ray_column, beam_columns.data, beam_columns.stride, &kernel, handle(grid), &sum,
                               accepted.data, accepted.stride));
}
inline void filter_beams(const covbeam_eye_ray& ray, Beams beams, float max_radius, Flags out) {
    const size_t n = detail::common(beams.count, out.count);
    check(covbeam_filter_beams(&ray, n, beams.data, beams.stride, max_radius, out.data, out.stride));
}

} // namespace many
} // namespace covbeam

#endif
