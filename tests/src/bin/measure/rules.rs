//! Rules for the kernel's radius against each other: error at equal passes and at equal CPU time.

use crate::rendering::{Reference, cpu_seconds, load, name, other_regions};
use crate::{Outcome, Size};
use covbeam_render::film::Film;
use covbeam_render::pass::{Method, Renderer};
use covbeam_render::radius::RadiusRule;
use covbeam_render::scene::Scene;
use std::path::{Path, PathBuf};

/// None: plain beams, once with the scene's radius, and once with the largest one for all pairs, falling as i^(-1/5).
const RULES: [(&str, Option<RadiusRule>); 6] = [
    ("plain", None),
    (ONE_RADIUS, None),
    ("bias (thesis)", Some(RadiusRule::Bias)),
    ("bias everywhere", Some(RadiusRule::BiasEverywhere)),
    ("least error", Some(RadiusRule::LeastError)),
    ("beam density", Some(RadiusRule::BeamDensity)),
];
const ONE_RADIUS: &str = "one wide radius";

/// When a picture's error is read.
pub(crate) struct Stops {
    /// After these passes, rising.
    pub(crate) passes: Vec<u32>,
    /// After the pass in which these CPU-seconds were spent, rising.
    pub(crate) seconds: Vec<f64>,
}

/// Mean over the runs.
#[derive(Clone, Default)]
struct Point {
    passes: f64,
    seconds: f64,
    rel_mse: Vec<f64>,
}

pub(crate) fn run(
    paths: &[PathBuf],
    references: &Path,
    stops: &Stops,
    planned: bool,
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
        println!(
            "\n{name}: {} x {} pixels, {} light paths a pass, {}, mean of {seeds} runs; {}\n",
            scene.camera.width,
            scene.camera.height,
            scene.settings.photons,
            if planned {
                "planned eye rays (not for the plain ones)"
            } else {
                "an eye ray through every pixel"
            },
            reference.about_noise()
        );
        let names: Vec<&str> = reference.regions.iter().map(|region| region.name).collect();
        println!("| rule | passes | CPU-s | {} |", names.join(" | "));
        println!("|---|---|---|{}", "---|".repeat(names.len()));
        for (label, rule) in RULES {
            let mut scene = scene.clone();
            if label == ONE_RADIUS {
                // Photons on surfaces get wider kernels too.
                (scene.settings.schedule.radius, scene.settings.schedule.alpha) =
                    (scene.settings.schedule.max_radius, 0.8);
            }
            let mut means = vec![Point::default(); stops.passes.len() + stops.seconds.len()];
            for seed in 1..=seeds {
                let points = curve(&scene, reference, rule, stops, planned, seed)?;
                eprintln!("{name}, {label}: run {seed} of {seeds} done");
                let share = 1.0 / f64::from(seeds);
                for (mean, point) in means.iter_mut().zip(points) {
                    mean.passes += share * point.passes;
                    mean.seconds += share * point.seconds;
                    mean.rel_mse.resize(point.rel_mse.len(), 0.0);
                    mean.rel_mse.iter_mut().zip(point.rel_mse).for_each(|(sum, error)| *sum += share * error);
                }
            }
            for Point { passes, seconds, rel_mse } in means {
                let errors: Vec<String> = rel_mse.iter().map(|error| format!("{error:.2e}")).collect();
                println!("| {label} | {passes:.0} | {seconds:.1} | {} |", errors.join(" | "));
            }
        }
    }
    Ok(())
}

/// One run, read at the stops: those by passes, then those by time.
fn curve(
    scene: &Scene,
    reference: &Reference,
    rule: Option<RadiusRule>,
    stops: &Stops,
    planned: bool,
    seed: u32,
) -> Outcome<Vec<Point>> {
    let start = cpu_seconds()?;
    let method = if rule.is_some() { Method::Adaptive } else { Method::Ppb };
    let mut renderer = Renderer::new(scene, method, scene.settings.photons, seed);
    renderer.widen_by(rule.unwrap_or_default());
    if planned {
        renderer.plan_eye_rays();
    }
    let mut film = Film::of_scene(scene);
    let mut spent = cpu_seconds()? - start;
    let (mut by_passes, mut by_time) = (Vec::new(), Vec::new());
    for pass in 1.. {
        let start = cpu_seconds()?;
        let (image, _) = renderer.pass(pass, &|| false).expect("never cancelled");
        film.add(&image)?;
        spent += cpu_seconds()? - start;
        let due = stops.passes.get(by_passes.len()) == Some(&pass);
        let paid = stops.seconds[by_time.len()..].iter().take_while(|budget| spent >= **budget).count();
        if due || paid > 0 {
            let start = cpu_seconds()?;
            let picture = film.picture();
            let seconds = spent + cpu_seconds()? - start;
            let point = Point { passes: f64::from(pass), seconds, rel_mse: reference.rel_mse(&picture)? };
            by_passes.extend(due.then(|| point.clone()));
            by_time.extend(std::iter::repeat_n(point, paid));
        }
        if (by_passes.len(), by_time.len()) == (stops.passes.len(), stops.seconds.len()) {
            break;
        }
    }
    by_passes.append(&mut by_time);
    Ok(by_passes)
}
