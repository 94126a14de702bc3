//! The renderer with planned eye rays: repeatable bits, the means and the silhouettes of the picture with all eye rays, and scenes
//! with next to nothing in them.

use covbeam_render::scene_file;
use covbeam_session::film::{Film, Picture};
use covbeam_session::kind::Split;
use covbeam_session::pass::Renderer;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Layers, Method, Settings};
use covbeam_tests::regions::of_ball;
use covbeam_tests::statistics::{Sample, sidak, welch};
use glam::Vec3;
use std::path::Path;

const GLASS: &str = include_str!("../../../examples/scenes/glass-ball.toml");
const BLACK: &str = include_str!("../../../examples/scenes/black-ball.toml");

fn scene(text: &str, width: u32, height: u32) -> Scene {
    let mut scene = scene_file::parse(text, "test scene", Path::new(".")).expect("a valid scene");
    (scene.camera.width, scene.camera.height) = (width, height);
    scene
}

fn picture(
    scene: &Scene,
    planned: bool,
    photons: u32,
    seed: u32,
    passes: impl IntoIterator<Item = u32>,
) -> Picture {
    picture_by(Method::Thesis, scene, planned, photons, seed, passes)
}

fn picture_by(
    method: Method,
    scene: &Scene,
    planned: bool,
    photons: u32,
    seed: u32,
    passes: impl IntoIterator<Item = u32>,
) -> Picture {
    let mut renderer = Renderer::new(scene, Settings { planned, ..Settings::of(method, photons, seed) });
    let mut film = Film::of_scene(scene);
    for index in passes {
        let (image, _) = renderer.pass(index, &|| false).expect("not cancelled");
        film.add(&image).expect("finite");
    }
    film.picture()
}

#[test]
fn the_picture_is_the_same_bits_for_any_number_of_threads_and_any_order_of_passes() {
    let scene = scene(GLASS, 40, 36);
    let in_order = picture(&scene, true, 700, 3, 1..=4);
    for threads in [1, 2, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let again = pool.install(|| picture(&scene, true, 700, 3, 1..=4));
        assert!(again == in_order, "{threads} threads");
    }
    assert!(picture(&scene, true, 700, 3, [3, 1, 4, 2]) == in_order, "passes in another order");
    assert!(picture(&scene, true, 700, 4, 1..=4) != in_order, "the seed does nothing");
}

/// Region means with few eye rays and filters, against an eye ray through every pixel.
#[test]
fn planned_eye_rays_change_no_region_mean() {
    let scene = scene(GLASS, 64, 64);
    let runs: u32 = 8;
    let means = |planned: bool, first: u32| -> Vec<Vec<f64>> {
        let mut means = vec![Vec::new(); 6];
        for seed in first..first + runs {
            let picture = picture(&scene, planned, 2000, seed, 1..=16);
            for (means, region) in means.iter_mut().zip(of_ball(64)) {
                let inside = (0..64 * 64_u32).filter(|pixel| region.contains(pixel % 64, pixel / 64));
                let sum: f64 = inside.map(|pixel| f64::from(picture.radiance[pixel as usize].x)).sum();
                means.push(sum / region.count() as f64);
            }
        }
        means
    };
    let (every, planned) = (means(false, 1), means(true, 101));
    // Filters may bias by ε = 1 % in the first pass and less later, of either sign: the test must see more than that.
    let level = sidak(0.01, 6);
    for (region, (every, planned)) in of_ball(64).iter().zip(every.iter().zip(&planned)) {
        let (a, b) = (Sample::of(every), Sample::of(planned));
        let p = welch(a, b);
        assert!(p > level, "{}: every pixel {a:?}, planned {b:?}, p {p}", region.name);
        // Few photons are seen on the floor and through the ball, and few beams in the caustic.
        let change = if ["volume", "smooth"].contains(&region.name) { 1.05 } else { 1.25 };
        let brighter: Vec<f64> = planned.iter().map(|mean| change * mean).collect();
        assert!(welch(a, Sample::of(&brighter)) < level, "{}: {change} times would not be seen", region.name);
    }
}

/// In front of the black ball there is half as much fog as beside it: a filter across the silhouette would mix the two.
#[test]
fn no_light_crosses_a_silhouette() {
    let size = 96;
    let scene = scene(BLACK, size, size);
    let every = picture(&scene, false, 3000, 1, 1..=24);
    let planned = picture(&scene, true, 3000, 1, 1..=24);
    let maps = planned.maps.as_ref().expect("planned");
    // Mean luminance of rings around the ball's silhouette, a pixel wide, without the shadow below it.
    let ring = |picture: &Picture, from: f32| {
        let (mut sum, mut count) = (Vec3::ZERO, 0.0);
        for pixel in 0..size * size {
            let (x, y) = ((pixel % size) as f32 + 0.5 - 48.0, (pixel / size) as f32 + 0.5 - 48.0);
            if (from..from + 1.0).contains(&x.hypot(y)) && y < 0.0 {
                sum += picture.radiance[pixel as usize];
                count += 1.0;
            }
        }
        sum.x / count
    };
    // 40.8 pixels of 256.
    let silhouette = 40.8 * size as f32 / 256.0;
    assert!(ring(&every, silhouette + 2.0) > 1.5 * ring(&every, silhouette - 3.0), "no contrast to lose");
    for offset in [-6.0, -4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 5.0] {
        let (a, b) = (ring(&every, silhouette + offset), ring(&planned, silhouette + offset));
        // The same photons; a filter of several pixels across the edge would take or give a quarter of the light next to it.
        assert!((a / b - 1.0).abs() < 0.04, "ring at {offset}: {a} with all eye rays, {b} planned");
    }
    let wide = maps.layers[0].filters.iter().filter(|filter| filter.xx > 4.0 && filter.yy > 4.0).count();
    assert!(wide > maps.layers[0].filters.len() / 2, "filters are narrow anyway: {wide} wide ones");
}

#[test]
fn few_eye_rays_are_traced_where_the_light_is_smooth_and_many_in_the_caustic() {
    let picture = picture(&scene(GLASS, 256, 256), true, 5000, 1, 1..=2);
    let maps = picture.maps.expect("planned");
    let mean = |region: usize| {
        let region = &of_ball(256)[region];
        let inside = (0..256 * 256_u32).filter(|pixel| region.contains(pixel % 256, pixel / 256));
        inside.map(|pixel| f64::from(maps.layers[0].filters[pixel as usize].density())).sum::<f64>()
            / region.count() as f64
    };
    // What the filters ask for; no density goes below half a ray a light path.
    assert!(maps.density().iter().all(|density| *density >= 2500.0 / 65536.0));
    let (smooth, caustic) = (mean(2), mean(3));
    assert!(smooth < 0.05, "{smooth} eye rays a pixel in smooth fog");
    assert!(caustic > 5.0 * smooth, "{caustic} eye rays a pixel in the caustic, {smooth} in smooth fog");
}

/// The noise of marching is small and its own in each pixel: with filters the picture must stay the same, pixel by pixel.
#[test]
fn marching_with_planned_eye_rays_gives_the_picture_of_all_eye_rays() {
    let scene = scene(BLACK, 96, 96);
    let all = picture_by(Method::March, &scene, false, 5000, 1, 1..=8);
    let planned = picture_by(Method::March, &scene, true, 5000, 1, 1..=8);
    assert!(planned == picture_by(Method::March, &scene, true, 5000, 1, [5, 1, 7, 2, 8, 3, 6, 4]));
    let rays = |picture: &Picture| picture.layers.as_ref().unwrap().samples.iter().sum::<f32>();
    assert!(rays(&planned) < 0.5 * rays(&all), "{} shadow rays of {}", rays(&planned), rays(&all));
    for (region, limit) in of_ball(96).iter().zip([0.04, 0.03, 0.02, 0.06, 0.04, 0.04]) {
        let inside = (0..96 * 96_u32).filter(|pixel| region.contains(pixel % 96, pixel / 96));
        let (mut difference, mut light) = (0.0, 0.0);
        for pixel in inside {
            let (a, b) = (all.radiance[pixel as usize].x, planned.radiance[pixel as usize].x);
            difference += f64::from(a - b).powi(2);
            light += f64::from(a).powi(2);
        }
        // Root mean square over that of the light: ε = 1 % of bias in the first pass, and the noise of eight.
        let error = (difference / light).sqrt();
        assert!(error < limit, "{}: {error}", region.name);
    }
}

#[test]
fn pictures_of_one_pixel_and_of_one_row_are_rendered() {
    for (width, height) in [(1, 1), (1, 9), (37, 1), (5, 3)] {
        let picture = picture(&scene(GLASS, width, height), true, 300, 1, 1..=2);
        assert_eq!(picture.radiance.len(), (width * height) as usize);
        assert!(picture.radiance.iter().all(|v| v.is_finite()), "{width} x {height}");
        assert!(picture.radiance.iter().any(|v| v.x > 0.0), "{width} x {height}");
    }
}

#[test]
fn a_picture_without_any_light_is_black() {
    // The lamp is shut in, so that no path is ever seen and most of the grid stays empty.
    let shut = GLASS.replace("[[light]]", "[[object]]\nshape = \"box\"\nmin = [-0.2, 2.3, -0.2]\nmax = [0.2, 2.7, 0.2]\nmaterial = \"black\"\n\n[[light]]");
    assert_ne!(shut, GLASS);
    let picture = picture(&scene(&shut, 33, 20), true, 300, 1, 1..=3);
    assert!(picture.radiance.iter().all(|v| *v == Vec3::ZERO));
    let maps = picture.maps.expect("planned");
    // Nothing is known there: an eye ray through each pixel, and no filter.
    assert!(maps.density().iter().all(|density| *density > 0.0 && *density <= 1.0));
}

/// Cancelled while it catches up with the light fields of passes 1 to 16, whichever it had got to.
#[test]
fn a_cancelled_pass_leaves_no_spectra_behind() {
    let scene = scene(GLASS, 24, 24);
    let clean = picture(&scene, true, 700, 3, [9]);
    for polls in 1..=30 {
        let settings = Settings { planned: true, ..Settings::of(Method::Thesis, 700, 3) };
        let mut renderer = Renderer::new(&scene, settings);
        let left = std::sync::atomic::AtomicI32::new(polls);
        let cancelled = || left.fetch_sub(1, std::sync::atomic::Ordering::Relaxed) <= 0;
        assert!(renderer.pass(20, &cancelled).is_none(), "{polls} polls are enough for a pass");
        let mut film = Film::of_scene(&scene);
        film.add(&renderer.pass(9, &|| false).expect("not cancelled").0).expect("finite");
        assert!(film.picture() == clean, "after {polls} polls");
    }
}

#[test]
fn a_camera_outside_all_media_still_sees_what_is_inside_glass() {
    let inside =
        GLASS.replace("outside_medium = \"fog\"", "").replace("# inside = \"fog\"", "inside = \"fog\"");
    assert!(inside != GLASS && inside.contains("\ninside = \"fog\""));
    let mut scene = scene(&inside, 24, 24);
    // Wide enough to be looked up where there is fog before the glass.
    scene.settings.schedule.max_radius = 4.0 * scene.settings.schedule.radius;
    let planned = picture(&scene, true, 2000, 1, 1..=2);
    assert!(planned.radiance[12 * 24 + 12].x > 0.0);
    assert!(planned.maps.is_none(), "there is nothing to plan");
    // Where no filter thins rays out wide kernels cost more than they are worth: these are plain ones.
    assert!(planned != picture(&scene, false, 2000, 1, 1..=2));
    assert!(planned == picture_by(Method::Plain, &scene, false, 2000, 1, 1..=2));
}

/// What is before the first surface alone is what a whole picture keeps of it, and it is kept where no eye rays need planning, too.
#[test]
fn what_is_beyond_the_first_surface_is_left_out_and_what_is_before_it_kept_apart() {
    let settings = Settings { planned: true, ..Settings::of(Method::Thesis, 2000, 1) };
    let render = |scene: &Scene, settings: Settings| {
        let mut renderer = Renderer::new(scene, settings);
        let mut film = Film::of_scene(scene);
        for index in 1..=3 {
            film.add(&renderer.pass(index, &|| false).expect("not cancelled").0).expect("finite");
        }
        film.picture()
    };
    let fog = scene(GLASS, 32, 32);
    let (whole, first) = (render(&fog, settings), render(&fog, Settings { beyond: false, ..settings }));
    let volume = &whole.maps.as_ref().expect("planned").volume;
    assert!(first.radiance == *volume && volume[5 * 32 + 16].x > 0.0);
    assert!(whole.radiance[16 * 32 + 16].x > 1.05 * first.radiance[16 * 32 + 16].x, "glass shows more");

    let inside =
        GLASS.replace("outside_medium = \"fog\"", "").replace("# inside = \"fog\"", "inside = \"fog\"");
    let inside = scene(&inside, 32, 32);
    let kept = Settings { first_apart: true, ..settings };
    let (plain, apart) = (render(&inside, settings), render(&inside, kept));
    assert!(plain.maps.is_none());
    assert!(apart.maps.expect("kept").volume.iter().all(|light| *light == Vec3::ZERO));
    let mean = |picture: &[Vec3]| picture.iter().map(|light| f64::from(light.x)).sum::<f64>();
    let ratio = mean(&apart.radiance) / mean(&plain.radiance);
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
}

/// A picture can be given up wherever it has got to, and asked for again.
#[test]
fn a_picture_that_was_given_up_leaves_no_trace() {
    let scene = scene(GLASS, 40, 40);
    let settings =
        Settings { planned: true, layers: Layers::EachKind, ..Settings::of(Method::Thesis, 500, 1) };
    let mut renderer = Renderer::new(&scene, settings);
    let mut film = Film::of_scene(&scene);
    film.keep_kinds(Split::of_each_kind(&scene));
    for index in 1..=3 {
        film.add(&renderer.pass(index, &|| false).expect("not cancelled").0).expect("finite");
    }
    let (before, mut given_up) = (film.picture(), 0);
    for polls in (0..).step_by(97) {
        let left = std::sync::atomic::AtomicI32::new(polls);
        let cancelled = || left.fetch_sub(1, std::sync::atomic::Ordering::Relaxed) <= 0;
        if let Some(picture) = film.picture_unless(&cancelled) {
            assert!(picture == before);
            break;
        }
        given_up += 1;
    }
    assert!(given_up > 20, "{given_up}");
    assert!(film.picture() == before);
}
