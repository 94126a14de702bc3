//! Media that send out light, by closed forms, quadrature, a balance and another estimator.

use covbeam_render::scene_file;
use covbeam_session::film::{Film, Picture};
use covbeam_session::pass::Renderer;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};
use covbeam_tests::energy::taken_by_chance;
use covbeam_tests::statistics::{Sample, sidak, welch};
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};
use std::path::Path;

fn scene(text: &str) -> Scene {
    scene_file::parse(text, "test scene", Path::new(".")).expect("a valid scene")
}

/// As the renderer makes pictures where nothing else is asked for.
fn picture(scene: &Scene, seed: u32, passes: u32) -> Picture {
    of_passes(scene, &mut Renderer::new(scene, Settings::of_scene(Method::Covbeam, scene, seed)), passes)
}

fn by(method: Method, scene: &Scene, photons: u32, seed: u32, passes: u32) -> Picture {
    of_passes(scene, &mut Renderer::new(scene, Settings::of(method, photons, seed)), passes)
}

fn of_passes(scene: &Scene, renderer: &mut Renderer, passes: u32) -> Picture {
    let mut film = Film::of_scene(scene);
    for index in 1..=passes {
        film.add(&renderer.pass(index, &|| false).expect("not cancelled").0).expect("finite");
    }
    film.picture()
}

fn mean(picture: &[Vec3]) -> DVec3 {
    picture.iter().map(|light| light.as_dvec3()).sum::<DVec3>() / picture.len() as f64
}

/// Seen from -z, 25 pixels across.
const BEFORE: &str =
    "position = [0, 0, -4]\nlook_at = [0, 0, 0]\nvertical_fov = 52\nwidth = 25\nheight = 25\n";

/// A ball of gas of radius 1.5 that absorbs and scatters nothing, in a vacuum.
fn ball(camera: &str, more: &str) -> Scene {
    scene(&format!(
        "[camera]\n{camera}\
         [[medium]]\nname = \"gas\"\nscattering = 0\nabsorption = [0.8, 3, 0]\nemission = [2, 5, 0.25]\n\
         [[object]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1.5\nmaterial = {{ dielectric = {{ index = 1 }} }}\n\
         inside = \"gas\"\n{more}"
    ))
}

/// Of rays through pixels' middles: emission/absorption (1 - exp(-absorption x length)).
fn expected_of_ball(x: u32, y: u32, end: f64) -> DVec3 {
    let tangent = |at: u32| (f64::from(at) - 12.0) / 12.5 * 26_f64.to_radians().tan();
    let direction = DVec3::new(tangent(x), tangent(y), 1.0).normalize();
    let foot = 4.0 * direction.z;
    let half = (1.5_f64.powi(2) - (16.0 - foot * foot)).max(0.0).sqrt();
    let length = ((foot + half).min(end / direction.z) - (foot - half)).max(0.0);
    let (absorption, emission) = (DVec3::new(0.8, 3.0, 0.0), DVec3::new(2.0, 5.0, 0.25));
    let seen = emission / absorption * (1.0 - (-absorption * length).exp());
    DVec3::new(seen.x, seen.y, emission.z * length)
}

/// No lamp, nothing that scatters: all is emission, also behind bounds, before a wall, and where nothing from beyond is asked for.
#[test]
fn a_ball_of_gas_is_as_bright_as_the_closed_form_has_it() {
    let wall = "[[object]]\nshape = \"rectangle\"\ncorner = [-9, -9, 0.5]\nedge_u = [0, 18, 0]\nedge_v = [18, 0, 0]\n\
        material = \"black\"\n";
    for (more, end) in [("", f64::INFINITY), (wall, 4.5)] {
        let scene = ball(BEFORE, more);
        assert!(scene.lights_fog());
        for beyond in [true, false] {
            // The filter of pixels is half a pixel wide: where the brightness bends little its mean is that of the middle.
            let settings = Settings { beyond, ..Settings::of_scene(Method::Covbeam, &scene, 1) };
            let found = of_passes(&scene, &mut Renderer::new(&scene, settings), 64);
            let mut most = 0.0_f64;
            for (x, y) in (0..25).flat_map(|y| (0..25).map(move |x| (x, y))) {
                let aside = f64::from((x - 12_i32).pow(2) + (y - 12_i32).pow(2)).sqrt();
                let light = found.radiance[(y * 25 + x) as usize].as_dvec3();
                if aside < 7.0 {
                    let expected = expected_of_ball(x as u32, y as u32, end);
                    most = most.max((light / expected - 1.0).abs().max_element());
                } else if aside > 12.5 {
                    assert_eq!(light, DVec3::ZERO, "({x}, {y})");
                }
            }
            println!("at most {most} off");
            assert!(most < 0.01, "{most}");
        }
    }
}

/// The light of a small ball of thin gas in thin fog, scattered once, by quadrature: the fluence of a ball is the mean over directions of its
/// chords.
#[test]
fn light_of_thin_gas_is_scattered_by_the_fog_around_it() {
    const RADIUS: f64 = 0.4;
    const FOG: f64 = 0.05;
    let text = format!(
        "outside_medium = \"fog\"\n\
         [camera]\nposition = [1.2, 0, -3]\nlook_at = [1.2, 0, 0]\nvertical_fov = 20\nwidth = 16\nheight = 16\n\
         [[medium]]\nname = \"fog\"\nscattering = {FOG}\nabsorption = 0\n\
         [[medium]]\nname = \"gas\"\nscattering = 0\nabsorption = 0\nemission = [3, 1, 0.5]\n\
         [[object]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = {RADIUS}\nmaterial = {{ dielectric = {{ index = 1 }} }}\n\
         inside = \"gas\"\n\
         [[object]]\nshape = \"rectangle\"\ncorner = [-9, -9, 3]\nedge_u = [0, 18, 0]\nedge_v = [18, 0, 0]\nmaterial = \"black\"\n"
    );
    let mut scene = scene(&text);
    scene.settings.bounces = Some(0);
    // Of emission 1 at a distance from the middle.
    let fluence = |distance: f64| {
        let cone = 1.0 - (1.0 - (RADIUS / distance).powi(2)).sqrt();
        let steps = 200;
        let rings = (0..steps).map(|step| {
            let cosine = 1.0 - (f64::from(step) + 0.5) / f64::from(steps) * cone;
            let foot = distance * cosine;
            let half = (RADIUS * RADIUS - (distance * distance - foot * foot)).max(0.0).sqrt();
            2.0 * half * (-FOG * (foot - half)).exp()
        });
        TAU * cone * rings.sum::<f64>() / f64::from(steps)
    };
    let (pixels, steps) = (64, 400);
    let pixel = |index: i32| (f64::from(index) + 0.5) / f64::from(pixels) * 2.0 - 1.0;
    let size = 10_f64.to_radians().tan();
    let mut expected = 0.0;
    for (x, y) in (0..pixels).flat_map(|y| (0..pixels).map(move |x| (x, y))) {
        let direction = DVec3::new(size * pixel(x), size * pixel(y), 1.0);
        let length = 6.0 * direction.length();
        let step = length / f64::from(steps);
        let seen = (0..steps).map(|at| {
            let at = (f64::from(at) + 0.5) * step;
            let place = DVec3::new(1.2, 0.0, -3.0) + at * direction.normalize();
            FOG / (4.0 * PI) * fluence(place.length()) * (-FOG * at).exp() * step
        });
        expected += seen.sum::<f64>() / f64::from(pixels * pixels);
    }
    let runs: Vec<DVec3> = (1..=6).map(|seed| mean(&picture(&scene, seed, 4).radiance)).collect();
    for (channel, emission) in [3.0, 1.0, 0.5].into_iter().enumerate() {
        let Sample { mean, error, .. } = Sample::of(&runs.iter().map(|run| run[channel]).collect::<Vec<_>>());
        let expected = emission * expected;
        println!("{mean} ± {error} for {expected}");
        assert!(error < 0.01 * expected, "too few to tell");
        // Kernels blur the glow by a percent in a first pass.
        assert!((mean - expected).abs() < 4.0 * error + 0.01 * expected, "{mean} ± {error} for {expected}");
    }
}

/// A glowing ball that scatters, absorbs and lights the fog around it and a floor.
fn hearth() -> Scene {
    scene(
        "outside_medium = \"fog\"\n\
         [camera]\nposition = [0, 1, -4]\nlook_at = [0, 0.3, 0]\nvertical_fov = 50\nwidth = 24\nheight = 24\n\
         [[medium]]\nname = \"fog\"\nscattering = 0.12\nabsorption = 0.04\n\
         [[medium]]\nname = \"fire\"\nscattering = [0.6, 0.3, 1.5]\nabsorption = 0.5\nemission = [3, 1, 0.5]\n\
         phase = { henyey_greenstein = 0.4 }\n\
         [[object]]\nshape = \"sphere\"\ncenter = [0, 0.5, 0]\nradius = 0.6\nmaterial = { dielectric = { index = 1 } }\n\
         inside = \"fire\"\n\
         [[object]]\nshape = \"rectangle\"\ncorner = [-4, -0.4, -5]\nedge_u = [0, 0, 9]\nedge_v = [8, 0, 0]\n\
         material = { lambert = { albedo = 0.6 } }\n",
    )
}

/// Light paths that connect each of their vertices, and where they start, with the pinhole.
#[test]
fn pictures_have_the_means_of_light_paths_connected_with_the_camera() {
    let scene = hearth();
    let quarters = |picture: &Picture| -> Vec<f64> {
        let of = |quarter: usize| {
            let inside = |pixel: &usize| (pixel % 24 / 12, pixel / 24 / 12) == (quarter % 2, quarter / 2);
            (0..576).filter(inside).map(|pixel| f64::from(picture.radiance[pixel].element_sum())).sum::<f64>()
        };
        (0..4).map(of).collect()
    };
    let seeds = 16;
    let connected: Vec<Vec<f64>> =
        (1..=seeds).map(|seed| quarters(&by(Method::LightTrace, &scene, 30_000, seed, 1))).collect();
    let found: Vec<Vec<f64>> = (1..=seeds).map(|seed| quarters(&picture(&scene, seed, 3))).collect();
    for quarter in 0..4 {
        let of = |runs: &[Vec<f64>]| Sample::of(&runs.iter().map(|run| run[quarter]).collect::<Vec<_>>());
        let (a, b) = (of(&found), of(&connected));
        let ratio = a.mean / b.mean;
        println!("quarter {quarter}: {ratio}, ± {} and {}", a.error / a.mean, b.error / b.mean);
        assert!(a.error.hypot(b.error) < 0.012 * b.mean, "too few to tell");
        // Kernels and filters blur by a percent in a first pass.
        let bias = 0.01 * b.mean;
        let nearest = Sample { mean: b.mean + (a.mean - b.mean).clamp(-bias, bias), ..b };
        assert!(welch(a, nearest) > sidak(0.001, 4), "quarter {quarter}: {ratio}");
    }
}

/// A mirror shows a glowing ball as it is seen from behind the mirror.
#[test]
fn mirrors_show_what_glows() {
    let mirror = "[[object]]\nshape = \"rectangle\"\ncorner = [-9, -9, 2]\nedge_u = [0, 18, 0]\nedge_v = [18, 0, 0]\n\
        material = { mirror = { reflectance = 0.5 } }\n";
    let scene = ball(
        "position = [0, 0, 1.9]\nlook_at = [0, 0, 3]\nvertical_fov = 10\nwidth = 9\nheight = 9\n",
        mirror,
    );
    let found = picture(&scene, 1, 16).radiance[40].as_dvec3();
    let expected = 0.5 * expected_of_ball(12, 12, f64::INFINITY);
    assert!((found / expected - 1.0).abs().max_element() < 5e-3, "{found} for {expected}");
}

/// In a white room everything is as bright as emission over absorption: gas, what it scatters, and walls.
#[test]
fn a_white_room_of_glowing_gas_is_a_furnace() {
    let scene = scene(
        "[camera]\nposition = [0.2, -0.3, -0.4]\nlook_at = [-1, 0.3, 1]\nvertical_fov = 80\nwidth = 12\nheight = 12\n\
         [[medium]]\nname = \"gas\"\nscattering = [0.4, 0.8, 0.1]\nabsorption = [0.8, 0.6, 1]\nemission = [1.6, 0.6, 0.5]\n\
         [[object]]\nshape = \"box\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\nmaterial = { dielectric = { index = 1 } }\n\
         inside = \"gas\"\n\
         [[object]]\nshape = \"box\"\nmin = [-1.001, -1.001, -1.001]\nmax = [1.001, 1.001, 1.001]\n\
         material = { lambert = { albedo = 1 } }\n",
    );
    let runs: Vec<DVec3> = (1..=4).map(|seed| mean(&picture(&scene, seed, 9).radiance)).collect();
    for (channel, expected) in [2.0, 1.0, 0.5].into_iter().enumerate() {
        let Sample { mean, error, .. } = Sample::of(&runs.iter().map(|run| run[channel]).collect::<Vec<_>>());
        println!("{mean} ± {error} for {expected}");
        assert!(error < 0.012 * expected, "too few to tell");
        // Beams and disks that end at the room's edges lose what others would add: a percent.
        assert!((mean - expected).abs() < 4.0 * error + 0.015 * expected, "{mean} ± {error} for {expected}");
    }
}

/// What a ball in a black room sends out, of which a cube around it is drawn: its volume's power, all of which goes somewhere.
#[test]
fn power_is_what_the_gas_sends_out_and_none_is_lost() {
    let scene = scene(
        "[camera]\nposition = [0, 0, -4]\nlook_at = [0, 0, 0]\nvertical_fov = 50\nwidth = 8\nheight = 8\n\
         [[medium]]\nname = \"gas\"\nscattering = [0.3, 1, 0.1]\nabsorption = [0.1, 0.6, 0]\nemission = [2, 1, 0.5]\n\
         [[object]]\nshape = \"sphere\"\ncenter = [0.3, -0.2, 0]\nradius = 1.5\nmaterial = { dielectric = { index = 1 } }\n\
         inside = \"gas\"\n\
         [[object]]\nshape = \"box\"\nmin = [-5, -5, -5]\nmax = [5, 5, 5]\nmaterial = { lambert = { albedo = 0.3 } }\n",
    );
    for share in taken_by_chance(&scene, 4) {
        assert!(share.mean.abs() < 5.0 * share.error + 1e-9, "{share:?}");
    }
    let mut renderer = Renderer::new(&scene, Settings::of(Method::Plain, 40_000, 1));
    renderer.pass(1, &|| false).expect("not cancelled");
    for (emitted, emission) in renderer.energy().emitted.into_iter().zip([2.0, 1.0, 0.5]) {
        let expected = emission * 4.0 * PI * 4.0 / 3.0 * PI * 1.5_f64.powi(3);
        println!("{emitted} for {expected}");
        // Of 40,000 places in a cube 52 % are in its ball: a standard error of half a percent, less for a sequence.
        assert!((emitted / expected - 1.0).abs() < 0.01, "{emitted} for {expected}");
    }
}

/// Voxels: emission goes with the density, here of two layers, and light starts where it is.
#[test]
fn voxels_glow_as_they_are_dense() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut bytes = b"VOL\x03".to_vec();
    [1_i32, 1, 1, 2, 1].iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    [-1.0_f32, -1.0, 0.0, 1.0, 1.0, 2.0].iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    [1.0_f32, 3.0].iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    std::fs::write(folder.path().join("layers.vol"), bytes).expect("written");
    let text = "outside_medium = \"gas\"\n\
         [camera]\nposition = [0, 0, -60]\nlook_at = [0, 0, 0]\nvertical_fov = 0.5\nwidth = 3\nheight = 3\n\
         [[medium]]\nname = \"gas\"\nscattering = 0\nabsorption = [0.5, 0, 1e-7]\nemission = [2, 1, 0.5]\n\
         density = { volume = { file = \"layers.vol\" } }\n";
    let scene = scene_file::parse(text, "layers", folder.path()).expect("a valid scene");
    let found = picture(&scene, 1, 4).radiance[4].as_dvec3();
    // The column is 4: half a metre of 1, one from 1 to 3, half of 3.
    let expected = DVec3::new(2.0 / 0.5 * (1.0 - (-2.0_f64).exp()), 4.0, 2.0);
    println!("{found} for {expected}");
    // Over a quarter of a voxel the density grows by .5, but counts as even: a column up to .5 x .25 / 8 off, times .5.
    assert!((found / expected - 1.0).abs().max_element() < 8e-3, "{found} for {expected}");
}

#[test]
fn gas_without_end_and_emission_that_is_none_are_refused_with_a_remedy() {
    let camera =
        "[camera]\nposition = [0, 0, -4]\nlook_at = [0, 0, 0]\nvertical_fov = 50\nwidth = 8\nheight = 8\n";
    let medium = |more: &str| {
        format!(
            "outside_medium = \"gas\"\n{camera}[[medium]]\nname = \"gas\"\nscattering = 1\nabsorption = 0\n{more}"
        )
    };
    for (more, words) in [
        ("emission = 1\n", ["medium[0].emission", "inside an object"]),
        (
            "emission = 1\ndensity = { exponential = { scale_height = 2 } }\n",
            ["medium[0].emission", "`density` of a volume"],
        ),
        ("emission = -1\n", ["medium[0].emission", "0..=1e9"]),
        ("emission = [1, nan, 1]\n", ["medium[0].emission", "0..=1e9"]),
        ("", ["light", "`emission`"]),
    ] {
        let error = scene_file::parse(&medium(more), "gas", Path::new("")).expect_err(more).to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
}
