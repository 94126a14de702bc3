//! Reference pictures.

use crate::rendering::{Run, ball_regions, first_run, in_region, load};
use crate::{Outcome, Size};
use covbeam_render::film::Picture;
use covbeam_render::output::{RenderInfo, check_writable, write_exr};
use covbeam_render::pass::Method;
use covbeam_tests::regions::{Region, by_sharpness};
use std::path::Path;

/// Narrowest kernel, in radii of the scene: its bias is a sixth of that of a plain first pass.
const RADIUS_FACTOR: f32 = 0.4;

/// A kernel as wide as this allows biases by 0.05 % in the first pass, and less in later ones.
const ERROR: f32 = 5e-4;

const SEEDS: [u32; 2] = [1001, 1002];

pub(crate) fn run(path: &Path, out: &Path, passes: u32, photons: u32, size: Size) -> Outcome<()> {
    check_writable(out)?;
    check_writable(&first_run(out))?;
    let mut scene = load(path, size)?;
    scene.settings.schedule.radius *= RADIUS_FACTOR;
    scene.settings.schedule.error = ERROR;
    let mut pictures = Vec::new();
    for seed in SEEDS {
        let run = Run { photons, ..Run::new(&scene, Method::Adaptive, seed, passes) };
        let (picture, times) = run.step_by_step(|pass, _, seconds| {
            eprintln!("seed {seed}: {pass} of {passes} passes, {seconds:.0} core-seconds");
            Ok(())
        })?;
        println!("seed {seed}: {passes} passes of {photons} paths, {:.0} core-seconds", times.total());
        pictures.push(picture);
    }
    let (first, second) = (&pictures[0], &pictures[1]);
    let radiance = first.radiance.iter().zip(&second.radiance).map(|(a, b)| 0.5 * (*a + *b)).collect();
    let mean =
        Picture { width: first.width, height: first.height, radiance, error: None, layers: None, maps: None };
    println!("noise of the average (relMSE), a quarter of the two runs' difference squared:");
    let print_noise = |region: &Region| -> Outcome<()> {
        let noise = in_region(first, second, region)?.rel_mse / 4.0;
        println!("  {:8} {noise:.2e}", region.name);
        Ok(())
    };
    by_sharpness(&mean).iter().try_for_each(print_noise)?;
    if let Some(regions) = ball_regions(path, &scene) {
        println!("and in the named regions of the ball scenes:");
        regions.iter().try_for_each(print_noise)?;
    }
    let info = RenderInfo {
        method: "adaptive, two runs".to_owned(),
        passes: 2 * passes,
        photons,
        seed: SEEDS[0],
        scene: path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default(),
    };
    write_exr(out, &mean, &info)?;
    let half = first_run(out);
    write_exr(&half, first, &RenderInfo { method: "adaptive".to_owned(), passes, ..info })?;
    println!("wrote {} and its first run, {}", out.display(), half.display());
    Ok(())
}
