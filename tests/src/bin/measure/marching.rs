//! Places along eye rays for light scattered once: error over shadow rays.

use crate::rendering::{load, name};
use crate::{Outcome, Size};
use covbeam_render::compare::compare;
use covbeam_render::film::{Film, Picture};
use covbeam_render::march::{Marching, Placement};
use covbeam_render::pass::{Method, Renderer};
use covbeam_render::scene::Scene;
use covbeam_tests::statistics::Sample;
use plotters::prelude::*;
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
    let mut renderer = Renderer::new(scene, Method::March, scene.settings.photons, seed);
    renderer.march_as(Marching { placement, samples, centred: true });
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
        let (first, second) = (first?.0, second?.0);
        let radiance = first.radiance.iter().zip(&second.radiance).map(|(a, b)| 0.5 * (*a + *b)).collect();
        let reference = Picture { radiance, layers: None, ..first.clone() };
        let noise = compare(&first, &second, |_, _| true)?.rel_mse / 4.0;
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
        draw(plot, &all)?;
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

/// One log-log plot of relMSE over shadow rays a pixel for each scene.
fn draw(path: &Path, scenes: &[(String, Vec<Curve>)]) -> Outcome<()> {
    let root = SVGBackend::new(path, (460 * scenes.len() as u32, 440)).into_drawing_area();
    root.fill(&WHITE)?;
    for (area, (name, curves)) in root.split_evenly((1, scenes.len())).iter().zip(scenes) {
        let all = || curves.iter().flat_map(|curve| &curve.points);
        let range = |value: fn(&Point) -> f64| {
            all().map(value).fold((f64::MAX, 0.0), |(low, high): (f64, f64), v| (low.min(v), high.max(v)))
        };
        let (fewest, most) = range(|point| point.rays);
        let (low, high) = range(|point| point.rel_mse);
        let mut chart = ChartBuilder::on(area)
            .caption(name, ("sans-serif", 20))
            .margin(12)
            .x_label_area_size(36)
            .y_label_area_size(64)
            .build_cartesian_2d(
                (0.8 * fewest..1.25 * most).log_scale(),
                (0.5 * low..2.0 * high).log_scale(),
            )?;
        chart
            .configure_mesh()
            .x_desc("shadow rays a pixel")
            .y_desc("relMSE")
            .light_line_style(TRANSPARENT)
            .y_label_formatter(&|v| format!("{v:.0e}"))
            .x_label_formatter(&|v| format!("{v}"))
            .draw()?;
        for (Curve { label, points }, color) in curves.iter().zip([RED, MAGENTA, GREEN, BLUE]) {
            let style = color.stroke_width(2);
            chart
                .draw_series(LineSeries::new(points.iter().map(|point| (point.rays, point.rel_mse)), style))?
                .label(*label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], style));
            // The spread of a run.
            chart.draw_series(points.iter().map(|point| {
                let ends = [1.0 / (1.0 + point.spread), 1.0 + point.spread];
                PathElement::new(ends.map(|end| (point.rays, end * point.rel_mse)).to_vec(), style)
            }))?;
        }
        if name == &scenes[0].0 {
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::LowerLeft)
                .background_style(WHITE.mix(0.8))
                .border_style(BLACK)
                .draw()?;
        }
    }
    root.present()?;
    Ok(())
}
