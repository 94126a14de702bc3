//! Prints the hashes of three small pictures, and compares them with `tests/golden.txt` or, with `--write`,
//! writes that.

use covbeam_tests::{golden, header::repository};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = repository().join("tests/golden.txt");
    let text = golden::text()?;
    print!("{text}");
    if std::env::args().nth(1).as_deref() == Some("--write") {
        std::fs::write(&path, &text)?;
    } else if std::fs::read_to_string(&path)? != text {
        return Err("other bits than in tests/golden.txt, which are the same on all machines: --write, if that was meant".into());
    }
    Ok(())
}
