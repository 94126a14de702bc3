//! Pictures that are the same along a row, or nearly: rows of four seeds, compared with what they should be.

use crate::statistics::Sample;
use covbeam_session::film::Film;
use covbeam_session::pass::Renderer;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};
use glam::Vec3;

/// Light paths of a pass.
const PATHS: u32 = 20_000;

/// The mean of each row of four pictures, each over its `passes`: first passes, each of a seed of its own.
pub fn runs(scene: &Scene, method: Method, passes: u32) -> Vec<Vec<Vec3>> {
    runs_of(scene, method, passes, PATHS)
}

/// The same, of so many light paths a pass.
pub fn runs_of(scene: &Scene, method: Method, passes: u32, paths: u32) -> Vec<Vec<Vec3>> {
    (0..4)
        .map(|run| {
            let mut film = Film::of_scene(scene);
            for seed in 0..passes {
                let mut renderer = Renderer::new(scene, Settings::of(method, paths, passes * run + seed));
                let (image, _) = renderer.pass(1, &|| false).expect("not cancelled");
                film.add(&image).expect("finite");
            }
            let width = scene.camera.width;
            let row = |row: &[Vec3]| row.iter().sum::<Vec3>() / width as f32;
            film.picture().radiance.chunks(width as usize).map(row).collect()
        })
        .collect()
}

/// A channel of the rows of [`runs`], as many at a time.
pub fn rows(runs: &[Vec<Vec3>], channel: usize, together: usize) -> Vec<Sample> {
    let mean = |run: &Vec<Vec3>, y: usize| {
        let band = &run[y * together..(y + 1) * together];
        band.iter().map(|row| f64::from(row[channel])).sum::<f64>() / together as f64
    };
    let of = |y: usize| runs.iter().map(|run| mean(run, y)).collect::<Vec<_>>();
    (0..runs[0].len() / together).map(|y| Sample::of(&of(y))).collect()
}

/// Whether a row is what it should be, and known well enough to tell.
///
/// - `bias`: relative, besides four standard errors; `noise`: most that the relative standard error may be.
///
/// # Panics
/// If not.
pub fn check(name: &str, found: &Sample, expected: f64, [bias, noise]: [f64; 2]) {
    let (ratio, error) = (found.mean / expected, found.error / expected);
    println!("{name}: {ratio:.4} ± {error:.4}");
    assert!(error < noise, "{name}: too noisy to tell, {error}");
    assert!((ratio - 1.0).abs() < bias + 4.0 * error, "{name}: {ratio} ± {error}");
}
