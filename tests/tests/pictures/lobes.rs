//! Surfaces of several lobes, by closed forms and by estimators that share nothing: transparent panes, and what rough metal shows.

use covbeam_render::scene_file;
use covbeam_session::scene::Scene;
use covbeam_session::settings::Method;
use covbeam_tests::rows::{check, rows, runs, runs_of};
use covbeam_tests::statistics::Sample;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::path::Path;

/// Pixels a side.
const SIZE: u32 = 10;
/// \[W/m²\]
const IRRADIANCE: f64 = 2.0;
/// Of the metal.
const ROUGHNESS: f64 = 0.5;
const REFLECTANCE: f64 = 0.7;

fn parse(text: &str) -> Scene {
    scene_file::parse(text, "lobes", Path::new(".")).expect("a valid scene")
}

/// Rows that are looked at together where they are noisy.
const HALF: usize = SIZE as usize / 2;

/// Sunlight through a pane, scattered by a box of thin fog, seen through another one: in each channel the square of what a pane lets through.
#[test]
fn panes_let_their_share_of_the_light_through() {
    const SCATTERING: f64 = 1e-4;
    let transparent = [0.25, 0.5, 0.75];
    let scene = parse(&format!(
        "[camera]\nposition = [0, 0, -40]\nlook_at = [0, 0, 0]\nvertical_fov = {}\nwidth = {SIZE}\nheight = {SIZE}\n\
         [[medium]]\nname = \"fog\"\nscattering = {SCATTERING}\nabsorption = 0\n\
         [[object]]\nshape = \"box\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\nmaterial = {{ dielectric = {{ index = 1 }} }}\ninside = \"fog\"\n\
         [[object]]\nshape = \"rectangle\"\ncorner = [-3, 2, -3]\nedge_u = [0, 0, 6]\nedge_v = [6, 0, 0]\n\
         material = {{ lobes = {{ transparent = {transparent:?} }} }}\n\
         [[object]]\nshape = \"rectangle\"\ncorner = [-3, -3, -4]\nedge_u = [0, 6, 0]\nedge_v = [6, 0, 0]\n\
         material = {{ lobes = {{ transparent = {transparent:?} }} }}\n\
         [[light]]\nkind = \"sun\"\ndirection = [0, -1, 0]\nirradiance = {IRRADIANCE}\n\
         [grid]\ncells = [12, 12, 12]\n[render]\nradius = 0.05\nmax_radius = 0.1\n",
        2.0 * (0.8f64 / 40.0).atan().to_degrees()
    ));
    let clear = SCATTERING / (4.0 * PI) * IRRADIANCE * 2.0;
    // Passes, and how well they must know a row.
    let methods = [
        (Method::Plain, 8, 0.02),
        (Method::Thesis, 4, 0.01),
        (Method::March, 2, 0.01),
        (Method::LightTrace, 8, 0.03),
    ];
    for (method, passes, noise) in methods {
        let runs = runs(&scene, method, passes);
        for (channel, share) in transparent.iter().enumerate() {
            for (y, found) in rows(&runs, channel, 1).iter().enumerate() {
                // Kernels and filters may bias by 1 %, as in the tests of the sun.
                let name = format!("{method:?}, channel {channel}, row {y}");
                check(&name, found, clear * share * share, [0.012, noise]);
            }
        }
    }
}

/// GGX with Smith's masking, shadowing correlated by height, and Schlick's curve: from the papers.
fn metal(normal: DVec3, a: DVec3, b: DVec3) -> f64 {
    let (alpha2, half) = (ROUGHNESS.powi(4), (a + b).normalize());
    let tan2 = |v: DVec3| 1.0 / v.dot(normal).powi(2) - 1.0;
    let density = alpha2 / (PI * half.dot(normal).powi(4) * (alpha2 + tan2(half)).powi(2));
    let hidden = |v: DVec3| ((1.0 + alpha2 * tan2(v)).sqrt() - 1.0) / 2.0;
    let fresnel = REFLECTANCE + (1.0 - REFLECTANCE) * (1.0 - half.dot(a)).powi(5);
    fresnel * density / (4.0 * a.dot(normal) * b.dot(normal) * (1.0 + hidden(a) + hidden(b)))
}

/// A metal floor, seen from one side.
fn floor_scene(rest: &str) -> Scene {
    parse(&format!(
        "[camera]\nposition = [0, 3, -4]\nlook_at = [0, 0, 0]\nvertical_fov = 12\nwidth = {SIZE}\nheight = {SIZE}\n\
         [[object]]\nshape = \"rectangle\"\ncorner = [-3, 0, -3]\nedge_u = [0, 0, 6]\nedge_v = [6, 0, 0]\n\
         material = {{ metal = {{ reflectance = {REFLECTANCE}, roughness = {ROUGHNESS} }} }}\n{rest}"
    ))
}

/// The mean over rows of what a place on the floor sends to the camera, given its direction from there.
fn expected(scene: &Scene, [from, to]: [usize; 2], radiance: impl Fn(DVec3, DVec3) -> f64) -> f64 {
    // Two by two places in a pixel.
    let at = |number: usize| (number as f32 + 0.5) / 2.0;
    let places = (2 * from..2 * to).flat_map(|y| (0..2 * SIZE as usize).map(move |x| [at(x), at(y)]));
    let count = 4 * (to - from) * SIZE as usize;
    let radiances = places.map(|[x, y]| {
        let direction = scene.camera.direction(x, y).as_dvec3();
        let camera = scene.camera.position.as_dvec3();
        radiance(camera - camera.y / direction.y * direction, -direction)
    });
    radiances.sum::<f64>() / count as f64
}

/// A highlight: the lamp's light on the floor, times the scattering function.
#[test]
fn rough_metal_under_a_lamp_is_the_closed_form() {
    let lamp = DVec3::new(0.5, 2.5, 3.0);
    let scene = floor_scene(&format!(
        "[[light]]\nkind = \"point\"\nposition = [{}, {}, {}]\nintensity = 3\n[grid]\ncells = [4, 4, 4]\n",
        lamp.x, lamp.y, lamp.z
    ));
    for (method, passes, noise) in [
        (Method::Plain, 16, 0.01),
        (Method::Thesis, 16, 0.01),
        (Method::March, 16, 0.01),
        (Method::LightTrace, 60, 0.02),
    ] {
        for (y, found) in rows(&runs(&scene, method, passes), 0, HALF).iter().enumerate() {
            let expected = expected(&scene, [y * HALF, (y + 1) * HALF], |place, view| {
                let (offset, up) = (lamp - place, DVec3::Y);
                let towards = offset.normalize();
                3.0 * metal(up, view, towards) * towards.y / offset.length_squared()
            });
            check(&format!("{method:?}, row {y}"), found, expected, [0.01, noise]);
        }
    }
}

/// A lamp behind a slab of frosted glass: of light across a slab (1 - R)/(1 + R) gets through, R what a side reflects; and light that is spread by
/// less than a degree finds the lamp.
#[test]
fn lamps_are_seen_through_rough_glass() {
    let reflected = (0.5f64 / 2.5).powi(2);
    let through = (1.0 - reflected) / (1.0 + reflected);
    let lamps = [
        ("kind = \"disk\"\ncenter = [0, 0, 6]\nnormal = [0, 0, -1]\nradius = 2\nradiance = 3", 3.0),
        ("kind = \"sphere\"\ncenter = [0, 0, 8]\nradius = 2\nradiance = 3", 3.0),
        (
            "kind = \"rectangle\"\ncorner = [-2, -2, 6]\nedge_u = [0, 4, 0]\nedge_v = [4, 0, 0]\nradiance = 3",
            3.0,
        ),
        ("kind = \"sun\"\ndirection = [0, 0, -1]\nangle = 60\nirradiance = 3", 3.0 / (PI * 0.25)),
    ];
    for (lamp, radiance) in lamps {
        let scene = parse(&format!(
            "[camera]\nposition = [0, 0, -10]\nlook_at = [0, 0, 0]\nvertical_fov = 2\nwidth = {SIZE}\nheight = {SIZE}\n\
             [[object]]\nshape = \"box\"\nmin = [-9, -9, 0]\nmax = [9, 9, 1]\nmaterial = {{ dielectric = {{ index = 1.5, roughness = 0.1 }} }}\n\
             [[light]]\n{lamp}\n[grid]\ncells = [4, 4, 4]\n[render]\nphotons = 100\nradius = 0.1\n"
        ));
        for method in [Method::Plain, Method::Thesis, Method::March] {
            let found = &rows(&runs(&scene, method, 2), 0, SIZE as usize)[0];
            // Aslant by up to a degree, spread by up to two: Fresnel's equations are flat there.
            check(&format!("{method:?}, {lamp}"), found, radiance * through, [0.002, 0.01]);
        }
    }
}

/// Fog that the sun shines on, behind a roof that keeps it off the floor.
fn lit_fog(scattering: f64) -> Scene {
    floor_scene(&format!(
        "[[medium]]\nname = \"fog\"\nscattering = {scattering}\nabsorption = 0\n\
         [[object]]\nshape = \"box\"\nmin = [-2, 1, 4]\nmax = [2, 4.5, 7]\nmaterial = {{ dielectric = {{ index = 1 }} }}\ninside = \"fog\"\n\
         [[object]]\nshape = \"rectangle\"\ncorner = [-9, 5, -9]\nedge_u = [0, 0, 12.5]\nedge_v = [18, 0, 0]\nmaterial = \"black\"\n\
         [[light]]\nkind = \"sun\"\ndirection = [0, -1, 0]\nirradiance = {IRRADIANCE}\n\
         [grid]\ncells = [12, 12, 12]\n[render]\nradius = 0.05\nmax_radius = 0.1\n"
    ))
}

/// Length of a ray inside the box of fog.
fn in_box(origin: DVec3, direction: DVec3) -> f64 {
    let corners = [DVec3::new(-2.0, 1.0, 4.0), DVec3::new(2.0, 4.5, 7.0)];
    let cuts = corners.map(|corner| (corner - origin) / direction);
    let (near, far) = (cuts[0].min(cuts[1]).max_element(), cuts[0].max(cuts[1]).min_element());
    (far - near.max(0.0)).max(0.0)
}

#[test]
fn fog_seen_in_rough_metal_is_the_closed_form() {
    const SCATTERING: f64 = 1e-4;
    let scene = lit_fog(SCATTERING);
    let source = SCATTERING / (4.0 * PI) * IRRADIANCE;
    let of_row = |y: usize| {
        expected(&scene, [y * HALF, (y + 1) * HALF], |place, view| {
            // Over the hemisphere above the floor.
            let (rings, parts) = (90, 180);
            (0..rings * parts)
                .map(|index| {
                    let height = (f64::from(index / parts) + 0.5) / f64::from(rings);
                    let phi = TAU * (f64::from(index % parts) + 0.5) / f64::from(parts);
                    let r = (1.0 - height * height).sqrt();
                    let out = DVec3::new(r * phi.cos(), height, r * phi.sin());
                    let seen = in_box(place, out) * height;
                    if seen > 0.0 { metal(DVec3::Y, view, out) * source * seen } else { 0.0 }
                })
                .sum::<f64>()
                * TAU
                / f64::from(rings * parts)
        })
    };
    let expected: Vec<f64> = (0..SIZE as usize / HALF).map(of_row).collect();
    // What is noisy is where rough metal looks, not the light there.
    for method in [Method::Plain, Method::Thesis, Method::March] {
        let found = rows(&runs_of(&scene, method, 80, 2_000), 0, HALF);
        assert_eq!(found.len(), expected.len());
        for (y, (found, expected)) in found.iter().zip(&expected).enumerate() {
            check(&format!("{method:?}, row {y}"), found, *expected, [0.015, 0.025]);
        }
    }
}

/// In thick fog there is no closed form, and what lights what: photons that come by the metal to the camera tell.
#[test]
fn light_tracing_finds_the_same_fog_in_rough_metal() {
    let scene = lit_fog(0.3);
    let whole = |method, passes, paths| rows(&runs_of(&scene, method, passes, paths), 0, SIZE as usize)[0];
    let traced = whole(Method::LightTrace, 90, 20_000);
    for method in [Method::Plain, Method::Thesis] {
        let found = whole(method, 30, 4_000);
        let both = Sample { error: found.error.hypot(traced.error), ..found };
        check(&format!("{method:?}"), &both, traced.mean, [0.015, 0.03]);
    }
}
