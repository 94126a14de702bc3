//! Sources of the workspace's own crates, and their code: what is left without comments and tests.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Crates that keep the rules, and their folders.
pub(crate) const CRATES: &[(&str, &str)] = &[
    ("core", "core/src"),
    ("ffi", "ffi/src"),
    ("geometry", "core/geometry/src"),
    ("session", "core/session/src"),
    ("program", "examples/render/src"),
    ("web", "examples/web/src"),
];

/// Texts of a crate by path in its folder, `beam_map/eight.rs`.
pub(crate) type Sources = BTreeMap<String, String>;

pub(crate) fn sources(folder: &str) -> Sources {
    let mut found = Sources::new();
    read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder), "", &mut found);
    assert!(found.contains_key("lib.rs") && found.len() > 1, "{folder}: {:?}", found.keys());
    found
}

fn read(folder: &Path, prefix: &str, found: &mut Sources) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = format!("{prefix}{}", path.file_name().unwrap().to_str().unwrap());
        if path.is_dir() {
            read(&path, &format!("{name}/"), found);
        } else if name.ends_with(".rs") {
            found.insert(name, fs::read_to_string(&path).unwrap());
        }
    }
}

/// Sources line by line, what is no code left empty.
pub(crate) fn code(sources: &Sources) -> Sources {
    let mut code = Sources::new();
    let mut tests = Vec::new();
    for (path, text) in sources {
        let lines: Vec<&str> = text.lines().map(without_comment).collect();
        code.insert(path.clone(), without_tests(path, &lines, &mut tests));
    }
    code.retain(|path, _| {
        let stem = path.trim_end_matches(".rs");
        !tests.iter().any(|test| stem == test || path.starts_with(&format!("{test}/")))
    });
    code
}

fn without_comment(line: &str) -> &str {
    if line.trim_start().starts_with("//") { "" } else { line.split(" //").next().unwrap() }
}

/// A source without items that only tests have; `modules` gets the files among them, `light/tests`.
fn without_tests(path: &str, lines: &[&str], modules: &mut Vec<String>) -> String {
    let mut kept = Vec::new();
    let mut lines = lines.iter();
    while let Some(line) = lines.next() {
        let attribute = line.trim_start();
        if !attribute.starts_with("#[cfg(test)]") && !attribute.starts_with("#[cfg(all(test,") {
            kept.push(*line);
            continue;
        }
        kept.push("");
        // rustfmt ends an item in the column that it starts in; what stands there in a block may be text.
        let indent = &line[..line.len() - attribute.len()];
        let (mut item, mut in_block) = (Vec::new(), false);
        for line in lines.by_ref() {
            kept.push("");
            item.push(line.trim());
            let same = line.len() - line.trim_start().len() == indent.len();
            if *line == format!("{indent}}}") || !in_block && same && line.ends_with([';', '}', ',']) {
                break;
            }
            in_block |= same && line.ends_with('{');
        }
        modules.extend(declared(path, &item));
    }
    kept.join("\n")
}

/// File of the module that an item `mod name;` declares, without its `.rs`.
fn declared(path: &str, item: &[&str]) -> Option<String> {
    let (folder, file) = path.rsplit_once('/').map_or(("", path), |(folder, file)| (folder, file));
    let inside = |folder: &str, name: &str| format!("{folder}/{name}").trim_start_matches('/').to_owned();
    let name = item.last()?.strip_suffix(';')?.rsplit_once("mod ")?.1;
    let elsewhere = item.iter().find_map(|line| line.strip_prefix("#[path = \"")?.strip_suffix(".rs\"]"));
    Some(match (elsewhere, file) {
        (Some(elsewhere), _) => inside(folder, elsewhere),
        (None, "lib.rs" | "main.rs" | "mod.rs") => inside(folder, name),
        (None, _) => inside(path.trim_end_matches(".rs"), name),
    })
}

/// Made-up sources.
pub(crate) fn made_up(texts: &[(&str, &str)]) -> Sources {
    texts.iter().map(|(path, text)| ((*path).to_owned(), (*text).to_owned())).collect()
}

#[test]
fn code_is_what_remains_without_tests_and_comments() {
    let method =
        "    /// Test.\n    #[cfg(test)]\n    fn new(\n        x: u8,\n    ) -> u8 {\n        x\n    }\n";
    let samples = "#[cfg(test)]\n#[allow(unused)]\nmod samples {\n    const X: &str = \"\na,\nb;\n\";\n}\n";
    let code = code(&made_up(&[
        ("lib.rs", "#[cfg(test)]\nmod hostile;\nmod a;\n#[cfg(all(test, unix))]\npub(crate) mod b;"),
        ("hostile.rs", "use crate::a::X;"),
        ("b/mod.rs", "mod inner;"),
        ("b/inner.rs", "fn inner() {}"),
        ("a.rs", "//! a\nfn f() {} // ends\n#[cfg(test)]\n#[path = \"a_tests.rs\"]\nmod tests;\nfn g() {}"),
        ("a_tests.rs", "fn f() {}"),
        ("a/c.rs", &format!("impl C {{\n{method}}}\n{samples}\n#[cfg(test)]\nmod tests;\nfn h() {{}}")),
        ("a/c/tests.rs", "mod deep;"),
        ("a/c/tests/deep.rs", "fn deep() {}"),
        ("a/c/tests_of_others.rs", "fn kept() {}"),
    ]));
    assert_eq!(code.keys().collect::<Vec<_>>(), ["a.rs", "a/c.rs", "a/c/tests_of_others.rs", "lib.rs"]);
    assert_eq!(code["a.rs"], "\nfn f() {}\n\n\n\nfn g() {}");
    let kept: Vec<(usize, &str)> =
        code["a/c.rs"].lines().enumerate().filter(|(_, line)| !line.is_empty()).collect();
    assert_eq!(kept, [(0, "impl C {"), (8, "}"), (20, "fn h() {}")]);
    assert_eq!(code["lib.rs"], "\n\nmod a;\n\n");
}

#[test]
fn no_test_is_taken_for_code() {
    for (_, folder) in CRATES {
        let sources = sources(folder);
        for (path, code) in code(&sources) {
            assert!(!code.contains("#[test]"), "{folder}/{path}");
            let lines = sources[&path].lines().count().max(1);
            assert_eq!(code.split('\n').count(), lines, "{folder}/{path}");
        }
    }
}
