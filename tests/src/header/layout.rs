//! `layout.h`: the numbers of `ffi/src/layout.rs`, for compilers of C and C++.

use std::fmt::Write;

/// The whole file.
pub(super) fn assertions(source: &str) -> String {
    let mut text =
        "/* Made from ffi/src/layout.rs by `cargo run -p covbeam-tests --bin header`; do not edit. */\n"
            .to_owned();
    let sections = |mark: &str| {
        let (_, rest) = source.split_once(mark).unwrap_or_default();
        rest.split("\n}\n").next().unwrap_or_default().replace(['{', '}', ','], " ")
    };
    // `covbeam_NAME: SIZE, ALIGNMENT { FIELD OFFSET, ... }`
    let mut name = "";
    let layouts = sections("\nlayout! {");
    let mut words = layouts.split_whitespace();
    while let (Some(word), Some(number)) = (words.next(), words.next()) {
        if let Some(of) = word.strip_suffix(':') {
            name = of.trim_start_matches("covbeam_");
            writeln!(text, "SIZE({name}, {number}, {})", words.next().unwrap_or_default()).unwrap();
        } else {
            writeln!(text, "AT({name}, {word}, {number})").unwrap();
        }
    }
    // `covbeam_KIND { NAME VALUE, ... }`
    let values = sections("\nvalues! {");
    let mut words = values.split_whitespace().filter(|word| !word.starts_with("covbeam_"));
    while let (Some(word), Some(number)) = (words.next(), words.next()) {
        writeln!(text, "VALUE({}, {number})", word.trim_start_matches("COVBEAM_")).unwrap();
    }
    let version = source.split_once("COVBEAM_ABI_VERSION == ").unwrap_or_default().1;
    let version: String = version.chars().take_while(char::is_ascii_digit).collect();
    writeln!(text, "VALUE(ABI_VERSION, {version})").unwrap();
    text
}
