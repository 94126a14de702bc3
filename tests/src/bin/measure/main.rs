//! The long measurements behind the figures in the documents: run one, read its table.

mod ablation;
mod brute;
mod budget;
mod emission;
mod fleet;
mod grids;
mod marching;
mod means;
mod parts;
mod picture;
mod reference;
mod rendering;
mod speed;
mod truth;
mod wedges;

use clap::{Parser, Subcommand};
use covbeam_tests::figures;
use std::error::Error;
use std::path::PathBuf;

/// Speed, error, agreement and truth of the methods. Tables go to standard output, progress to standard error.
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
        #[command(flatten)]
        size: Size,
    },
    /// Region means of all three methods, each over independent runs, with t-tests. The light tracer does not see what is
    /// behind glass: in scenes other than the balls the whole picture is compared, so these should have no glass.
    Means {
        /// The scene.
        scene: PathBuf,
        /// Its reference, whose means are set beside them.
        #[arg(long)]
        reference: Option<PathBuf>,
        /// Runs of each method.
        #[arg(long, default_value_t = 12, value_parser = clap::value_parser!(u32).range(2..))]
        runs: u32,
        #[command(flatten)]
        size: Size,
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
        #[command(flatten)]
        size: Size,
    },
    /// Renders a scene by brute-force path tracing, which shares nothing with the renderer: what a picture must look like, with its noise.
    Brute {
        /// The scene.
        scene: PathBuf,
        /// Where the picture goes (EXR).
        #[arg(long)]
        out: PathBuf,
        /// CPU-seconds, about.
        #[arg(long, default_value_t = 20.0)]
        time: f64,
        /// Seed.
        #[arg(long, default_value_t = 1)]
        seed: u32,
        /// Part of the picture whose mean is told with its standard error: x0 x1 y0 y1 in parts of its width and height.
        #[arg(long, num_args = 4)]
        region: Option<Vec<f64>>,
    },
    /// Scenes made from a seed: blocks of pixels of the default method against plain beams and light tracing, all tested; brightness by
    /// distance from the brightest part; error at equal CPU time. Writes the scenes, a table of them (fleet.csv) and pictures of the worst.
    Fleet {
        /// Number of scenes.
        #[arg(long, default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..))]
        scenes: u32,
        /// Seed of the fleet.
        #[arg(long, default_value_t = 1)]
        seed: u32,
        /// Number of the first scene.
        #[arg(long, default_value_t = 1)]
        first: u32,
        /// Scenes made as people make them: lengths are quarters, things touch, lamps hang in planes, suns and cameras look along axes. Blocks
        /// against brute-force path tracing, light tracing, and the same scene with everything a hair apart; nothing at equal time.
        #[arg(long)]
        grid: bool,
        /// Pixels across, and down.
        #[arg(long, default_value_t = 72, value_parser = clap::value_parser!(u32).range(16..=16384))]
        width: u32,
        /// CPU-seconds of a method on a scene, rising.
        #[arg(long, value_delimiter = ',', default_values_t = [1.25, 5.0])]
        seconds: Vec<f64>,
        /// Independent runs of each method at equal time.
        #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..))]
        runs: u32,
        /// CPU-seconds of each half of the reference that errors are held against. With less than some eight times what a method has, its
        /// own rare bright pixels hide those of plain beams.
        #[arg(long, default_value_t = 10.0)]
        reference: f64,
        /// Folder to write.
        #[arg(long, default_value = "fleet")]
        out: PathBuf,
    },
    /// Wedges of beams that run nearly along an eye ray, in a ball scene after few passes: how bright, and is their light all there?
    Wedges {
        /// The scene.
        scene: PathBuf,
        /// Its reference.
        reference: PathBuf,
        /// Passes.
        #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..))]
        passes: u32,
        /// Independent runs.
        #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(2..))]
        seeds: u32,
        /// A folder for the pictures of the first run.
        #[arg(long)]
        out: Option<PathBuf>,
        #[command(flatten)]
        size: Size,
    },
    /// Shadow rays along eye rays, for light scattered once: error over shadow rays of the ways to choose their places; writes a log-log plot.
    Marching {
        /// The scenes.
        #[arg(required = true)]
        scenes: Vec<PathBuf>,
        /// Places a piece of an eye path.
        #[arg(long, value_delimiter = ',', default_values_t = [4, 8, 16, 32, 64, 128])]
        budgets: Vec<u32>,
        /// Independent runs to average over.
        #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u32).range(2..))]
        seeds: u32,
        /// Places of each of the two runs of the reference.
        #[arg(long, default_value_t = 2048)]
        reference: u32,
        /// The plot (SVG).
        #[arg(long)]
        plot: Option<PathBuf>,
        #[command(flatten)]
        size: Size,
    },
    /// What making a picture of the passes costs, over its size.
    Picture {
        /// The scene.
        scene: PathBuf,
        /// Pixels across and down.
        #[arg(long, value_delimiter = ',', default_values_t = [256, 1024, 4096])]
        sides: Vec<u32>,
        /// Passes.
        #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..))]
        passes: u32,
    },
    /// Ceilings of a core, tests of beams and rays a core-second, growth of gather and build with the number of beams, and two threads against one.
    Speed,
    /// Writes examples/figures.md and the table of the README: runs the commands that it names, one after the other.
    Figures {
        /// 1: some ten minutes of CPU time; 10: ten times as long, for less noise.
        #[arg(long, default_value_t = 1.0, value_parser = effort)]
        effort: f64,
        /// A folder to write into instead; the README is left alone.
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Each part of light by kind left out in turn: error at equal CPU time. And how much of the error comes from which kind of light, and
    /// from where in the picture.
    Parts {
        /// The scenes.
        #[arg(required = true)]
        scenes: Vec<PathBuf>,
        /// CPU-seconds of a picture.
        #[arg(long, default_value_t = 6.0)]
        seconds: f64,
        /// Independent runs to average over.
        #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(2..))]
        seeds: u32,
        /// CPU-seconds of each of the two halves of the reference.
        #[arg(long, default_value_t = 60.0)]
        reference: f64,
        #[command(flatten)]
        size: Size,
    },
    /// Each operator on light fields left out in turn: truth of the predicted spectra, image error, time.
    Ablation {
        /// The scene.
        scene: PathBuf,
        /// Its reference; without it, no image error.
        #[arg(long)]
        reference: Option<PathBuf>,
        #[command(flatten)]
        effort: Effort,
        #[command(flatten)]
        size: Size,
    },
    /// Shares of photons with a light field and sizes of the grid: truth of the predicted spectra, image error, time.
    Grids {
        /// The scene.
        scene: PathBuf,
        /// Its reference.
        #[arg(long)]
        reference: PathBuf,
        #[command(flatten)]
        effort: Effort,
        #[command(flatten)]
        size: Size,
    },
}

/// Of the pictures.
#[derive(clap::Args, Clone, Copy)]
struct Size {
    /// Pixels across; the height follows [default: those of the reference, if there is one, or of the scene]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=16384))]
    width: Option<u32>,
}

/// Of a truth test with its picture.
#[derive(clap::Args, Clone, Copy)]
struct Effort {
    /// Passes of the picture and of the grid.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..))]
    passes: u32,
    /// Light paths that measure the fluence.
    #[arg(long, default_value_t = 16_000_000, value_parser = clap::value_parser!(u32).range(16..=1 << 30))]
    paths: u32,
}

fn effort(text: &str) -> Result<f64, String> {
    let effort = text.parse().ok().filter(|effort: &f64| *effort > 0.0 && *effort <= 100.0);
    effort.ok_or_else(|| "expected a number above 0, at most 100".to_owned())
}

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    match Arguments::parse().measurement {
        Measurement::Reference { scene, out, passes, photons, size } => {
            reference::run(&scene, &out, passes, photons, size)
        }
        Measurement::Means { scene, reference, runs, size } => {
            means::run(&scene, reference.as_deref(), runs, size)
        }
        Measurement::Emission { scene, passes, pairs, size } => emission::run(&scene, passes, pairs, size),
        Measurement::Brute { scene, out, time, seed, region } => {
            brute::run(&scene, &out, time, seed, region.as_deref().unwrap_or(&[0.0, 1.0, 0.0, 1.0]))
        }
        Measurement::Fleet { scenes, seed, first, grid: true, width, seconds, out, .. } => {
            fleet::grid::run(seed, first..first + scenes, width, seconds[0], &out)
        }
        Measurement::Fleet { scenes, seed, first, grid: false, width, seconds, runs, reference, out } => {
            fleet::run(&fleet::Fleet { scenes, seed, first, width, seconds, runs, reference, out })
        }
        Measurement::Wedges { scene, reference, passes, seeds, out, size } => {
            wedges::run(&scene, &reference, passes, seeds, out, size)
        }
        Measurement::Marching { scenes, budgets, seeds, reference, plot, size } => {
            marching::run(&scenes, &budgets, seeds, reference, plot.as_deref(), size)
        }
        Measurement::Picture { scene, sides, passes } => picture::run(&scene, &sides, passes),
        Measurement::Speed => speed::run(),
        Measurement::Figures { effort, out } => figures::write(effort, out.as_deref()),
        Measurement::Parts { scenes, seconds, seeds, reference, size } => {
            parts::run(&scenes, seconds, seeds, reference, size)
        }
        Measurement::Ablation { scene, reference, effort, size } => {
            ablation::run(&scene, reference.as_deref(), effort, size)
        }
        Measurement::Grids { scene, reference, effort, size } => grids::run(&scene, &reference, effort, size),
    }
}
