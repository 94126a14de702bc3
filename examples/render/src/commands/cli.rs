//! The command line: what it accepts and what it says about itself.

mod render;
mod study;
mod values;

pub(crate) use render::{MergeArgs, MethodName, PictureArgs, PrepareArgs, RenderArgs};
pub(crate) use study::{CompareArgs, ReportArgs, SpectrumArgs};
pub(crate) use values::{LineArgument, PassesArgument};

use clap::{Parser, Subcommand};

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

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_well_formed() {
        Cli::command().debug_assert();
    }
}
