//! Straight light by shadow rays and light paths that go where the picture needs them: unbiased by estimators that share none of that,
//! right by quadrature, repeatable, without a loss of energy, and sound where a scene has next to nothing in it.

use covbeam_render::scene_file;
use covbeam_session::film::Film;
use covbeam_session::pass::Renderer;
use covbeam_session::paths::Energy;
use covbeam_session::scene::{Light, Scene};
use covbeam_session::settings::{Method, Settings};
use covbeam_tests::single_scatter::{Density, Emission, Lamp, World, sunflower};
use covbeam_tests::statistics::{Sample, sidak, welch};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::path::Path;

const GLASS: &str = include_str!("../../../examples/scenes/glass-ball.toml");

/// Chance that one comparison of two estimators raises a false alarm: some ten of them, 1e-4 together.
const FAMILY_WISE: f64 = 1e-5;

/// Runs of each estimator. Student's quantile at the level of one region is 6.3 standard errors for them, and would be 10 for 8.
const RUNS: u32 = 12;

/// Pixels a side of the pictures that are compared, and of their blocks.
const SIZE: usize = 24;
const BLOCK: usize = 8;

fn scene(text: &str) -> Scene {
    scene_file::parse(text, "test scene", Path::new(".")).expect("a valid scene")
}

fn sized(text: &str, size: u32) -> Scene {
    let mut scene = scene(text);
    (scene.camera.width, scene.camera.height) = (size, size);
    scene
}

#[derive(Clone, Copy, Debug)]
enum Estimator {
    /// What is tested: straight light by shadow rays, guided paths, an eye ray through every pixel.
    Guided,
    /// The same kernels for beams of all light, from paths without guidance.
    Unguided,
    /// Connections with the camera, which have no kernels, no shadow rays along eye rays and no guidance.
    LightTrace,
}

fn renderer(scene: &Scene, estimator: Estimator, photons: u32, seed: u32) -> Renderer<'_> {
    let method = match estimator {
        Estimator::Guided => Method::Covbeam,
        Estimator::Unguided => Method::Thesis,
        Estimator::LightTrace => Method::LightTrace,
    };
    Renderer::new(scene, Settings { planned: false, ..Settings::of(method, photons, seed) })
}

/// Refuses values that are not finite.
fn picture(mut renderer: Renderer, scene: &Scene, passes: impl IntoIterator<Item = u32>) -> Vec<Vec3> {
    let mut film = Film::of_scene(scene);
    for index in passes {
        let (image, _) = renderer.pass(index, &|| false).expect("not cancelled");
        film.add(&image).expect("finite");
    }
    film.picture().radiance
}

fn guided(scene: &Scene, photons: u32, seed: u32, passes: u32) -> Vec<Vec3> {
    picture(renderer(scene, Estimator::Guided, photons, seed), scene, 1..=passes)
}

/// What is compared of a picture: each channel of the mean of each block, and of the whole.
fn regions(picture: &[Vec3]) -> Vec<f64> {
    let across = SIZE / BLOCK;
    let mut sums = vec![0.0; 3 * (across * across + 1)];
    for (pixel, color) in picture.iter().enumerate() {
        let block = pixel / SIZE / BLOCK * across + pixel % SIZE / BLOCK;
        for channel in 0..3 {
            sums[3 * block + channel] += f64::from(color[channel]) / (BLOCK * BLOCK) as f64;
            sums[3 * across * across + channel] += f64::from(color[channel]) / picture.len() as f64;
        }
    }
    sums
}

/// Means of each region over the runs of an estimator.
fn samples(scene: &Scene, estimator: Estimator, photons: u32, passes: u32, first: u32) -> Vec<Sample> {
    let runs: Vec<Vec<f64>> = (first..first + RUNS)
        .map(|seed| regions(&picture(renderer(scene, estimator, photons, seed), scene, 1..=passes)))
        .collect();
    let of = |region: usize| Sample::of(&runs.iter().map(|run| run[region]).collect::<Vec<_>>());
    (0..runs[0].len()).map(of).collect()
}

/// Every region's means must be the same.
///
/// - `noise`: largest relative standard error of the difference that the whole picture, and the median region, may have in a channel.
fn agree(name: &str, tested: &[Sample], against: &[Sample], noise: [f64; 2]) {
    let level = sidak(FAMILY_WISE, tested.len());
    let mut failures = Vec::new();
    let mut errors = Vec::new();
    for (region, (a, b)) in tested.iter().zip(against).enumerate() {
        if a.mean == 0.0 && b.mean == 0.0 {
            continue;
        }
        let (p, ratio, error) = (welch(*a, *b), a.mean / b.mean, a.error.hypot(b.error) / b.mean);
        errors.push(error);
        if region + 3 >= tested.len() || p < level {
            let [a, b] = [a, b].map(|sample| sample.error / b.mean);
            println!("{name}, region {region}: {ratio:.4} ± {a:.4} of ± {b:.4}, p {p:.2e}");
        }
        if !(p > level) {
            failures.push(region);
        }
        if region + 3 >= tested.len() {
            assert!(error < noise[0], "{name}: too noisy to tell: {error}");
        }
    }
    errors.sort_by(f64::total_cmp);
    let median = errors[errors.len() / 2];
    println!("{name}: median region ± {median:.4}");
    assert!(median < noise[1], "{name}: too noisy to tell: {median}");
    assert!(failures.is_empty(), "{name}: regions {failures:?} differ");
}

/// The inside of a matt box of 8 m, with a black ball; the camera sees no edge of the room and, but where a test says so, no lamp.
///
/// Kernels of beams are 3 cm wide and those of surface photons 30 cm: light that varies over a length l is blurred by about r²/(10 l²). What
/// beams show has been scattered before and varies over .3 m or more, on surfaces over 1 m or more: some 1e-3 of it, where a block's noise is
/// above 5e-3.
fn room(fog: &str, albedo: &str, rest: &str) -> Scene {
    let outside = if fog.is_empty() { "" } else { "outside_medium = \"fog\"\n" };
    let fog = if fog.is_empty() { String::new() } else { format!("[[medium]]\nname = \"fog\"\n{fog}\n") };
    scene(&format!(
        "{outside}[camera]\nposition = [0, 0, -3]\nlook_at = [0, 0, 0]\nvertical_fov = 40\nwidth = {SIZE}\nheight = {SIZE}\n\
         {fog}\
         [[object]]\nshape = \"box\"\nmin = [-4, -4, -4]\nmax = [4, 4, 4]\nmaterial = {{ lambert = {{ albedo = {albedo} }} }}\n\
         [[object]]\nshape = \"sphere\"\ncenter = [0.8, -0.3, 1.0]\nradius = 0.7\nmaterial = \"black\"\n\
         {rest}\
         [grid]\nmin = [-4, -4, -4]\nmax = [4, 4, 4]\ncells = [16, 16, 16]\n\
         [render]\nradius = 0.03\nmax_radius = 0.03\n"
    ))
}

const SPOT: &str = "[[light]]\nkind = \"spot\"\nposition = [-2, 3, 1]\nlook_at = [1, -2, 1]\nintensity = [40, 30, 10]\ninner_angle = 15\nouter_angle = 25\n";
const POINT: &str = "[[light]]\nkind = \"point\"\nposition = [2.5, 2, -1]\nintensity = [1, 2, 6]\n";

fn agrees_with_light_tracing(name: &str, scene: &Scene, photons: u32, noise: [f64; 2]) {
    let tested = samples(scene, Estimator::Guided, photons, 2, 1000);
    // As noisy as the guided paths, or less: what fog shows of a path that passes the camera at h goes as 1/h.
    let more = if scene.media.is_empty() { 10 } else { 100 };
    let against = samples(scene, Estimator::LightTrace, more * photons, 1, 2000);
    agree(name, &tested, &against, noise);
}

#[test]
fn a_channel_without_extinction_is_that_of_light_tracing() {
    let fog = "scattering = [0.2, 0.1, 0.0]\nabsorption = [0.0, 0.2, 0.0]";
    let scene = room(fog, "[0.2, 0.5, 0.7]", &[SPOT, POINT].concat());
    agrees_with_light_tracing("one channel clear", &scene, 2000, [0.02, 0.03]);
}

#[test]
fn fog_that_thins_out_is_that_of_light_tracing() {
    let fog = "scattering = [0.3, 0.25, 0.2]\nabsorption = 0.02\ndensity = { exponential = { origin = [0, -1, 0], scale_height = 1.5 } }";
    let scene = room(fog, "0.4", &[SPOT, POINT].concat());
    agrees_with_light_tracing("exponential", &scene, 1500, [0.012, 0.02]);
}

#[test]
fn fog_with_the_camera_beside_a_disk_is_that_of_light_tracing() {
    let fog = "scattering = [0.15, 0.1, 0.05]\nabsorption = 0.03\nphase = { henyey_greenstein = 0.7 }";
    let disk = "[[light]]\nkind = \"disk\"\ncenter = [1.6, 0.8, -1.5]\nnormal = [-0.6, -0.3, 1]\nradius = 0.3\nradiance = [10, 20, 30]\nvisible = false\n";
    let scene = room(fog, "0.4", disk);
    agrees_with_light_tracing("disk", &scene, 8000, [0.04, 0.05]);
}

#[test]
fn thick_white_fog_is_that_of_light_tracing() {
    let scene = room("scattering = [0.4, 0.35, 0.3]\nabsorption = 0.005", "0.3", POINT);
    agrees_with_light_tracing("thick", &scene, 2000, [0.02, 0.04]);
}

#[test]
fn a_room_without_fog_is_that_of_light_tracing() {
    let scene = room("", "[0.8, 0.5, 0.2]", &[SPOT, POINT].concat());
    agrees_with_light_tracing("vacuum", &scene, 3000, [0.012, 0.025]);
}

/// Where light tracing is blind. The caustics have the same kernels in both; what differs are beams of straight light, which vary over 1 m.
#[test]
fn glass_and_a_mirror_are_those_of_paths_without_guidance() {
    let specular = "[[object]]\nshape = \"sphere\"\ncenter = [-0.6, 0.3, 0.5]\nradius = 0.6\nmaterial = { dielectric = { index = 1.5 } }\n\
        [[object]]\nshape = \"rectangle\"\ncorner = [-1.5, -1.6, 2.0]\nedge_u = [3, 0, 0.8]\nedge_v = [0, 1.2, 0.5]\n\
        material = { mirror = { reflectance = [0.9, 0.7, 0.5] } }\n";
    let fog = "scattering = [0.2, 0.15, 0.1]\nabsorption = [0.02, 0.1, 0.0]";
    let scene = room(fog, "[0.5, 0.4, 0.3]", &[specular, SPOT, POINT].concat());
    let tested = samples(&scene, Estimator::Guided, 2000, 2, 1000);
    let against = samples(&scene, Estimator::Unguided, 6000, 2, 3000);
    agree("glass and mirror", &tested, &against, [0.02, 0.04]);
}

/// A mirror that fills the view and reflects a twentieth of the light: beams around such pieces of eye paths are gathered now and then. Both are
/// in a clear ball with the index of air: in fog before the mirror, a beam would be seen twenty times as bright.
#[test]
fn what_a_faint_mirror_shows_is_that_of_paths_without_guidance() {
    let ball = "[[object]]\nshape = \"sphere\"\ncenter = [0, 0, -3]\nradius = 0.2\nmaterial = { dielectric = { index = 1.0 } }\n";
    let mirror = "[[object]]\nshape = \"rectangle\"\ncorner = [-0.05, -0.05, -3.0]\nedge_u = [0.1, 0, 0.1]\nedge_v = [0, 0.1, 0]\n\
        material = { mirror = { reflectance = [0.05, 0.04, 0.03] } }\n";
    let fog = "scattering = [0.3, 0.25, 0.2]\nabsorption = 0.02";
    let scene = room(fog, "0.4", &[ball, mirror, POINT].concat());
    let tested = samples(&scene, Estimator::Guided, 3000, 2, 1000);
    let against = samples(&scene, Estimator::Unguided, 6000, 2, 3000);
    agree("faint mirror", &tested, &against, [0.03, 0.05]);
}

/// Light scattered once in a black room, by quadrature: light scattered twice is 1e-3 of it at most.
#[test]
fn straight_light_is_that_of_quadrature() {
    const SCATTERING: f64 = 1e-4;
    const ROOM: f64 = 4.0;
    let absorption = DVec3::new(0.3, 0.1, 0.0);
    let position = DVec3::new(0.3, 2.6, 0.2);
    let axis = DVec3::new(0.2, -1.0, 0.1).normalize();
    let radius = 0.3;
    let look_at = position + axis;
    let place = "position = [0.3, 2.6, 0.2]\nintensity = 1.0\n";
    let point = format!("kind = \"point\"\n{place}");
    let spot = format!(
        "kind = \"spot\"\n{place}look_at = [{}, {}, {}]\ninner_angle = 15\nouter_angle = 30\n",
        look_at.x, look_at.y, look_at.z
    );
    let disk = format!(
        "kind = \"disk\"\ncenter = [0.3, 2.6, 0.2]\nnormal = [0.2, -1.0, 0.1]\nradius = {radius}\nradiance = {}\n",
        1.0 / (PI * radius * radius)
    );
    let cone = Emission::Spot { axis, inner: 15f64.to_radians(), outer: 30f64.to_radians() };
    let places = sunflower(position, radius, axis, 64);
    let even = "";
    let thinning = "density = { exponential = { scale_height = 1.5 } }\n";
    // Of the same air in the air: nothing changes, but every shadow ray crosses one or two of its sides.
    let boxed = "[[object]]\nshape = \"box\"\nmin = [-1.5, -2, -1.5]\nmax = [1.5, 2, 1.5]\nmaterial = { dielectric = { index = 1.0 } }\n\
        inside = \"air\"\n";
    let open = "";
    let cases = [
        ("point", &point, Emission::Even, vec![position], even, 0.0, open),
        ("thinning", &point, Emission::Even, vec![position], thinning, 0.6, open),
        ("spot", &spot, cone, vec![position], even, -0.5, open),
        ("disk", &disk, Emission::Lambert { normal: axis }, places, thinning, 0.0, open),
        ("point and box", &point, Emission::Even, vec![position], even, 0.0, boxed),
    ];
    for (name, light, emission, places, density, asymmetry, more) in cases {
        let scene = scene(&format!(
            "outside_medium = \"air\"\n\
             [camera]\nposition = [0, 0.5, -3.5]\nlook_at = [0, 0.4, 0]\nvertical_fov = 50\nwidth = {SIZE}\nheight = {SIZE}\n\
             [[medium]]\nname = \"air\"\nscattering = {SCATTERING}\nabsorption = [0.3, 0.1, 0.0]\n\
             phase = {{ henyey_greenstein = {asymmetry:?} }}\n{density}\
             [[object]]\nshape = \"box\"\nmin = [-{ROOM}, -{ROOM}, -{ROOM}]\nmax = [{ROOM}, {ROOM}, {ROOM}]\nmaterial = \"black\"\n\
             [[object]]\nshape = \"sphere\"\ncenter = [0.4, 0.0, 0.3]\nradius = 0.4\nmaterial = \"black\"\n{more}\
             [[light]]\n{light}\nvisible = false\n[grid]\ncells = [16, 16, 16]\n[render]\nradius = 0.05\nmax_radius = 0.05\n"
        ));
        let world = |place: DVec3| World {
            density: Density::Exponential { scale_height: if density.is_empty() { 1e12 } else { 1.5 } },
            scattering: DVec3::splat(SCATTERING),
            absorption,
            asymmetry,
            lamp: Lamp { position: place, intensity: DVec3::ONE, emission },
            ball: (DVec3::new(0.4, 0.0, 0.3), 0.4),
            room: (DVec3::splat(-ROOM), DVec3::splat(ROOM)),
        };
        let worlds: Vec<World> = places.iter().map(|&place| world(place)).collect();
        // Rays across a pixel, and points along each: silhouettes are off by 1/(2 x rays) of a pixel or less, 3e-3 of a block of 8 at most
        // where all of its light ends there. With 64 lamps one does for several.
        let (rays, points) = (6_usize, 200 / worlds.len().min(8) as u32);
        let truth: Vec<Vec3> = (0..SIZE * SIZE)
            .into_par_iter()
            .map(|pixel| {
                let mut sum = DVec3::ZERO;
                for ray in 0..rays * rays {
                    let at = |pixel: usize, ray: usize| (pixel as f32) + (ray as f32 + 0.5) / rays as f32;
                    let direction =
                        scene.camera.direction(at(pixel % SIZE, ray % rays), at(pixel / SIZE, ray / rays));
                    let (eye, direction) =
                        (scene.camera.position.as_dvec3(), direction.as_dvec3().normalize());
                    // A different eighth of the lamps for each ray.
                    let some =
                        worlds.iter().skip(ray % worlds.len().div_ceil(8)).step_by(worlds.len().div_ceil(8));
                    let count = some.clone().count() as f64;
                    sum += some.map(|world| world.radiance(eye, direction, points)).sum::<DVec3>() / count;
                }
                (sum / (rays * rays) as f64).as_vec3()
            })
            .collect();
        let truth = regions(&truth);
        let whole = truth[truth.len() - 1];
        let runs: Vec<Vec<f64>> = (1..=8).map(|seed| regions(&guided(&scene, 64, seed, 16))).collect();
        for (region, truth) in truth.iter().enumerate() {
            // A block that is darker than a fifth of the picture is held against that fifth.
            let unit = truth.max(0.2 * whole);
            let found = |run: &Vec<f64>| 1.0 + (run[region] - truth) / unit;
            let found = Sample::of(&runs.iter().map(found).collect::<Vec<_>>());
            // 1e-3 for light scattered twice, 3e-3 for the quadrature's silhouettes and shadows.
            let allowed = 4e-3 + 6.0 * found.error;
            if (found.mean - 1.0).abs() > allowed || region + 3 >= runs[0].len() {
                println!("{name}, region {region}: {:.4} ± {:.4}", found.mean, found.error);
            }
            assert!((found.mean - 1.0).abs() < allowed, "{name}, region {region}: {found:?}");
            let noise = if region + 3 < runs[0].len() { 0.02 } else { 0.005 };
            assert!(found.error < noise, "{name}, region {region}: too noisy to tell: {found:?}");
        }
    }
}

/// Rays that run into the middle of a disk lamp, square to it: the fog's light goes as the disk's solid angle, 2π (1 - s/√(s² + R²)).
#[test]
fn fog_right_before_a_disk_has_no_specks() {
    const SCATTERING: f64 = 1e-4;
    let (distance, radius): (f64, f64) = (3.0, 0.5);
    let scene = scene(&format!(
        "outside_medium = \"air\"\n\
         [camera]\nposition = [0, 0, -3]\nlook_at = [0, 0, 0]\nvertical_fov = 0.5\nwidth = {SIZE}\nheight = {SIZE}\n\
         [[medium]]\nname = \"air\"\nscattering = {SCATTERING}\nabsorption = 0.0\n\
         [[object]]\nshape = \"box\"\nmin = [-4, -4, -4]\nmax = [4, 4, 4]\nmaterial = \"black\"\n\
         [[light]]\nkind = \"disk\"\ncenter = [0, 0, 0]\nnormal = [0, 0, -1]\nradius = {radius}\nradiance = 1.0\nvisible = false\n\
         [grid]\ncells = [16, 16, 16]\n[render]\nradius = 0.05\nmax_radius = 0.05\n"
    ));
    let exact = SCATTERING / 2.0 * (distance + radius - distance.hypot(radius));
    let found: Vec<f64> = guided(&scene, 64, 1, 1).iter().map(|color| f64::from(color.x) / exact).collect();
    let sample = Sample::of(&found);
    println!("{sample:?}");
    // Extinction takes 6e-4 at most, light scattered twice gives as much.
    assert!((sample.mean - 1.0).abs() < 1e-3 + 5.0 * sample.error, "{sample:?}");
    // Solid angle over the density of places is within 17 % of its greatest value.
    assert!(found.iter().all(|ratio| (ratio - 1.0).abs() < 0.2), "{found:?}");
}

#[test]
fn the_picture_is_the_same_bits_for_any_number_of_threads_and_any_order_of_passes() {
    let thinning = GLASS.replace(
        "absorption = 0.02",
        "absorption = 0.02\ndensity = { exponential = { scale_height = 2.0 } }",
    );
    assert_ne!(thinning, GLASS);
    for text in [GLASS, &thinning] {
        let scene = sized(text, 40);
        let bits = |seed: u32, passes: &[u32]| -> Vec<[u32; 3]> {
            let renderer = renderer(&scene, Estimator::Guided, 700, seed);
            let picture = picture(renderer, &scene, passes.iter().copied());
            picture.iter().map(|color| color.to_array().map(f32::to_bits)).collect()
        };
        let first = bits(3, &[1, 2, 3, 4]);
        for threads in [1, 2, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert!(pool.install(|| bits(3, &[1, 2, 3, 4])) == first, "{threads} threads");
        }
        assert!(bits(3, &[3, 1, 4, 2]) == first, "passes in another order");
        assert!(bits(4, &[1, 2, 3, 4]) != first, "the seed does nothing");
    }
}

#[test]
fn a_cancelled_pass_returns_nothing() {
    let scene = sized(GLASS, 40);
    assert!(renderer(&scene, Estimator::Guided, 700, 3).pass(1, &|| true).is_none());
}

/// emitted = medium + surfaces + escaped + roulette; the roulette's share is noise around zero, and what is emitted is so around the
/// lamps' flux.
#[test]
fn no_energy_is_lost_or_made() {
    let coloured = GLASS
        .replace("scattering = 0.2 ", "scattering = [0.5, 0.2, 0.1] ")
        .replace("absorption = 0.02", "absorption = [0.01, 0.0, 0.3]")
        .replace("albedo = 0.5", "albedo = [0.7, 0.5, 0.3]");
    assert_ne!(coloured, GLASS);
    for text in [GLASS, &coloured] {
        let scene = sized(text, 8);
        let Light::Point { intensity, .. } = scene.lights[0] else { panic!("a point") };
        let flux = 4.0 * PI * f64::from(intensity.x);
        let shares: Vec<[[f64; 2]; 3]> = (1..=20)
            .map(|seed| {
                let mut renderer = renderer(&scene, Estimator::Guided, 3000, seed);
                renderer.pass(1, &|| false).expect("not cancelled");
                let Energy { emitted, medium, surfaces, escaped, spent, roulette } = renderer.energy();
                std::array::from_fn(|c| {
                    let balance = medium[c] + surfaces[c] + escaped[c] + spent[c] + roulette[c] - emitted[c];
                    assert!(balance.abs() < 1e-5 * emitted[c], "balance {balance} of {}", emitted[c]);
                    assert_eq!(escaped[c], 0.0, "the room is closed");
                    [roulette[c] / flux, emitted[c] / flux - 1.0]
                })
            })
            .collect();
        for c in 0..3 {
            for what in 0..2 {
                let sample = Sample::of(&shares.iter().map(|share| share[c][what]).collect::<Vec<_>>());
                println!("channel {c}, {what}: {:.5} ± {:.5}", sample.mean, sample.error);
                // Six independent tests at 6 standard errors of 20 runs: a false alarm in 1e4.
                assert!(sample.mean.abs() < 6.0 * sample.error + 1e-6, "channel {c}, {what}: {sample:?}");
                // Where channels differ, much of the power goes where it is of no use to the picture, by chance: the other scene sees less.
                let seen = if text == coloured { 0.05 } else { 0.02 };
                assert!(sample.error < seen, "the test could not see a loss of some percent: {sample:?}");
            }
        }
    }
}

/// One lamp, and a thousand in its place that share its power: of these a piece of an eye path asks four. Light scattered twice, and its noise,
/// is 1e-3 of it at most.
#[test]
fn a_thousand_lamps_in_one_place_are_one_lamp() {
    let one = room("scattering = 1e-4\nabsorption = 0.05", "0.0", POINT);
    let mut many = one.clone();
    let Light::Point { position, intensity } = one.lights[0] else { panic!("a point") };
    // In shares of 1 to 1000.
    let share = |k: u16| Light::Point { position, intensity: intensity * (f32::from(k) / 500_500.0) };
    many.lights = (1..=1000).map(share).collect();
    let tested = samples(&many, Estimator::Guided, 100, 2, 1000);
    let against = samples(&one, Estimator::Guided, 100, 2, 5000);
    agree("a thousand lamps", &tested, &against, [0.005, 0.01]);
}

fn is_black(picture: &[Vec3]) -> bool {
    picture.iter().all(|color| *color == Vec3::ZERO)
}

fn is_lit(picture: &[Vec3]) -> bool {
    // The film refuses what is not finite.
    picture.iter().all(|color| color.min_element() >= 0.0) && !is_black(picture)
}

const FOG: &str = "scattering = 0.2\nabsorption = 0.05";

#[test]
fn no_light_reaches_the_camera() {
    let shut = "[[object]]\nshape = \"box\"\nmin = [-0.1, -0.1, -3.1]\nmax = [0.1, 0.1, -2.9]\nmaterial = \"black\"\n";
    assert!(is_black(&guided(&room(FOG, "0.5", &[shut, POINT].concat()), 300, 1, 2)), "a shut box");
    let wall = "[[object]]\nshape = \"rectangle\"\ncorner = [-4, -4, -2]\nedge_u = [8, 0, 0]\nedge_v = [0, 8, 0]\nmaterial = \"black\"\n";
    let behind = POINT.replace("[2.5, 2, -1]", "[2.5, 2, 1]");
    assert_ne!(behind, POINT);
    assert!(is_black(&guided(&room(FOG, "0.5", &[wall, &behind].concat()), 300, 1, 2)), "a wall");
    // Light that falls on black walls, and air that scatters none.
    assert!(
        is_black(&guided(&room("scattering = 0.0\nabsorption = 0.1", "0.0", POINT), 300, 1, 2)),
        "no fog"
    );
    assert!(is_black(&guided(&room("", "0.0", POINT), 300, 1, 2)), "vacuum");
}

#[test]
fn all_light_that_reaches_the_camera_is_straight() {
    // Lit fog in view, and a black wall around all of it: what is scattered twice is next to nothing.
    let scene = room("scattering = 1e-8\nabsorption = 0.1", "0.0", POINT);
    assert!(is_lit(&guided(&scene, 300, 1, 2)));
    // Straight light on surfaces, from which nothing goes on.
    assert!(is_lit(&guided(&room("", "1e-8", POINT), 300, 1, 2)));
}

#[test]
fn one_voxel_is_a_grid() {
    let mut scene = room(FOG, "0.5", &[SPOT, POINT].concat());
    scene.grid.cells = [1, 1, 1];
    assert!(is_lit(&guided(&scene, 300, 1, 2)));
    // And one that light and eye rays miss.
    (scene.grid.min, scene.grid.max) = (Vec3::splat(3.9), Vec3::splat(3.95));
    assert!(is_lit(&guided(&scene, 300, 1, 2)));
}

#[test]
fn a_lamp_in_a_ball_of_fog() {
    let ball = "[[object]]\nshape = \"sphere\"\ncenter = [2.5, 2, -1]\nradius = 0.5\nmaterial = { dielectric = { index = 1.5 } }\ninside = \"ball\"\n";
    for fog in [FOG, "scattering = 20.0\nabsorption = 0.0"] {
        let inside = format!("[[medium]]\nname = \"ball\"\n{fog}\n");
        let scene = room(FOG, "0.5", &[&inside, ball, POINT].concat());
        assert!(is_lit(&guided(&scene, 300, 1, 2)), "{fog}");
        let mut clear = scene.clone();
        clear.outside = None;
        assert!(is_lit(&guided(&clear, 300, 1, 2)), "{fog}, vacuum around it");
    }
}

#[test]
fn the_camera_in_the_beam_behind_a_lens() {
    let lens = "[[object]]\nshape = \"sphere\"\ncenter = [0, 0, -1]\nradius = 0.8\nmaterial = { dielectric = { index = 1.5 } }\n";
    // Straight ahead: the lamp is in the middle of the picture, its image near the camera.
    let lamp = "[[light]]\nkind = \"spot\"\nposition = [0, 0, 3]\nlook_at = [0, 0, -3]\nintensity = 50\ninner_angle = 5\nouter_angle = 15\n";
    for eye in [-3.0, -2.2, -1.80001] {
        let mut scene = room(FOG, "0.5", &[lens, lamp].concat());
        scene.camera.position.z = eye;
        assert!(is_lit(&guided(&scene, 300, 1, 2)), "{eye}");
    }
}

#[test]
fn paths_end_where_nothing_is_absorbed() {
    let white = room("scattering = 1.0\nabsorption = 0.0", "1.0", POINT);
    assert!(is_lit(&guided(&white, 50, 1, 1)), "white walls");
    // Fog without an end.
    let mut open = white.clone();
    open.objects.clear();
    assert!(is_lit(&guided(&open, 50, 1, 1)), "no walls");
}

/// Light that fog scatters dozens of times on its way: paths as plain as power goes are worth more there than trees of which one in 25
/// arrives. Pictures stray from seed to seed no more than those without guidance, to twice, for twelve seeds say a spread to a fifth; guided
/// ones strayed four times as much.
#[test]
fn thick_fog_that_absorbs_nothing_is_as_quiet_as_without_guidance() {
    let scene = scene(
        "outside_medium = \"fog\"\n[camera]\nposition = [0, 0.5, -5]\nlook_at = [0, 0, 0]\nvertical_fov = 35\nwidth = 24\nheight = 24\n\
         [[medium]]\nname = \"fog\"\nscattering = 1.5\nabsorption = 0.0\n\
         [[object]]\nshape = \"box\"\nmin = [-4, -4, -6]\nmax = [4, 4, 4]\nmaterial = \"black\"\n\
         [[light]]\nkind = \"point\"\nposition = [0.5, 2.5, 0]\nintensity = 25\n",
    );
    let [tested, against] = [(Estimator::Guided, 1), (Estimator::Unguided, 101)].map(|(estimator, first)| {
        let regions = samples(&scene, estimator, 2000, 2, first);
        *regions.last().expect("the whole picture")
    });
    let p = welch(tested, against);
    println!("{tested:?}, without guidance {against:?}: p {p:.2e}");
    assert!(p > FAMILY_WISE, "{tested:?}, {against:?}");
    assert!(tested.error / tested.mean < 2.0 * against.error / against.mean, "{tested:?}, {against:?}");
}
