//! core's house: no circle of imports, no file over 500 lines, no function over 60.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Source of each module by its path, `beam_map/eight`, without tests and comments.
fn modules(folder: &Path, prefix: &str, found: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap();
        if path.is_dir() {
            modules(&path, &format!("{prefix}{name}/"), found);
        } else if name != "lib" {
            let text = fs::read_to_string(&path).unwrap();
            assert!(text.lines().count() <= 500, "{}: {} lines", path.display(), text.lines().count());
            let code = text.split("#[cfg(test)]\nmod tests").next().unwrap();
            let lines = code.lines().map(|line| line.split("//").next().unwrap());
            let module =
                if name == "mod" { prefix.trim_end_matches('/').into() } else { format!("{prefix}{name}") };
            found.insert(module, lines.collect::<Vec<_>>().join("\n"));
        }
    }
}

fn all() -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    modules(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../core/src"), "", &mut found);
    assert!(found.len() > 30, "{found:?}");
    found
}

/// The module that a path of names leads into, if it is one of core's.
fn target(modules: &BTreeMap<String, String>, mut path: Vec<&str>) -> Option<String> {
    while !path.is_empty() {
        let module = path.join("/");
        if modules.contains_key(&module) {
            return Some(module);
        }
        path.pop();
    }
    None
}

/// What a module names of others: `crate::…`, `super::…`, and of its children's all but what it hands on.
fn imports(modules: &BTreeMap<String, String>, module: &str) -> BTreeSet<String> {
    let here: Vec<&str> = module.split('/').collect();
    let code = &modules[module];
    let mut found = BTreeSet::new();
    for statement in code.split(';') {
        let statement = statement.trim_start();
        let names = |at: usize| -> Vec<&str> {
            let path = &statement[at..];
            let end = path.find(|c: char| !c.is_alphanumeric() && c != '_' && c != ':').unwrap_or(path.len());
            path[..end].split("::").filter(|name| !name.is_empty()).collect()
        };
        for (at, _) in statement.match_indices("crate::") {
            found.extend(target(modules, names(at + 7)));
        }
        for (at, _) in statement.match_indices("super::") {
            let parent = &here[..here.len() - 1];
            found.extend(target(modules, parent.iter().copied().chain(names(at + 7)).collect()));
        }
        if let Some(at) = statement.strip_prefix("use ").map(|_| 4) {
            let child: Vec<&str> = here.iter().copied().chain(names(at)).collect();
            found.extend(target(modules, child).filter(|child| child.starts_with(&format!("{module}/"))));
        }
    }
    found.remove(module);
    found
}

#[test]
fn no_module_imports_itself_in_a_circle() {
    let modules = all();
    let mut left: BTreeMap<&str, BTreeSet<String>> =
        modules.keys().map(|module| (module.as_str(), imports(&modules, module))).collect();
    assert!(left["pair"].contains("kernel") && left["beam_map/eight"].contains("beam_map/simd"), "{left:?}");
    // Takes away what imports nothing that is left, until nothing can be taken away.
    while let Some(leaf) = left.iter().find(|(_, imports)| imports.is_empty()).map(|(module, _)| *module) {
        left.remove(leaf);
        left.values_mut().for_each(|imports| {
            imports.remove(leaf);
        });
    }
    assert!(left.is_empty(), "a circle among {left:?}");
}

#[test]
fn no_function_is_longer_than_a_screen() {
    for (module, code) in all() {
        let mut started: Vec<(usize, usize)> = Vec::new();
        for (number, line) in code.lines().enumerate() {
            let indent = line.len() - line.trim_start().len();
            let words: Vec<&str> = line.split_whitespace().collect();
            if words.contains(&"fn") && !line.trim_end().ends_with([';', '}']) {
                started.push((indent, number));
            } else if line.trim_end() == format!("{}}}", " ".repeat(indent))
                && started.last().is_some_and(|(at, _)| *at == indent)
            {
                let (_, first) = started.pop().unwrap();
                let length = number - first + 1;
                assert!(length <= 60, "{module}, line {}: a function of {length} lines", first + 1);
            }
        }
    }
}

#[test]
fn eight_numbers_side_by_side_meet_no_operation_that_processors_do_differently() {
    // Of NaN and of zeros of two signs the crate's least and greatest are the processor's choice; fused and approximate operations
    // round as it does.
    let forbidden = [".min(", ".max(", "_precise(", "reduce_", "clamp(", "mul_add", "mul_sub", "approximate"];
    let modules = all();
    for module in ["eight", "packet", "shade", "simd"] {
        let code = &modules[&format!("beam_map/{module}")];
        assert!(code.contains("fearless_simd"), "{module}");
        let found: Vec<&str> = forbidden.into_iter().filter(|name| code.contains(name)).collect();
        assert!(found.is_empty(), "{module}: {found:?}");
    }
}
