//! Lamps and skies that are seen: straight, in mirrors and through glass, against closed forms, and counted once.

use covbeam_render::scene_file;
use covbeam_session::film::Film;
use covbeam_session::pass::Renderer;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};
use covbeam_tests::statistics::Sample;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use std::path::Path;

const SIZE: u32 = 8;
const RADIANCE: DVec3 = DVec3::new(3.0, 2.0, 1.0);
/// Light that the fog scatters is 1e-6 of a lamp's.
const FOG: &str =
    "outside_medium = \"fog\"\n[[medium]]\nname = \"fog\"\nscattering = 1e-7\nabsorption = [0.1, 0.2, 0.4]\n";
const EXTINCTION: DVec3 = DVec3::new(0.1, 0.2, 0.4);
const METHODS: [Method; 4] = [Method::Plain, Method::Covbeam, Method::March, Method::LightTrace];

fn parse(text: &str) -> Scene {
    scene_file::parse(text, "seen lamps", Path::new("")).expect("a valid scene")
}

/// A camera at the origin with a field of view of `angle` degrees.
fn camera(look_at: Vec3, angle: f32) -> String {
    let up = if look_at.x == 0.0 && look_at.z == 0.0 { "up = [0, 0, 1]\n" } else { "" };
    format!(
        "[camera]\nposition = [0, 0, 0]\nlook_at = {:?}\nvertical_fov = {angle}\nwidth = {SIZE}\nheight = {SIZE}\n{up}",
        look_at.to_array()
    )
}

fn pictured(scene: &Scene, method: Method, [paths, passes]: [u32; 2], seed: u32) -> Vec<Vec3> {
    let mut renderer = Renderer::new(scene, Settings::of(method, paths, seed));
    // Of one unit, whatever the lamps are.
    let mut film = Film::new(SIZE, SIZE);
    for pass in 1..=passes {
        film.add(&renderer.pass(pass, &|| false).expect("not cancelled").0).expect("finite");
    }
    film.picture().radiance
}

/// Whether each pixel of each method is as expected, to a share.
fn check(name: &str, text: &str, methods: &[Method], expected: DVec3, tolerance: f64) {
    let scene = parse(text);
    for &method in methods {
        for found in pictured(&scene, method, [200, 1], 1) {
            let off = (found.as_dvec3() - expected).abs().max_element();
            assert!(off <= tolerance * RADIANCE.x, "{name}, {method:?}: {found} for {expected}");
        }
    }
}

fn dimmed(distance: f64) -> DVec3 {
    RADIANCE * (-EXTINCTION * distance).exp()
}

const ROOM: &str = "[[object]]\nshape = \"box\"\nmin = [-9, -9, -9]\nmax = [9, 9, 9]\nmaterial = \"black\"\n";

/// A triangle across the view at z = 3, and its file.
fn triangle(folder: &Path) -> String {
    let file = folder.join("lamp.obj");
    std::fs::write(&file, "v -3 -3 3\nv 3 -3 3\nv 0 5 3\nf 1 2 3\n").expect("written");
    format!("kind = \"mesh\"\nfile = {file:?}\n")
}

/// Each kind of lamp at 3 m, which fills the view: its radiance times what fog leaves. Rays are .7° aslant at most: 7e-5 of the way. From
/// behind those that shine on one side are not there; and where a file says so none is.
#[test]
fn lamps_of_each_kind_are_dimmed_by_the_fog_before_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let spread = 30f64.to_radians();
    let narrow = spread.tan() / (spread.tan() - spread);
    let disk = |towards: i32| {
        format!("kind = \"disk\"\ncenter = [0, 0, 3]\nnormal = [0, 0, {towards}]\nradius = 2\n")
    };
    let rectangle = |edges: [&str; 2]| {
        format!("kind = \"rectangle\"\ncorner = [-1, -1, 3]\nedge_u = {}\nedge_v = {}\n", edges[0], edges[1])
    };
    let area = |edges: [&str; 2], more: &str| {
        format!("kind = \"area\"\ncenter = [0, 0, 3]\nedge_u = {}\nedge_v = {}\n{more}\n", edges[0], edges[1])
    };
    let (x, y) = ("[2, 0, 0]", "[0, 2, 0]");
    let sphere = "kind = \"sphere\"\ncenter = [0, 0, 5]\nradius = 2\n".to_owned();
    for (lamp, factor) in [
        (disk(-1), 1.0),
        (rectangle([y, x]), 1.0),
        (area([y, x], ""), 1.0),
        (area([y, x], "round = true"), 1.0),
        (sphere.clone(), 1.0),
        (triangle(folder.path()), 1.0),
        (disk(1), 0.0),
        (rectangle([x, y]), 0.0),
        (area([x, y], "spread = 30"), 0.0),
        (format!("{sphere}visible = false\n"), 0.0),
        // From inside.
        ("kind = \"sphere\"\ncenter = [0, 0, 1]\nradius = 2\n".to_owned(), 0.0),
    ] {
        let text = format!(
            "{FOG}{}{ROOM}[[light]]\n{lamp}radiance = [3, 2, 1]\n[grid]\ncells = [4, 4, 4]\n",
            camera(Vec3::Z, 1.0)
        );
        check(&lamp, &text, &METHODS, factor * dimmed(3.0), 1e-3);
    }
    // 1e-3°, at most 4e-5 of the tangent of the spread.
    let text = format!(
        "{FOG}{}{ROOM}[[light]]\n{}radiance = [3, 2, 1]\n[grid]\ncells = [4, 4, 4]\n",
        camera(Vec3::Z, 1e-3),
        area([y, x], "spread = 30")
    );
    check("spread", &text, &METHODS, narrow * dimmed(3.0), 1e-3);
}

/// A sky and a wide sun, through 2 m of fog with an end; and where nothing is in the way.
#[test]
fn what_is_infinitely_far_away_is_dimmed_by_all_fog() {
    let box_of_fog = "[[medium]]\nname = \"fog\"\nscattering = 1e-7\nabsorption = [0.1, 0.2, 0.4]\n\
         [[object]]\nshape = \"box\"\nmin = [-2, -2, 1]\nmax = [2, 2, 3]\nmaterial = { dielectric = { index = 1 } }\ninside = \"fog\"\n";
    let sun = format!(
        "kind = \"sun\"\ndirection = [0, 0, -1]\nangle = 60\nvisible = true\nirradiance = {:?}\n",
        (0.25 * PI * RADIANCE).to_array()
    );
    for lamp in ["kind = \"sky\"\nradiance = [3, 2, 1]\n", &sun] {
        for (towards, distance) in [(Vec3::Z, 2.0), (Vec3::new(0.28, 0.0, 0.05), 0.0)] {
            // The sun is not everywhere.
            let expected = if towards.x > 0.0 && lamp == sun { DVec3::ZERO } else { dimmed(distance) };
            let text =
                format!("{box_of_fog}{}[[light]]\n{lamp}[grid]\ncells = [4, 4, 4]\n", camera(towards, 1.0));
            check(lamp, &text, &METHODS, expected, 1e-3);
        }
    }
}

/// Lamps that fill an eighth of a pixel: that has an eighth of their radiance in every pass, and no other has any, whatever the method. On the corner
/// of four pixels each has all of it in a quarter of the passes. Behind a wall none.
#[test]
fn lamps_much_smaller_than_a_pixel_are_no_dots() {
    let folder = tempfile::tempdir().expect("a folder");
    // A pixel's width at distance 1.
    let step = 2.0 * 20f64.to_radians().tan() / f64::from(SIZE);
    let middle = 0.5 * step * 3.0;
    let area = 0.125 * (3.0 * step).powi(2);
    let (side, radius) = (area.sqrt(), (area / PI).sqrt());
    let file = folder.path().join("lamp.obj");
    let lamps = |x: f64| {
        let (low, high) = (x - 0.5 * side, x + 0.5 * side);
        let square =
            format!("v {low} {low} 3\nv {low} {high} 3\nv {high} {high} 3\nv {high} {low} 3\nf 1 2 3 4\n");
        std::fs::write(&file, square).expect("written");
        [
            format!("kind = \"disk\"\ncenter = [{x}, {x}, 3]\nnormal = [0, 0, -1]\nradius = {radius}\n"),
            format!(
                "kind = \"rectangle\"\ncorner = [{low}, {low}, 3]\nedge_u = [0, {side}, 0]\nedge_v = [{side}, 0, 0]\n"
            ),
            format!(
                "kind = \"area\"\ncenter = [{x}, {x}, 3]\nedge_u = [0, {d}, 0]\nedge_v = [{d}, 0, 0]\nround = true\n",
                d = 2.0 * radius
            ),
            format!("kind = \"sphere\"\ncenter = [{x}, {x}, 3]\nradius = {radius}\n"),
            format!("kind = \"mesh\"\nfile = {file:?}\n"),
        ]
    };
    let text = |lamp: &str, wall: &str| {
        let camera = camera(Vec3::Z, 40.0);
        format!("{FOG}{camera}{ROOM}{wall}[[light]]\n{lamp}radiance = [3, 2, 1]\n[grid]\ncells = [4, 4, 4]\n")
    };
    let expected = 0.125 * dimmed(middle.hypot(middle).hypot(3.0));
    let wall = "[[object]]\nshape = \"box\"\nmin = [-1, -1, 1]\nmax = [1, 1, 1.5]\nmaterial = \"black\"\n";
    for lamp in lamps(middle) {
        for (wall, factor) in [("", 1.0), (wall, 0.0)] {
            let scene = parse(&text(&lamp, wall));
            for method in METHODS {
                let found = pictured(&scene, method, [200, 1], 1);
                let lit = found.iter().filter(|value| value.max_element() > 1e-4).count();
                let sum = found.iter().map(|value| value.as_dvec3()).sum::<DVec3>();
                // Over the lamp importance and the way change by less than 1 %; a ball is seen from aside, and its nearest points, by as much.
                let off = (sum - factor * expected).abs().max_element();
                assert!(
                    off < 0.02 * expected.x && lit <= 1,
                    "{lamp}, {method:?}: {sum} for {expected}, {lit} pixels"
                );
            }
        }
    }
    let expected = 0.125 * dimmed(3.0);
    for lamp in lamps(0.0) {
        let scene = parse(&text(&lamp, ""));
        for (method, seed) in METHODS.into_iter().zip(1..) {
            const PASSES: u32 = 200;
            let found = pictured(&scene, method, [10, PASSES], seed);
            let sum = found.iter().map(|value| f64::from(value.x)).sum::<f64>() / expected.x;
            // Four pixels, each of which has all or nothing.
            let error = (4.0 * 0.25 * 0.75 / f64::from(PASSES)).sqrt();
            assert!((sum - 1.0).abs() < 4.5 * error, "{lamp}, {method:?}: {sum}");
        }
    }
}

/// Share of each pixel that a rectangle fills, seen at 1 / `step` pixels a metre; its sides lie along the picture's.
fn filled([low, high]: [[f64; 2]; 2], step: f64) -> Vec<f64> {
    let share = |axis: usize, at: u32| {
        let from = f64::from(at) - f64::from(SIZE) / 2.0;
        let sides = [low[axis] / step - from, high[axis] / step - from].map(|side| side.clamp(0.0, 1.0));
        sides[1] - sides[0]
    };
    // The camera's right hand is at -x, and rows run down.
    (0..SIZE * SIZE)
        .map(|pixel| share(0, SIZE - 1 - pixel % SIZE) * share(1, SIZE - 1 - pixel / SIZE))
        .collect()
}

/// Lamps that fill pixels in part, of the field's cameras: in a few passes of the default method, whose eye rays are few, each pixel has what they
/// fill of it. Of lamps too large to be small in the picture, of one that is thinner than a pixel, with a corner in one, and of one that a wall
/// hides in part.
#[test]
fn borders_of_lamps_are_smooth_after_a_few_passes() {
    const DISTANCE: f64 = 3.0;
    const PASSES: u32 = 4;
    let step =
        |pinhole| if pinhole { 2.0 * DISTANCE * 20f64.to_radians().tan() / f64::from(SIZE) } else { 0.25 };
    let wall = |pinhole| {
        // Half as far away, so half as large if it is seen through a pinhole.
        let edge = 0.37 * step(pinhole) * if pinhole { 0.5 } else { 1.0 };
        format!(
            "[[object]]\nshape = \"box\"\nmin = [{edge}, -9, 1.5]\nmax = [9, 9, 1.6]\nmaterial = \"black\"\n"
        )
    };
    let shapes = [
        ([[-1.63, -1.21], [1.83, 2.33]], false),
        ([[-0.93, -2.21], [-0.85, 2.83]], false),
        ([[-1.02, -1.02], [1.98, 1.98]], false),
        ([[-1.63, -1.21], [1.83, 2.33]], true),
    ];
    for pinhole in [true, false] {
        let step = step(pinhole);
        for (shape, is_hidden) in shapes {
            let [low, high] = shape.map(|corner| corner.map(|at| at * step));
            let mut text = format!("{FOG}{}", camera(Vec3::Z, 40.0));
            if !pinhole {
                let size = step * f64::from(SIZE);
                text = text.replace(
                    "vertical_fov = 40",
                    &format!("projection = \"orthographic\"\nvertical_size = {size}"),
                );
            }
            text += ROOM;
            if is_hidden {
                text += &wall(pinhole);
            }
            let [width, height] = [high[0] - low[0], high[1] - low[1]];
            text += &format!(
                "[[light]]\nkind = \"rectangle\"\ncorner = [{}, {}, {DISTANCE}]\nedge_u = [0, {height}, 0]\n\
                 edge_v = [{width}, 0, 0]\nradiance = [3, 2, 1]\n[grid]\ncells = [4, 4, 4]\n",
                low[0], low[1]
            );
            let seen = if is_hidden { [low, [high[0].min(0.37 * step), high[1]]] } else { [low, high] };
            let found = pictured(&parse(&text), Method::Covbeam, [200, PASSES], 3);
            for (pixel, (found, filled)) in found.iter().zip(filled(seen, step)).enumerate() {
                // At the picture's corners the way is longer than in its middle by a seventh of a tenth of what the fog takes.
                let expected = filled * RADIANCE.x * (-EXTINCTION.x * DISTANCE).exp();
                // 256 even places; of four, and 16 at a wall, a share is known to a quarter and less well.
                let most = if is_hidden { 0.1 } else { 0.04 };
                assert!(
                    (f64::from(found.x) - expected).abs() < (most + 0.05 * filled) * RADIANCE.x,
                    "{pinhole} {shape:?} {is_hidden}, pixel {pixel}: {found} for {expected}"
                );
            }
        }
    }
}

/// In a mirror at 45°, and through a plate without absorption, whose two sides let (1 - R)/(1 + R) of the light through.
#[test]
fn lamps_are_seen_in_mirrors_and_through_glass() {
    let lamp = "[[light]]\nkind = \"disk\"\ncenter = [3, 0, 2]\nnormal = [-1, 0, 0]\nradius = 1\nradiance = [3, 2, 1]\n[grid]\ncells = [4, 4, 4]\n";
    let mirror = "[[object]]\nshape = \"rectangle\"\ncorner = [-1, -1, 1]\nedge_u = [2, 0, 2]\nedge_v = [0, 2, 0]\n\
         material = { mirror = { reflectance = 0.8 } }\n";
    let metal =
        mirror.replace("{ mirror = { reflectance = 0.8 } }", "{ metal = { reflectance = 0.8, edge = 0.8 } }");
    let eyes = &METHODS[..3];
    let text = format!("{FOG}{}{ROOM}{mirror}{lamp}", camera(Vec3::Z, 1.0));
    check("mirror", &text, eyes, 0.8 * dimmed(5.0), 1e-3);
    check("metal", &text.replace(mirror, &metal), eyes, 0.8 * dimmed(5.0), 1e-3);
    let glass = "[[object]]\nshape = \"box\"\nmin = [-4, -4, 1]\nmax = [4, 4, 2]\nmaterial = { dielectric = { index = 1.5 } }\n";
    let behind = lamp.replace("[3, 0, 2]\nnormal = [-1, 0, 0]", "[0, 0, 4]\nnormal = [0, 0, -1]");
    let text = format!("{FOG}{}{ROOM}{glass}{behind}", camera(Vec3::Z, 1.0));
    let through = 0.96 / 1.04;
    // What is reflected inside, 1.6e-3 of the light, comes by chance in pieces of up to .02: 6e-3 a path, and of 1,024 paths 2e-4.
    let scene = parse(&text);
    for &method in eyes {
        let picture = pictured(&scene, method, [200, 16], 1);
        let mean = picture.iter().map(|color| color.as_dvec3()).sum::<DVec3>() / picture.len() as f64;
        let off = (mean / (through * dimmed(3.0)) - 1.0).abs().max_element();
        assert!(off < 1e-3, "glass, {method:?}: {mean}");
    }
    // A pane that lets half of it through, with the lamp before, in and behind it.
    let pane = "[[object]]\nshape = \"rectangle\"\ncorner = [-4, -4, 3]\nedge_u = [0, 8, 0]\nedge_v = [8, 0, 0]\nmaterial = { lobes = { transparent = 0.5 } }\n";
    for (place, share) in [("2.9", 1.0), ("3", 1.0), ("3.1", 0.5)] {
        let lamp = behind.replace("[0, 0, 4]", &format!("[0, 0, {place}]"));
        let text = format!("{FOG}{}{ROOM}{pane}{lamp}", camera(Vec3::Z, 1.0));
        let distance: f64 = place.parse().expect("a number");
        check(place, &text, &METHODS, share * dimmed(distance), 1e-3);
    }
}

/// People hang lamps into ceilings, walls and faces of fog: all in one plane, in any order. Numbers that are not whole, and rays up to 45° aslant.
#[test]
fn a_lamp_in_the_plane_of_a_ceiling_is_seen_from_below_and_from_nowhere_else() {
    let ceiling = |corner: &str| {
        format!(
            "[[object]]\nshape = \"rectangle\"\ncorner = {corner}\nedge_u = [0, 0, 40]\nedge_v = [40, 0, 0]\nmaterial = \"black\"\n"
        )
    };
    let fog = |min: &str, max: &str| {
        format!(
            "[[object]]\nshape = \"box\"\nmin = {min}\nmax = {max}\nmaterial = {{ dielectric = {{ index = 1 }} }}\ninside = \"fog\"\n"
        )
    };
    let medium = "[[medium]]\nname = \"fog\"\nscattering = 1e-7\nabsorption = 0\n";
    let [above, below] = [("2.7", "4.1"), ("0.3", "2.7")]
        .map(|(low, high)| fog(&format!("[-20, {low}, -20]"), &format!("[20, {high}, 20]")));
    let ceiling = ceiling("[-20, 2.7, -20]");
    let lamp = "[[light]]\nkind = \"rectangle\"\ncorner = [-15, 2.7, -15]\nedge_u = [30, 0, 0]\nedge_v = [0, 0, 30]\nradiance = [3, 2, 1]\n";
    // The whole room is fog's box, too.
    let room =
        "[[object]]\nshape = \"box\"\nmin = [-20, -1.3, -20]\nmax = [20, 2.7, 20]\nmaterial = \"black\"\n";
    for parts in [
        vec![&ceiling],
        vec![&ceiling, &below],
        vec![&below, &ceiling],
        vec![&above, &ceiling, &below],
        vec![&below, &above],
        vec![&above, &below],
    ] {
        let objects: String = parts.into_iter().map(String::as_str).collect();
        for (y, expected) in [(0.0, RADIANCE), (2.0, RADIANCE), (3.9, DVec3::ZERO), (5.3, DVec3::ZERO)] {
            let towards = Vec3::new(0.1, if y < 2.7 { y + 1.0 } else { y - 1.0 }, 0.2);
            let eye =
                camera(towards, 60.0).replace("position = [0, 0, 0]", &format!("position = [0, {y}, 0]"));
            let text = format!("{medium}{eye}{objects}{lamp}[grid]\ncells = [4, 4, 4]\n");
            check(&format!("{y}, {objects}"), &text, &METHODS, expected, 1e-3);
        }
    }
    let eye = camera(Vec3::new(0.1, 1.0, 0.2), 60.0);
    for objects in [format!("{room}{below}"), format!("{below}{room}")] {
        let text = format!("{medium}{eye}{objects}{lamp}[grid]\ncells = [4, 4, 4]\n");
        check(&objects, &text, &METHODS, RADIANCE, 1e-3);
    }
}

/// Under an even sky everything that absorbs nothing is as bright as the sky, if each way of the light is counted once: fog, a diffuse ball, a mirror
/// ball, a glass ball with and without fog.
#[test]
fn everything_that_absorbs_nothing_is_as_bright_as_the_even_sky() {
    let ball = |x: f32, material: &str| {
        format!("[[object]]\nshape = \"sphere\"\ncenter = [{x}, 0, 6]\nradius = 0.8\nmaterial = {material}\n")
    };
    let text = [
        &camera(Vec3::Z, 45.0),
        "[[medium]]\nname = \"fog\"\nscattering = 0.3\nabsorption = 0\n",
        "[[object]]\nshape = \"box\"\nmin = [-3, -2.5, 4]\nmax = [3, 0.1, 8]\nmaterial = { dielectric = { index = 1 } }\ninside = \"fog\"\n",
        &ball(-2.0, "{ lambert = { albedo = 1 } }"),
        &ball(0.0, "{ mirror = { reflectance = 1 } }"),
        &ball(2.0, "{ dielectric = { index = 1.5 } }"),
        "[[light]]\nkind = \"sky\"\nradiance = 2\n[grid]\ncells = [8, 8, 8]\n[render]\nradius = 0.1\n",
    ]
    .concat();
    let scene = parse(&text);
    for method in [Method::Plain, Method::Covbeam] {
        let means: Vec<f64> = (0..8)
            .map(|seed| {
                let radiance = pictured(&scene, method, [1000, 8], seed);
                radiance.iter().map(|color| f64::from(color.x)).sum::<f64>() / radiance.len() as f64
            })
            .collect();
        let found = Sample::of(&means);
        println!("{method:?}: {found:?}");
        // Kernels lose some light beside faces and ball: 1 % of what comes from fog, half of it.
        assert!((found.mean - 2.0).abs() < 0.01 + 4.0 * found.error, "{method:?}: {found:?}");
        assert!(found.error < 0.02, "too noisy to tell: {found:?}");
    }
}

/// Where a lamp is not in sight, rough metal and diffuse walls that it lights are the same bits whether it would be seen or not.
#[test]
fn surfaces_that_a_lamp_lights_do_not_see_it_again() {
    let text = format!(
        "{FOG}{}{ROOM}[[object]]\nshape = \"rectangle\"\ncorner = [-4, -1, 0]\nedge_u = [0, 0, 8]\nedge_v = [8, 0, 0]\n\
         material = {{ lobes = {{ metal = 0.9, roughness = 0.4, diffuse = 0.1 }} }}\n\
         [[object]]\nshape = \"sphere\"\ncenter = [0.5, -0.5, 4]\nradius = 0.5\nmaterial = {{ lambert = {{ albedo = 0.5 }} }}\n\
         [[light]]\nkind = \"disk\"\ncenter = [0, 5, 5]\nnormal = [0, -1, 0]\nradius = 2\nradiance = 9\n[grid]\ncells = [4, 4, 4]\n",
        camera(Vec3::new(0.0, -1.0, 4.0), 15.0)
    );
    let hidden = text.replace("radiance = 9\n", "radiance = 9\nvisible = false\n");
    for method in METHODS {
        let [seen, unseen] = [&text, &hidden].map(|text| pictured(&parse(text), method, [200, 2], 1));
        assert!(seen.iter().any(|color| color.x > 1e-3), "{method:?}");
        assert_eq!(seen, unseen, "{method:?}");
    }
}
