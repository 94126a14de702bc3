//! Adaptive against plain beams, scene by scene.

use crate::rendering::{Errors, Reference, Run, SHARPNESS, load, name};
use crate::{Outcome, Size};
use covbeam_render::pass::Method;
use covbeam_render::scene::Scene;
use std::path::{Path, PathBuf};

/// After some passes, mean over the runs.
#[derive(Clone, Copy, Default)]
struct Point {
    passes: u32,
    seconds: f64,
    errors: Errors,
}

pub(crate) fn run(paths: &[PathBuf], references: &Path, passes: u32, seeds: u32, size: Size) -> Outcome<()> {
    // All files first: a missing one must not be found after an hour.
    let mut scenes = Vec::new();
    for path in paths {
        let scene = load(path, size)?;
        let reference = Reference::load(&references.join(name(path) + ".exr"), &scene, Vec::new())?;
        scenes.push((name(path), scene, reference));
    }
    let mut last = Vec::new();
    for (name, scene, reference) in &scenes {
        let curve = |method, label: &str| -> Outcome<Vec<Point>> {
            let mut points = vec![Point::default(); passes.ilog2() as usize + 1];
            for seed in 1..=seeds {
                Run::new(scene, method, seed, passes).step_by_step(|pass, picture, seconds| {
                    eprintln!("{name}, {label}, run {seed} of {seeds}: {pass} of {passes} passes");
                    let point = &mut points[pass.ilog2() as usize];
                    point.passes = pass;
                    point.seconds += seconds / f64::from(seeds);
                    point.errors.add_share(&reference.errors(picture)?, f64::from(seeds));
                    Ok(())
                })?;
            }
            Ok(points)
        };
        let plain = curve(Method::Ppb, "plain")?;
        let adaptive = curve(Method::Adaptive, "adaptive")?;
        print_table(name, scene, &reference.about_noise(), seeds, &plain, &adaptive);
        last.push((name, plain[plain.len() - 1], adaptive[adaptive.len() - 1]));
    }
    println!("\nRatio of relMSE, adaptive over plain, after {passes} passes of the same photons\n");
    println!("| scene | {} | core-seconds |\n|---|---|---|---|---|", SHARPNESS.join(" | "));
    for (name, plain, adaptive) in &last {
        let [whole, smooth, sharp] = adaptive.errors.ratio(&plain.errors);
        let seconds = adaptive.seconds / plain.seconds;
        println!("| {name} | {whole:.3} | {smooth:.3} | {sharp:.3} | {seconds:.2} |");
    }
    Ok(())
}

fn print_table(name: &str, scene: &Scene, noise: &str, seeds: u32, plain: &[Point], adaptive: &[Point]) {
    println!(
        "\n{name}: adaptive against plain beams (ppb) over passes of {} light paths, the same for both; {} x {} pixels, mean \
         of {seeds} runs; smooth, sharp: half and fifth of the picture; {noise}\n",
        scene.settings.photons, scene.camera.width, scene.camera.height
    );
    println!(
        "| passes | method | relMSE {} | bias [%] {} | core-seconds |",
        SHARPNESS.join(" | relMSE "),
        SHARPNESS.join(" | bias [%] ")
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for (plain, adaptive) in plain.iter().zip(adaptive) {
        for (label, point) in [("plain", plain), ("adaptive", adaptive)] {
            let [rel_mse, bias] = point.errors.cells();
            println!("| {} | {label} | {rel_mse} | {bias} | {:.1} |", point.passes, point.seconds);
        }
        let [whole, smooth, sharp] = adaptive.errors.ratio(&plain.errors);
        println!(
            "| {} | ratio | {whole:.3} | {smooth:.3} | {sharp:.3} | | | | {:.2} |",
            plain.passes,
            adaptive.seconds / plain.seconds
        );
    }
}
