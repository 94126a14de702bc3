// Sessions through covbeam_session.hpp: a tetrahedron of glass in fog, polls that stop and throw, sums that add up, hosts with geometry and threads
// of their own.
#include <covbeam_session.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

static void require(bool holds, const char* what) {
    if (holds) return;
    std::fprintf(stderr, "session.cpp: %s\n", what);
    std::exit(1);
}

static bool is_near(double a, double b, double within) { return std::abs(a - b) <= within; }

// A ball above a floor whose holes a function cuts: a host of its own.
struct Ball {
    float radius = 0.5f;

    void cast(const covbeam_host_ray& ray, covbeam_host_hit& hit) const {
        covbeam_host_hit other = hit;
        const bool is_floor = covbeam::meet_triangle(ray, {{{-40, -1, -40}, {0, -1, 80}, {40, -1, -40}}}, hit);
        const bool is_ball = meets(ray, other);
        hit.object = hit.material = 0;
        if (is_ball && (!is_floor || other.distance < hit.distance)) {
            hit = other;
            hit.object = hit.material = 1;
        } else if (!is_floor) {
            hit.distance = 0;
        }
    }
    void blocked(const covbeam_host_ray& ray, uint8_t& is_blocked) const {
        covbeam_host_hit hit = covbeam_host_hit();
        cast(ray, hit);
        is_blocked = hit.distance > 0;
    }
    void lobes(const covbeam_host_hit& hit, covbeam_material& there) const { there.diffuse[0] = hit.position[0] < 0 ? 0.2f : 0.6f; }

private:
    bool meets(const covbeam_host_ray& ray, covbeam_host_hit& hit) const {
        return covbeam::meet_sphere(ray, {0, 0, 0}, radius, 0, hit) || covbeam::meet_sphere(ray, {0, 0, 0}, radius, 1e9, hit);
    }
};

// Hits that are filled in doubles: on the surface, not where the ray has just left it, and curved as they should be.
static void hits() {
    const covbeam_host_ray down = { { 0.25, 3, 0.25 }, { 0, -1, 0 }, 10 };
    covbeam_host_hit hit = covbeam_host_hit();
    require(covbeam::meet_triangle(down, {{{0, 1, 0}, {0, 1, 1}, {1, 1, 0}}}, hit), "a triangle is missed");
    require(is_near(hit.distance, 2, 0) && is_near(hit.position[1], 1, 0) && is_near(hit.normal[1], 1, 0), "a triangle's hit");
    require(is_near(hit.offset, 4 * 1.2e-7, 1e-8) && is_near(hit.along, 0, 0), "a triangle's offset and curvature");
    covbeam_host_ray leaving = down;
    leaving.origin[1] = 1 - 1e-9;
    require(!covbeam::meet_triangle(leaving, {{{0, 1, 0}, {0, 1, 1}, {1, 1, 0}}}, hit), "a surface that was left is met");
    leaving.reach = 1.9, leaving.origin[1] = 3;
    require(!covbeam::meet_triangle(leaving, {{{0, 1, 0}, {0, 1, 1}, {1, 1, 0}}}, hit), "what is out of reach is met");
    const covbeam_host_ray along = { { 0, 0, 0 }, { 1, 0, 0 }, 10 };
    require(!covbeam::meet_triangle(along, {{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}}}, hit), "a plane is met by a ray in it");

    // Far from the middle, where single precision would be off by 1e-3: entered, and left.
    const double away = 1000, radius = 0.5;
    covbeam_host_ray ray = { { away - 3, 0.3, 0 }, { 1, 0, 0 }, 1e30 };
    require(covbeam::meet_sphere(ray, {away, 0, 0}, radius, 2.59, hit), "a sphere is missed");
    require(is_near(hit.distance, 2.6, 1e-6) && is_near(hit.normal[0], -0.8, 1e-6) && is_near(hit.normal[1], 0.6, 1e-6), "a sphere's hit");
    require(is_near(hit.along, 2, 0) && is_near(hit.across, 2, 0) && is_near(hit.twist, 0, 0), "a sphere's curvature");
    require(covbeam::meet_sphere(ray, {away, 0, 0}, radius, 3.41, hit) && is_near(hit.distance, 3.4, 1e-6), "where a sphere is left");
    ray.origin[1] = 0.6;
    require(!covbeam::meet_sphere(ray, {away, 0, 0}, radius, 3, hit), "a sphere is met beside it");

    // A sphere's triangle with a sphere's normals is as curved, whichever way round its corners are.
    const std::array<covbeam::Vec3, 3> corners = {{{2, 0.02, 0.01}, {2, -0.01, 0.02}, {2, 0, -0.03}}};
    std::array<covbeam::Vec3, 3> normals = {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}};
    for (size_t i = 0; i < 3; ++i) normals[i] = corners[i].unit();
    const covbeam_host_ray inwards = { { 5, 0, 0 }, { -1, 0, 0 }, 10 };
    require(covbeam::meet_triangle(inwards, corners, hit), "a triangle of a sphere is missed");
    covbeam::smooth(hit, corners, normals, 1.0 / 3, 1.0 / 3);
    require(is_near(hit.along, 0.5, 1e-3) && is_near(hit.across, 0.5, 1e-3) && is_near(hit.twist, 0, 1e-3), "curvature between normals");
    const covbeam_host_hit before = hit;
    for (covbeam::Vec3& normal : normals) normal = normal * -1;
    covbeam::smooth(hit, corners, normals, 0.2, 0.3);
    require(is_near(hit.normal[0], before.normal[0], 0), "normals that contradict a triangle count");
}

// A host's own geometry, textures and threads.
static void own_geometry() {
    const Ball ball{};
    covbeam_host functions = covbeam::host(ball, 7);
    require(functions.version == 7 && functions.cast && functions.blocked && functions.lobes, "a method is not there");
    require(!functions.scatter && !functions.emit && !functions.illuminate && !functions.eye, "a method is there that is not");
    covbeam::Vec3{-40, -1, -40}.store(functions.min), covbeam::Vec3{40, 0.5, 80}.store(functions.max);

    covbeam::Description description;
    covbeam_material matt{}, glass{};
    covbeam_volume fog{};
    covbeam_light lamp{};
    for (int i = 0; i < 3; i++) matt.diffuse[i] = 0.6f, glass.glass_reflection[i] = glass.glass_transmission[i] = 1, fog.scattering[i] = 0.1, lamp.intensity[i] = 10;
    matt.asks = COVBEAM_ASKS_LOBES;
    lamp.position[1] = 3;
    description.materials = {matt, glass};
    description.objects = {{-1, 0, 0, 0, 0}, {-1, 1, 0, 0, 0}};
    description.volumes = {fog}, description.fixed.world_volume = 0;
    description.lights = {lamp};
    covbeam_camera& camera = description.fixed.camera;
    camera.position[2] = -4, camera.forward[2] = camera.up[1] = 1;
    camera.half_height = 0.5, camera.width = camera.height = 16;

    covbeam_session_settings settings = covbeam::options<covbeam_session_settings>();
    settings.photons = 500, settings.threads = 3;
    const covbeam::Session library(covbeam::Scene(functions, description), settings);
    const covbeam::Threads threads(settings);
    const covbeam::Session own(covbeam::Scene(functions, description), settings);
    require(threads.size() == 3, "three threads");
    library.pass(), own.pass();
    const std::vector<float> picture = own.picture();
    require(picture == library.picture(), "the host's threads give other bits");
    // The floor is darker at the left in red, as the function has it; the camera's left is where x is above 0.
    const auto red = [&](size_t x) { return picture[3 * (16 * 14 + x)]; };
    require(red(14) > 0 && red(2) > 1.2f * red(14), "textures do not show");

    description.lights[0].is_own = 1;
    bool caught = false;
    try {
        covbeam::Scene(functions, description);
    } catch (const covbeam::Error& error) {
        caught = std::string(error.what()).find("host.emit") != std::string::npos;
    }
    require(caught, "a method that is asked for and not there is not named");
}

int main() {
    hits();
    own_geometry();
    const float positions[4][3] = { { -1, 0, -1 }, { 1, 0, -1 }, { 0, 0, 1 }, { 0, 1.5f, 0 } };
    const int32_t triangles[4][3] = { { 0, 1, 2 }, { 0, 3, 1 }, { 1, 3, 2 }, { 2, 3, 0 } };
    const int32_t material = 0;
    covbeam_mesh mesh = covbeam::options<covbeam_mesh>();
    mesh.position_count = 4, mesh.positions = positions[0];
    mesh.triangle_count = 4, mesh.triangles = triangles[0];
    mesh.material_count = 1, mesh.materials = &material;
    covbeam_instance instance{};
    instance.matrix[0] = instance.matrix[5] = instance.matrix[10] = instance.matrix[15] = 1;
    instance.material = -1;
    covbeam::Geometry geometry;
    require(geometry.add(mesh) == 0, "a triangle was left out");
    geometry.add({ &instance, 1 });
    geometry.build();
    require(geometry.info().triangle_count == 4, "four triangles");

    covbeam_material glass{};
    for (int i = 0; i < 3; i++) glass.glass_reflection[i] = glass.glass_transmission[i] = 1;
    covbeam_object object{};
    object.volume = -1, object.is_closed = 1;
    covbeam_volume fog{};
    covbeam_light lamp{};
    for (int i = 0; i < 3; i++) fog.scattering[i] = 0.2, lamp.intensity[i] = 10;
    lamp.position[1] = 3;
    covbeam_description description = covbeam::options<covbeam_description>();
    description.material_count = 1, description.materials = &glass;
    description.object_count = 1, description.objects = &object;
    description.volume_count = 1, description.volumes = &fog;
    description.light_count = 1, description.lights = &lamp;
    description.camera.position[1] = 0.5, description.camera.position[2] = -4;
    description.camera.forward[2] = description.camera.up[1] = 1;
    description.camera.half_height = 0.4, description.camera.width = 24, description.camera.height = 16;
    const covbeam::Scene scene(geometry, description);

    covbeam_session_settings settings = covbeam::options<covbeam_session_settings>();
    settings.photons = 500;
    const covbeam::Session whole(scene, settings);
    covbeam_goal goal = covbeam::options<covbeam_goal>();
    goal.passes = 4;
    require(whole.until(goal) == COVBEAM_END_REACHED, "the goal was not reached");
    const std::vector<float> picture = whole.picture();
    require(picture.size() == 24 * 16 * 3, "the size of the picture");
    for (float value : picture) require(value > 0 && value < 1e6f, "a pixel is dark, or no number");

    // Two machines, each with half of the passes.
    const covbeam::Session first(scene, settings);
    settings.first_pass = 2;
    const covbeam::Session second(scene, settings);
    first.pass(), first.pass(), second.pass(), second.pass();
    first.merge(second.save());
    require(first.picture() == picture, "halves do not add up to the same bits");

    bool caught = false;
    try {
        first.merge(second.save());
    } catch (const covbeam::Error& error) {
        caught = error.status() == COVBEAM_BAD_DATA;
    }
    require(caught, "passes that are there were taken twice");
    // A poll is asked a few times a second: of many passes one is stopped.
    goal.passes = 1000000;
    caught = false;
    try {
        first.until(goal, [] { return false; });
    } catch (const covbeam::Cancelled&) {
        caught = true;
    }
    require(caught && first.info().passes >= 4, "a poll that says no");
    caught = false;
    try {
        first.until(goal, []() -> bool { throw 7; });
    } catch (int seven) {
        caught = seven == 7;
    }
    require(caught, "what a poll throws comes out of the call");
    std::puts("session.cpp: a picture, halves that add up to its bits, polls that stop and throw, a host's own geometry and threads");
}
