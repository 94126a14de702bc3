//! Packages as strangers get them: what `cargo publish` and wheels need, and copies of what lies outside of a package's folder.

use covbeam_tests::header::repository;
use std::fs;
use toml::{Table, Value};

/// Folders of the packages that go to crates.io, in the order of RELEASING.md.
const PUBLISHED: [&str; 4] = ["core", "core/geometry", "core/session", "examples/render"];

fn read(file: &str) -> String {
    fs::read_to_string(repository().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

fn manifest(folder: &str) -> Table {
    read(&format!("{folder}/Cargo.toml")).parse().unwrap()
}

#[test]
fn copies_are_those_of_their_originals() {
    let licences = PUBLISHED.iter().chain(&["ffi/python"]).flat_map(|folder| {
        ["LICENSE-MIT", "LICENSE-APACHE"].map(|file| (format!("{folder}/{file}"), file.to_owned()))
    });
    let scene = ("examples/render/src/commands/render/default_scene.toml", "examples/scenes/glass-ball.toml");
    for (copy, original) in licences.chain([(scene.0.to_owned(), scene.1.to_owned())]) {
        assert!(read(&copy) == read(&original), "{copy} is no copy of {original}");
    }
}

#[test]
fn what_is_published_says_all_that_crates_io_shows() {
    let root: Table = read("Cargo.toml").parse().unwrap();
    let members = root["workspace"]["members"].as_array().unwrap();
    let published: Vec<&str> = members
        .iter()
        .map(|member| member.as_str().unwrap())
        .filter(|folder| manifest(folder)["package"].get("publish") != Some(&Value::Boolean(false)))
        .collect();
    assert_eq!(published, PUBLISHED);
    for folder in PUBLISHED {
        let package = &manifest(folder)["package"];
        let text = |key: &str| package.get(key).and_then(Value::as_str).unwrap_or_default();
        assert!(!text("description").is_empty(), "{folder}");
        let readme = read(&format!("{folder}/{}", text("readme")));
        assert!(readme.starts_with(&format!("# {}\n", text("name"))) && readme.contains("```"), "{folder}");
        for key in ["keywords", "categories"] {
            let count = package.get(key).and_then(Value::as_array).map_or(0, Vec::len);
            assert!((1..=5).contains(&count), "{folder}: {count} {key}");
        }
    }
}

/// A published package asks for those beside it by their version, and they have one.
#[test]
fn packages_ask_for_each_other_by_the_version_they_have() {
    let workspace = &read("Cargo.toml").parse::<Table>().unwrap()["workspace"];
    let version = &workspace["package"]["version"];
    for name in ["covbeam", "covbeam-geometry", "covbeam-session"] {
        assert_eq!(workspace["dependencies"][name].get("version"), Some(version), "{name}");
    }
}
