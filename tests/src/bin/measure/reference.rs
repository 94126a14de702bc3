//! Reference pictures.

use crate::rendering::{Run, in_region, load, name};
use crate::{Outcome, Size};
use covbeam_render::files::output::{RenderInfo, check_writable, write_exr};
use covbeam_render::progress::Display;
use covbeam_session::settings::Method;
use covbeam_tests::fleet::runs::mean;
use covbeam_tests::regions::of_scene;
use std::path::Path;

/// Narrowest kernel, in radii of the scene: its bias is a sixth of that of a plain first pass.
const RADIUS_FACTOR: f32 = 0.4;

/// A kernel as wide as this allows biases by 0.05 % in the first pass, and less in later ones.
const ERROR: f32 = 5e-4;

const SEEDS: [u32; 2] = [1001, 1002];

pub(crate) fn run(path: &Path, out: &Path, passes: u32, photons: u32, size: Size) -> Outcome<()> {
    // Where those look for the first of its two runs who take the reference's noise off.
    let half = out.with_file_name(name(out) + "-half.exr");
    check_writable(out)?;
    check_writable(&half)?;
    let mut scene = load(path, size)?;
    scene.settings.schedule.radius *= RADIUS_FACTOR;
    scene.settings.schedule.error = ERROR;
    let display = Display::new();
    let mut pictures = Vec::new();
    for (number, seed) in (0..).zip(SEEDS) {
        let run = Run { photons, ..Run::new(&scene, Method::Thesis, seed, passes) };
        let (picture, times) = run.picture_telling(|pass, _| {
            let share = f64::from(number * passes + pass) / f64::from(2 * passes);
            display.show(&format!("run {} of 2: {pass} of {passes} passes", number + 1), share);
        })?;
        println!("seed {seed}: {passes} passes of {photons} paths, {:.0} core-seconds", times.total());
        pictures.push(picture);
    }
    display.finish();
    let mean = mean(&pictures);
    println!("noise of the average (relMSE), a quarter of the two runs' difference squared:");
    for region in &of_scene(&name(path), &mean) {
        let noise = in_region(&pictures[0], &pictures[1], region)?.rel_mse / 4.0;
        println!("  {:8} {noise:.2e}", region.name);
    }
    let info = RenderInfo {
        method: "adaptive, two runs".to_owned(),
        passes: 2 * passes,
        photons,
        seed: SEEDS[0],
        scene: path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default(),
    };
    write_exr(out, &mean, &info)?;
    write_exr(&half, &pictures[0], &RenderInfo { method: "adaptive".to_owned(), passes, ..info })?;
    println!("wrote {} and its first run, {}", out.display(), half.display());
    Ok(())
}
