//! Writes `tests/vectors.txt`: `cargo run -p covbeam-tests --bin vectors`.

use covbeam_tests::{header::repository, vectors};
use std::collections::BTreeMap;
use std::process::ExitCode;

fn main() -> ExitCode {
    let path = repository().join("tests/vectors.txt");
    let text = vectors::text();
    if let Err(error) = std::fs::write(&path, &text) {
        eprintln!("{}: {error}", path.display());
        return ExitCode::FAILURE;
    }
    let mut names: BTreeMap<&str, usize> = BTreeMap::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        *names.entry(line.split(' ').next().unwrap_or_default()).or_default() += 1;
    }
    for (name, calls) in &names {
        println!("{calls:5} {name}");
    }
    println!("{} calls, {} names, {} bytes", names.values().sum::<usize>(), names.len(), text.len());
    ExitCode::SUCCESS
}
