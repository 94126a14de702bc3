//! Error over passes.

use crate::rendering::{Run, in_region, load, load_reference, regions};
use crate::{Outcome, Size};
use covbeam_render::pass::Method;
use covbeam_render::random::Emission;
use covbeam_tests::regions::Region;
use covbeam_tests::statistics::Sample;
use plotters::prelude::*;
use std::path::Path;

/// Error of one method at the powers of two, averaged over the runs.
struct Curve {
    name: &'static str,
    color: RGBColor,
    /// Passes, core-seconds, relMSE by region.
    points: Vec<(u32, f64, Vec<f64>)>,
    /// Bias by region at the end, of each run.
    bias: Vec<Vec<f64>>,
}

pub(crate) fn run(
    path: &Path,
    reference: &Path,
    plot: &Path,
    passes: u32,
    seeds: u32,
    size: Size,
) -> Outcome<()> {
    let scene = load(path, size)?;
    let reference = load_reference(reference, &scene)?;
    let regions = regions(path, &scene, Some(&reference));
    let photons = scene.settings.photons;
    let mut curves = Vec::new();
    for (name, color, method, emission) in [
        ("ppb", RED, Method::Ppb, Emission::LowDiscrepancy),
        ("adaptive", BLUE, Method::Adaptive, Emission::LowDiscrepancy),
        ("ppb, independent photons", MAGENTA, Method::Ppb, Emission::Independent),
        ("adaptive, independent photons", CYAN, Method::Adaptive, Emission::Independent),
    ] {
        let mut curve = Curve { name, color, points: Vec::new(), bias: vec![Vec::new(); regions.len()] };
        for seed in 1..=seeds {
            let mut step = 0;
            let run = Run { emission, ..Run::new(&scene, method, seed, passes) };
            let (last, _) = run.step_by_step(|pass, picture, seconds| {
                if seed == 1 {
                    curve.points.push((pass, 0.0, vec![0.0; regions.len()]));
                }
                let (_, time, errors) = &mut curve.points[step];
                *time += seconds / f64::from(seeds);
                for (error, region) in errors.iter_mut().zip(&regions) {
                    *error += in_region(picture, &reference, region)?.rel_mse / f64::from(seeds);
                }
                step += 1;
                Ok(())
            })?;
            for (bias, region) in curve.bias.iter_mut().zip(&regions) {
                bias.push(in_region(&last, &reference, region)?.bias);
            }
        }
        print_curve(&curve, &regions);
        curves.push(curve);
    }
    let last = |curve: &Curve, region: usize| curve.points.last().expect("at least one pass").2[region];
    println!("\nratio of relMSE at {passes} passes of {photons} paths ({seeds} runs each):");
    println!(
        "{:8} {:>14} {:>22} {:>26}",
        "", "adaptive/ppb", "independent/low-d. ppb", "independent/low-d. adaptive"
    );
    for (i, region) in regions.iter().enumerate() {
        let [ppb, adaptive, ppb_random, adaptive_random] = [0, 1, 2, 3].map(|curve| last(&curves[curve], i));
        println!(
            "{:8} {:14.3} {:22.2} {:26.2}",
            region.name,
            adaptive / ppb,
            ppb_random / ppb,
            adaptive_random / adaptive
        );
    }
    println!("\nbias of the region's mean, % ± standard error; and of adaptive minus ppb, same photons:");
    for (i, region) in regions.iter().enumerate().filter(|_| seeds > 1) {
        let percent = |values: &[f64]| {
            let s = Sample::of(values);
            format!("{:+.2} ± {:.2}", 100.0 * s.mean, 100.0 * s.error)
        };
        let difference: Vec<f64> =
            curves[1].bias[i].iter().zip(&curves[0].bias[i]).map(|(a, p)| a - p).collect();
        println!(
            "{:8} ppb {}   adaptive {}   difference {}",
            region.name,
            percent(&curves[0].bias[i]),
            percent(&curves[1].bias[i]),
            percent(&difference)
        );
    }
    draw(plot, &curves, &regions)?;
    println!("wrote {}", plot.display());
    Ok(())
}

fn print_curve(curve: &Curve, regions: &[Region]) {
    println!("\n{}", curve.name);
    print!("passes  core-s");
    regions.iter().for_each(|region| print!(" {:>9}", region.name));
    println!();
    for (passes, seconds, errors) in &curve.points {
        print!("{passes:6} {seconds:7.2}");
        errors.iter().for_each(|error| print!(" {error:9.2e}"));
        println!();
    }
}

/// One log-log plot of relMSE over passes for each of some regions.
fn draw(path: &Path, curves: &[Curve], regions: &[Region]) -> Outcome<()> {
    let root = SVGBackend::new(path, (1260, 460)).into_drawing_area();
    root.fill(&WHITE)?;
    let passes = curves[0].points.last().map_or(1, |point| point.0);
    let drawn = ["smooth", "volume", "caustic", "sharp"];
    let drawn = regions.iter().enumerate().filter(|(_, region)| drawn.contains(&region.name));
    let areas = root.split_evenly((1, drawn.clone().count()));
    for (area, (index, region)) in areas.iter().zip(drawn) {
        let errors = || curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.2[index]));
        let (low, high) = (errors().fold(f64::MAX, f64::min), errors().fold(0.0, f64::max));
        let mut chart = ChartBuilder::on(area)
            .caption(region.name, ("sans-serif", 20))
            .margin(12)
            .x_label_area_size(36)
            .y_label_area_size(64)
            .build_cartesian_2d((1.0..f64::from(passes)).log_scale(), (0.6 * low..1.6 * high).log_scale())?;
        chart
            .configure_mesh()
            .x_desc("passes")
            .y_desc("relMSE")
            .light_line_style(TRANSPARENT)
            .y_label_formatter(&|v| format!("{v:.0e}"))
            .x_label_formatter(&|v| format!("{v:.0}"))
            .draw()?;
        for curve in curves {
            let style = curve.color.stroke_width(2);
            let points = curve.points.iter().map(|point| (f64::from(point.0), point.2[index]));
            chart
                .draw_series(LineSeries::new(points, style))?
                .label(curve.name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], style));
        }
        if region.name == "smooth" {
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
