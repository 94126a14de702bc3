//! `examples/figures.md`, and the figures in the README: written by `measure figures`, from what commands
//! print.

mod equal_time;
mod sections;

pub use sections::{Answer, SCRATCH, Section, sections};

use crate::header::repository;
use covbeam_render::study::report::Machine;
use std::error::Error;
use std::fs;
use std::process::Command;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// The document, from the repository's folder.
pub const DOCUMENT: &str = "examples/figures.md";

/// Where plots stay.
pub const PICTURES: &str = "examples/pictures";

/// Around what is written into the README.
pub const MARKS: [&str; 2] = ["<!-- written by `measure figures`: from here -->", "<!-- to here -->"];

/// Runs all commands, then writes the document, its plots, and the table of the README.
///
/// - `effort`: see [`sections`].
/// - `folder`: where the document and its plots go instead, and the README is left alone.
///
/// # Errors
/// A command that fails, or a file that cannot be written.
pub fn write(effort: f64, folder: Option<&std::path::Path>) -> Outcome<()> {
    let root = repository();
    let plots = folder.map_or(root.join(PICTURES), Into::into);
    fs::create_dir_all(root.join(SCRATCH))?;
    let head = head(effort)?;
    let (mut text, mut short) = (format!("# Figures\n\n{head}\n"), None);
    for Section { title, about, command, answer } in sections(effort) {
        eprintln!("== {title}: cargo {command}");
        let said = run(&command)?;
        text += &format!("\n## {title}\n\n{about}\n\n```sh\ncargo {command}\n```\n\n");
        let shown = |name: &str| format!("![{title}](pictures/{name})\n\n");
        match answer {
            Answer::Tables => text += &tidy(&said),
            Answer::Text => text += &format!("```text\n{}```\n", tidy(&said)),
            Answer::Plot(name) => {
                fs::copy(root.join(SCRATCH).join(name), plots.join(name))?;
                text += &(shown(name) + &tidy(&said));
            }
            Answer::Report => {
                let report = root.join(SCRATCH).join("report");
                fs::copy(report.join("figure.svg"), plots.join("report.svg"))?;
                let [all, four] = equal_time::tables(&fs::read_to_string(report.join("results.csv"))?)?;
                text += &(shown("report.svg") + &all);
                short = Some(four);
            }
        }
    }
    let document = folder.map_or(root.join(DOCUMENT), |folder| folder.join("figures.md"));
    fs::write(&document, text)?;
    if folder.is_none() {
        let readme = root.join("README.md");
        let short = short.ok_or("no section has the table of the README")?;
        fs::write(&readme, with_table(&fs::read_to_string(&readme)?, &short)?)?;
    }
    Ok(())
}

/// When, where and of what.
fn head(effort: f64) -> Outcome<String> {
    let said = |program: &str, arguments: &[&str]| -> Outcome<String> {
        let output = Command::new(program).args(arguments).current_dir(repository()).output()?;
        let text = String::from_utf8(output.stdout)?.trim().to_owned();
        if output.status.success() { Ok(text) } else { Err(format!("{program} failed").into()) }
    };
    let commit = said("git", &["describe", "--always", "--dirty"])?;
    let date = said("date", &["-u", "+%Y-%m-%d"])?;
    let Machine { processor, cores, memory, system, compiler, .. } = Machine::here(1);
    Ok(format!(
        "Commit {commit}, {date}. {processor}, {cores} cores, {memory}; {system}; {compiler}.\n\n\
         Nothing here is typed by hand. Remade, with the table of the README, by\n\n```sh\n\
         cargo run --release -p covbeam-tests --bin measure -- figures --effort {effort}\n```"
    ))
}

/// What a command of cargo prints, progress aside.
fn run(command: &str) -> Outcome<String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let output = Command::new(cargo)
        .args(command.split(' '))
        .current_dir(repository())
        .stderr(std::process::Stdio::inherit())
        .output()?;
    if !output.status.success() {
        return Err(format!("cargo {command}: {}", output.status).into());
    }
    Ok(String::from_utf8(output.stdout)?)
}

/// Without where files went, and with one line's end at the end.
fn tidy(said: &str) -> String {
    let kept = said.lines().filter(|line| !line.contains(SCRATCH));
    kept.map(str::trim_end).collect::<Vec<_>>().join("\n").trim().to_owned() + "\n"
}

/// The README with another table between the marks.
///
/// # Errors
/// The marks are not there.
pub fn with_table(readme: &str, table: &str) -> Result<String, String> {
    let [from, to] = MARKS;
    let (before, rest) = readme.split_once(from).ok_or("the README has no place for figures")?;
    let (_, after) = rest.split_once(to).ok_or("the README's place for figures has no end")?;
    Ok(format!("{before}{from}\n\n{table}\n{to}{after}"))
}
