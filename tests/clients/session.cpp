// Sessions through covbeam_session.hpp: a tetrahedron of glass in fog, polls that stop and throw, sums that add up.
#include <covbeam_session.hpp>

#include <cstdio>
#include <cstdlib>

static void require(bool holds, const char* what) {
    if (holds) return;
    std::fprintf(stderr, "session.cpp: %s\n", what);
    std::exit(1);
}

int main() {
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
    std::puts("session.cpp: a picture, halves that add up to its bits, polls that stop and throw");
}
