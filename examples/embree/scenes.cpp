// Four scenes: those of examples/scenes that have the same names, and one with textures.

#include "scene.hpp"

static Vec3 grey(double value) { return {value, value, value}; }

static covbeam_material material(Vec3 diffuse, Vec3 metal = {0, 0, 0}, Vec3 glass = {0, 0, 0}) {
    covbeam_material made{};
    diffuse.store(made.diffuse), metal.store(made.metal), metal.store(made.edge);
    glass.store(made.glass_reflection), glass.store(made.glass_transmission), made.ior = 1.5f;
    return made;
}
static void add(World& world, const Solid& solid, covbeam_material material) {
    material.asks = solid.texture.pixels.empty() ? COVBEAM_ASKS_NOTHING : COVBEAM_ASKS_LOBES;
    if (!solid.mask.pixels.empty()) grey(1).store(material.transparent); // the most that there is
    world.solids.push_back(solid), world.materials.push_back(material);
    world.objects.push_back({-1, solid.mesh.triangles.empty(), 0, 0, 0});
}

static void fill(World& world, double scattering, double absorption, double asymmetry) {
    covbeam_volume fog{};
    grey(scattering).store(fog.scattering), grey(absorption).store(fog.absorption);
    fog.phase = COVBEAM_PHASE_HENYEY_GREENSTEIN, fog.asymmetry = asymmetry;
    world.volumes.push_back(fog), world.fixed.world_volume = 0;
}
static void light(World& world, Vec3 place, Vec3 lit, double inner, double outer, Vec3 intensity) { // half angles of its cone [degrees]
    covbeam_light lamp{};
    lamp.kind = outer < 180 ? COVBEAM_LIGHT_SPOT : COVBEAM_LIGHT_POINT;
    place.store(lamp.position), (lit - place).unit().store(lamp.axis), intensity.store(lamp.intensity);
    lamp.cosine = std::cos(outer * PI / 180), lamp.blend = std::cos(inner * PI / 180) - lamp.cosine;
    world.lights.push_back(lamp);
}
static void look(World& world, Vec3 from, Vec3 at, double angle) { // of the view upwards [degrees]
    covbeam_camera& camera = world.fixed.camera;
    from.store(camera.position), (at - from).store(camera.forward);
    camera.up[1] = 1, camera.half_height = std::tan(angle * PI / 360);
}

static void glass_ball(World& world) {
    look(world, {0, 0.5, -5}, {0, 0, 0}, 35), fill(world, 0.2, 0.02, 0);
    light(world, {0, 2.5, 0}, {0, 0, 0}, 180, 180, grey(25));
    add(world, {load_mesh("embree/assets/glass-ball-floor.obj")}, material(grey(0.5)));
    add(world, {{}, {0, 0, 0, 0.5f}}, material({}, {}, grey(1)));
    covbeam_volume clear{}; // without it there is fog in the ball
    grey(-0.5).store(clear.min), grey(0.5).store(clear.max);
    world.volumes.push_back(clear), world.objects.back().volume = 1;
}

static void shaft(World& world) {
    look(world, {0.4, 1.7, -6.6}, {0.1, 1.62, 0}, 33), fill(world, 0.25, 0.02, 0.2);
    light(world, {-0.5, 4.2, 0}, {0.1, 1.9, 0}, 18, 20, grey(60));
    world.volumes[0].scale_height = 1.5, Vec3{0, 1, 0}.store(world.volumes[0].up);
    add(world, {load_mesh("embree/assets/shaft-floor.obj")}, material(grey(0.08)));
    add(world, {{}, {0.1f, 1.9f, 0, 0.4f}}, material({}));
}

static void rose_window(World& world) {
    look(world, {-3.3, 2.6, 20}, {0.6, 5.3, 4}, 48), fill(world, 0.04, 0.005, 0.4);
    light(world, {-4, 17, -17}, {0, 7, -0.4}, 8.6, 9.2, {40000, 36000, 29000});
    add(world, {load_mesh("scenes/meshes/nave.obj")}, material({0.2, 0.185, 0.165}));
    add(world, {load_mesh("scenes/meshes/rose-window.obj")}, material({0.2, 0.185, 0.165}));
}

static void leaves(World& world) { // their shadows fall on tiles and marble, and on a ball that mirrors
    look(world, {0.5, 1.75, -5.6}, {-0.05, 1.7, 0}, 38), fill(world, 0.12, 0.01, 0.3);
    light(world, {-2.6, 4.6, -0.6}, {0.3, 0.7, 0.5}, 15, 17, {260, 245, 215});
    add(world, {load_mesh("embree/assets/leaves-floor.obj"), {}, load_image("embree/assets/tiles.ppm")}, material(grey(0.9)));
    add(world, {load_mesh("embree/assets/leaves-wall.obj"), {}, load_image("embree/assets/marble.ppm")}, material(grey(0.9)));
    add(world, {load_mesh("embree/assets/leaves.obj"), {}, load_image("embree/assets/leaf.ppm"), load_image("embree/assets/leaf-mask.ppm")}, material(grey(0.9)));
    add(world, {{}, {1.2f, 0.5f, 0.3f, 0.5f}}, material({}, {0.95, 0.93, 0.88}));
}

World build(const std::string& scene, uint32_t width) {
    const bool is_tall = scene == "rose-window", is_wide = scene == "leaves";
    World world;
    (scene == "glass-ball" ? glass_ball : scene == "shaft" ? shaft : is_tall ? rose_window : is_wide ? leaves
     : throw std::invalid_argument(scene + ": no scene"))(world);
    add(world, {load_mesh("embree/assets/" + scene + "-room.obj")}, material({})); // from which nothing comes back
    world.fixed.camera.width = width, world.fixed.camera.height = uint32_t(std::ceil(width * (is_tall ? 1.25 : is_wide ? 0.75 : 1)));
    return world;
}
