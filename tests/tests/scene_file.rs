//! Scene files: the shipped ones are what they claim, and whatever is wrong is refused with file, line and field.

use std::path::{Path, PathBuf};

use covbeam::{Kernel, PhaseFunction, PhaseKind};
use covbeam_render::scene::{Light, Material, Scene, Shape};
use covbeam_render::scene_file::SceneError;
use glam::Vec3;
use proptest::prelude::*;

/// A valid scene that uses every field; the tests below break it.
const VALID: &str = r#"outside_medium = "fog"
[camera]
position = [0.0, 0.5, -5.0]
look_at = [0, 0, 0]
up = [0, 2, 0]
vertical_fov = 35
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
"#;

const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

/// A folder with the mesh that [`VALID`] names, an open one and a broken one.
fn meshes() -> tempfile::TempDir {
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
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes").join(name)
}

#[test]
fn every_field_arrives() {
    let folder = meshes();
    let scene = Scene::parse(VALID, "valid.toml", folder.path()).expect("valid");
    assert_eq!(scene.outside, Some(0));
    assert_eq!((scene.camera.width, scene.camera.height), (64, 32));
    assert!((scene.camera.tan_half_height - 17.5f32.to_radians().tan()).abs() < 1e-7);
    assert_eq!(scene.camera.right, Vec3::NEG_X);
    assert_eq!(scene.media[0].scattering, Vec3::new(0.2, 0.3, 0.4));
    assert_eq!(scene.media[0].absorption, Vec3::splat(0.02));
    assert_eq!(scene.media[0].phase, PhaseFunction { kind: PhaseKind::HenyeyGreenstein, asymmetry: 0.7 });
    assert_eq!(scene.media[1].phase.kind, PhaseKind::Rayleigh);
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
    assert_eq!(scene.grid.cells, [8, 16, 32]);
    let settings = scene.settings;
    assert_eq!((settings.passes, settings.photons, settings.seed), (3, 1000, 7));
    assert_eq!((settings.radius, settings.alpha, settings.error), (0.05, 0.6, 0.02));
    assert_eq!((settings.max_radius, settings.light_field_share), (0.3, 0.2));
    assert_eq!(settings.kernel, Kernel::Biweight);
}

/// The figures of scenes G and O, written out again from their specification.
#[test]
fn the_ball_scenes_are_the_ones_that_were_measured_elsewhere() {
    for (name, material) in
        [("glass-ball.toml", Material::Dielectric { index: 1.5 }), ("black-ball.toml", Material::Black)]
    {
        let scene = Scene::load(&shipped(name)).expect("shipped scenes are valid");
        let fog = scene.media[scene.outside.expect("fog outside") as usize];
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
        assert!((camera.tan_half_height - 17.5f32.to_radians().tan()).abs() < 1e-7);
        assert_eq!((scene.grid.min, scene.grid.max), (Vec3::new(-4.0, -1.5, -6.0), Vec3::new(4.0, 4.5, 4.0)));
        assert_eq!(scene.grid.cells, [32; 3]);
        // The floor is lit from above: its normal is up.
        let hit = scene.intersect(Vec3::new(2.0, 0.0, 0.0), Vec3::NEG_Y, f32::INFINITY).expect("the floor");
        assert_eq!((hit.object, hit.normal), (1, Vec3::Y));
    }
}

#[test]
fn every_shipped_scene_is_valid_and_its_camera_stands_outside_all_glass() {
    let folder = std::fs::read_dir(shipped("")).expect("the scenes folder");
    let files: Vec<PathBuf> = folder.map(|entry| entry.expect("readable").path()).collect();
    let scenes: Vec<_> = files.iter().filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    assert!(scenes.len() >= 2);
    for path in scenes {
        let scene = Scene::load(path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scene.containing(scene.camera.position), [0u32; 0], "{}", path.display());
        assert!(scene.intersect(scene.camera.position, scene.camera.forward, f32::INFINITY).is_some());
    }
}

#[test]
fn what_a_file_does_not_say_has_a_default() {
    let text = "[camera]\nposition=[0,0,-9]\nlook_at=[0,0,0]\nvertical_fov=40\nwidth=8\nheight=8\n\
                [[object]]\nshape=\"box\"\nmin=[-1,-2,-3]\nmax=[4,5,6]\nmaterial=\"black\"\n\
                [[object]]\nshape=\"sphere\"\ncenter=[0,0,0]\nradius=10\nmaterial=\"black\"\n\
                [[light]]\nkind=\"point\"\nposition=[0,1,0]\nintensity=1\n";
    let scene = Scene::parse(text, "small.toml", Path::new("")).expect("valid");
    assert_eq!((scene.outside, scene.camera.up), (None, Vec3::Y));
    assert_eq!(
        (scene.grid.min, scene.grid.max, scene.grid.cells),
        (Vec3::splat(-10.0), Vec3::splat(10.0), [32; 3])
    );
    let settings = scene.settings;
    assert_eq!((settings.passes, settings.photons, settings.alpha), (64, 5000, 0.5));
    assert_eq!(settings.max_radius, 4.0 * settings.radius);
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
    ("width = 64", "width = 0", 0, "camera.width", "1 to 16384"),
    ("height = 32", "height = 16385", 0, "camera.height", "1 to 16384"),
    ("photons = 1000", "photons = 0", 0, "render.photons", "268435456"),
    ("photons = 1000", "photons = 268435457", 0, "render.photons", "268435456"),
    ("passes = 3", "passes = 0", 0, "render.passes", "from 1"),
    ("seed = 7", "seed = 4294967296", 0, "render.seed", "4294967295"),
    ("radius = 0.05", "radius = 0", 0, "render.radius", "length"),
    ("alpha = 0.6", "alpha = 1", 0, "render.alpha", "between 0 and 1"),
    ("error = 0.02", "error = 0", 0, "render.error", "0.000001"),
    ("max_radius = 0.3", "max_radius = 0.04", 0, "render.max_radius", "at least radius = 0.05"),
    ("light_field_share = 0.2", "light_field_share = 1.5", 0, "render.light_field_share", "..=1"),
    ("cells = [8, 16, 32]", "cells = [8, 0, 32]", 0, "grid.cells[1]", "from 1"),
    ("cells = [8, 16, 32]", "cells = [512, 512, 512]", 0, "grid.cells", "16777216"),
    ("cells = [8, 16, 32]", "cells = [16777216, 16777216, 16777216]", 0, "grid.cells", "16777216"),
    ("cells = [8, 16, 32]", "cells = 32", 0, "grid.cells", "three"),
    ("scale = 0.5", "scale = 0", 0, "object[3].scale", "length"),
    ("degrees = 90", "degrees = 1e5", 0, "object[3].rotate.degrees", "degrees"),
    // Contradictions.
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
    ("outside_medium = \"fog\"", "outside_medium = \"mist\"", 0, "outside_medium", "fog, milk"),
    ("inside = \"milk\"", "inside = \"beer\"", 0, "object[0].inside", "fog, milk"),
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
fn whatever_is_wrong_is_refused_with_file_line_field_and_expectation() {
    let folder = meshes();
    for &(text, replacement, offset, path, part) in WRONG {
        let place = VALID.find(text).unwrap_or_else(|| panic!("{text:?} is not in the valid scene"));
        let at = (1 + VALID[..place].matches('\n').count()).saturating_add_signed(offset);
        let broken = VALID.replacen(text, replacement, 1);
        match Scene::parse(&broken, "broken.toml", folder.path()) {
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

#[test]
fn an_error_reads_as_one_line() {
    let broken = VALID.replace("radius = 0.5\n", "radius = -0.5\n");
    let error = Scene::parse(&broken, "fog.toml", Path::new("")).expect_err("negative");
    assert_eq!(
        error.to_string(),
        "fog.toml:23: object[0].radius: found -0.5, expected a length in 1e-9..=1e9"
    );
}

#[test]
fn a_scene_without_lights_or_camera_or_a_box_to_fill_is_refused() {
    let folder = meshes();
    let dark = &VALID[..VALID.find("[[light]]").expect("present")];
    let error = Scene::parse(dark, "dark.toml", folder.path()).expect_err("no light");
    assert_eq!(error.to_string(), "dark.toml:1: light: found nothing, expected at least one [[light]]");
    let blind = VALID.replace("[camera]", "[render2]");
    assert!(Scene::parse(&blind, "blind.toml", folder.path()).is_err());
    let flat = "[camera]\nposition=[0,0,-9]\nlook_at=[0,0,0]\nvertical_fov=40\nwidth=8\nheight=8\n\
                [[object]]\nshape=\"rectangle\"\ncorner=[0,0,0]\nedge_u=[1,0,0]\nedge_v=[0,1,0]\nmaterial=\"black\"\n\
                [[light]]\nkind=\"point\"\nposition=[0,1,0]\nintensity=1\n";
    let error = Scene::parse(flat, "flat.toml", Path::new("")).expect_err("no volume");
    assert!(error.to_string().starts_with("flat.toml:1: grid: found nothing, expected [grid]"), "{error}");
}

#[test]
fn a_missing_broken_or_open_mesh_is_refused_where_it_is_named() {
    let folder = meshes();
    let parse = |text: &str| Scene::parse(text, "m.toml", folder.path()).expect_err("refused").to_string();
    let missing = parse(&VALID.replace("tetrahedron.obj", "none.obj"));
    assert!(
        missing.starts_with("m.toml:39: object[3].file: mesh ") && missing.contains("cannot be read"),
        "{missing}"
    );
    let folder_itself = parse(&VALID.replace("tetrahedron.obj", "."));
    assert!(folder_itself.contains("is not a regular file"), "{folder_itself}");
    let broken = parse(&VALID.replace("tetrahedron.obj", "broken.obj"));
    assert!(broken.contains("broken.obj: line 2: found `nan`, expected a finite number"), "{broken}");
    let huge = parse(&VALID.replace("scale = 0.5", "scale = 1e9").replace("[1, 2, 3]", "[-9e8, 0, 0]"));
    assert!(huge.starts_with("m.toml:39: object[3].file: mesh ") && huge.contains("±1e9"), "{huge}");
    let glass = VALID.replace("{ mirror = { reflectance = 0.9 } }", "{ dielectric = { index = 1.5 } }");
    assert!(Scene::parse(&glass, "m.toml", folder.path()).is_ok(), "a tetrahedron is closed");
    let open = parse(&glass.replace("tetrahedron.obj", "open.obj"));
    assert!(open.starts_with("m.toml:44: object[3].material") && open.contains("3 open edges"), "{open}");
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
        let error = Scene::parse(text, "bad.toml", Path::new("")).expect_err("not TOML");
        let SceneError::Syntax { line, .. } = error else { panic!("{text:?}: {error}") };
        // An unfinished value may be noticed at its start or at the end of the text.
        assert!(line.abs_diff(at) <= 1, "{text:?}: line {line}");
    }
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let error = Scene::load(Path::new("no/such/scene.toml")).expect_err("missing");
    assert!(error.to_string().starts_with("no/such/scene.toml: cannot be read: "), "{error}");
    let folder = meshes();
    let binary = folder.path().join("binary.toml");
    std::fs::write(&binary, [0xff, 0xfe, 0x00]).expect("written");
    let error = Scene::load(&binary).expect_err("not text");
    assert!(matches!(error, SceneError::Unreadable { .. }), "{error}");
    let endless = folder.path().join("long.toml");
    std::fs::write(&endless, vec![b'#'; (1 << 24) + 1]).expect("written");
    let error = Scene::load(&endless).expect_err("too long");
    assert!(error.to_string().contains("longer than 16777216 bytes"), "{error}");
}

#[test]
fn a_valid_scene_cut_anywhere_or_with_any_byte_changed_is_read_or_refused() {
    let folder = meshes();
    for end in 0..=VALID.len() {
        let _ = Scene::parse(&VALID[..end], "cut.toml", folder.path());
    }
    for place in 0..VALID.len() {
        for byte in *b" \n-9e.[]{}\"='#x\0" {
            let mut bytes = VALID.as_bytes().to_vec();
            bytes[place] = byte;
            let text = String::from_utf8(bytes).expect("ASCII");
            let _ = Scene::parse(&text, "changed.toml", folder.path());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(3000) })]

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
        let _ = Scene::parse(&text, "edited.toml", Path::new("no/such/folder"));
    }
}
