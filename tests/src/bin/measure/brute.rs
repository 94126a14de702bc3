//! A scene by brute-force path tracing.

use crate::Outcome;
use covbeam_render::files::output::{RenderInfo, check_writable, write_exr};
use covbeam_session::film::Picture;
use covbeam_tests::brute_force::BruteForce;
use covbeam_tests::fleet::runs::mean;
use covbeam_tests::statistics::Sample;
use cpu_time::ProcessTime;
use std::path::Path;

/// Independent pictures, from which the error is known.
const RUNS: u32 = 16;

pub(crate) fn run(path: &Path, out: &Path, time: f64, seed: u32, region: &[f64]) -> Outcome<()> {
    check_writable(out)?;
    let text = std::fs::read_to_string(path)?;
    let scene = BruteForce::parse(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    if !scene.is_all_found() {
        println!("light of lamps without a size that glass or mirrors send on is missing");
    }
    // One path a pixel tells what a path costs.
    let start = ProcessTime::now();
    scene.picture(0, 1);
    let a_path = start.elapsed().as_secs_f64();
    let paths = ((time / f64::from(RUNS) / a_path) as u32).max(1);
    let pictures: Vec<Picture> = (0..RUNS).map(|run| scene.picture(RUNS * seed + run, paths)).collect();
    let spent = start.elapsed().as_secs_f64();
    println!("{} paths a pixel, {spent:.1} CPU-seconds", RUNS * paths);
    for (channel, name) in ["red", "green", "blue"].into_iter().enumerate() {
        let means: Vec<f64> = pictures.iter().map(|picture| of_region(picture, region, channel)).collect();
        let Sample { mean, error, .. } = Sample::of(&means);
        println!("{name}: mean {mean:.5e}, standard error {error:.1e}");
    }
    let info = RenderInfo {
        method: "brute force".to_owned(),
        passes: RUNS * paths,
        photons: 1,
        seed,
        scene: path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default(),
    };
    write_exr(out, &mean(&pictures), &info)?;
    Ok(())
}

fn of_region(picture: &Picture, region: &[f64], channel: usize) -> f64 {
    let side = |part: f64, side: u32| (part * f64::from(side)).round() as u32;
    let (mut sum, mut count) = (0.0, 0.0);
    for y in side(region[2], picture.height)..side(region[3], picture.height) {
        for x in side(region[0], picture.width)..side(region[1], picture.width) {
            sum += f64::from(picture.radiance[(y * picture.width + x) as usize][channel]);
            count += 1.0;
        }
    }
    sum / count
}
