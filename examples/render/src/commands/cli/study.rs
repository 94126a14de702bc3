//! `covbeam compare`, `spectrum` and `report`: what a picture is worth.

use super::values::{LineArgument, NamedRegion, named_region, point, report_method, seconds, share};
use clap::Args;
use glam::Vec3;
use std::path::PathBuf;
use std::time::Duration;

#[derive(Args, Debug)]
pub(crate) struct CompareArgs {
    /// The picture to judge
    #[arg(value_name = "A.exr")]
    pub(crate) picture: PathBuf,
    /// What it should be
    #[arg(value_name = "R.exr")]
    pub(crate) reference: PathBuf,
    /// Pixels to judge besides the whole picture, from the upper left, upper bounds excluded; may be repeated, and
    /// named: caustic=116,172,140,236
    #[arg(long = "region", value_name = "x0,y0,x1,y1", value_parser = named_region, allow_hyphen_values = true)]
    pub(crate) regions: Vec<NamedRegion>,
}

const SPECTRUM_HELP: &str = "\
The adaptive radius of a photon beam is only as good as the bandwidth that the covariance grid predicts. This
command measures the fluence of every voxel with many plain light paths, takes from its differences the standard
deviation of the spectrum that the light really has along x, y and z, and sets the predicted one beside it.

In the folder:
  summary.txt     what is compared and how; shares within a factor of 2, too small (biased), too large (noisy);
                  the worst voxels (also printed)
  table.csv       all of it, a line a voxel
  lines.svg       predicted and measured along lines, with the noise
  slice-*.svg     maps of predicted, measured and their ratio in three planes
  gaussians.svg   the equivalent Gaussians of the spectrum at some points

Examples:
  covbeam spectrum scene.toml                               the grid of the scene and its passes
  covbeam spectrum scene.toml --grid 64 --photons 128000000 finer; more light paths keep the noise down
  covbeam spectrum scene.toml --share 0.01 --passes 8       what little data says
  covbeam spectrum scene.toml --line 0,-1,-2:0,-1,2 --point 0,-1,0

Ctrl-C stops it; then nothing is written.";

#[derive(Args, Debug)]
#[command(after_help = SPECTRUM_HELP)]
pub(crate) struct SpectrumArgs {
    /// The scene file
    #[arg(value_name = "SCENE.toml")]
    pub(crate) scene: PathBuf,
    /// The folder to write into; created if it is missing [default: SCENE-spectrum in the current folder]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Light paths of the measurement. If more than 2 % of the voxels are undecided, ask for more
    #[arg(long, value_name = "N", default_value_t = 16_000_000, value_parser = clap::value_parser!(u32).range(16..=2_000_000_000))]
    pub(crate) photons: u32,
    /// Passes of the prediction: what a render's grid holds after so many [default: the scene's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) passes: Option<u32>,
    /// Share of a pass' light paths that carry a light field, above 0 and at most 1 [default: the scene's]
    #[arg(long, value_name = "S", value_parser = share, allow_negative_numbers = true)]
    pub(crate) share: Option<f32>,
    /// Voxels along each axis, 2 to 128 [default: the scene's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=128))]
    pub(crate) grid: Option<u32>,
    /// Another seed gives another noise, the same seed the same bits [default: the scene's]
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u32>,
    /// Threads; 0 = one for each core. The results are the same bits for any number
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1024))]
    pub(crate) threads: u32,
    /// A line to plot along; may be repeated [default: along x, y and z through the caustic or the middle of the light]
    #[arg(long = "line", value_name = "x0,y0,z0:x1,y1,z1", allow_hyphen_values = true)]
    pub(crate) lines: Vec<LineArgument>,
    /// A point whose Gaussian is drawn; may be repeated, the slices go through the first [default: smooth light, a
    /// border, a caustic]
    #[arg(long = "point", value_name = "x,y,z", value_parser = point, allow_hyphen_values = true)]
    pub(crate) points: Vec<Vec3>,
}

const REPORT_HELP: &str = "\
Renders each scene with each method and several seeds, passes after passes, and compares with a reference after
1, 2, 4, 8, ... of them. Without --references it first renders one of each scene itself: two long runs of plain
beams with narrow kernels, so that its noise can be taken off the errors, and no spectrum or filter judges itself.

In the folder:
  report.html     the page, one file that needs nothing else: error over time and over passes with slopes, by region;
                  pictures and their errors at equal time; maps of radius, bandwidth and eye rays; where time and
                  memory go; what each feature costs; the machine and this command
  report.json     all its numbers
  results.csv     errors, a line a point and region
  figure.svg      error over time of the glass ball (or of the first scene)

Examples:
  covbeam report --quick                            the built-in glass ball, small, in some seconds
  covbeam report examples/scenes                    all scenes of a folder, in about ten minutes on two cores
  covbeam report scene.toml --methods plain,covbeam --seeds 4 --width 256 --budget 60
  covbeam report glass-ball.toml --references tests/references

Ctrl-C stops it; the page then holds what was measured until then, and says so.";

#[derive(Args, Debug)]
#[command(after_help = REPORT_HELP)]
pub(crate) struct ReportArgs {
    /// Scene files, or folders of them; without any the built-in glass ball
    #[arg(value_name = "SCENES")]
    pub(crate) scenes: Vec<PathBuf>,
    /// Smaller pictures and shorter runs: a first impression, and noisy numbers
    #[arg(long)]
    pub(crate) quick: bool,
    /// The folder to write into; created if it is missing
    #[arg(long, value_name = "DIR", default_value = "covbeam-report")]
    pub(crate) out: PathBuf,
    /// Methods to compare, separated by commas [default: all]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = report_method)]
    pub(crate) methods: Vec<&'static str>,
    /// Runs of each method, with seeds 1, 2, ... [default: 2]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    pub(crate) seeds: Option<u32>,
    /// CPU-seconds of a run; one pass is always made [default: 6, quick: 0.3]
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) budget: Option<Duration>,
    /// Pixels across; heights follow [default: those of the given reference, else 128, quick: 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16384))]
    pub(crate) width: Option<u32>,
    /// Folder with references: NAME.exr for NAME.toml, and NAME-half.exr, the first of its two runs
    #[arg(long, value_name = "DIR")]
    pub(crate) references: Option<PathBuf>,
    /// Threads; 0 = one for each core. Errors after a number of passes are the same for any number
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1024))]
    pub(crate) threads: u32,
}
