//! Marching beside plain beams: lamps of all kinds and spreads in a box of thin fog, seen from the side.

use covbeam_render::scene_file;
use covbeam_session::film::Film;
use covbeam_session::pass::Renderer;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};
use covbeam_tests::statistics::Sample;
use std::path::Path;

/// Pixels a side; the picture is 2 m wide, as the box of fog is.
const SIZE: u32 = 16;
/// Light paths of a pass, and passes of plain beams.
const PATHS: u32 = 4000;
const PASSES: u32 = 12;

/// Light scattered twice is 1e-3 of it at most.
fn scene(light: &str) -> Scene {
    let text = format!(
        "[camera]\nposition = [0, 0, -6]\nlook_at = [0, 0, 0]\nprojection = \"orthographic\"\nvertical_size = 2\n\
         width = {SIZE}\nheight = {SIZE}\n[[medium]]\nname = \"fog\"\nscattering = 1e-3\nabsorption = 0.2\n\
         phase = \"isotropic\"\n[[object]]\nshape = \"box\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n\
         material = {{ dielectric = {{ index = 1 }} }}\ninside = \"fog\"\n[[light]]\n{light}\nvisible = false\n\
         [grid]\ncells = [12, 12, 12]\n[render]\nradius = 0.03\nmax_radius = 0.06\n"
    );
    scene_file::parse(&text, "march", Path::new("")).expect("a valid scene")
}

/// The sum of a picture's light, by runs of passes with seeds of their own.
fn sums(scene: &Scene, method: Method, paths: u32, passes: u32) -> Sample {
    let runs: Vec<f64> = (0..4)
        .map(|run| {
            let mut film = Film::of_scene(scene);
            for seed in 0..passes {
                let renderer = &mut Renderer::new(scene, Settings::of(method, paths, passes * run + seed));
                film.add(&renderer.pass(1, &|| false).expect("not cancelled").0).expect("finite");
            }
            film.picture().radiance.iter().map(|color| f64::from(color.x)).sum()
        })
        .collect();
    Sample::of(&runs)
}

/// What leaves the picture at its border is as much as what kernels blur into it: lamps shine across its middle.
fn check(name: &str, light: &str) {
    check_by(16, name, light);
}

/// The same by so many marching passes: few eye rays meet light that is thinner than a pixel.
fn check_by(passes: u32, name: &str, light: &str) {
    let scene = scene(light);
    let beams = sums(&scene, Method::Plain, PATHS, PASSES);
    let march = sums(&scene, Method::March, 500, passes);
    let ratio = march.mean / beams.mean;
    let error = march.error.hypot(beams.error) / beams.mean;
    println!("{name}: {ratio:.4} ± {:.4} of ± {:.4}", march.error / beams.mean, beams.error / beams.mean);
    assert!(error < 0.03, "{name}: too noisy to tell, {error}");
    // Kernels are 1.5 % of the picture wide: of light that is as 1/r they move so much over the border at most.
    assert!((ratio - 1.0).abs() < 0.015 + 4.0 * error, "{name}: {ratio} ± {error}");
}

#[test]
fn lamps_of_all_kinds_have_the_light_of_plain_beams() {
    let lamps = [
        ("point", "kind = \"point\"\nposition = [0.1, 0.2, 0.1]\nintensity = 1"),
        (
            "spot",
            "kind = \"spot\"\nposition = [-0.9, 0, 0]\nlook_at = [1, 0.3, 0.2]\nintensity = 1\ninner_angle = 2\nouter_angle = 9",
        ),
        (
            "disk",
            "kind = \"disk\"\ncenter = [-0.5, 0, 0]\nnormal = [1, 0.2, 0.3]\nradius = 0.2\nradiance = 1",
        ),
        (
            "rectangle",
            "kind = \"rectangle\"\ncorner = [-0.5, -0.1, 0]\nedge_u = [0, 0.3, 0.1]\nedge_v = [0, 0, 0.3]\nradiance = 1",
        ),
        ("sphere", "kind = \"sphere\"\ncenter = [0, 0.1, 0.2]\nradius = 0.2\nradiance = 1"),
        ("sun", "kind = \"sun\"\ndirection = [0.3, -1, 0.2]\nirradiance = 1"),
        ("wide sun", "kind = \"sun\"\ndirection = [0.3, -1, 0.2]\nangle = 40\nirradiance = 1"),
        ("sky", "kind = \"sky\"\nradiance = 1"),
    ];
    for (name, light) in lamps {
        check_by(if name == "spot" { 128 } else { 16 }, name, light);
    }
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("lamp.obj");
    std::fs::write(&file, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        .expect("written");
    check("mesh", &format!("kind = \"mesh\"\nfile = {file:?}\nscale = 0.4\nradiance = 1"));
}

#[test]
fn blender_s_lamps_have_the_light_of_plain_beams() {
    let lamp = "kind = \"lamp\"\nposition = [-0.6, 0, 0]\nintensity = 1";
    for (radius, soft) in [("", false), ("radius = 0.2", false), ("radius = 0.2", true)] {
        check(&format!("all around, {radius}, {soft}"), &format!("{lamp}\n{radius}\nsoft = {soft}"));
        // Few eye rays meet cones that are thinner than a pixel: those of points, and where soft ones begin.
        let narrow = [(0.5, 0.0), (4.0, 0.5)].into_iter().filter(|_| !(radius.is_empty() || soft));
        for (angle, blend) in narrow.chain([(40.0, 1.0), (90.0, 0.1)]) {
            let cone = format!("cone = {{ look_at = [1, 0.2, 0.1], angle = {angle}, blend = {blend} }}");
            check(
                &format!("{angle}°, {radius}, {soft}"),
                &format!("{lamp}\n{radius}\nsoft = {soft}\n{cone}"),
            );
        }
    }
}

/// From a narrow beam to a Lambert surface. Spreads are half-angles; of three features each two come together in all ways.
#[test]
fn areas_of_all_spreads_have_the_light_of_plain_beams() {
    for (number, spread) in (0..).zip([0.5, 10.0, 29.0, 90.0]) {
        for round in [false, true] {
            let edge_v = if round == (number % 2 == 0) { "[0, 0, 0.3]" } else { "[0, 0.05, 0.1]" };
            let light = format!(
                "kind = \"area\"\ncenter = [-0.8, 0.05, 0]\nedge_u = [0, 0.3, 0]\nedge_v = {edge_v}\nradiance = 1\n\
                 round = {round}\nspread = {spread}"
            );
            let passes = if spread < 10.0 { 48 } else { 16 };
            check_by(passes, &format!("{spread}°, {edge_v}, {round}"), &light);
        }
    }
}
