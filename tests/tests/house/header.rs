//! What is made from the C ABI is up to date, and the headers document what a C programmer must know.

use crate::rooms::sources;
use covbeam_tests::header::{Function, files, headers, repository};
use std::fs;

/// All that are exported.
fn functions() -> Vec<Function> {
    let headers = headers().unwrap();
    headers.functions.into_iter().chain(headers.session_functions).collect()
}

#[test]
fn the_committed_files_are_the_generated_ones() {
    for (path, generated) in files().unwrap() {
        let committed = fs::read_to_string(repository().join(path)).unwrap();
        assert!(committed == generated, "{path} is out of date: cargo run -p covbeam-tests --bin header");
    }
}

#[test]
fn every_exported_function_is_declared() {
    let mut exported = Vec::new();
    for source in sources("ffi/src").into_values() {
        for (_, item) in
            source.match_indices("#[unsafe(no_mangle)]\n").map(|(at, mark)| source.split_at(at + mark.len()))
        {
            let (head, _) = item.split_once('(').unwrap();
            exported.push(head.rsplit(' ').next().unwrap().to_owned());
        }
    }
    let mut declared: Vec<String> = functions().into_iter().map(|function| function.name).collect();
    exported.sort();
    declared.sort();
    assert_eq!(exported, declared);
}

#[test]
fn the_main_header_stays_small() {
    let headers = headers().unwrap();
    // Comments, and the bodies of inline functions, are indented.
    let of_main = |function: &&Function| {
        let declared = [format!(" {}(", function.name), format!("*{}(", function.name)];
        let declares = |line: &str| !line.starts_with(' ') && declared.iter().any(|part| line.contains(part));
        headers.main.lines().any(declares)
    };
    let count = headers.functions.iter().filter(of_main).count();
    assert!((50..=70).contains(&count), "{count} functions");
}

#[test]
fn every_parameter_has_its_line_in_the_manual() {
    for Function { doc, name, parameters, .. } in functions() {
        // `@param count, beams, beam_stride what they are`
        let documented: Vec<&str> = doc
            .iter()
            .filter_map(|line| line.strip_prefix("@param "))
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
            assert!(documented.contains(&parameter.name.as_str()), "{name}: no @param {}", parameter.name);
        }
        for written in documented {
            assert!(parameters.iter().any(|p| p.name == written), "{name}: @param {written} is no parameter");
        }
    }
}

#[test]
fn names_are_covbeams_and_text_is_ascii() {
    let headers = headers().unwrap();
    for header in [&headers.main, &headers.extra, &headers.session] {
        assert!(header.is_ascii(), "compilers may read the header in any code page");
        for line in header.lines().filter_map(|line| line.strip_prefix("#define ")) {
            assert!(line.starts_with("COVBEAM_"), "{line}");
        }
    }
    for Function { name, .. } in headers.functions {
        assert!(name.starts_with("covbeam_"), "{name}");
    }
}
