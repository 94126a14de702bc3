//! Writes what is made from the C ABI: `cargo run -p covbeam-tests --bin header`.

use covbeam_tests::header::{files, repository};
use std::process::ExitCode;

fn main() -> ExitCode {
    let written = files().and_then(|files| {
        files.into_iter().try_for_each(|(path, text)| {
            std::fs::write(repository().join(path), text).map_err(|error| format!("{path}: {error}"))
        })
    });
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
