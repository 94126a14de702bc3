//! Writes `include/covbeam.h`: `cargo run -p covbeam-tests --bin header`.

use covbeam_tests::header::{generate, repository};
use std::process::ExitCode;

fn main() -> ExitCode {
    let path = repository().join("include/covbeam.h");
    let written = generate()
        .and_then(|text| std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display())));
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
