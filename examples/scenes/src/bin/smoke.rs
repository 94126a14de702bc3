//! Writes the plume of smoke.toml: `smoke FILE.vol`.

use covbeam_scenes::plume::{CELLS, STEPS, plume};
use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut arguments = std::env::args_os().skip(1);
    let (Some(path), None) = (arguments.next().map(PathBuf::from), arguments.next()) else {
        eprintln!("usage: smoke FILE.vol");
        return ExitCode::from(2);
    };
    match std::fs::write(&path, plume(CELLS, STEPS).to_bytes()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cannot write '{}': {error}", path.display());
            ExitCode::FAILURE
        }
    }
}
