//! The renderer as a whole: repeatable bits, energy, and what must be invisible.

use covbeam_render::scene_file;
use covbeam_session::camera::Frame;
use covbeam_session::film::Film;
use covbeam_session::pass::Renderer;
use covbeam_session::paths::Energy;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};
use covbeam_tests::energy::taken_by_chance;
use covbeam_tests::statistics::{Sample, welch};
use glam::Vec3;
use std::path::Path;

const GLASS: &str = include_str!("../../../examples/scenes/glass-ball.toml");

fn scene(text: &str, size: u32) -> Scene {
    let mut scene = scene_file::parse(text, "test scene", Path::new(".")).expect("a valid scene");
    (scene.camera.width, scene.camera.height) = (size, size);
    scene
}

/// The same with no more of the picture than is looked at: from a pixel on, as wide and high.
fn part(text: &str, size: u32, [x, y]: [u32; 2], [width, height]: [u32; 2]) -> Scene {
    let mut scene = scene(text, size);
    let Frame::Middle { half_height } = scene.camera.frame else { panic!("a whole picture") };
    let step = 2.0 * half_height / size as f32;
    let (left, top) = (x as f32 * step - half_height, half_height - y as f32 * step);
    scene.camera.frame = Frame::Part { left, top, step: [step; 2] };
    (scene.camera.width, scene.camera.height) = (width, height);
    scene
}

fn picture(
    scene: &Scene,
    method: Method,
    photons: u32,
    seed: u32,
    passes: impl IntoIterator<Item = u32>,
) -> Vec<Vec3> {
    let mut renderer = Renderer::new(scene, Settings::of(method, photons, seed));
    let mut film = Film::of_scene(scene);
    for index in passes {
        let (image, _) = renderer.pass(index, &|| false).expect("not cancelled");
        film.add(&image).expect("finite");
    }
    film.picture().radiance
}

fn bits(picture: &[Vec3]) -> Vec<[u32; 3]> {
    picture.iter().map(|color| color.to_array().map(f32::to_bits)).collect()
}

/// The room with fog that thins out with height.
fn thinning(text: &str) -> String {
    const DENSITY: &str = "absorption = 0.02\ndensity = { exponential = { scale_height = 2.0 } }";
    let thinning = text.replace("absorption = 0.02", DENSITY);
    assert_ne!(thinning, text);
    thinning
}

#[test]
fn the_picture_is_the_same_bits_for_any_number_of_threads() {
    let (homogeneous, thinning) = (scene(GLASS, 40), scene(&thinning(GLASS), 40));
    for (method, scene) in [
        (Method::Plain, &homogeneous),
        (Method::Thesis, &homogeneous),
        (Method::LightTrace, &homogeneous),
        (Method::Thesis, &thinning),
    ] {
        let with_threads = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| bits(&picture(scene, method, 700, 3, 1..=3)))
        };
        let one = with_threads(1);
        assert!(one == with_threads(2), "{method:?}: 1 and 2 threads");
        assert!(one == with_threads(7), "{method:?}: 1 and 7 threads");
        assert!(one != bits(&picture(scene, method, 700, 4, 1..=3)), "{method:?}: the seed does nothing");
    }
}

#[test]
fn the_picture_is_the_same_bits_for_any_order_of_passes() {
    let scene = scene(GLASS, 40);
    for method in [Method::Plain, Method::Thesis, Method::LightTrace] {
        let in_order = bits(&picture(&scene, method, 700, 3, 1..=4));
        assert!(in_order == bits(&picture(&scene, method, 700, 3, [3, 1, 4, 2])), "{method:?}");
    }
}

#[test]
fn a_cancelled_pass_returns_nothing() {
    let scene = scene(GLASS, 40);
    for method in [Method::Plain, Method::Thesis, Method::LightTrace] {
        assert!(Renderer::new(&scene, Settings::of(method, 700, 3)).pass(1, &|| true).is_none());
    }
}

/// emitted = medium + surfaces + escaped + roulette, and the roulette's share is noise around zero.
#[test]
fn no_energy_is_lost_or_made() {
    let coloured = GLASS
        .replace("scattering = 0.2 ", "scattering = [0.5, 0.2, 0.1] ")
        .replace("absorption = 0.02", "absorption = [0.01, 0.0, 0.3]")
        .replace("albedo = 0.5", "albedo = [0.9, 0.5, 0.1]");
    assert_ne!(coloured, GLASS);
    for text in [GLASS, &coloured] {
        let scene = scene(text, 8);
        for (c, sample) in taken_by_chance(&scene, 20).iter().enumerate() {
            // Six tests at 5 standard errors: a false alarm in 1e5.
            assert!(sample.mean.abs() < 5.0 * sample.error + 1e-9, "channel {c}: {sample:?}");
            assert!(sample.error < 0.005, "the test could not see a loss of a few percent: {sample:?}");
        }
    }
}

#[test]
fn paths_end_in_a_medium_that_never_does() {
    // No walls, no floor, no absorption: nothing but chance ends a path, and takes no energy on average.
    let open = "outside_medium = \"fog\"\n\
        [camera]\nposition = [0, 0, -5]\nlook_at = [0, 0, 0]\nvertical_fov = 35\nwidth = 8\nheight = 8\n\
        [[medium]]\nname = \"fog\"\nscattering = 2.0\nabsorption = 0.0\n\
        [[light]]\nkind = \"point\"\nposition = [0, 0, 0]\nintensity = 1.0\n\
        [grid]\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n";
    for text in [
        open.to_owned(),
        open.replace(
            "absorption = 0.0",
            "absorption = 0.0\ndensity = { exponential = { scale_height = 0.5 } }",
        ),
    ] {
        let scene = scene(&text, 8);
        let shares: Vec<f64> = (1..=12)
            .map(|seed| {
                let mut renderer = Renderer::new(&scene, Settings::of(Method::Thesis, 2000, seed));
                renderer.pass(1, &|| false).expect("not cancelled");
                let Energy { emitted, medium, surfaces, escaped, spent, roulette } = renderer.energy();
                let balance = medium[0] + surfaces[0] + escaped[0] + spent[0] + roulette[0] - emitted[0];
                assert!(balance.abs() < 1e-6 * emitted[0], "balance {balance}");
                // What is neither absorbed nor escapes is taken by chance: all of it where the fog is everywhere.
                (escaped[0] + roulette[0]) / emitted[0]
            })
            .collect();
        assert!(shares.iter().all(|share| (share - 1.0).abs() < 1e-6), "{shares:?}");
    }
}

#[test]
fn a_ball_of_fog_with_the_index_of_air_is_invisible() {
    // Beams and eye rays are cut, refracted and put together again at its surface.
    let ball = GLASS.replace("index = 1.5", "index = 1.0").replace("# inside = \"fog\"", "inside = \"fog\"");
    assert_ne!(ball, GLASS);
    let (start, end) = (
        GLASS.find("[[object]]\nname = \"ball\"").unwrap(),
        GLASS.find("[[object]]\nname = \"floor\"").unwrap(),
    );
    let none = GLASS[..start].to_owned() + &GLASS[end..];
    // Pixels that see the ball: a disk of 5.1 pixels around the centre of 32, which is at 5 of the 10 from the eleventh on.
    let mean = |picture: &[Vec3]| {
        let seen = |i: usize| (i % 10).abs_diff(5).pow(2) + (i / 10).abs_diff(5).pow(2) <= 20;
        let values: Vec<f64> = picture
            .iter()
            .enumerate()
            .filter(|(i, _)| seen(*i))
            .map(|(_, color)| f64::from(color.y))
            .collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    // The scene's kernels have one radius: plain beams make the same picture.
    let sample = |text: &str, first| {
        let scene = part(text, 32, [11, 11], [10, 10]);
        let picture = |seed| picture(&scene, Method::Thesis, 10_000, seed, 1..=6);
        Sample::of(&(first..first + 10).map(|seed| mean(&picture(seed))).collect::<Vec<_>>())
    };
    let (with, without) = (sample(&ball, 500), sample(&none, 600));
    println!("with {with:?}, without {without:?}");
    assert!(welch(with, without) > 0.001, "{with:?} {without:?}");
    // Losing what one of the two surfaces reflects at the index 1.5 would show.
    assert!(with.error / with.mean < 0.012 && without.error / without.mean < 0.012);
}
