//! Scene files: the shipped ones are what they claim, and whatever is wrong is refused with file, line and field.

use covbeam_render::scene_file;
use std::path::{Path, PathBuf};

use covbeam::{ExponentialDensity, GridLayout, KernelShape, PhaseFunction, PhaseKind, Schedule};
use covbeam_render::files::output::{RenderInfo, write_exr};
use covbeam_render::scene_file::SceneError;
use covbeam_session::camera::{Camera, Frame, Lens, Projection};
use covbeam_session::film::Picture;
use covbeam_session::random::Random;
use covbeam_session::scene::{Area, Light, Lobes, Material, MediumDensity, Scene, Settings, Shape};
use glam::Vec3;
use proptest::prelude::*;

/// A valid scene that uses every field but those of [`SMOKE`]; the tests below break it.
pub(super) const VALID: &str = r#"outside_medium = "fog"
[camera]
position = [0.0, 0.5, -5.0]
look_at = [0, 0, 0]
up = [0, 2, 0]
vertical_fov = 35
near = 0.01
lens = { radius = 0.02, focus_distance = 4.5, blades = 6, rotation = 90, ratio = 1.5 }
width = 64
height = 32
[[medium]]
name = "fog"
scattering = [0.2, 0.3, 0.4]
absorption = 0.02
phase = { henyey_greenstein = 0.7 }
[[medium]]
name = "milk"
scattering = 5
absorption = 0
phase = "rayleigh"
[[object]]
name = "ball"
shape = "sphere"
center = [0, 0, 0]
radius = 0.5
material = { dielectric = { index = 1.5 } }
inside = "milk"
[[object]]
shape = "rectangle"
corner = [-4, -1.5, -6]
edge_u = [0, 0, 10]
edge_v = [8, 0, 0]
material = { lambert = { albedo = [0.5, 0.6, 0.7] } }
[[object]]
shape = "box"
min = [-4, -1.51, -6]
max = [4, 4.5, 4]
material = "black"
[[object]]
shape = "mesh"
file = "tetrahedron.obj"
scale = 0.5
rotate = { axis = [0, 0, 1], degrees = 90 }
translate = [1, 2, 3]
smooth = false
material = { mirror = { reflectance = 0.9 } }
[[light]]
kind = "point"
position = [0, 2.5, 0]
intensity = 25
[[light]]
kind = "spot"
position = [0, 3, 0]
look_at = [0, 0, 0]
intensity = [1, 0, 0]
inner_angle = 10
outer_angle = 20
[[light]]
kind = "disk"
center = [0, 3, 0]
normal = [0, -2, 0]
radius = 0.1
radiance = 4
[[light]]
kind = "rectangle"
corner = [1, 2, 3]
edge_u = [0.5, 0, 0]
edge_v = [0, 0, 0.25]
radiance = [1, 2, 3]
[[light]]
kind = "sphere"
center = [-1, 2, 0]
radius = 0.25
radiance = 8
[grid]
min = [-4, -1.5, -6]
max = [4, 4.5, 4]
cells = [8, 16, 32]
[render]
passes = 3
photons = 1000
seed = 7
radius = 0.05
alpha = 0.6
error = 0.02
max_radius = 0.3
light_field_share = 0.2
kernel = "biweight"
[[medium]]
name = "air"
scattering = [0.1, 0.2, 0.4]
absorption = 0
density = { exponential = { origin = [0, 1, 0], up = [0, 0, 2], scale_height = 1.5 } }
"#;

/// A medium for the end of [`VALID`], which names a file.
pub(super) const SMOKE: &str = r#"[[medium]]
name = "smoke"
scattering = [5, 4, 3]
absorption = 1
density = { volume = { file = "smoke.vol", min = [-1, -2, -3], max = [1, 2, 3] } }
"#;

const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

/// A .vol file of bytes, which is all 0 where `values` end.
pub(super) fn volume(cells: [i32; 3], values: &[u8]) -> Vec<u8> {
    let mut bytes = b"VOL\x03".to_vec();
    [3, cells[0], cells[1], cells[2], 1].iter().for_each(|integer: &i32| bytes.extend(integer.to_le_bytes()));
    [0.0f32, 0.0, 0.0, 1.0, 2.0, 3.0].iter().for_each(|corner| bytes.extend(corner.to_le_bytes()));
    bytes.extend(values);
    bytes.resize(48 + cells.iter().product::<i32>() as usize, 0);
    bytes
}

/// A folder with the mesh that [`VALID`] names, an open one and a broken one.
pub(super) fn meshes() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, text) in [
        ("tetrahedron.obj", TETRAHEDRON),
        ("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("broken.obj", "v 0 0 0\nv 1 nan 0\n"),
    ] {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    folder
}

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(name)
}

fn half_height(camera: &Camera) -> f32 {
    match camera.frame {
        Frame::Middle { half_height } => half_height,
        Frame::Part { .. } => panic!("scene files show the middle"),
    }
}

#[test]
fn every_field_arrives() {
    let folder = meshes();
    let scene = scene_file::parse(VALID, "valid.toml", folder.path()).expect("valid");
    assert_eq!(scene.outside, Some(0));
    assert_eq!((scene.camera.width, scene.camera.height), (64, 32));
    assert_eq!(scene.camera.projection, Projection::Perspective);
    assert!((half_height(&scene.camera) - 17.5f32.to_radians().tan()).abs() < 1e-7);
    assert_eq!(scene.camera.right, Vec3::NEG_X);
    let rotation = std::f32::consts::FRAC_PI_2;
    let lens = Lens { radius: 0.02, focus_distance: 4.5, blades: 6, rotation, ratio: 1.5 };
    assert_eq!((scene.camera.near, scene.camera.lens), (0.01, Some(lens)));
    assert_eq!(scene.media[0].medium.scattering, Vec3::new(0.2, 0.3, 0.4));
    assert_eq!(scene.media[0].medium.absorption, Vec3::splat(0.02));
    assert_eq!(
        scene.media[0].medium.phase,
        PhaseFunction { kind: PhaseKind::HenyeyGreenstein, asymmetry: 0.7 }
    );
    assert_eq!(scene.media[1].medium.phase.kind, PhaseKind::Rayleigh);
    assert!(matches!(scene.media[1].density, MediumDensity::Uniform));
    let MediumDensity::Exponential(air) = scene.media[2].density else { panic!("exponential") };
    assert_eq!(air, ExponentialDensity { origin: Vec3::Y, up: Vec3::Z, scale_height: 1.5 });
    let [ball, floor, room, mesh] = scene.objects.as_slice() else { panic!("four objects") };
    assert_eq!((ball.name.as_str(), ball.inside), ("ball", Some(1)));
    assert_eq!(ball.material, Material::Dielectric { index: 1.5 });
    assert!(matches!(ball.shape, Shape::Sphere { center: Vec3::ZERO, radius: 0.5 }));
    assert_eq!((floor.name.as_str(), floor.inside), ("object[1]", None));
    assert_eq!(floor.material, Material::Lambert { albedo: Vec3::new(0.5, 0.6, 0.7) });
    assert_eq!(room.material, Material::Black);
    assert_eq!(mesh.material, Material::Mirror { reflectance: Vec3::splat(0.9) });
    // [0, 1]³ halved, x turned to y and y to -x, moved.
    let (min, max) = mesh.shape.bounds();
    assert!(
        (min - Vec3::new(0.5, 2.0, 3.0)).length() < 1e-6 && (max - Vec3::new(1.0, 2.5, 3.5)).length() < 1e-6
    );
    assert_eq!(scene.lights[0], Light::Point { position: Vec3::Y * 2.5, intensity: Vec3::splat(25.0) });
    let Light::Spot { direction, inner_angle, outer_angle, .. } = scene.lights[1] else { panic!("a spot") };
    assert_eq!((direction, inner_angle, outer_angle), (Vec3::NEG_Y, 10f32.to_radians(), 20f32.to_radians()));
    assert!(matches!(scene.lights[2], Light::Disk { normal: Vec3::NEG_Y, radius: 0.1, .. }));
    let (corner, edge_u, edge_v) = (Vec3::new(1.0, 2.0, 3.0), 0.5 * Vec3::X, 0.25 * Vec3::Z);
    let radiance = Vec3::new(1.0, 2.0, 3.0);
    assert_eq!(scene.lights[3], Light::Rectangle { corner, edge_u, edge_v, radiance });
    let center = Vec3::new(-1.0, 2.0, 0.0);
    assert_eq!(scene.lights[4], Light::Sphere { center, radius: 0.25, radiance: Vec3::splat(8.0) });
    assert_eq!(scene.grid.cells, [8, 16, 32]);
    let settings = scene.settings;
    assert_eq!((settings.passes, settings.photons, settings.seed), (3, 1000, 7));
    assert_eq!(
        (settings.schedule.radius, settings.schedule.alpha, settings.schedule.error),
        (0.05, 0.6, 0.02)
    );
    assert_eq!((settings.schedule.max_radius, settings.light_field_share), (0.3, 0.2));
    assert_eq!(settings.schedule.shape, KernelShape::Biweight);
}

/// The figures of scenes G and O, written out again from their specification.
#[test]
fn the_ball_scenes_are_the_ones_that_were_measured_elsewhere() {
    for (name, material) in
        [("glass-ball.toml", Material::Dielectric { index: 1.5 }), ("black-ball.toml", Material::Black)]
    {
        let scene = scene_file::load(&shipped(name)).expect("shipped scenes are valid");
        let fog = scene.media[scene.outside.expect("fog outside") as usize].medium;
        assert_eq!((fog.scattering, fog.absorption), (Vec3::splat(0.2), Vec3::splat(0.02)));
        assert_eq!(fog.phase, PhaseFunction::ISOTROPIC);
        let [ball, floor, room] = scene.objects.as_slice() else { panic!("three objects") };
        assert!(matches!(ball.shape, Shape::Sphere { center: Vec3::ZERO, radius: 0.5 }));
        assert_eq!((ball.material, ball.inside), (material, None));
        let floor_box = (Vec3::new(-4.0, -1.5, -6.0), Vec3::new(4.0, -1.5, 4.0));
        assert_eq!(
            (floor.shape.bounds(), floor.material),
            (floor_box, Material::Lambert { albedo: Vec3::splat(0.5) })
        );
        let room_box = (Vec3::new(-4.0, -1.51, -6.0), Vec3::new(4.0, 4.5, 4.0));
        assert_eq!((room.shape.bounds(), room.material), (room_box, Material::Black));
        assert_eq!(scene.lights, [Light::Point { position: Vec3::Y * 2.5, intensity: Vec3::splat(25.0) }]);
        let camera = scene.camera;
        assert_eq!((camera.position, camera.width, camera.height), (Vec3::new(0.0, 0.5, -5.0), 256, 256));
        assert!((camera.forward - Vec3::new(0.0, -0.5, 5.0).normalize()).length() < 1e-6);
        assert!((half_height(&camera) - 17.5f32.to_radians().tan()).abs() < 1e-7);
        // The floor is lit from above: its normal is up.
        let hit = scene.intersect(Vec3::new(2.0, 0.0, 0.0), Vec3::NEG_Y, f32::INFINITY).expect("the floor");
        assert_eq!((hit.object, hit.normal), (1, Vec3::Y));
    }
}

#[test]
fn every_shipped_scene_is_valid_and_its_camera_stands_outside_all_glass() {
    let folder = std::fs::read_dir(shipped("")).expect("the scenes folder");
    let files: Vec<PathBuf> = folder.map(|entry| entry.expect("readable").path()).collect();
    // The folder is also the package of the programs that make its meshes and volumes.
    let is_scene =
        |path: &&PathBuf| path.extension().is_some_and(|e| e == "toml") && !path.ends_with("Cargo.toml");
    let scenes: Vec<_> = files.iter().filter(is_scene).collect();
    assert!(scenes.len() >= 2);
    for path in scenes {
        let scene = scene_file::load(path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scene.containing(scene.camera.position).count(), 0, "{}", path.display());
        assert!(scene.intersect(scene.camera.position, scene.camera.forward, f32::INFINITY).is_some());
    }
}

#[test]
fn cameras_of_all_projections_are_read() {
    let camera = |fields: &str, [width, height]: [u32; 2]| {
        let text = format!(
            "[camera]\nposition=[0,0,-9]\nlook_at=[0,0,0]\nwidth={width}\nheight={height}\n{fields}\n\
             [[light]]\nkind=\"point\"\nposition=[0,1,0]\nintensity=1\n"
        );
        Ok::<Camera, SceneError>(scene_file::parse(&text, "camera.toml", Path::new(""))?.camera)
    };
    for (fields, size, projection, expected) in [
        ("projection='perspective'\nvertical_fov=90", [4, 4], Projection::Perspective, 1.0),
        ("projection='orthographic'\nvertical_size=6", [4, 4], Projection::Orthographic, 3.0),
        ("projection='equirectangular'", [8, 4], Projection::Equirectangular, 90.0_f32.to_radians()),
        ("projection='equirectangular'", [4, 4], Projection::Equirectangular, 90.0_f32.to_radians()),
        (
            "projection='equirectangular'\nvertical_fov=80",
            [16, 4],
            Projection::Equirectangular,
            40.0_f32.to_radians(),
        ),
        (
            "projection='fisheye'\nvertical_fov=250",
            [4, 4],
            Projection::Fisheye { widest: std::f32::consts::PI },
            125.0_f32.to_radians(),
        ),
    ] {
        let camera = camera(fields, size).expect("valid");
        assert_eq!((camera.projection, camera.near, camera.lens), (projection, 0.0, None));
        assert!((half_height(&camera) - expected).abs() < 1e-6, "{fields}");
    }
    // All around is 360 degrees: twice as wide as high.
    let error = camera("projection='equirectangular'", [9, 4]).expect_err("too wide").to_string();
    assert!(error.contains("vertical_fov") && error.contains("160.0"), "{error}");
    let error = camera("projection='fisheye'", [4, 4]).expect_err("no angle").to_string();
    assert!(error.contains("vertical_fov"), "{error}");
}

#[test]
fn what_a_file_does_not_say_has_a_default() {
    let text = "[camera]\nposition=[0,0,-9]\nlook_at=[0,0,0]\nvertical_fov=40\nwidth=8\nheight=8\n\
                [[object]]\nshape=\"box\"\nmin=[-1,-2,-3]\nmax=[4,5,6]\nmaterial=\"black\"\n\
                [[object]]\nshape=\"sphere\"\ncenter=[0,0,0]\nradius=10\nmaterial=\"black\"\n\
                [[light]]\nkind=\"point\"\nposition=[0,1,0]\nintensity=1\n";
    let scene = scene_file::parse(text, "small.toml", Path::new("")).expect("valid");
    assert_eq!((scene.outside, scene.camera.up), (None, Vec3::Y));
    // Without a medium nothing is known but where the objects are.
    assert_eq!((scene.grid.min, scene.grid.max), (Vec3::splat(-10.0), Vec3::splat(10.0)));
    let settings = scene.settings;
    assert_eq!((settings.passes, settings.photons, settings.seed), (64, 5000, 1));
    assert_eq!(
        (settings.schedule.alpha, settings.schedule.error, settings.light_field_share),
        (0.8, 0.01, 0.1)
    );
    assert_eq!(settings.schedule.shape, KernelShape::Epanechnikov);
}

/// [`VALID`] without its numbers for the grid and the render.
fn untuned() -> String {
    let (start, end) = (VALID.find("[grid]").expect("present"), VALID.rfind("[[medium]]").expect("present"));
    VALID[..start].to_owned() + &VALID[end..]
}

#[test]
fn each_field_overrides_its_default_and_leaves_the_others() {
    let folder = meshes();
    let read = |extra: &str| {
        let scene = scene_file::parse(&(untuned() + extra), "untuned.toml", folder.path()).expect("valid");
        (scene.grid, scene.settings)
    };
    let (grid, settings) = read("");
    let corners = "[grid]\nmin = [-1, -1, -1]\nmax = [1, 1, 2]\n";
    let (min, max) = (Vec3::splat(-1.0), Vec3::new(1.0, 1.0, 2.0));
    let (given, others) = read(corners);
    assert_eq!((given.min, given.max), (min, max));
    // What follows from the light, and not from the box.
    assert_eq!((others.schedule.radius, others.photons), (settings.schedule.radius, settings.photons));
    assert_eq!(read("[grid]\ncells = [2, 3, 4]\n").0, GridLayout { cells: [2, 3, 4], ..grid });
    let paths = Settings { photons: 77, guided_photons: 77, ..settings };
    assert_eq!(read("[render]\nphotons = 77\n"), (grid, paths));
    // What is asked for is asked for: no fewer guided ones.
    let paths = Settings { photons: 9000, guided_photons: 9000, ..settings };
    assert_eq!(read("[render]\nphotons = 9000\n"), (grid, paths));
    let with = |schedule| (grid, Settings { schedule, ..settings });
    assert_eq!(read("[render]\nerror = 0.5\n"), with(Schedule { error: 0.5, ..settings.schedule }));
    assert_eq!(read("[render]\nmax_radius = 3\n"), with(Schedule { max_radius: 3.0, ..settings.schedule }));
    // As many beams a pixel take fewer paths.
    let (same, wide) = read(&format!("[render]\nradius = {}\n", 4.0 * settings.schedule.radius));
    assert_eq!((same, wide.schedule.radius), (grid, 4.0 * settings.schedule.radius));
    assert!(
        wide.photons < settings.photons && wide.schedule.max_radius == settings.schedule.max_radius,
        "{wide:?}"
    );
}

/// (text in `VALID`, what replaces it, line of the error after that of the text, field, part of what is expected)
const WRONG: &[(&str, &str, isize, &str, &str)] = &[
    // Wrong kinds and unknown or missing fields.
    ("radius = 0.5", "radius = \"big\"", 0, "object[0].radius", "length"),
    ("radius = 0.5", "raduis = 0.5", 0, "object[0].raduis", "radius"),
    ("radius = 0.5\n", "", -4, "object[0].radius", "this field"),
    ("[render]", "[renderer]", 0, "renderer", "render"),
    ("[camera]", "[grip]", 0, "grip", "camera"),
    ("smooth = false", "smooth = 0", 0, "object[3].smooth", "true or false"),
    ("width = 64", "width = 64.5", 0, "camera.width", "integer"),
    ("width = 64", "width = -1", 0, "camera.width", "integer"),
    ("center = [0, 0, 0]", "center = [0, 0]", 0, "object[0].center", "three numbers"),
    ("center = [0, 0, 0]", "center = [0, \"a\", 0]", 0, "object[0].center[1]", "number"),
    ("center = [0, 0, 0]", "center = 5", 0, "object[0].center", "three numbers"),
    ("shape = \"sphere\"", "shape = \"ball\"", 0, "object[0].shape", "\"sphere\""),
    ("shape = \"sphere\"", "shape = 3", 0, "object[0].shape", "\"sphere\""),
    ("center = [0, 0, 0]", "corner = [0, 0, 0]", 0, "object[0].corner", "center"),
    ("name = \"ball\"", "name = 1", 0, "object[0].name", "name"),
    ("kind = \"spot\"", "kind = \"laser\"", 0, "light[1].kind", "\"spot\""),
    ("kernel = \"biweight\"", "kernel = \"gauss\"", 0, "render.kernel", "\"biweight\""),
    ("phase = \"rayleigh\"", "phase = \"mie\"", 0, "medium[1].phase", "\"rayleigh\""),
    ("phase = \"rayleigh\"", "phase = { rayleigh = 1 }", 0, "medium[1].phase", "\"rayleigh\""),
    ("material = \"black\"", "material = \"dielectric\"", 0, "object[2].material", "index"),
    ("material = \"black\"", "material = { black = 1, glass = 2 }", 0, "object[2].material", "\"black\""),
    (
        "{ lambert = { albedo = [0.5, 0.6, 0.7] } }",
        "{ lambert = 0.5 }",
        0,
        "object[1].material.lambert",
        "table",
    ),
    (
        "{ dielectric = { index = 1.5 } }",
        "{ dielectric = { ior = 1.5 } }",
        0,
        "object[0].material.dielectric.ior",
        "index",
    ),
    // Not numbers.
    ("radius = 0.5", "radius = nan", 0, "object[0].radius", "length"),
    ("radius = 0.5", "radius = inf", 0, "object[0].radius", "length"),
    ("radius = 0.5", "radius = 1e99", 0, "object[0].radius", "length"),
    ("position = [0, 2.5, 0]", "position = [0, nan, 0]", 0, "light[0].position[1]", "number"),
    ("position = [0, 2.5, 0]", "position = [0, 2e9, 0]", 0, "light[0].position[1]", "1e9"),
    // Out of range.
    ("radius = 0.5", "radius = -0.5", 0, "object[0].radius", "length"),
    ("radius = 0.5", "radius = 0", 0, "object[0].radius", "length"),
    ("radius = 0.5", "radius = 1e-50", 0, "object[0].radius", "length"),
    ("index = 1.5", "index = 0", 0, "object[0].material.dielectric.index", "0.1..=10"),
    ("index = 1.5", "index = -1.5", 0, "object[0].material.dielectric.index", "0.1..=10"),
    ("[0.5, 0.6, 0.7]", "[0.5, 1.6, 0.7]", 0, "object[1].material.lambert.albedo[1]", "0..=1"),
    ("reflectance = 0.9", "reflectance = 1.01", 0, "object[3].material.mirror.reflectance", "0..=1"),
    ("absorption = 0.02", "absorption = -0.02", 0, "medium[0].absorption", "0..=1e9"),
    ("[0.2, 0.3, 0.4]", "[0.2, 0.3, nan]", 0, "medium[0].scattering[2]", "0..=1e9"),
    ("henyey_greenstein = 0.7", "henyey_greenstein = 1", 0, "medium[0].phase.henyey_greenstein", "0.999"),
    ("vertical_fov = 35", "vertical_fov = 0", 0, "camera.vertical_fov", "179"),
    ("vertical_fov = 35", "vertical_fov = 180", 0, "camera.vertical_fov", "179"),
    ("vertical_fov = 35", "vertical_size = 35", 0, "camera.vertical_size", "vertical_fov"),
    ("vertical_fov = 35", "vertical_fov = 35\nprojection = \"flat\"", 1, "camera.projection", "orthographic"),
    (
        "vertical_fov = 35",
        "vertical_fov = 35\nprojection = \"orthographic\"",
        0,
        "camera.vertical_fov",
        "vertical_size",
    ),
    (
        "vertical_fov = 35",
        "vertical_size = 0\nprojection = \"orthographic\"",
        0,
        "camera.vertical_size",
        "length",
    ),
    (
        "vertical_fov = 35",
        "vertical_fov = 181\nprojection = \"equirectangular\"",
        0,
        "camera.vertical_fov",
        "180.0",
    ),
    (
        "vertical_fov = 35",
        "vertical_fov = 162\nprojection = \"fisheye\"",
        0,
        "camera.vertical_fov",
        "160.9969",
    ),
    ("near = 0.01", "near = -0.01", 0, "camera.near", "0..=1e9"),
    ("near = 0.01", "near = nan", 0, "camera.near", "0..=1e9"),
    ("{ radius = 0.02, focus", "{ radius = 0, focus", 0, "camera.lens.radius", "length"),
    ("{ radius = 0.02, focus", "{ focus", 0, "camera.lens.radius", "this field"),
    ("focus_distance = 4.5", "focus_distance = -4.5", 0, "camera.lens.focus_distance", "length"),
    ("focus_distance = 4.5", "focus = 4.5", 0, "camera.lens.focus", "focus_distance"),
    ("blades = 6", "blades = 2", 0, "camera.lens.blades", "at least 3"),
    ("blades = 6", "blades = 1025", 0, "camera.lens.blades", "1024"),
    ("rotation = 90", "rotation = 400", 0, "camera.lens.rotation", "360"),
    ("ratio = 1.5", "ratio = 0", 0, "camera.lens.ratio", "0.01..=100"),
    ("width = 64", "width = 0", 0, "camera.width", "1 to 16384"),
    ("height = 32", "height = 16385", 0, "camera.height", "1 to 16384"),
    ("photons = 1000", "photons = 0", 0, "render.photons", "268435456"),
    ("photons = 1000", "photons = 268435457", 0, "render.photons", "268435456"),
    ("passes = 3", "passes = 0", 0, "render.passes", "from 1"),
    ("seed = 7", "seed = 4294967296", 0, "render.seed", "4294967295"),
    ("radius = 0.05", "radius = 0", 0, "render.radius", "length"),
    ("alpha = 0.6", "alpha = 1", 0, "render.alpha", "between 0 and 1"),
    ("error = 0.02", "error = 0", 0, "render.error", "0.000001"),
    ("max_radius = 0.3", "max_radius = 0", 0, "render.max_radius", "length"),
    ("light_field_share = 0.2", "light_field_share = 1.5", 0, "render.light_field_share", "..=1"),
    ("cells = [8, 16, 32]", "cells = [8, 0, 32]", 0, "grid.cells[1]", "from 1"),
    ("cells = [8, 16, 32]", "cells = [512, 512, 512]", 0, "grid.cells", "16777216"),
    ("cells = [8, 16, 32]", "cells = [16777216, 16777216, 16777216]", 0, "grid.cells", "16777216"),
    ("cells = [8, 16, 32]", "cells = 32", 0, "grid.cells", "three"),
    ("scale = 0.5", "scale = 0", 0, "object[3].scale", "length"),
    ("degrees = 90", "degrees = 1e5", 0, "object[3].rotate.degrees", "degrees"),
    ("scale_height = 1.5", "scale_height = 0", 0, "medium[2].density.exponential.scale_height", "length"),
    ("scale_height = 1.5", "scale_height = -1.5", 0, "medium[2].density.exponential.scale_height", "length"),
    ("scale_height = 1.5", "scale_height = inf", 0, "medium[2].density.exponential.scale_height", "length"),
    (", scale_height = 1.5", "", 0, "medium[2].density.exponential.scale_height", "this field"),
    ("up = [0, 0, 2]", "up = [0, 0, 0]", 0, "medium[2].density.exponential.up", "not zero"),
    ("origin = [0, 1, 0]", "origin = [0, nan, 0]", 0, "medium[2].density.exponential.origin[1]", "number"),
    ("origin = [0", "orgin = [0", 0, "medium[2].density.exponential.orgin", "origin, up, scale_height"),
    ("density = {", "density = \"exponential\" # {", 0, "medium[2].density", "{ exponential = {"),
    ("density = {", "density = 2 # {", 0, "medium[2].density", "{ volume = {"),
    ("density = {", "density = { volume = 1 } # {", 0, "medium[2].density.volume", "table"),
    ("density = {", "density = { volume = {} } # {", 0, "medium[2].density.volume.file", "this field"),
    ("density = {", "density = { volume = { file = 1 } } # {", 0, "medium[2].density.volume.file", ".vol"),
    ("density = {", "density = { volume = {}, a = 1 } # {", 0, "medium[2].density", "{ exponential = {"),
    ("density = {", "densty = {", 0, "medium[2].densty", "density"),
    (
        "{ mirror = { reflectance = 0.9 } }",
        "{ metal = { roughness = 0.5 } }",
        0,
        "object[3].material.metal.reflectance",
        "this field",
    ),
    (
        "{ mirror = { reflectance = 0.9 } }",
        "{ metal = { reflectance = 0.9, roughness = 1.5 } }",
        0,
        "object[3].material.metal.roughness",
        "0..=1",
    ),
    (
        "{ mirror = { reflectance = 0.9 } }",
        "{ plastic = { albedo = nan } }",
        0,
        "object[3].material.plastic.albedo",
        "0..=1",
    ),
    (
        "{ mirror = { reflectance = 0.9 } }",
        "{ lobes = { gloss = 0.5 } }",
        0,
        "object[3].material.lobes.gloss",
        "translucent",
    ),
    // Contradictions.
    (
        "{ mirror = { reflectance = 0.9 } }",
        "{ lobes = { diffuse = 0.6, translucent = [0.3, 0.5, 0.3] } }",
        0,
        "object[3].material.lobes",
        "1.100",
    ),
    (
        "{ lambert = { albedo = [0.5, 0.6, 0.7] } }",
        "{ lobes = { glass_transmission = 0.5 } }",
        0,
        "object[1].material",
        "open",
    ),
    ("max = [4, 4.5, 4]\nmaterial", "max = [4, -1.51, 4]\nmaterial", 0, "object[2].max", "above"),
    ("max = [4, 4.5, 4]\ncells", "max = [-5, 4.5, 4]\ncells", 0, "grid.max", "above"),
    ("look_at = [0, 0, 0]\nup", "look_at = [0, 0.5, -5.0]\nup", 0, "camera.look_at", "other than"),
    ("up = [0, 2, 0]", "up = [0, 0.5, -5]", 0, "camera.up", "along the view"),
    ("up = [0, 2, 0]", "up = [0, 0, 0]", 0, "camera.up", "not zero"),
    ("look_at = [0, 0, 0]\nintensity", "look_at = [0, 3, 0]\nintensity", 0, "light[1].look_at", "other than"),
    ("outer_angle = 20", "outer_angle = 10", 0, "light[1].outer_angle", "above inner_angle = 10"),
    ("outer_angle = 20", "outer_angle = 90", 0, "light[1].outer_angle", "below 90"),
    ("inner_angle = 10", "inner_angle = -1", 0, "light[1].inner_angle", "0..90"),
    ("normal = [0, -2, 0]", "normal = [0, 0, 0]", 0, "light[2].normal", "not zero"),
    ("axis = [0, 0, 1]", "axis = [0, 0, 0]", 0, "object[3].rotate.axis", "not zero"),
    ("edge_u = [0, 0, 10]", "edge_u = [0, 0, 0]", 0, "object[1].edge_u", "longer"),
    ("edge_u = [0, 0, 10]", "edge_u = [-3, 0, 0]", 1, "object[1].edge_v", "parallel"),
    (
        "{ lambert = { albedo = [0.5, 0.6, 0.7] } }",
        "{ dielectric = { index = 1.5 } }",
        0,
        "object[1].material",
        "open",
    ),
    ("intensity = 25", "intensity = 0", 0, "light[0].intensity", "not dark"),
    ("intensity = [1, 0, 0]", "intensity = [0, 0, 0]", 0, "light[1].intensity", "not dark"),
    ("radiance = 4", "radiance = -4", 0, "light[2].radiance", "0..=1e9"),
    ("edge_u = [0.5, 0, 0]", "edge_u = [0, 0, -3]", 1, "light[3].edge_v", "parallel"),
    ("radius = 0.25", "radius = 0", 0, "light[4].radius", "length"),
    ("radius = 0.25", "angle = 0.25", 0, "light[4].angle", "radius"),
    ("outside_medium = \"fog\"", "outside_medium = \"mist\"", 0, "outside_medium", "fog, milk"),
    ("inside = \"milk\"", "inside = \"beer\"", 0, "object[0].inside", "fog, milk"),
    ("inside = \"milk\"", "inside = \"air\"", 0, "object[0].inside", "without `density`"),
    ("name = \"milk\"", "name = \"fog\"", 0, "medium[1].name", "no other"),
    (
        "material = \"black\"",
        "material = \"black\"\ninside = \"fog\"",
        1,
        "object[2].inside",
        "not a dielectric",
    ),
];

#[test]
fn materials_are_sums_of_lobes() {
    let material = |text: &str| {
        let text = VALID.replace("{ mirror = { reflectance = 0.9 } }", text);
        let scene = scene_file::parse(&text, "scene.toml", meshes().path());
        scene.unwrap_or_else(|error| panic!("{error}")).objects[3].material
    };
    let grey = Vec3::splat;
    let cases = [
        ("{ metal = { reflectance = 0.9 } }", Lobes { metal: grey(0.9), edge: Vec3::ONE, ..Lobes::NONE }),
        (
            "{ metal = { reflectance = [0.9, 0.6, 0.5], edge = 0.8, roughness = 0.5 } }",
            Lobes { metal: Vec3::new(0.9, 0.6, 0.5), edge: grey(0.8), alpha: 0.25, ..Lobes::NONE },
        ),
        (
            "{ plastic = { albedo = 0.4, index = 1.4, roughness = 0.02 } }",
            Lobes { diffuse: grey(0.4), coat: Vec3::ONE, index: 1.4, ..Lobes::NONE },
        ),
        (
            "{ lobes = { diffuse = 0.2, translucent = 0.1, metal = 0.3, transparent = 0.4 } }",
            Lobes {
                diffuse: grey(0.2),
                translucent: grey(0.1),
                metal: grey(0.3),
                edge: grey(0.3),
                transparent: grey(0.4),
                ..Lobes::NONE
            },
        ),
    ];
    for (text, lobes) in cases {
        assert_eq!(material(text), Material::Lobes(lobes), "{text}");
    }
}

#[test]
fn whatever_is_wrong_is_refused_with_file_line_field_and_expectation() {
    let folder = meshes();
    for &(text, replacement, offset, path, part) in WRONG {
        let place = VALID.find(text).unwrap_or_else(|| panic!("{text:?} is not in the valid scene"));
        let at = (1 + VALID[..place].matches('\n').count()).saturating_add_signed(offset);
        let broken = VALID.replacen(text, replacement, 1);
        match scene_file::parse(&broken, "broken.toml", folder.path()) {
            Err(SceneError::Field { file, line, field, expected, .. }) => {
                let as_it_should = (file.as_str(), line, field.as_str()) == ("broken.toml", at, path);
                assert!(
                    as_it_should && expected.contains(part),
                    "{replacement:?}: {file}:{line}: {field}: expected {expected}"
                );
            }
            Err(error) => panic!("{replacement:?}: another kind of error: {error}"),
            Ok(_) => panic!("{replacement:?} was accepted"),
        }
    }
}

/// A sun above a box of fog; `outside` at its beginning.
fn sunny(outside: &str, light: &str) -> Result<Scene, SceneError> {
    lit(outside, &format!("kind = \"sun\"\n{light}"), Path::new(""))
}

/// A light of any kind there.
fn lit(outside: &str, light: &str, folder: &Path) -> Result<Scene, SceneError> {
    let text = format!(
        "{outside}\n[camera]\nposition = [0, 0, -9]\nlook_at = [0, 0, 0]\nvertical_fov = 40\nwidth = 8\nheight = 8\n\
         [[medium]]\nname = \"fog\"\nscattering = 0.1\nabsorption = 0\n\
         [[medium]]\nname = \"haze\"\nscattering = 0.1\nabsorption = 0\ndensity = {{ exponential = {{ scale_height = 2 }} }}\n\
         [[medium]]\nname = \"nothing\"\nscattering = 0\nabsorption = 0\n\
         [[light]]\n{light}\n\
         [[object]]\nshape = \"box\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\nmaterial = {{ dielectric = {{ index = 1 }} }}\ninside = \"fog\"\n"
    );
    scene_file::parse(&text, "sunny.toml", folder)
}

#[test]
fn a_sun_arrives_and_is_refused_where_its_light_would_not() {
    let light = "direction = [0, -2, 0]\nangle = 0.5\nirradiance = [3, 2, 1]";
    for outside in ["", "outside_medium = \"haze\"", "outside_medium = \"nothing\""] {
        let Light::Sun(sun) = sunny(outside, light).expect("valid").lights[0] else { panic!("a sun") };
        assert_eq!((sun.direction, sun.irradiance), (Vec3::NEG_Y, Vec3::new(3.0, 2.0, 1.0)));
        assert_eq!(sun.angle, 0.25f32.to_radians());
    }
    let parallel = sunny("", "direction = [0, -1, 0]\nirradiance = 1").expect("valid").lights[0].clone();
    assert!(matches!(parallel, Light::Sun(sun) if sun.angle == 0.0));
    let wrong = [
        ("outside_medium = \"fog\"", light, "kind", "no sun where outside_medium has no end"),
        ("outside_medium = \"haze\"", "direction = [1, 0.1, 0]\nirradiance = 1", "direction", "down"),
        ("", "direction = [0, 0, 0]\nirradiance = 1", "direction", "not zero"),
        ("", "direction = [0, -1, 0]\nangle = 91\nirradiance = 1", "angle", "0..=90"),
        ("", "direction = [0, -1, 0]\nirradiance = 0", "irradiance", "not dark"),
        ("", "direction = [0, -1, 0]\nradiance = 1", "radiance", "irradiance"),
    ];
    for (outside, light, name, part) in wrong {
        match sunny(outside, light) {
            Err(SceneError::Field { field, expected, .. }) => {
                assert!(
                    field == format!("light[0].{name}") && expected.contains(part),
                    "{field}: {expected}"
                );
            }
            other => panic!("{outside} {light}: {other:?}"),
        }
    }
    let empty = "[camera]\nposition=[0,0,-9]\nlook_at=[0,0,0]\nvertical_fov=40\nwidth=8\nheight=8\n\
                 [[light]]\nkind=\"sun\"\ndirection=[0,-1,0]\nirradiance=1\n";
    let error = scene_file::parse(empty, "empty.toml", Path::new("")).expect_err("nothing to shine on");
    assert!(error.to_string().contains("an object, or a medium with an end"), "{error}");
}

#[test]
fn lamps_areas_meshes_and_skies_arrive() {
    let folder = meshes();
    let read = |light: &str| {
        let scene = lit("", light, folder.path()).unwrap_or_else(|error| panic!("{light}: {error}"));
        scene.lights[0].clone()
    };
    let Light::Lamp(lamp) = read("kind = \"lamp\"\nposition = [0, 2.5, 0]\nintensity = [3, 2, 1]") else {
        panic!("a lamp")
    };
    assert_eq!((lamp.position, lamp.intensity), (Vec3::Y * 2.5, Vec3::new(3.0, 2.0, 1.0)));
    assert!(lamp.radius == 0.0 && !lamp.soft && lamp.cone.is_none() && lamp.pattern.is_none());
    let cone = "cone = { look_at = [0, 0, 0], angle = 60, blend = 0.5 }";
    let text =
        format!("kind = \"lamp\"\nposition = [0, 2.5, 0]\nintensity = 1\nradius = 0.25\nsoft = true\n{cone}");
    let Light::Lamp(lamp) = read(&text) else { panic!("a lamp") };
    assert!(lamp.radius == 0.25 && lamp.soft);
    let cone = lamp.cone.expect("a cone");
    assert!(cone.axis == Vec3::NEG_Y && (cone.cosine - 0.5).abs() < 1e-6 && (cone.blend - 0.25).abs() < 1e-6);

    let edges = "edge_u = [0.5, 0, 0]\nedge_v = [0, 0, 0.25]";
    let Light::Area(area) = read(&format!("kind = \"area\"\ncenter = [1, 2, 3]\n{edges}\nradiance = 4"))
    else {
        panic!("an area")
    };
    let (edge_u, edge_v) = (0.5 * Vec3::X, 0.25 * Vec3::Z);
    let (center, spread) = (Vec3::new(1.0, 2.0, 3.0), 90f32.to_radians());
    assert_eq!(area, Area { center, edge_u, edge_v, round: false, spread, radiance: Vec3::splat(4.0) });
    let narrow =
        format!("kind = \"area\"\ncenter = [1, 2, 3]\n{edges}\nradiance = 4\nround = true\nspread = 30");
    let Light::Area(narrow) = read(&narrow) else { panic!("an area") };
    assert_eq!(narrow, Area { round: true, spread: 30f32.to_radians(), ..area });

    // The right angle's triangles, of ½ each, and the slope's: √3/2; half as large as the file's.
    let mesh = read("kind = \"mesh\"\nfile = \"tetrahedron.obj\"\nscale = 0.5\nradiance = [1, 2, 3]");
    let flux = std::f32::consts::TAU * 0.25 * (1.5 + 0.75f32.sqrt()) * Vec3::new(1.0, 2.0, 3.0);
    assert!(matches!(mesh, Light::Mesh(_)) && (mesh.flux() / flux - 1.0).abs().max_element() < 1e-5);
}

/// Above +y, and from the left of the picture's first row: -x, -z, x and z, where y points up; the same turned.
#[test]
fn a_skys_picture_arrives_upright() {
    let folder = meshes();
    let radiance: Vec<Vec3> = (1..=8u8).map(|value| Vec3::new(f32::from(value), 1.0, 0.0)).collect();
    let picture = Picture { width: 4, height: 2, radiance, ..Picture::default() };
    let (method, scene) = ("sky".to_owned(), "sky".to_owned());
    let info = RenderInfo { method, passes: 1, photons: 1, seed: 1, scene };
    write_exr(&folder.path().join("sky.exr"), &picture, &info).expect("written");
    let sky = |more: &str| {
        let light = format!("kind = \"sky\"\nradiance = [2, 1, 1]\n{more}");
        let scene = lit("", &light, folder.path()).unwrap_or_else(|error| panic!("{error}"));
        assert!(matches!(scene.lights[0], Light::Sky(_)));
        scene.lights[0].clone()
    };
    let mut random = Random::new([5, 5, 5, 5]);
    let mut found = |light: &Light| {
        let mut sums = [[Vec3::ZERO; 4]; 2];
        for _ in 0..80_000 {
            let (density, from) = light.flux_density(Vec3::ZERO, [random.uniform(), random.uniform()]);
            let quarter = [
                [from.x < 0.0 && from.z < 0.0],
                [from.x >= 0.0 && from.z < 0.0],
                [from.x >= 0.0 && from.z >= 0.0],
            ];
            let column = quarter.iter().position(|[is_there]| *is_there).unwrap_or(3);
            sums[usize::from(from.y < 0.0)][column] += density / 80_000.0;
        }
        sums
    };
    // Each cell is an eighth of the sphere, and drawn by its light; the least by 1 in 36: 2 %.
    let check = |found: [[Vec3; 4]; 2], turned: usize| {
        for (row, column) in (0..8).map(|cell| (cell / 4, cell % 4)) {
            let value = (4 * row + (column + turned) % 4 + 1) as f32;
            let expected = std::f32::consts::FRAC_PI_2 * Vec3::new(2.0 * value, 1.0, 0.0);
            let off = (found[row][column] - expected).length() / expected.length();
            assert!(off < 0.08, "{row} {column}: {} {expected}", found[row][column]);
        }
    };
    check(found(&sky("picture = \"sky.exr\"")), 0);
    // To the left: what was in the second column is in the first.
    check(found(&sky("picture = \"sky.exr\"\nturn = 90")), 1);
    let even = sky("");
    assert!(
        (even.flux_density(Vec3::ZERO, [0.3, 0.4]).0 / Vec3::new(2.0, 1.0, 1.0) - 4.0 * std::f32::consts::PI)
            .length()
            < 1e-3
    );
}

#[test]
fn lamps_areas_meshes_and_skies_that_are_wrong_are_refused() {
    let folder = meshes();
    std::fs::write(folder.path().join("flat.exr"), "no picture").expect("written");
    let lamp = "kind = \"lamp\"\nposition = [0, 2.5, 0]\nintensity = 1\n";
    let area = "kind = \"area\"\ncenter = [0, 2, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = 1\n";
    let (mesh, sky) = ("kind = \"mesh\"\n", "kind = \"sky\"\nradiance = 1\n");
    let wrong = [
        ("", lamp, "radius = -1", "radius", "1e-9"),
        ("", lamp, "soft = 1", "soft", "true or false"),
        ("", lamp, "color = 1", "color", "radius, soft, cone"),
        ("", lamp, "cone = 3", "cone", "table"),
        ("", lamp, "cone = { look_at = [0, 0, 0], angle = 30 }", "cone.blend", "this field"),
        ("", lamp, "cone = { look_at = [0, 0, 0], angle = 0, blend = 0 }", "cone.angle", "above 0"),
        ("", lamp, "cone = { look_at = [0, 0, 0], angle = 91, blend = 0 }", "cone.angle", "90"),
        ("", lamp, "cone = { look_at = [0, 0, 0], angle = 9, blend = 1.5 }", "cone.blend", "0..=1"),
        ("", lamp, "cone = { look_at = [0, 2.5, 0], angle = 9, blend = 0 }", "cone.look_at", "other than"),
        ("", area, "spread = 0.01", "spread", "0.03..=90"),
        ("", area, "spread = 91", "spread", "0.03..=90"),
        ("", area, "round = \"yes\"", "round", "true or false"),
        ("", area, "corner = [0, 0, 0]", "corner", "center"),
        ("", mesh, "radiance = 1", "file", "this field"),
        ("", mesh, "file = \"tetrahedron.obj\"", "radiance", "this field"),
        ("", mesh, "file = \"tetrahedron.obj\"\nradiance = 0", "radiance", "not dark"),
        ("", mesh, "file = \"tetrahedron.obj\"\nradiance = 1\nsmooth = true", "smooth", "rotate"),
        ("", sky, "turn = 400", "turn", "360"),
        ("", sky, "visible = 1", "visible", "true or false"),
        ("", lamp, "radius = 0.1\nvisible = true", "visible", "use kind = \"sphere\""),
        (
            "",
            "kind = \"point\"\n",
            "position = [0, 2, 0]\nintensity = 1\nvisible = true",
            "visible",
            "\"disk\"",
        ),
        (
            "",
            "kind = \"sun\"\n",
            "direction = [0, -1, 0]\nirradiance = 1\nvisible = true",
            "visible",
            "`angle`",
        ),
        ("", sky, "picture = 3", "picture", "EXR"),
        ("", sky, "picture = \"none.exr\"", "picture", "regular file"),
        ("", sky, "picture = \"flat.exr\"", "picture", "EXR"),
        ("outside_medium = \"fog\"", sky, "", "kind", "no sky where outside_medium has no end"),
        ("outside_medium = \"haze\"", sky, "", "kind", "no sky where outside_medium has no end"),
    ];
    for (outside, light, more, name, part) in wrong {
        match lit(outside, &format!("{light}{more}"), folder.path()) {
            Err(SceneError::Field { field, expected, .. }) => {
                assert!(
                    field == format!("light[0].{name}") && expected.contains(part),
                    "{more}: {field}: {expected}"
                );
            }
            other => panic!("{light} {more}: {other:?}"),
        }
    }
    let missing = lit("", "kind = \"mesh\"\nfile = \"none.obj\"\nradiance = 1", folder.path());
    assert!(matches!(missing, Err(SceneError::Mesh { field, .. }) if field == "light[0].file"));
    let empty = "[camera]\nposition=[0,0,-9]\nlook_at=[0,0,0]\nvertical_fov=40\nwidth=8\nheight=8\n\
                 [[light]]\nkind=\"sky\"\nradiance=1\n";
    let error = scene_file::parse(empty, "empty.toml", Path::new("")).expect_err("nothing to shine on");
    assert!(error.to_string().contains("an object, or a medium with an end"), "{error}");
}

/// What has a surface is seen, and a sky; a sun where a file says so; and nothing that a file says is not.
#[test]
fn lamps_are_seen_by_default_where_they_have_a_surface() {
    let folder = meshes();
    let sun = "kind = \"sun\"\ndirection = [0, -1, 0]\nangle = 1\nirradiance = 1";
    for (light, expected) in [
        ("kind = \"disk\"\ncenter = [0, 2, 0]\nnormal = [0, -1, 0]\nradius = 1\nradiance = 2", true),
        (
            "kind = \"rectangle\"\ncorner = [0, 2, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = 2",
            true,
        ),
        ("kind = \"sphere\"\ncenter = [0, 2, 0]\nradius = 1\nradiance = 2", true),
        ("kind = \"area\"\ncenter = [0, 2, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = 2", true),
        ("kind = \"mesh\"\nfile = \"tetrahedron.obj\"\nradiance = 2", true),
        ("kind = \"sky\"\nradiance = 2", true),
        (sun, false),
        (&format!("{sun}\nvisible = true"), true),
        ("kind = \"point\"\nposition = [0, 2, 0]\nintensity = 1", false),
        ("kind = \"point\"\nposition = [0, 2, 0]\nintensity = 1\nvisible = false", false),
        ("kind = \"lamp\"\nposition = [0, 2, 0]\nintensity = 1\nradius = 0.1", false),
        ("kind = \"sky\"\nradiance = 2\nvisible = false", false),
    ] {
        let scene = lit("", light, folder.path()).expect("valid");
        assert_eq!(!scene.shown.is_empty(), expected, "{light}");
    }
    // A film of the picture holds what is seen, over 131,072 passes, and the light of dark fog.
    let bright = |radius: f32, more: &str| {
        let disk = format!(
            "kind = \"disk\"\ncenter = [0, 2, 0]\nnormal = [0, -1, 0]\nradius = {radius}\nradiance = 1e9"
        );
        lit("", &format!("{disk}\n{more}"), folder.path()).expect("valid").typical_radiance()
    };
    let without = bright(2e-3, "visible = false");
    assert!(without < 0.1 * bright(2e-3, ""));
    assert_eq!(bright(2e-3, ""), 1e9 / 16384.0);
    assert_eq!(bright(1e-6, ""), 4096.0 * bright(1e-6, "visible = false"));
}

/// A picture of a sky with one bad number is refused by its place, and mended where the scene says so.
#[test]
fn bad_pixels_of_a_sky_are_named_and_replaced_if_the_scene_asks_for_it() {
    let folder = meshes();
    for (bad, found, mended) in [(f32::INFINITY, "inf", 9.0), (f32::NAN, "NaN", 2.0), (-2.5, "-2.5", 0.0)] {
        // Twelve pixels of 1, but for a 9 beside the bad one.
        let mut radiance = vec![Vec3::ONE; 12];
        (radiance[5].y, radiance[6].y) = (9.0, bad);
        let write = |radiance: &[Vec3]| {
            let at = |x: usize, y: usize| <(f32, f32, f32)>::from(radiance[4 * y + x].to_array());
            exr::prelude::write_rgb_file(folder.path().join("sky.exr"), 4, 3, at).expect("written");
        };
        write(&radiance);
        let sky = "kind = \"sky\"\nradiance = 1\npicture = \"sky.exr\"\n";
        let Err(SceneError::Field { field, expected, .. }) = lit("", sky, folder.path()) else {
            panic!("{found} was taken")
        };
        assert_eq!(field, "light[0].picture");
        for part in
            [&format!("G is {found} at pixel (2, 1) of"), "sky.exr", "1 of its pixels", "repair = true"]
        {
            assert!(expected.contains(part), "{expected}");
        }
        let scene = lit("", &format!("{sky}repair = true\n"), folder.path()).expect("repaired");
        assert!(scene.notes.len() == 1 && scene.notes[0].contains("(2, 1)"), "{:?}", scene.notes);
        radiance[6].y = mended;
        // A sky that has that number from the start.
        write(&radiance);
        let sound = lit("", sky, folder.path()).expect("sound");
        assert!(sound.notes.is_empty());
        assert_eq!(scene.lights, sound.lights, "{found}");
    }
    let even = lit("", "kind = \"sky\"\nradiance = 1\nrepair = true\n", folder.path());
    assert!(matches!(even, Err(SceneError::Field { field, .. }) if field == "light[0].repair"));
}

#[test]
fn an_error_reads_as_one_line() {
    let broken = VALID.replace("radius = 0.5\n", "radius = -0.5\n");
    let error = scene_file::parse(&broken, "fog.toml", Path::new("")).expect_err("negative");
    assert_eq!(
        error.to_string(),
        "fog.toml:25: object[0].radius: found -0.5, expected a length in 1e-9..=1e9"
    );
}

#[test]
fn a_scene_without_lights_or_camera_is_refused_and_one_without_a_box_to_fill_is_not() {
    let folder = meshes();
    let dark = &VALID[..VALID.find("[[light]]").expect("present")];
    let error = scene_file::parse(dark, "dark.toml", folder.path()).expect_err("no light");
    let expected =
        "dark.toml:1: light: found nothing, expected at least one [[light]], or a [[medium]] with `emission`";
    assert_eq!(error.to_string(), expected);
    let blind = VALID.replace("[camera]", "[render2]");
    assert!(scene_file::parse(&blind, "blind.toml", folder.path()).is_err());
    let flat = "[camera]\nposition=[0,0,-9]\nlook_at=[0,0,0]\nvertical_fov=40\nwidth=8\nheight=8\n\
                [[object]]\nshape=\"rectangle\"\ncorner=[0,0,0]\nedge_u=[1,0,0]\nedge_v=[0,1,0]\nmaterial=\"black\"\n\
                [[light]]\nkind=\"point\"\nposition=[0,1,0]\nintensity=1\n";
    let scene = scene_file::parse(flat, "flat.toml", Path::new("")).expect("valid");
    assert!((scene.grid.max - scene.grid.min).min_element() > 0.0, "{:?}", scene.grid);
}

#[test]
fn a_missing_broken_or_open_mesh_is_refused_where_it_is_named() {
    let folder = meshes();
    let parse =
        |text: &str| scene_file::parse(text, "m.toml", folder.path()).expect_err("refused").to_string();
    let missing = parse(&VALID.replace("tetrahedron.obj", "none.obj"));
    assert!(
        missing.starts_with("m.toml:41: object[3].file: mesh ") && missing.contains("cannot be read"),
        "{missing}"
    );
    let folder_itself = parse(&VALID.replace("tetrahedron.obj", "."));
    assert!(folder_itself.contains("is not a regular file"), "{folder_itself}");
    let broken = parse(&VALID.replace("tetrahedron.obj", "broken.obj"));
    assert!(broken.contains("broken.obj: line 2: found `nan`, expected a finite number"), "{broken}");
    let huge = parse(&VALID.replace("scale = 0.5", "scale = 1e9").replace("[1, 2, 3]", "[-9e8, 0, 0]"));
    assert!(huge.starts_with("m.toml:41: object[3].file: mesh ") && huge.contains("±1e9"), "{huge}");
    let glass = VALID.replace("{ mirror = { reflectance = 0.9 } }", "{ dielectric = { index = 1.5 } }");
    assert!(scene_file::parse(&glass, "m.toml", folder.path()).is_ok(), "a tetrahedron is closed");
    let open = parse(&glass.replace("tetrahedron.obj", "open.obj"));
    assert!(open.starts_with("m.toml:46: object[3].material") && open.contains("3 open edges"), "{open}");
}

#[test]
fn a_volume_arrives_in_its_own_box_or_in_the_scenes() {
    let folder = meshes();
    std::fs::write(folder.path().join("smoke.vol"), volume([2, 1, 1], &[0, 255])).expect("written");
    let text = format!("{VALID}{SMOKE}").replace("outside_medium = \"fog\"", "outside_medium = \"smoke\"");
    let own = text.replace(", min = [-1, -2, -3], max = [1, 2, 3]", "");
    for (text, min, max) in [
        (&text, Vec3::new(-1.0, -2.0, -3.0), Vec3::new(1.0, 2.0, 3.0)),
        (&own, Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0)),
    ] {
        let scene = scene_file::parse(text, "smoke.toml", folder.path()).expect("valid");
        assert_eq!(scene.outside, Some(3));
        let MediumDensity::Grid(volume) = &scene.media[3].density else { panic!("a volume") };
        assert_eq!(volume.layout, GridLayout { min, max, cells: [2, 1, 1] });
        assert_eq!(volume.values, [0.0, 1.0]);
    }
}

#[test]
fn what_an_exponential_density_does_not_say_has_a_default() {
    let text = VALID.replace("origin = [0, 1, 0], up = [0, 0, 2], ", "");
    let scene = scene_file::parse(&text, "air.toml", meshes().path()).expect("valid");
    let MediumDensity::Exponential(air) = scene.media[2].density else { panic!("exponential") };
    assert_eq!(air, ExponentialDensity { origin: Vec3::ZERO, up: Vec3::Y, scale_height: 1.5 });
}

#[test]
fn a_missing_or_broken_volume_is_refused_where_it_is_named() {
    let folder = meshes();
    std::fs::write(folder.path().join("smoke.vol"), volume([2, 1, 1], &[])).expect("written");
    std::fs::write(folder.path().join("cut.vol"), &volume([2, 1, 1], &[])[..49]).expect("written");
    let text = format!("{VALID}{SMOKE}");
    let line = text.lines().count();
    let refused = |from: &str, to: &str| {
        assert!(text.contains(from));
        let error =
            scene_file::parse(&text.replace(from, to), "v.toml", folder.path()).expect_err(to).to_string();
        let place = format!("v.toml:{line}: medium[3].density.volume.");
        error.strip_prefix(&place).unwrap_or_else(|| panic!("{error}")).to_owned()
    };
    let path = |name: &str| folder.path().join(name).display().to_string();
    let missing = refused("smoke.vol", "none.vol");
    assert!(
        missing.starts_with(&format!("file: volume {}: cannot be read: ", path("none.vol"))),
        "{missing}"
    );
    assert_eq!(refused("smoke.vol", ""), format!("file: volume {}: is not a regular file", path("")));
    let cut = refused("smoke.vol", "cut.vol");
    let expected =
        "has 49 bytes, expected 50 for 2 x 1 x 1 voxels: the file is cut off, copy or export it again";
    assert_eq!(cut, format!("file: volume {}: {expected}", path("cut.vol")));
    let mesh = refused("smoke.vol", "tetrahedron.obj");
    assert!(mesh.contains("starts with v 0, expected \"VOL\""), "{mesh}");
    assert_eq!(refused(", max = [1, 2, 3]", ""), "max: found nothing, expected this field");
    assert_eq!(refused("min = [-1, -2, -3], ", ""), "min: found nothing, expected this field");
    let empty = refused("max = [1, 2, 3]", "max = [1, -2, 3]");
    assert!(empty.starts_with("max: found [1, -2, 3], expected each coordinate above"), "{empty}");
    let unknown = refused("min = [-1, -2, -3]", "minimum = [-1, -2, -3]");
    assert_eq!(unknown, "minimum: found an unknown field, expected one of file, min, max");
}

#[test]
fn a_medium_denser_than_the_bound_is_refused() {
    let folder = meshes();
    let write = |largest: f32| {
        let mut bytes = volume([1, 1, 1], &[]);
        bytes.truncate(48);
        bytes[4] = 1;
        bytes.extend(largest.to_le_bytes());
        std::fs::write(folder.path().join("smoke.vol"), bytes).expect("written");
    };
    let parse = |text: &str| scene_file::parse(text, "dense.toml", folder.path());
    let text = format!("{VALID}{SMOKE}");
    // The largest channel's coefficients are 5 + 1 per unit of length.
    write(1.6e8);
    assert!(parse(&text).is_ok());
    write(1.7e8);
    let error = parse(&text).expect_err("too dense").to_string();
    assert!(
        error.contains("medium[3].density.volume.file: found \"smoke.vol\", expected density x (scattering")
            && error.contains("of at most 1e9, but the largest density 1.7e8 times 6e0 is above"),
        "{error}"
    );
    write(1.1e9);
    let clear = text.replace("[5, 4, 3]\nabsorption = 1", "0\nabsorption = 0");
    let error = parse(&clear).expect_err("no density however clear the medium").to_string();
    assert!(error.contains("has density 1100000000 in voxel [0, 0, 0]"), "{error}");
}

#[test]
fn volumes_share_a_bound_on_their_voxels() {
    let folder = meshes();
    std::fs::write(folder.path().join("smoke.vol"), volume([256; 3], &[])).expect("written");
    let text = |count: usize| {
        let media: Vec<String> =
            (0..count).map(|i| SMOKE.replace("smoke\"", &format!("smoke {i}\""))).collect();
        format!("{VALID}{}", media.concat())
    };
    assert!(scene_file::parse(&text(4), "many.toml", folder.path()).is_ok(), "4 x 2²⁴ = 2²⁶");
    let error =
        scene_file::parse(&text(5), "many.toml", folder.path()).expect_err("2²⁶ and more").to_string();
    assert!(
        error.contains("medium[7].density.volume.file") && error.contains("at most 67108864 voxels"),
        "{error}"
    );
}

/// The grid of [`VALID`] reaches from z = -6 to 4, the lights stand at z = 0 and the camera at z = -5.
#[test]
fn an_exponential_density_is_moderate_where_the_scene_is() {
    let folder = meshes();
    let outside = VALID.replace("outside_medium = \"fog\"", "outside_medium = \"air\"");
    let parse = |from: &str, to: &str| {
        assert!(outside.contains(from));
        scene_file::parse(&outside.replacen(from, to, 1), "air.toml", folder.path())
            .map_err(|error| error.to_string())
    };
    // e^(6 / 0.29) = 9.7e8 and e^(6 / 0.289) = 1.04e9.
    assert!(parse("scale_height = 1.5", "scale_height = 0.29").is_ok());
    let error = parse("scale_height = 1.5", "scale_height = 0.289").expect_err("dense");
    let line = VALID.lines().count();
    assert!(
        error.starts_with(&format!("air.toml:{line}: medium[2].density: found a table, expected")),
        "{error}"
    );
    assert!(error.contains(", -6] the density is e^20.8: raise scale_height"), "{error}");
    // e^(4 / 0.194) = 9.0e8 and e^(4 / 0.192) = 1.1e9, upside down.
    assert!(parse("up = [0, 0, 2], scale_height = 1.5", "up = [0, 0, -2], scale_height = 0.194").is_ok());
    let error = parse("up = [0, 0, 2], scale_height = 1.5", "up = [0, 0, -2], scale_height = 0.192");
    assert!(error.expect_err("dense").contains("the density is e^20.8"));
    // 1e8 e^(6 / 1.5) = 5e9, and 1e7 e^(6 / 1.5) = 5e8.
    let error = parse("[0.1, 0.2, 0.4]", "[0.1, 1e8, 0.4]").expect_err("dense");
    assert!(error.contains("the density is e^4.0"), "{error}");
    assert!(parse("[0.1, 0.2, 0.4]", "[0.1, 1e7, 0.4]").is_ok());
    // A light and a camera far below.
    let error = parse("position = [0, 2.5, 0]", "position = [0, 2.5, -60]").expect_err("deep light");
    assert!(error.contains("at [0, 2.5, -60] the density is e^40.0"), "{error}");
    let error =
        parse("position = [0.0, 0.5, -5.0]", "position = [0.0, 0.5, -50.0]").expect_err("deep camera");
    assert!(error.contains("at [0, 0.5, -50] the density is e^33.3"), "{error}");
}

#[test]
fn text_that_is_not_toml_is_refused_with_its_line() {
    for (text, at) in [
        ("[camera\n", 1),
        ("\n\nposition = = 3", 3),
        ("a = 1\na = 2", 2),
        ("[camera]\nwidth = 1\n[camera]\n", 3),
        ("x = \"unfinished", 1),
        ("x = [1, 2\n", 1),
        ("\u{0}", 1),
    ] {
        let error = scene_file::parse(text, "bad.toml", Path::new("")).expect_err("not TOML");
        let SceneError::Syntax { line, .. } = error else { panic!("{text:?}: {error}") };
        // An unfinished value may be noticed at its start or at the end of the text.
        assert!(line.abs_diff(at) <= 1, "{text:?}: line {line}");
    }
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let error = scene_file::load(Path::new("no/such/scene.toml")).expect_err("missing");
    assert!(error.to_string().starts_with("no/such/scene.toml: cannot be read: "), "{error}");
    let folder = meshes();
    let binary = folder.path().join("binary.toml");
    std::fs::write(&binary, [0xff, 0xfe, 0x00]).expect("written");
    let error = scene_file::load(&binary).expect_err("not text");
    assert!(matches!(error, SceneError::Unreadable { .. }), "{error}");
    let endless = folder.path().join("long.toml");
    std::fs::write(&endless, vec![b'#'; (1 << 24) + 1]).expect("written");
    let error = scene_file::load(&endless).expect_err("too long");
    assert!(error.to_string().contains("longer than 16777216 bytes"), "{error}");
}

#[test]
fn a_valid_scene_cut_anywhere_or_with_any_byte_changed_is_read_or_refused() {
    let folder = meshes();
    for end in 0..=VALID.len() {
        let _ = scene_file::parse(&VALID[..end], "cut.toml", folder.path());
    }
    for place in 0..VALID.len() {
        for byte in *b" \n-9e.[]{}\"='#x\0" {
            let mut bytes = VALID.as_bytes().to_vec();
            bytes[place] = byte;
            let text = String::from_utf8(bytes).expect("ASCII");
            let _ = scene_file::parse(&text, "changed.toml", folder.path());
        }
    }
}

#[test]
fn a_density_cut_anywhere_or_with_any_byte_changed_is_read_or_refused() {
    let folder = meshes();
    std::fs::write(folder.path().join("smoke.vol"), volume([2, 1, 1], &[0, 255])).expect("written");
    for end in 0..=SMOKE.len() {
        let _ = scene_file::parse(&format!("{VALID}{}", &SMOKE[..end]), "cut.toml", folder.path());
    }
    for place in 0..SMOKE.len() {
        for byte in *b" \n-9e.[]{}\"='#x\0" {
            let mut bytes = SMOKE.as_bytes().to_vec();
            bytes[place] = byte;
            let text = String::from_utf8(bytes).expect("ASCII");
            let _ = scene_file::parse(&format!("{VALID}{text}"), "changed.toml", folder.path());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12 * ProptestConfig::default().cases))]

    #[test]
    fn a_scene_with_random_edits_is_read_or_refused(
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0usize..40, "\\PC{0,12}"), 1..6)
    ) {
        let mut characters: Vec<char> = VALID.chars().collect();
        for (place, removed, inserted) in edits {
            let start = place.index(characters.len() + 1);
            let end = (start + removed).min(characters.len());
            characters.splice(start..end, inserted.chars());
        }
        let text: String = characters.into_iter().collect();
        let _ = scene_file::parse(&text, "edited.toml", Path::new("no/such/folder"));
    }
}
