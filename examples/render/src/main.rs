//! `covbeam`: renders a scene, merges pieces of a picture, compares two pictures, tests the predicted spectra, or reports on all methods.

mod commands;

use clap::Parser;
use commands::cli::{Cli, Command, CompareArgs, RenderArgs};
use commands::failure::Usage;
use commands::{failure, merge, prepare, render, report, spectrum};
use covbeam_render::files::output::read_picture;
use covbeam_render::progress::Listener;
use covbeam_render::study::compare::{Comparison, compare};
use std::error::Error;
use std::fmt::Write as _;
use std::io::{Write as _, stdout};
use std::process::ExitCode;
use std::time::Duration;

/// How long a render without any argument takes, on a fast machine and on a slow one.
const FIRST_LOOK: Duration = Duration::from_secs(30);

/// 0 = done, 1 = failed, 2 = wrong usage, 3 = refused input, 128 + n = stopped by signal n with the work kept.
fn main() -> ExitCode {
    let first_look = RenderArgs { time: Some(FIRST_LOOK), ..RenderArgs::default() };
    let command = Cli::parse().command.unwrap_or(Command::Render(first_look));
    let listener = match &command {
        Command::Render(args) => args.progress.listener(),
        Command::Prepare(args) => args.progress.listener(),
        Command::Merge(args) => args.progress.listener(),
        Command::Compare(_) | Command::Spectrum(_) | Command::Report(_) => Listener::Person,
    };
    let done = match &command {
        Command::Render(args) => render::run(args),
        Command::Prepare(args) => prepare::run(args),
        Command::Merge(args) => merge::run(args),
        Command::Compare(args) => run_compare(args),
        Command::Spectrum(args) => spectrum::run(args),
        Command::Report(args) => report::run(args),
    };
    done.unwrap_or_else(|error| {
        let code = failure::exit_code(&*error);
        listener.failed(code, &error.to_string());
        ExitCode::from(code)
    })
}

fn run_compare(args: &CompareArgs) -> Result<ExitCode, Box<dyn Error>> {
    let picture = read_picture(&args.picture)?;
    let reference = read_picture(&args.reference)?;
    let mut table =
        format!("{:<24} {:>10} {:>10} {:>12} {:>12}\n", "region", "relMSE", "bias", "mean", "reference");
    let mut row = |name: &str, found: Comparison| {
        let Comparison { rel_mse, bias, mean, reference_mean } = found;
        let bias = format!("{:+.3} %", 100.0 * bias);
        writeln!(table, "{name:<24} {rel_mse:>10.3e} {bias:>10} {mean:>12.5e} {reference_mean:>12.5e}")
    };
    row("whole", compare(&picture, &reference, |_, _| true)?)?;
    for named in &args.regions {
        let region = named.region;
        if region.x1 > picture.width || region.y1 > picture.height {
            let (width, height) = (picture.width, picture.height);
            return Err(Usage(format!(
                "the region {region} reaches beyond the picture of {width} x {height} pixels"
            ))
            .into());
        }
        row(&named.name, compare(&picture, &reference, |x, y| region.contains(x, y))?)?;
    }
    stdout().write_all(table.as_bytes())?;
    Ok(ExitCode::SUCCESS)
}
