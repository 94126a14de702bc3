//! The command line: what it accepts and what it says about itself.

use clap::{Args, Parser, Subcommand, ValueEnum};
use covbeam_render::compare::Region;
use covbeam_render::pass::Method;
use std::path::PathBuf;
use std::time::Duration;

const EXAMPLES: &str = "\
Examples:
  covbeam                                             render the glass ball in fog for half a minute
  covbeam render scene.toml --time 60                 as good as it gets in a minute
  covbeam render scene.toml --method ppb              plain progressive photon beams
  covbeam render scene.toml --passes 1000 --seed 2 --out reference.exr
  covbeam compare scene-adaptive.exr reference.exr --region caustic=116,172,140,236

Ctrl-C stops a render and keeps the passes finished until then.";

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
    /// Say how far a picture is from a reference
    Compare(CompareArgs),
}

#[derive(Args, Debug, Default)]
pub(crate) struct RenderArgs {
    /// The scene file; without it the built-in glass ball
    #[arg(value_name = "SCENE.toml")]
    pub(crate) scene: Option<PathBuf>,
    /// How the picture is made
    #[arg(long, value_enum, default_value_t)]
    pub(crate) method: MethodName,
    /// Stop after this many passes [default: the scene's]
    #[arg(long, value_name = "N", conflicts_with = "time", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) passes: Option<u32>,
    /// Stop after this many seconds; a pass that would end later is not begun, one pass is always made
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) time: Option<Duration>,
    /// Light paths a pass [default: the scene's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) photons: Option<u32>,
    /// Another seed gives another noise, the same seed the same bits [default: the scene's]
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u32>,
    /// Threads; 0 = one for each core. The picture is the same bits for any number
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1024))]
    pub(crate) threads: u32,
    /// The picture to write; its preview gets the ending .png [default: SCENE-METHOD.exr in the current folder]
    #[arg(long, value_name = "F.exr", value_parser = exr_path)]
    pub(crate) out: Option<PathBuf>,
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
}

impl MethodName {
    pub(crate) fn method(self) -> Method {
        match self {
            Self::Ppb => Method::Ppb,
            Self::Adaptive => Method::Adaptive,
            Self::LightTrace => Method::LightTrace,
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Ppb => "ppb",
            Self::Adaptive => "adaptive",
            Self::LightTrace => "light-trace",
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

fn exr_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("exr") => Ok(path),
        _ => Err("expected a file name that ends in .exr (the PNG preview is written beside it)".to_owned()),
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
    fn a_region_may_have_a_name() {
        let region = Region { x0: 1, y0: 2, x1: 3, y1: 4 };
        assert_eq!(named_region("fog=1,2,3,4").unwrap(), NamedRegion { name: "fog".into(), region });
        assert_eq!(named_region("1,2,3,4").unwrap(), NamedRegion { name: "1,2,3,4".into(), region });
        assert!(named_region("fog").is_err());
    }

    #[test]
    fn a_picture_ends_in_exr() {
        assert!(exr_path("a/b.exr").is_ok() && exr_path("B.EXR").is_ok());
        assert!(exr_path("a.png").is_err() && exr_path("exr").is_err() && exr_path(".exr").is_err());
    }
}
