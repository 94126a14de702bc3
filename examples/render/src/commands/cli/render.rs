//! `covbeam render`, `prepare` and `merge`: pictures, whole and in pieces.

use super::values::{PassesArgument, interval, merged_path, relative_error, seconds};
use clap::{Args, ValueEnum};
use covbeam_render::progress::Listener;
use covbeam_session::settings::Method;
use std::path::PathBuf;
use std::time::Duration;

/// Groups of --help.
const PICTURE: &str = "The picture";
const LENGTH: &str = "How long, and which passes";
const FILES: &str = "Files";
const MACHINE: &str = "Machine and progress";

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

const PREPARE_HELP: &str = "\
A pass of the methods adaptive and march needs the light fields of earlier ones: without this file a piece traces them again,
for each of the passes before it that have some (31 of the first 1,024). Worth it where many machines make few passes each.

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
            Self::Ppb => Method::Plain,
            Self::Adaptive => Method::Covbeam,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_has_the_name_that_is_typed() {
        for method in MethodName::value_variants() {
            assert_eq!(method.to_possible_value().unwrap().get_name(), method.name());
        }
    }
}
