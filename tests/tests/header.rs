//! The C header is the one that the sources give, and documents what a C programmer must know.

use covbeam_tests::header::{generate, repository};
use std::fs;

/// A function that C sees: its doc comment, name and parameters.
struct Function {
    doc: String,
    name: String,
    parameters: Vec<String>,
}

/// The functions of the ABI, in rustfmt's layout.
fn functions() -> Vec<Function> {
    let mut functions = Vec::new();
    for entry in fs::read_dir(repository().join("ffi/src")).unwrap() {
        let source = fs::read_to_string(entry.unwrap().path()).unwrap();
        let mut doc = String::new();
        let mut lines = source.lines();
        while let Some(line) = lines.next() {
            if let Some(text) = line.strip_prefix("///") {
                doc.push_str(text);
                doc.push('\n');
            } else if line.starts_with("pub ") && line.contains("extern \"C\" fn ") {
                let mut signature = line.to_owned();
                while !signature.contains(')') {
                    signature.push_str(lines.next().expect("a signature ends").trim());
                }
                let (head, rest) = signature.split_once('(').unwrap();
                let (inside, _) = rest.split_once(')').unwrap();
                functions.push(Function {
                    doc: std::mem::take(&mut doc),
                    name: head.rsplit(' ').next().unwrap().to_owned(),
                    parameters: inside
                        .split(',')
                        .filter_map(|parameter| Some(parameter.split_once(':')?.0.trim().to_owned()))
                        .collect(),
                });
            } else if !line.starts_with("#[") {
                doc.clear();
            }
        }
    }
    assert!(
        functions.len() > 70,
        "only {} functions found: has the sources' layout changed?",
        functions.len()
    );
    functions
}

#[test]
fn the_committed_header_is_the_generated_one() {
    let committed = fs::read_to_string(repository().join("include/covbeam.h")).unwrap();
    let generated = generate().unwrap();
    assert!(
        committed == generated,
        "include/covbeam.h is out of date: cargo run -p covbeam-tests --bin header"
    );
}

#[test]
fn every_function_is_declared_once() {
    let header = generate().unwrap();
    for Function { name, .. } in functions() {
        let declared = |line: &&str| {
            let head = line.split('(').next().unwrap_or_default();
            head.strip_suffix(name.as_str())
                .is_some_and(|kind| kind.ends_with([' ', '*']) && !kind.starts_with(' '))
        };
        assert_eq!(header.lines().filter(declared).count(), 1, "{name}");
    }
}

#[test]
fn every_parameter_has_its_line_in_the_manual() {
    for Function { doc, name, parameters } in functions() {
        // `@param count, beams, beam_stride what they are`
        let documented: Vec<&str> = doc
            .lines()
            .filter_map(|line| line.trim_start().strip_prefix("@param "))
            .flat_map(|line| {
                let mut names = Vec::new();
                for word in line.split(' ') {
                    names.push(word.trim_end_matches(','));
                    if !word.ends_with(',') {
                        break;
                    }
                }
                names
            })
            .collect();
        for parameter in &parameters {
            assert!(documented.contains(&parameter.as_str()), "{name}: no @param {parameter}");
        }
        for written in documented {
            assert!(parameters.iter().any(|p| p == written), "{name}: @param {written} is no parameter");
        }
    }
}

#[test]
fn names_are_covbeams_and_text_is_ascii() {
    let header = generate().unwrap();
    assert!(header.is_ascii(), "compilers may read the header in any code page");
    for line in header.lines().filter_map(|line| line.strip_prefix("#define ")) {
        assert!(line.starts_with("COVBEAM_"), "{line}");
    }
    for Function { name, .. } in functions() {
        assert!(name.starts_with("covbeam_"), "{name}");
    }
}
