//! Error at equal CPU time.

use crate::budget::spend;
use crate::rendering::{Reference, load, name, other_regions};
use crate::{Outcome, Size};
use covbeam_render::pass::{Method, Renderer};
use covbeam_render::scene::Scene;
use std::path::{Path, PathBuf};

/// What is compared: with whether the eye rays are planned.
const METHODS: [(&str, Method, bool); 2] =
    [("plain", Method::Ppb, false), ("adaptive, planned", Method::Adaptive, true)];

/// One method when a budget was spent, mean over the runs.
#[derive(Clone, Default)]
struct Point {
    passes: f64,
    seconds: f64,
    /// Without the reference's noise, by region.
    rel_mse: Vec<f64>,
}

pub(crate) fn run(
    paths: &[PathBuf],
    references: &Path,
    budgets: &[f64],
    seeds: u32,
    size: Size,
) -> Outcome<()> {
    let mut scenes = Vec::new();
    for path in paths {
        let scene = load(path, size)?;
        let others = other_regions(path, &scene);
        let reference = Reference::load(&references.join(name(path) + ".exr"), &scene, others)?;
        scenes.push((name(path), scene, reference));
    }
    for (name, scene, reference) in &scenes {
        let mut curves = Vec::new();
        for (label, method, planned) in METHODS {
            let mut points = vec![Point::default(); budgets.len()];
            for seed in 1..=seeds {
                let renderer = || {
                    let mut renderer = Renderer::new(scene, method, scene.settings.photons, seed);
                    if planned {
                        renderer.plan_eye_rays();
                    }
                    renderer
                };
                let found = spend(scene, renderer, budgets)?;
                eprintln!("{name}, {label}: run {seed} of {seeds} done");
                for (point, found) in points.iter_mut().zip(found) {
                    let share = 1.0 / f64::from(seeds);
                    point.passes += share * f64::from(found.passes);
                    point.seconds += share * found.seconds;
                    let rel_mse = reference.rel_mse(&found.picture)?;
                    point.rel_mse.resize(rel_mse.len(), 0.0);
                    point.rel_mse.iter_mut().zip(rel_mse).for_each(|(sum, error)| *sum += share * error);
                }
            }
            curves.push((label, points));
        }
        print_table(name, scene, reference, seeds, &curves);
    }
    Ok(())
}

fn print_table(name: &str, scene: &Scene, reference: &Reference, seeds: u32, curves: &[(&str, Vec<Point>)]) {
    let noise = reference.about_noise();
    println!(
        "\n{name}: relMSE at equal CPU time, {} x {} pixels, {} light paths a pass, mean of {seeds} runs; {noise}\n",
        scene.camera.width, scene.camera.height, scene.settings.photons
    );
    let names: Vec<&str> = reference.regions.iter().map(|region| region.name).collect();
    println!("| CPU-s | method | passes | {} |", names.join(" | "));
    println!("|---|---|---|{}", "---|".repeat(names.len()));
    let row = |values: &[f64]| values.iter().map(|e| format!("{e:.2e}")).collect::<Vec<_>>().join(" | ");
    for budget in 0..curves[0].1.len() {
        let plain = &curves[0].1[budget];
        for (label, points) in curves {
            let point = &points[budget];
            println!("| {:.1} | {label} | {:.0} | {} |", point.seconds, point.passes, row(&point.rel_mse));
        }
        for (label, points) in &curves[1..] {
            let ratio: Vec<String> = points[budget]
                .rel_mse
                .iter()
                .zip(&plain.rel_mse)
                .map(|(e, p)| format!("{:.3}", e / p))
                .collect();
            println!("| | {label} / plain | | {} |", ratio.join(" | "));
        }
    }
}
