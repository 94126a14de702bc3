//! Every figure has its source: `examples/figures.md` is what `measure figures` writes, the README's numbers
//! are in it, and pictures exist.

use covbeam_tests::figures::{Answer, DOCUMENT, MARKS, PICTURES, sections, with_table};
use covbeam_tests::header::repository;
use std::collections::BTreeSet;
use std::fs;
use std::process::Command;

fn read(file: &str) -> String {
    fs::read_to_string(repository().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

/// The effort that the document says it was made with.
fn effort(document: &str) -> f64 {
    let (_, rest) = document.split_once("-- figures --effort ").unwrap();
    rest.lines().next().unwrap().parse().unwrap()
}

#[test]
fn each_section_is_answered_by_the_command_it_names() {
    let document = read(DOCUMENT);
    let parts: Vec<&str> = document.split("\n## ").collect();
    let wanted = sections(effort(parts[0]));
    assert_eq!(parts.len() - 1, wanted.len(), "remake {DOCUMENT}");
    for (part, section) in parts[1..].iter().zip(wanted) {
        let start =
            format!("{}\n\n{}\n\n```sh\ncargo {}\n```\n", section.title, section.about, section.command);
        assert!(part.starts_with(&start), "remake {DOCUMENT}: {part:.400}");
        let answer = part[start.len()..].trim();
        let shown = match section.answer {
            Answer::Text => answer.starts_with("```text\n"),
            Answer::Tables => answer.contains("|---|"),
            Answer::Plot(_) | Answer::Report => answer.contains("](pictures/") && answer.contains("|---|"),
        };
        assert!(shown && answer.contains(|c: char| c.is_ascii_digit()), "{}: {answer:.400}", section.title);
    }
}

#[test]
fn the_commands_exist() {
    for section in sections(1.0) {
        if let Some((_, arguments)) = section.command.split_once("--bin measure -- ") {
            let subcommand = arguments.split(' ').next().unwrap();
            let said =
                Command::new(env!("CARGO_BIN_EXE_measure")).args([subcommand, "--help"]).output().unwrap();
            assert!(said.status.success(), "{subcommand}");
            let help = String::from_utf8(said.stdout).unwrap();
            for option in arguments.split(' ').filter(|word| word.starts_with("--")) {
                assert!(help.contains(option), "{subcommand} {option}");
            }
        }
        let files = section
            .command
            .split(' ')
            .filter(|word| word.starts_with("examples/") || word.starts_with("tests/"));
        for file in files {
            assert!(repository().join(file).exists(), "{file}");
        }
    }
}

#[test]
fn the_numbers_of_the_readme_are_among_the_figures() {
    let (readme, document) = (read("README.md"), read(DOCUMENT));
    let table = readme.split_once(MARKS[0]).unwrap().1.split_once(MARKS[1]).unwrap().0.trim();
    let rows: Vec<&str> = table.lines().collect();
    assert_eq!(rows.len(), 6, "{table}");
    for row in rows {
        assert!(document.lines().any(|line| line == row), "not in {DOCUMENT}: {row}");
    }
    assert_eq!(with_table(&readme, &format!("{table}\n")).unwrap(), readme);
}

/// Files that a document links to, or shows, without `#` and what follows it.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](")
        .skip(1)
        .filter_map(|rest| rest.split(')').next())
        .map(|link| link.split('#').next().unwrap())
}

#[test]
fn what_documents_link_to_is_there_and_no_picture_is_left_over() {
    let mut shown = BTreeSet::new();
    let documents = [
        "README.md",
        "ARCHITECTURE.md",
        "CONTRIBUTING.md",
        "CHANGELOG.md",
        DOCUMENT,
        "examples/scenes/README.md",
        "examples/blender/README.md",
        "examples/c/README.md",
        "examples/cpp/README.md",
        "examples/embree/README.md",
        "examples/python/README.md",
        "examples/web/README.md",
    ];
    for document in documents {
        let folder = repository().join(document).parent().unwrap().to_owned();
        let text = read(document);
        for link in links(&text).filter(|link| !link.is_empty() && !link.contains("://")) {
            let file = folder.join(link);
            assert!(file.exists(), "{document}: {link}");
            shown.insert(file.canonicalize().unwrap());
        }
    }
    for entry in fs::read_dir(repository().join(PICTURES)).unwrap() {
        let picture = entry.unwrap().path().canonicalize().unwrap();
        let kept = picture.extension().is_none_or(|ending| ending == "exr") || shown.contains(&picture);
        assert!(kept, "{} is shown nowhere", picture.display());
    }
}

#[test]
fn the_readme_names_the_rust_that_cargo_asks_for() {
    let version = |manifest: &str| {
        let text = read(manifest);
        let (_, rest) = text.split_once("rust-version = \"").unwrap();
        rest.split('"').next().unwrap().to_owned()
    };
    let (oldest, of_core) = (version("Cargo.toml"), version("core/Cargo.toml"));
    assert!(read("README.md").contains(&format!("| Rust | {oldest} or newer")), "{oldest}");
    assert!(read("README.md").contains(&format!("`core` without feature `bvh`: {of_core},")), "{of_core}");
    assert_eq!(version("tests/bare-metal/Cargo.toml"), of_core);
}
