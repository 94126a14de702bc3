//! `covbeam report`: from scenes to one page, with the numbers beside it.

use crate::commands::cli::ReportArgs;
use crate::commands::failure::{Refused, Usage};
use crate::commands::render::job::{DEFAULT_NAME, DEFAULT_SCENE};
use crate::commands::stop::Stop;
use covbeam_render::files::output::{check_writable, replace_file};
use covbeam_render::progress::{Display, say, seconds};
use covbeam_render::scene_file;
use covbeam_render::study::report::{
    METHODS, Options, Reference, Report, Subject, Watch, csv, figure, json, measure, page,
};
use std::error::Error;
use std::io::{Write, stdout};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// What is written into the folder.
const FILES: [&str; 4] = ["report.html", "report.json", "results.csv", "figure.svg"];

/// CPU-seconds of a run, seeds and pixels across, by default and with --quick: so that the eight scenes in examples/scenes take
/// less than 15 minutes and less than one on two cores.
const USUAL: (f64, u32, u32) = (6.0, 2, 128);
const QUICK: (f64, u32, u32) = (0.3, 2, 64);

/// A reference's two runs take this many times as long as a method's, each.
const REFERENCE_FACTOR: f64 = 3.0;

pub(crate) fn run(args: &ReportArgs) -> Result<ExitCode, Box<dyn Error>> {
    let mut subjects = subjects(&args.scenes)?;
    let glass_ball = scene_file::parse(DEFAULT_SCENE, "built-in scene", Path::new("."))?;
    if args.scenes.is_empty() {
        subjects.push(Subject { name: DEFAULT_NAME.to_owned(), scene: glass_ball.clone() });
    }
    let options = options(args);
    let prepared = prepared(subjects, &options)?;
    let folder = &args.out;
    make_folder(folder)?;

    let stop = Stop::on_signals()?;
    let cancelled = || stop.is_asked();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads as usize).build()?;
    let allowed = options.cpu_seconds(&prepared);
    say(format!(
        "{} scenes, {} methods, {} seeds: about {allowed:.0} CPU-seconds on {} threads",
        prepared.len(),
        options.methods.len(),
        options.seeds,
        pool.current_num_threads()
    ));
    let display = Display::new();
    let show = |step: &str, share: f64| display.show(step, share);
    let watch = Watch::new(allowed, &cancelled, &show);
    let command =
        command_line(std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned()));
    let report = pool.install(|| measure(prepared, &glass_ball, &options, command, &watch));
    display.finish();
    let report = report?;
    if report.scenes.is_empty() {
        say("stopped before the first run was finished: nothing is written");
        return Ok(stop.exit_code());
    }
    save(&report, folder, &stop)
}

/// Scenes with their names.
fn subjects(given: &[PathBuf]) -> Result<Vec<Subject>, Box<dyn Error>> {
    let mut subjects = Vec::new();
    for path in scene_files(given)? {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        subjects.push(Subject { name, scene: scene_file::load(&path)? });
    }
    Ok(subjects)
}

/// A scene with its reference, if one is there.
type Prepared = (Subject, Option<Reference>);

/// Scenes with the references that are there; the user is told of others.
fn prepared(subjects: Vec<Subject>, options: &Options) -> Result<Vec<Prepared>, Box<dyn Error>> {
    if let Some(folder) = options.references.as_ref().filter(|folder| !folder.is_dir()) {
        return Err(Usage(format!(
            "there is no folder '{}'; give the one of the references with --references",
            folder.display()
        ))
        .into());
    }
    let mut prepared = Vec::new();
    for mut subject in subjects {
        let reference = options.prepare(&mut subject)?;
        if let (None, Some(folder)) = (&reference, &options.references) {
            let name = &subject.name;
            say(format!(
                "{}/{name}.exr does not exist: a reference of {name} is rendered first",
                folder.display()
            ));
        }
        prepared.push((subject, reference));
    }
    Ok(prepared)
}

/// Makes the folder that all is written into.
fn make_folder(folder: &Path) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder).map_err(|error| {
        format!("cannot create the folder {}: {error}; choose another with --out", folder.display())
    })?;
    for file in FILES {
        check_writable(&folder.join(file))?;
    }
    Ok(())
}

fn options(args: &ReportArgs) -> Options {
    let (budget, seeds, width) = if args.quick { QUICK } else { USUAL };
    let budget = args.budget.map_or(budget, |budget| budget.as_secs_f64());
    let methods =
        METHODS.iter().filter(|method| args.methods.is_empty() || args.methods.contains(&method.name));
    Options {
        methods: methods.collect(),
        seeds: args.seeds.unwrap_or(seeds),
        budget,
        reference_budget: REFERENCE_FACTOR * budget,
        width: args.width,
        usual_width: width,
        references: args.references.clone(),
        quick: args.quick,
        features: true,
    }
}

/// The scenes themselves; of a folder, all files in it that end in .toml, by name, but for a Cargo.toml.
fn scene_files(given: &[PathBuf]) -> Result<Vec<PathBuf>, Refused> {
    let mut files = Vec::new();
    for path in given {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let failed = |error| Refused(format!("cannot read the folder '{}': {error}", path.display()));
        let entries: Result<Vec<_>, _> = std::fs::read_dir(path).map_err(failed)?.collect();
        let mut scenes: Vec<PathBuf> = entries.map_err(failed)?.iter().map(std::fs::DirEntry::path).collect();
        let is_scene = |file: &PathBuf| {
            file.extension().is_some_and(|ending| ending == "toml")
                && file.file_name() != Some("Cargo.toml".as_ref())
        };
        scenes.retain(|file| file.is_file() && is_scene(file));
        if scenes.is_empty() {
            return Err(Refused(format!(
                "the folder '{}' holds no scene (a file that ends in .toml); name scenes or another folder",
                path.display()
            )));
        }
        scenes.sort();
        files.append(&mut scenes);
    }
    Ok(files)
}

/// What was typed, for a shell to repeat.
fn command_line(arguments: impl Iterator<Item = String>) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c);
    let quoted = arguments.map(|argument| {
        if !argument.is_empty() && argument.chars().all(is_plain) {
            argument
        } else {
            format!("'{}'", argument.replace('\'', r"'\''"))
        }
    });
    std::iter::once("covbeam".to_owned()).chain(quoted).collect::<Vec<_>>().join(" ")
}

fn save(report: &Report, folder: &Path, stop: &Stop) -> Result<ExitCode, Box<dyn Error>> {
    let write =
        |file: &str, text: &str| replace_file(&folder.join(file), |out| out.write_all(text.as_bytes()));
    write("report.json", &json(report))?;
    write("results.csv", &csv(report))?;
    let figure = figure(report)?;
    if let Some(figure) = &figure {
        write("figure.svg", figure)?;
    }
    write("report.html", &page(report)?)?;
    let written: Vec<&str> =
        FILES.into_iter().filter(|file| figure.is_some() || *file != "figure.svg").collect();
    let mut said = String::new();
    if let Some(stopped) = &report.stopped {
        said += &format!("{stopped}: the page holds what was measured until then\n");
    }
    said += &format!(
        "wrote {} into {}\n{} by the clock, {:.0} CPU-seconds\n",
        written.join(", "),
        folder.display(),
        seconds(Duration::from_secs_f64(report.elapsed)),
        report.cpu_seconds
    );
    stdout().write_all(said.as_bytes())?;
    Ok(if report.stopped.is_some() { stop.exit_code() } else { ExitCode::SUCCESS })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_can_be_pasted_into_a_shell() {
        let typed = ["report", "my scene.toml", "it's", "--out", "a/b", ""].map(str::to_owned);
        assert_eq!(command_line(typed.into_iter()), r"covbeam report 'my scene.toml' 'it'\''s' --out a/b ''");
    }
}
