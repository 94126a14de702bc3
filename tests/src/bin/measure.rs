//! The long measurements behind the figures in the README: run one, read its table.

use clap::{Parser, Subcommand};
use covbeam_render::compare::{Comparison, compare};
use covbeam_render::film::{Film, Picture};
use covbeam_render::output::{RenderInfo, read_picture, write_exr};
use covbeam_render::pass::{Method, PassTimes, Renderer};
use covbeam_render::random::Emission;
use covbeam_render::scene::{Material, Scene, SceneMedium};
use covbeam_tests::regions::{CAUSTIC, REGIONS, Region, SMOOTH, VOLUME};
use covbeam_tests::statistics::{Sample, sidak, welch};
use glam::Vec3;
use plotters::prelude::*;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Speed, error and agreement of the methods on the ball scenes.
#[derive(Parser)]
struct Arguments {
    #[command(subcommand)]
    measurement: Measurement,
}

#[derive(Subcommand)]
enum Measurement {
    /// Makes a reference picture: two long runs with a tiny error bound, averaged. Prints the noise left.
    Reference {
        /// The scene.
        scene: PathBuf,
        /// Where the picture goes.
        out: PathBuf,
        /// Passes of each run.
        #[arg(long, default_value_t = 100)]
        passes: u32,
        /// Light paths a pass.
        #[arg(long, default_value_t = 50_000)]
        photons: u32,
    },
    /// Error over passes of plain and adaptive beams, and of independent emission; writes a log-log plot.
    Convergence {
        /// The scene.
        scene: PathBuf,
        /// Its reference.
        reference: PathBuf,
        /// The plot (SVG).
        plot: PathBuf,
        /// Passes, a power of two.
        #[arg(long, default_value_t = 64)]
        passes: u32,
        /// Independent runs to average the error over.
        #[arg(long, default_value_t = 3)]
        seeds: u32,
    },
    /// Region means of all three methods, each over independent runs, with t-tests.
    Means {
        /// The scene.
        scene: PathBuf,
        /// Its reference, whose means are set beside them.
        #[arg(long)]
        reference: Option<PathBuf>,
        /// Runs of each method.
        #[arg(long, default_value_t = 12)]
        runs: u32,
    },
    /// What low-discrepancy emission is worth: noise of both ways to draw light paths, from pairs of runs, in the scene
    /// as it is and with single scattering only.
    Emission {
        /// The scene.
        scene: PathBuf,
        /// Passes of a run.
        #[arg(long, default_value_t = 32)]
        passes: u32,
        /// Pairs of runs.
        #[arg(long, default_value_t = 2)]
        pairs: u32,
    },
    /// Core time of a pass by part, pairs per core-second at two radii, and peak memory.
    Cost {
        /// The scene.
        scene: PathBuf,
        /// Passes to average over.
        #[arg(long, default_value_t = 8)]
        passes: u32,
    },
}

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    match Arguments::parse().measurement {
        Measurement::Reference { scene, out, passes, photons } => reference(&scene, &out, passes, photons),
        Measurement::Convergence { scene, reference, plot, passes, seeds } => {
            convergence(&scene, &reference, &plot, passes, seeds)
        }
        Measurement::Means { scene, reference, runs } => means(&scene, reference.as_deref(), runs),
        Measurement::Emission { scene, passes, pairs } => emission(&scene, passes, pairs),
        Measurement::Cost { scene, passes } => cost(&scene, passes),
    }
}

/// Renders `passes` passes and calls `after` with the picture so far after each pass that is a power of two.
fn run(
    scene: &Scene,
    method: Method,
    emission: Emission,
    seed: u32,
    photons: u32,
    passes: u32,
    mut after: impl FnMut(u32, &Picture, f64) -> Outcome<()>,
) -> Outcome<(Picture, PassTimes)> {
    let mut renderer = Renderer::with_emission(scene, method, photons, seed, emission);
    let mut film = Film::new(scene.camera.width, scene.camera.height);
    let mut total = PassTimes::default();
    for index in 1..=passes {
        let (image, times) = renderer.pass(index, &|| false).expect("never cancelled");
        film.add(&image)?;
        total += times;
        if index.is_power_of_two() {
            after(index, &film.picture(), total.total())?;
        }
    }
    Ok((film.picture(), total))
}

fn in_region(picture: &Picture, reference: &Picture, region: &Region) -> Outcome<Comparison> {
    Ok(compare(picture, reference, |x, y| (region.contains)(x, y))?)
}

fn reference(path: &Path, out: &Path, passes: u32, photons: u32) -> Outcome<()> {
    let mut scene = Scene::load(path)?;
    // A kernel this narrow biases by less than its error bound allows: 0.05 % in the first pass, falling.
    scene.settings.radius = 0.02;
    scene.settings.error = 5e-4;
    scene.settings.max_radius = 0.1;
    let mut pictures = Vec::new();
    for seed in [1001, 1002] {
        let emission = Emission::LowDiscrepancy;
        let (picture, times) =
            run(&scene, Method::Adaptive, emission, seed, photons, passes, |_, _, _| Ok(()))?;
        println!("seed {seed}: {passes} passes of {photons} paths, {:.0} core-seconds", times.total());
        pictures.push(picture);
    }
    let (first, second) = (&pictures[0], &pictures[1]);
    let radiance = first.radiance.iter().zip(&second.radiance).map(|(a, b)| 0.5 * (*a + *b)).collect();
    let mean = Picture { width: first.width, height: first.height, radiance, layers: None };
    println!("noise of the average (relMSE), a quarter of the two runs' difference squared:");
    for region in &REGIONS {
        let noise = in_region(first, second, region)?.rel_mse / 4.0;
        println!("  {:8} {noise:.2e}", region.name);
    }
    let info = RenderInfo {
        method: "adaptive, two runs".to_owned(),
        passes: 2 * passes,
        photons,
        seed: 1001,
        scene: path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default(),
    };
    write_exr(out, &mean, &info)?;
    println!("wrote {}", out.display());
    Ok(())
}

/// Error of one method at the powers of two, averaged over the runs.
struct Curve {
    name: &'static str,
    color: RGBColor,
    /// Passes, core-seconds, relMSE by region.
    points: Vec<(u32, f64, [f64; REGIONS.len()])>,
    /// Bias by region at the end, of each run.
    bias: [Vec<f64>; REGIONS.len()],
}

fn convergence(path: &Path, reference: &Path, plot: &Path, passes: u32, seeds: u32) -> Outcome<()> {
    let scene = Scene::load(path)?;
    let reference = read_picture(reference)?;
    let photons = scene.settings.photons;
    let mut curves = Vec::new();
    for (name, color, method, emission) in [
        ("ppb", RED, Method::Ppb, Emission::LowDiscrepancy),
        ("adaptive", BLUE, Method::Adaptive, Emission::LowDiscrepancy),
        ("ppb, independent photons", MAGENTA, Method::Ppb, Emission::Independent),
        ("adaptive, independent photons", CYAN, Method::Adaptive, Emission::Independent),
    ] {
        let mut curve = Curve { name, color, points: Vec::new(), bias: Default::default() };
        for seed in 1..=seeds {
            let mut step = 0;
            let (last, _) =
                run(&scene, method, emission, seed, photons, passes, |pass, picture, seconds| {
                    if seed == 1 {
                        curve.points.push((pass, 0.0, [0.0; REGIONS.len()]));
                    }
                    let (_, time, errors) = &mut curve.points[step];
                    *time += seconds / f64::from(seeds);
                    for (error, region) in errors.iter_mut().zip(&REGIONS) {
                        *error += in_region(picture, &reference, region)?.rel_mse / f64::from(seeds);
                    }
                    step += 1;
                    Ok(())
                })?;
            for (bias, region) in curve.bias.iter_mut().zip(&REGIONS) {
                bias.push(in_region(&last, &reference, region)?.bias);
            }
        }
        print_curve(&curve);
        curves.push(curve);
    }
    let last = |curve: &Curve| curve.points.last().expect("at least one pass").2;
    println!("\nratio of relMSE at {passes} passes of {photons} paths ({seeds} runs each):");
    println!(
        "{:8} {:>14} {:>22} {:>26}",
        "", "adaptive/ppb", "independent/low-d. ppb", "independent/low-d. adaptive"
    );
    for (i, region) in REGIONS.iter().enumerate() {
        let [ppb, adaptive, ppb_random, adaptive_random] = [0, 1, 2, 3].map(|curve| last(&curves[curve])[i]);
        println!(
            "{:8} {:14.3} {:22.2} {:26.2}",
            region.name,
            adaptive / ppb,
            ppb_random / ppb,
            adaptive_random / adaptive
        );
    }
    println!("\nbias of the region's mean, % ± standard error; and of adaptive minus ppb, same photons:");
    for (i, region) in REGIONS.iter().enumerate().filter(|_| seeds > 1) {
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
    draw(plot, &curves)?;
    println!("wrote {}", plot.display());
    Ok(())
}

fn print_curve(curve: &Curve) {
    println!("\n{}", curve.name);
    print!("passes  core-s");
    REGIONS.iter().for_each(|region| print!(" {:>9}", region.name));
    println!();
    for (passes, seconds, errors) in &curve.points {
        print!("{passes:6} {seconds:7.2}");
        errors.iter().for_each(|error| print!(" {error:9.2e}"));
        println!();
    }
}

/// One log-log plot of relMSE over passes for each of three regions.
fn draw(path: &Path, curves: &[Curve]) -> Outcome<()> {
    let root = SVGBackend::new(path, (1260, 460)).into_drawing_area();
    root.fill(&WHITE)?;
    let passes = curves[0].points.last().map_or(1, |point| point.0);
    for (area, region) in root.split_evenly((1, 3)).iter().zip([SMOOTH, VOLUME, CAUSTIC]) {
        let index = REGIONS.iter().position(|r| r.name == region.name).expect("a region of the list");
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
        if region.name == VOLUME.name {
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

fn means(path: &Path, reference: Option<&Path>, runs: u32) -> Outcome<()> {
    let scene = Scene::load(path)?;
    let reference = reference.map(read_picture).transpose()?;
    let methods = [
        ("ppb", Method::Ppb, 16, scene.settings.photons),
        ("adaptive", Method::Adaptive, 8, scene.settings.photons),
        ("light-trace", Method::LightTrace, 1, 2_000_000),
    ];
    let mut values: Vec<Vec<Vec<f64>>> = Vec::new();
    for (name, method, passes, photons) in methods {
        let mut by_region = vec![Vec::new(); REGIONS.len()];
        for seed in 1..=runs {
            // Seeds of one method never meet those of another.
            let seed = 100_000 * (values.len() as u32 + 1) + seed;
            let (picture, _) =
                run(&scene, method, Emission::LowDiscrepancy, seed, photons, passes, |_, _, _| Ok(()))?;
            for (values, region) in by_region.iter_mut().zip(&REGIONS) {
                values.push(in_region(&picture, &picture, region)?.mean);
            }
        }
        eprintln!("{name}: {runs} runs of {passes} x {photons} paths");
        values.push(by_region);
    }
    // The light tracer sees neither the glass nor anything through it.
    let compared = [VOLUME, SMOOTH, CAUSTIC, REGIONS[5]];
    let level = sidak(0.01, 3 * compared.len());
    println!("region means (luminance) and two-sided p-values of Welch's t-test; reject below {level:.1e}");
    for region in compared {
        let index = REGIONS.iter().position(|r| r.name == region.name).expect("a region of the list");
        let [p, a, l] = [0, 1, 2].map(|method| Sample::of(&values[method][index]));
        let show = |s: Sample| format!("{:.5} ± {:.2} %", s.mean, 100.0 * s.error / s.mean);
        println!(
            "{:8} ppb {}   adaptive {}   light-trace {}   p(ppb, adaptive) {:.3}  p(ppb, light) {:.3}  p(adaptive, light) {:.3}",
            region.name,
            show(p),
            show(a),
            show(l),
            welch(p, a),
            welch(p, l),
            welch(a, l)
        );
        if let Some(reference) = &reference {
            let mean = in_region(reference, reference, &region)?.mean;
            let off = |s: Sample| format!("{:+.2} σ", (mean - s.mean) / s.error);
            println!(
                "         reference {mean:.5}: {} from ppb, {} from adaptive, {} from light-trace",
                off(p),
                off(a),
                off(l)
            );
        }
        if welch(p, a) < level || welch(p, l) < level || welch(a, l) < level {
            return Err(format!("the means of '{}' differ", region.name).into());
        }
    }
    Ok(())
}

/// Scales scattering down by a thousand at equal extinction and makes diffuse surfaces black: the second order of
/// scattering is lost in the first.
fn scatter_once(scene: &mut Scene) {
    for SceneMedium { medium, .. } in &mut scene.media {
        let extinction = medium.extinction();
        medium.scattering *= 1e-3;
        medium.absorption = extinction - medium.scattering;
    }
    for object in &mut scene.objects {
        if let Material::Lambert { albedo } = &mut object.material {
            *albedo = Vec3::ZERO;
        }
    }
}

fn emission(path: &Path, passes: u32, pairs: u32) -> Outcome<()> {
    println!("noise (relMSE) after {passes} passes: independent photons, low-discrepancy photons, ratio");
    for single in [false, true] {
        let mut scene = Scene::load(path)?;
        if single {
            scatter_once(&mut scene);
        }
        for (name, method) in [("ppb", Method::Ppb), ("adaptive", Method::Adaptive)] {
            let mut noise = [[0.0; REGIONS.len()]; 2];
            for (noise, emission) in noise.iter_mut().zip([Emission::Independent, Emission::LowDiscrepancy]) {
                for pair in 0..pairs {
                    let picture = |seed| {
                        run(&scene, method, emission, seed, scene.settings.photons, passes, |_, _, _| Ok(()))
                    };
                    let ((a, _), (b, _)) = (picture(2 * pair + 1)?, picture(2 * pair + 2)?);
                    for (noise, region) in noise.iter_mut().zip(&REGIONS) {
                        *noise += 0.5 * in_region(&a, &b, region)?.rel_mse / f64::from(pairs);
                    }
                }
            }
            println!("{name}, {}", if single { "single scattering" } else { "the scene as it is" });
            for (i, region) in REGIONS.iter().enumerate() {
                let [independent, low] = [noise[0][i], noise[1][i]];
                println!("  {:8} {independent:.2e} {low:.2e} {:6.2}", region.name, independent / low);
            }
        }
    }
    Ok(())
}

fn cost(path: &Path, passes: u32) -> Outcome<()> {
    let mut scene = Scene::load(path)?;
    println!(
        "{:9} {:>6}  core-milliseconds a pass: trace | light fields | grid | build | gather",
        "method", "radius"
    );
    for (name, method, radius) in
        [("ppb", Method::Ppb, 0.05), ("ppb", Method::Ppb, 0.004), ("adaptive", Method::Adaptive, 0.05)]
    {
        // The radius stays (almost) where it is: α near 1.
        scene.settings.radius = radius;
        scene.settings.alpha = 0.999;
        let photons = scene.settings.photons;
        let emission = Emission::LowDiscrepancy;
        let (_, times) = run(&scene, method, emission, 1, photons, passes, |_, _, _| Ok(()))?;
        let part = |seconds: f64| 1e3 * seconds / f64::from(passes);
        let fields = times.light_fields + times.grid;
        println!(
            "{name:9} {radius:6.3}  {:.1} | {:.1} | {:.1} | {:.1} | {:.1}   light fields + grid {:.1} %, {:.2} M accepted pairs, {:.1} M a core-second of gather",
            part(times.trace),
            part(times.light_fields),
            part(times.grid),
            part(times.build),
            part(times.gather),
            100.0 * fields / times.total(),
            times.pairs as f64 / f64::from(passes) / 1e6,
            times.pairs as f64 / times.gather / 1e6,
        );
    }
    if let Some(peak) = std::fs::read_to_string("/proc/self/status")
        .ok()
        .and_then(|status| status.lines().find(|line| line.starts_with("VmHWM")).map(str::to_owned))
    {
        println!("peak memory: {}", peak.trim_start_matches("VmHWM:").trim());
    }
    Ok(())
}
