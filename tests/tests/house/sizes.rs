//! Sizes: lines of files and of functions, files of folders.

use crate::rooms::{Sources, code, made_up};
use std::collections::BTreeMap;

/// Most lines of a file, tests and comments included.
pub(crate) const FILE: usize = 500;

/// Most lines of a function, which is a screen.
pub(crate) const FUNCTION: usize = 60;

/// Most files of a folder, those of its folders not counted.
pub(crate) const FOLDER: usize = 20;

/// Files that are too long.
pub(crate) fn long_files(sources: &Sources) -> Vec<(String, usize)> {
    let sizes = sources.iter().map(|(path, text)| (path.clone(), text.lines().count()));
    sizes.filter(|(_, lines)| *lines > FILE).collect()
}

/// Folders with too many files; a crate's own is an empty name.
pub(crate) fn full_folders(sources: &Sources) -> Vec<(String, usize)> {
    let mut sizes = BTreeMap::new();
    for path in sources.keys() {
        *sizes.entry(path.rsplit_once('/').map_or("", |(folder, _)| folder).to_owned()).or_default() += 1;
    }
    sizes.into_iter().filter(|(_, files)| *files > FOLDER).collect()
}

/// Functions that are too long, `photon.rs trace`.
pub(crate) fn long_functions(code: &Sources) -> Vec<(String, usize)> {
    let of_file = |(path, code): (&String, &String)| {
        let sizes = functions(code).into_iter().filter(|(_, lines)| *lines > FUNCTION);
        sizes.map(|(name, lines)| (format!("{path} {name}"), lines)).collect::<Vec<_>>()
    };
    code.iter().flat_map(of_file).collect()
}

/// Functions of more than a line, and their lines: rustfmt ends them in the column that they start in.
fn functions(code: &str) -> Vec<(&str, usize)> {
    let mut found = Vec::new();
    let mut started: Vec<(usize, usize, &str)> = Vec::new();
    for (number, line) in code.lines().enumerate() {
        let text = line.trim();
        let indent = line.len() - line.trim_start().len();
        if let Some(name) = function_name(text).filter(|_| !text.ends_with([';', '}'])) {
            started.push((indent, number, name));
        } else if text == "}" || text.starts_with(')') && text.ends_with([';', '}']) {
            // What is deeper had no end of its own, as functions in macros.
            while started.pop_if(|(deeper, _, _)| *deeper > indent).is_some() {}
            if let Some((_, first, name)) = started.pop_if(|(same, _, _)| *same == indent)
                && text == "}"
            {
                found.push((name, number - first + 1));
            }
        }
    }
    found
}

/// Name of the function that a line starts.
fn function_name(line: &str) -> Option<&str> {
    let (before, name) = line.split_once("fn ")?;
    let end = name.find(|c: char| !c.is_alphanumeric() && c != '_' && c != '$').unwrap_or(name.len());
    (end > 0 && (before.is_empty() || before.ends_with(' '))).then_some(&name[..end])
}

#[test]
fn lines_of_functions_are_counted_from_the_name_to_the_brace() {
    let code = "pub fn a(\n    x: u8,\n) -> u8\nwhere\n    u8: Copy,\n{\n    x\n}\n\n\
        impl X for Y {\n    fn one(&self) {}\n\
        \x20   fn b<T>(t: T) {\n        fn inner() {\n        }\n        if t {\n        }\n    }\n}\n\n\
        trait T {\n    fn none(\n        &self,\n    ) -> u8;\n    fn c() {\n    }\n}\n\
        unsafe extern \"C\" fn d() {\n    x: fn (u8),\n}";
    assert_eq!(functions(code), [("a", 8), ("inner", 2), ("b", 6), ("c", 2), ("d", 3)]);
}

#[test]
fn one_more_is_too_much() {
    let function = |lines: usize| format!("/// Long.\nfn f() {{\n{}}}\n", "    //\n".repeat(lines - 2));
    let sizes = |lines: usize| {
        let text = function(lines);
        let sources = made_up(&[("a/f.rs", text.as_str()), ("tests.rs", text.as_str())]);
        (long_files(&sources), long_functions(&code(&sources)))
    };
    assert_eq!(sizes(60), (vec![], vec![]));
    assert_eq!(sizes(61), (vec![], vec![("a/f.rs f".into(), 61), ("tests.rs f".into(), 61)]));
    assert_eq!(sizes(499).0, vec![]);
    assert_eq!(sizes(500).0, [("a/f.rs".into(), 501), ("tests.rs".into(), 501)]);

    let folder = |files: usize| {
        let folders =
            ["", "a/", "a/b/"].into_iter().flat_map(|at| (0..files).map(move |i| format!("{at}{i}.rs")));
        let sources: Sources = folders.chain(["c/d.rs".into()]).map(|path| (path, String::new())).collect();
        full_folders(&sources)
    };
    assert_eq!(folder(20), []);
    assert_eq!(folder(21), [(String::new(), 21), ("a".into(), 21), ("a/b".into(), 21)]);
}
