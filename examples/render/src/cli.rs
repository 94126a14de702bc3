//! The command line: what it accepts and what it says about itself.

use clap::{Args, Parser, Subcommand, ValueEnum};
use covbeam_render::compare::Region;
use covbeam_render::pass::Method;
use covbeam_render::progress::Listener;
use covbeam_render::report::{METHODS, Method as ReportMethod};
use covbeam_render::shard::PassRange;
use glam::Vec3;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

const EXAMPLES: &str = "\
Examples:
  covbeam                                             render the glass ball in fog for half a minute
  covbeam render scene.toml --time 60                 as good as it gets in a minute
  covbeam render scene.toml --until 0.02              until half of the pixels are within 2 %
  covbeam render scene.toml --method ppb              plain progressive photon beams
  covbeam render scene.toml --passes 1000 --seed 2 --out reference.exr
  covbeam render scene.toml --resume                  go on where a render was stopped, even by kill -9
  covbeam render scene.toml --passes 0..8 --out a.shard    a piece, on one of many machines
  covbeam merge *.shard --out scene.exr               all pieces: the same bits as one render
  covbeam compare scene-adaptive.exr reference.exr --region caustic=116,172,140,236
  covbeam spectrum scene.toml                         is the predicted bandwidth that of the light?
  covbeam report scene.toml --quick                   which method is how far after how much time?

Ctrl-C stops a render and keeps the passes finished until then.
Exit codes: 0 done, 1 failed, 2 wrong usage, 3 refused input, 128 + n stopped by signal n with the work kept.";

/// Renders fog lit by strong lights, with photon beams as wide as the light's frequencies allow.
///
/// Without a command: renders the built-in scene, a glass ball in fog, for half a minute.
#[derive(Debug, Parser)]
#[command(name = "covbeam", version, after_help = EXAMPLES)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene to an EXR, with a PNG preview beside it
    Render(RenderArgs),
    /// Trace what pieces of a picture need of earlier passes, once for all of them
    Prepare(PrepareArgs),
    /// Add up pieces of a picture that were rendered apart
    Merge(MergeArgs),
    /// Say how far a picture is from a reference
    Compare(CompareArgs),
    /// Test the predicted bandwidth of the light against the measured one, voxel by voxel
    Spectrum(SpectrumArgs),
    /// Measure error against time of all methods, and write it up as one page
    Report(ReportArgs),
}

/// What makes a picture what it is: the same in all pieces of it.
#[derive(Args, Debug, Default)]
pub(crate) struct PictureArgs {
    /// The scene file; without it the built-in glass ball
    #[arg(value_name = "SCENE.toml")]
    pub(crate) scene: Option<PathBuf>,
    /// How the picture is made
    #[arg(long, value_enum, default_value_t, help_heading = PICTURE)]
    pub(crate) method: MethodName,
    /// Trace an eye ray through every pixel in each pass; without it, the methods adaptive and march trace few where the picture is smooth,
    /// and filter between them
    #[arg(long, help_heading = PICTURE)]
    pub(crate) every_pixel: bool,
    /// Keep the light of each kind apart, as layers of the picture's file that add up to it: straight (from lamps), focused (by mirrors and
    /// glass), scattered (by fog and surfaces). Needs 310 bytes a pixel more memory
    #[arg(long, help_heading = PICTURE)]
    pub(crate) light_passes: bool,
    /// Light paths a pass [default: the scene's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = PICTURE)]
    pub(crate) photons: Option<u32>,
    /// Shadow rays a pixel and pass of the method march, on average, for each light and each piece of an eye path
    /// [default: 16]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536), help_heading = PICTURE)]
    pub(crate) samples: Option<u32>,
    /// Another seed gives another noise, the same seed the same bits [default: the scene's]
    #[arg(long, value_name = "N", help_heading = PICTURE)]
    pub(crate) seed: Option<u32>,
}

#[derive(Args, Debug, Default)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
    /// Stop after this many passes; A..B = only passes A to B - 1, counted from 0, into a shard for `covbeam merge`: a piece of a picture,
    /// which goes on from one that is there, and is done at once if that has them all [default: the scene's, unless --time or --until says
    /// when to stop]
    #[arg(long, value_name = "N|A..B", help_heading = LENGTH)]
    pub(crate) passes: Option<PassesArgument>,
    /// Be done after this many seconds, with the picture written; a pass that is not finished by then is cut, one pass is always made
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true, help_heading = LENGTH)]
    pub(crate) time: Option<Duration>,
    /// Stop when the median over the lit pixels of standard error over brightness is below this: 0.02 for 2 %; with --passes or --time,
    /// these end the render at the latest
    #[arg(long, value_name = "E", value_parser = relative_error, allow_negative_numbers = true, help_heading = LENGTH)]
    pub(crate) until: Option<f64>,
    /// Go on from the sums beside the picture, NAME.shard, with the same bits as without the break
    #[arg(long, help_heading = LENGTH)]
    pub(crate) resume: bool,
    /// Seconds between two writings of the sums that --resume goes on from; 0 = after every pass [default: 60, or as many as keep the
    /// writing below 1 % of the time]
    #[arg(long, value_name = "S", value_parser = interval, allow_negative_numbers = true, help_heading = LENGTH)]
    pub(crate) checkpoint: Option<Duration>,
    /// The picture to write; its preview gets the ending .png, its sums .shard [default: SCENE-METHOD.exr, or SCENE-METHOD-A-B.shard, in the
    /// current folder]
    #[arg(long, value_name = "F.exr|F.shard", help_heading = FILES)]
    pub(crate) out: Option<PathBuf>,
    /// Write maps of the eye rays beside the picture: NAME-density.png and NAME-filters.png
    #[arg(long, conflicts_with = "every_pixel", help_heading = FILES)]
    pub(crate) maps: bool,
    /// Light fields of earlier passes, which `covbeam prepare` wrote: a piece reads them instead of tracing them again
    #[arg(long, value_name = "F.fields", help_heading = FILES)]
    pub(crate) fields: Option<PathBuf>,
    /// Threads; 0 = one for each core. The picture is the same bits for any number
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1024), help_heading = MACHINE)]
    pub(crate) threads: u32,
    /// Whom progress is for
    #[arg(long, value_enum, default_value_t, help_heading = MACHINE)]
    pub(crate) progress: ProgressName,
}

/// Groups of --help.
const PICTURE: &str = "The picture";
const LENGTH: &str = "How long, and which passes";
const FILES: &str = "Files";
const MACHINE: &str = "Machine and progress";

/// `N` or `A..B`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PassesArgument {
    Count(u32),
    Range(PassRange),
}

impl PassesArgument {
    pub(crate) fn count(self) -> Option<u32> {
        if let Self::Count(count) = self { Some(count) } else { None }
    }

    pub(crate) fn range(self) -> Option<PassRange> {
        if let Self::Range(range) = self { Some(range) } else { None }
    }
}

impl FromStr for PassesArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.contains("..") {
            return text.parse().map(Self::Range);
        }
        let count = text.parse().ok().filter(|count| *count > 0);
        count.map(Self::Count).ok_or_else(|| "expected a number of passes above 0, or A..B".to_owned())
    }
}

/// The command line's names of [`Listener`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgressName {
    /// A person: a bar in a terminal, else a line every few seconds, on standard error
    #[default]
    Plain,
    /// A program: a JSON object a line on standard output, with "event": progress, done, stopped or failed
    Json,
    /// An Open Job Description runner: lines openjd_progress, openjd_status and openjd_fail on standard output
    Openjd,
}

impl ProgressName {
    pub(crate) fn listener(self) -> Listener {
        match self {
            Self::Plain => Listener::Person,
            Self::Json => Listener::Json,
            Self::Openjd => Listener::Openjd,
        }
    }
}

const PREPARE_HELP: &str = "\
A pass of the methods adaptive and march needs the light fields of earlier ones: without this file a piece traces them again,
some hundredths of a second for each of the passes 0 to 7, 15, 23, 31, ... before it. Worth it where many machines make few
passes each.

Examples:
  covbeam prepare scene.toml --passes 512 --out scene.fields
  covbeam render scene.toml --fields scene.fields --passes 504..512 --out 63.shard";

#[derive(Args, Debug)]
#[command(after_help = PREPARE_HELP)]
pub(crate) struct PrepareArgs {
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
    /// Passes of the whole picture [default: the scene's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) passes: Option<u32>,
    /// The file to write [default: SCENE-METHOD.fields in the current folder]
    #[arg(long, value_name = "F.fields")]
    pub(crate) out: Option<PathBuf>,
    /// Threads; 0 = one for each core. The file is the same bits for any number
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1024))]
    pub(crate) threads: u32,
    /// Whom progress is for
    #[arg(long, value_enum, default_value_t)]
    pub(crate) progress: ProgressName,
}

const MERGE_HELP: &str = "\
The sums in shards are exact: the picture has the same bits in whatever order and groups they are merged, and as if one
render had made all passes. Shards of another scene, seed, method, size or version, passes that are there twice, missing
ones, and damaged files are refused by name; then nothing is written.

Examples:
  covbeam merge pieces/*.shard --out picture.exr
  covbeam merge pieces/*.shard --out picture.exr --passes 64   and the last ones must be there too
  covbeam merge a.shard b.shard --out ab.shard                 in a tree, where there are very many
  covbeam merge pieces/*.shard --out picture.exr --allow-gaps  a machine died, and the picture is wanted";

#[derive(Args, Debug)]
#[command(after_help = MERGE_HELP)]
pub(crate) struct MergeArgs {
    /// What `covbeam render --passes A..B` wrote, or the sums beside a picture
    #[arg(value_name = "F.shard", required = true)]
    pub(crate) shards: Vec<PathBuf>,
    /// The picture to write, whose preview gets the ending .png; or a shard with the passes of all
    #[arg(long, value_name = "F.exr|F.shard", value_parser = merged_path)]
    pub(crate) out: PathBuf,
    /// Passes that the picture should have [default: up to the last that there is]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) passes: Option<u32>,
    /// Make the picture of the passes that there are
    #[arg(long)]
    pub(crate) allow_gaps: bool,
    /// Threads; 0 = one for each core. The picture is the same bits for any number
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1024))]
    pub(crate) threads: u32,
    /// Whom progress is for
    #[arg(long, value_enum, default_value_t)]
    pub(crate) progress: ProgressName,
}

/// The command line's names of [`Method`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum MethodName {
    /// Plain progressive photon beams
    Ppb,
    /// Beams as wide as the covariance of the light allows
    #[default]
    Adaptive,
    /// Unbiased connections to the camera: right in the mean, noisy, blind to what is behind glass
    LightTrace,
    /// Light scattered once, by shadow rays from places along the eye rays
    March,
}

impl MethodName {
    pub(crate) fn method(self) -> Method {
        match self {
            Self::Ppb => Method::Ppb,
            Self::Adaptive => Method::Adaptive,
            Self::LightTrace => Method::LightTrace,
            Self::March => Method::March,
        }
    }

    /// Whether it traces few eye rays where the picture is smooth.
    pub(crate) fn plans_eye_rays(self) -> bool {
        matches!(self, Self::Adaptive | Self::March)
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Ppb => "ppb",
            Self::Adaptive => "adaptive",
            Self::LightTrace => "light-trace",
            Self::March => "march",
        }
    }
}

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
1, 2, 4, 8, ... of them. Without --references it first renders one of each scene itself: two long runs with narrow
kernels, so that the noise of the reference can be taken off the errors.

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

fn report_method(text: &str) -> Result<&'static str, String> {
    let names = || METHODS.iter().map(|method| method.name).collect::<Vec<_>>().join(", ");
    ReportMethod::named(text).map(|method| method.name).ok_or_else(|| format!("expected one of {}", names()))
}

/// `x0,y0,z0:x1,y1,z1`
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LineArgument {
    pub(crate) from: Vec3,
    pub(crate) to: Vec3,
}

impl FromStr for LineArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = "expected two points x0,y0,z0:x1,y1,z1";
        let (from, to) = text.split_once(':').ok_or(expected)?;
        let (from, to) = (point(from)?, point(to)?);
        if from == to {
            Err("the line has no length: both points are the same".into())
        } else {
            Ok(Self { from, to })
        }
    }
}

fn point(text: &str) -> Result<Vec3, String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) if [x, y, z].iter().all(|v| v.is_finite()) => Ok(Vec3::new(x, y, z)),
        _ => Err(format!("expected three finite numbers x,y,z, not '{text}'")),
    }
}

fn share(text: &str) -> Result<f32, String> {
    let share = text.parse().ok().filter(|share| *share > 0.0 && *share <= 1.0);
    share.ok_or_else(|| "expected a number above 0 and at most 1".to_owned())
}

/// `name=x0,y0,x1,y1`; without a name the numbers are the name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct NamedRegion {
    pub(crate) name: String,
    pub(crate) region: Region,
}

fn named_region(text: &str) -> Result<NamedRegion, String> {
    let (name, numbers) = text.split_once('=').unwrap_or((text, text));
    Ok(NamedRegion { name: name.to_owned(), region: numbers.parse()? })
}

fn seconds(text: &str) -> Result<Duration, String> {
    let time = text.parse().ok().and_then(|s| Duration::try_from_secs_f64(s).ok());
    time.filter(|t| !t.is_zero()).ok_or_else(|| "expected a number of seconds above 0".to_owned())
}

fn relative_error(text: &str) -> Result<f64, String> {
    let error = text.parse().ok().filter(|error| *error > 0.0 && *error < 1.0);
    error.ok_or_else(|| "expected a number above 0 and below 1, such as 0.02 for 2 %".to_owned())
}

fn interval(text: &str) -> Result<Duration, String> {
    let time = text.parse().ok().and_then(|s| Duration::try_from_secs_f64(s).ok());
    time.ok_or_else(|| "expected a number of seconds, 0 or above".to_owned())
}

fn merged_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("exr") || ending.eq_ignore_ascii_case("shard") => {
            Ok(path)
        }
        _ => Err("expected a file name that ends in .exr, for the picture, or in .shard".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_well_formed() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_method_has_the_name_that_is_typed() {
        for method in MethodName::value_variants() {
            assert_eq!(method.to_possible_value().unwrap().get_name(), method.name());
        }
    }

    #[test]
    fn a_time_is_a_finite_number_of_seconds_above_zero() {
        assert_eq!(seconds("1.5").unwrap(), Duration::from_millis(1500));
        for text in ["0", "-1", "nan", "inf", "1e300", "ten", ""] {
            assert!(seconds(text).unwrap_err().contains("seconds above 0"), "{text}");
        }
    }

    #[test]
    fn an_error_is_above_zero_and_below_one() {
        assert_eq!(relative_error("0.02"), Ok(0.02));
        for text in ["0", "1", "-0.1", "nan", "2%"] {
            assert!(relative_error(text).unwrap_err().contains("0.02 for 2 %"), "{text}");
        }
    }

    #[test]
    fn a_region_may_have_a_name() {
        let region = Region { x0: 1, y0: 2, x1: 3, y1: 4 };
        assert_eq!(named_region("fog=1,2,3,4").unwrap(), NamedRegion { name: "fog".into(), region });
        assert_eq!(named_region("1,2,3,4").unwrap(), NamedRegion { name: "1,2,3,4".into(), region });
        assert!(named_region("fog").is_err());
    }

    #[test]
    fn a_line_is_two_different_points() {
        let line = LineArgument { from: Vec3::new(-1.0, 0.5, 2.0), to: Vec3::new(3.0, 0.5, 2.0) };
        assert_eq!("-1,0.5,2:3, 0.5,2".parse(), Ok(line));
        for text in ["", "1,2,3", "1,2:3,4", "1,2,3:4,5,nan", "1,2,3:4,5,6:7,8,9"] {
            assert!(text.parse::<LineArgument>().unwrap_err().starts_with("expected"), "{text}");
        }
        assert!("1,2,3:1,2,3".parse::<LineArgument>().unwrap_err().contains("no length"));
    }

    #[test]
    fn a_share_is_above_zero_and_at_most_one() {
        assert_eq!(share("0.5"), Ok(0.5));
        assert_eq!(share("1"), Ok(1.0));
        for text in ["0", "-0.1", "1.01", "nan", "some"] {
            assert!(share(text).is_err(), "{text}");
        }
    }

    #[test]
    fn what_is_merged_is_a_picture_or_a_shard() {
        assert!(
            merged_path("a/b.exr").is_ok() && merged_path("B.EXR").is_ok() && merged_path("c.shard").is_ok()
        );
        assert!(merged_path("a.png").is_err() && merged_path("exr").is_err() && merged_path(".exr").is_err());
    }

    #[test]
    fn passes_are_a_number_or_a_range() {
        assert_eq!("64".parse(), Ok(PassesArgument::Count(64)));
        assert_eq!("8..16".parse(), Ok(PassesArgument::Range(PassRange { start: 8, end: 16 })));
        for text in ["0", "-1", "8..8", "..", "1.5", ""] {
            assert!(text.parse::<PassesArgument>().is_err(), "{text}");
        }
    }
}
