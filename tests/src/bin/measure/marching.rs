//! Places along eye rays for light scattered once: error over shadow rays.

use crate::rendering::{load, name};
use crate::{Outcome, Size};
use covbeam_render::study::compare::compare;
use covbeam_render::study::plot::{self, Plot, sheet};
use covbeam_session::film::{Film, Picture};
use covbeam_session::gather::march::{Marching, Placement};
use covbeam_session::pass::Renderer;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};
use covbeam_tests::fleet::runs::mean;
use covbeam_tests::statistics::Sample;
use std::path::{Path, PathBuf};

const PLACEMENTS: [(Placement, &str); 4] = [
    (Placement::Uniform, "uniform"),
    (Placement::EquiAngular, "equi-angular"),
    (Placement::MaximumDensity, "maximum density"),
    (Placement::Adaptive, "adaptive"),
];

/// How many times the greatest budget is doubled for the placements that the adaptive one is compared with.
const FARTHER: u32 = 3;

/// One method at one budget: mean over the runs.
#[derive(Clone, Copy)]
struct Point {
    /// Places a piece of an eye path, as asked for.
    samples: u32,
    /// Shadow rays a pixel.
    rays: f64,
    /// Core-seconds a picture.
    seconds: f64,
    rel_mse: f64,
    /// Of one run, as a share of the mean.
    spread: f64,
}

/// One method.
struct Curve {
    label: &'static str,
    points: Vec<Point>,
}

/// The picture of one pass, its shadow rays a pixel and its core-seconds.
fn picture(scene: &Scene, placement: Placement, samples: u32, seed: u32) -> Outcome<(Picture, f64, f64)> {
    let marching = Marching { placement, samples, centred: true };
    let settings = Settings { marching, ..Settings::of_scene(Method::March, scene, seed) };
    let mut renderer = Renderer::new(scene, settings);
    let (image, times) = renderer.pass(1, &|| false).expect("never cancelled");
    let mut film = Film::new(image.width, image.height);
    film.add(&image)?;
    let rays = times.shadow_rays as f64 / image.gather.len() as f64;
    Ok((film.picture(), rays, times.total()))
}

pub(crate) fn run(
    paths: &[PathBuf],
    budgets: &[u32],
    seeds: u32,
    reference_samples: u32,
    plot: Option<&Path>,
    size: Size,
) -> Outcome<()> {
    let mut all = Vec::new();
    for path in paths {
        let scene = load(path, size)?;
        let name = name(path);
        // Two methods that are not judged against the third: their difference is the noise of their mean.
        let [first, second] = [Placement::EquiAngular, Placement::Uniform]
            .map(|placement| picture(&scene, placement, reference_samples, 1001));
        let halves = [first?.0, second?.0];
        let reference = mean(&halves);
        let noise = compare(&halves[0], &halves[1], |_, _| true)?.rel_mse / 4.0;
        println!(
            "\n{name}, {} x {} pixels, {seeds} runs; noise of the reference (relMSE) {noise:.1e}\n",
            reference.width, reference.height
        );
        println!(
            "| places | method | shadow rays a pixel | relMSE | ± of a run | core-seconds |\n|---|---|---|---|---|---|"
        );
        let mut curves = Vec::new();
        for (placement, label) in PLACEMENTS {
            let mut points = Vec::new();
            // The others go on, to find what they need for the adaptive placement's errors.
            let last = budgets.iter().max().copied().unwrap_or(1);
            let more = if placement == Placement::Adaptive { 0 } else { FARTHER };
            for samples in budgets.iter().copied().chain((1..=more).map(|step| last << step)) {
                let (mut errors, mut rays, mut seconds) = (Vec::new(), 0.0, 0.0);
                for seed in 1..=seeds {
                    let (picture, traced, time) = picture(&scene, placement, samples, seed)?;
                    errors.push(compare(&picture, &reference, |_, _| true)?.rel_mse);
                    rays += traced / f64::from(seeds);
                    seconds += time / f64::from(seeds);
                }
                let sample = Sample::of(&errors);
                let spread = sample.error * sample.count.sqrt() / sample.mean;
                let point = Point { samples, rays, seconds, rel_mse: sample.mean, spread };
                println!(
                    "| {samples} | {label} | {rays:.2} | {:.2e} | {:.0} % | {seconds:.2} |",
                    point.rel_mse,
                    100.0 * spread
                );
                points.push(point);
            }
            curves.push(Curve { label, points });
        }
        print_ratios(&curves);
        all.push((name, curves));
    }
    if let Some(plot) = plot {
        std::fs::write(plot, drawn(&all)?)?;
        println!("\nwrote {}", plot.display());
    }
    Ok(())
}

/// What a curve needs of `cost` to reach an error: log-log interpolation; None outside the curve.
fn cost_at(points: &[Point], rel_mse: f64, cost: impl Fn(&Point) -> f64) -> Option<f64> {
    points.windows(2).find_map(|pair| {
        let (a, b) = (pair[0].rel_mse.ln(), pair[1].rel_mse.ln());
        let share = (rel_mse.ln() - a) / (b - a);
        let (low, high) = (cost(&pair[0]).ln(), cost(&pair[1]).ln());
        (0.0..=1.0).contains(&share).then(|| (low + share * (high - low)).exp())
    })
}

/// What the adaptive placement saves at its own errors, against the best of the others.
fn print_ratios(curves: &[Curve]) {
    println!(
        "\n| places | adaptive's shadow rays over the best other's | its places | its core-seconds | at equal shadow rays, relMSE over the best other's |\n|---|---|---|---|---|"
    );
    let (others, adaptive) = curves.split_at(3);
    for point in &adaptive[0].points {
        let best = |cost: fn(&Point) -> f64| {
            let costs = others.iter().filter_map(|curve| cost_at(&curve.points, point.rel_mse, cost));
            costs.reduce(f64::min).map_or("-".to_owned(), |other| format!("{:.2}", cost(point) / other))
        };
        let errors = others.iter().filter_map(|curve| {
            curve.points.windows(2).find_map(|pair| {
                let share = (point.rays.ln() - pair[0].rays.ln()) / (pair[1].rays.ln() - pair[0].rays.ln());
                let (low, high) = (pair[0].rel_mse.ln(), pair[1].rel_mse.ln());
                (0.0..=1.0).contains(&share).then(|| (low + share * (high - low)).exp())
            })
        });
        let error = errors.reduce(f64::min).map_or("-".to_owned(), |e| format!("{:.2}", point.rel_mse / e));
        println!(
            "| {} | {} | {} | {} | {error} |",
            point.samples,
            best(|p| p.rays),
            best(|p| f64::from(p.samples)),
            best(|p| p.seconds)
        );
    }
}

/// Error over shadow rays a pixel, a plot for each scene side by side; the bands are the spread of a run.
fn drawn(scenes: &[(String, Vec<Curve>)]) -> Outcome<String> {
    const COLORS: [[u8; 3]; 4] = [[213, 94, 0], [204, 121, 167], [0, 158, 115], [0, 114, 178]];
    let point = |point: &Point| plot::Point {
        x: point.rays,
        y: point.rel_mse,
        band: [1.0 / (1.0 + point.spread), 1.0 + point.spread].map(|factor| factor * point.rel_mse),
    };
    let curve = |(mark, (curve, color)): (usize, (&Curve, [u8; 3]))| plot::Curve {
        name: curve.label.to_owned(),
        color,
        mark,
        points: curve.points.iter().map(point).collect(),
    };
    let plot = |(name, curves): &(String, Vec<Curve>)| Plot {
        title: name.clone(),
        axes: ["shadow rays a pixel", "relMSE"],
        curves: curves.iter().zip(COLORS).enumerate().map(curve).collect(),
        laws: &[],
        text: 18,
    };
    let plots: Vec<Plot> = scenes.iter().map(plot).collect();
    let (width, height) = (460 * scenes.len() as u32, 440);
    let legend = plots.iter().map(Plot::legend_height).max().unwrap_or(0);
    let svg = sheet((width, height + legend), |root| {
        root.split_evenly((1, plots.len()))
            .iter()
            .zip(&plots)
            .try_for_each(|(area, plot)| plot.draw(area, height))
    });
    Ok(svg?)
}
