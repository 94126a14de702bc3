//! What modules of a crate import of each other.

use crate::rooms::{Sources, made_up};
use std::collections::{BTreeMap, BTreeSet};

/// Modules, `beam_map/eight`, and which others each of them imports.
pub(crate) type Arrows = BTreeMap<String, BTreeSet<String>>;

/// Arrows between the modules of a crate's code. Its lib.rs and main.rs have all others and count for none.
pub(crate) fn arrows(code: &Sources) -> Arrows {
    let modules: BTreeMap<&str, &str> = code
        .iter()
        .filter(|(path, _)| !["lib.rs", "main.rs"].contains(&path.as_str()))
        .map(|(path, code)| (path.trim_end_matches(".rs").trim_end_matches("/mod"), code.as_str()))
        .collect();
    modules.iter().map(|(module, code)| ((*module).to_owned(), imports(&modules, module, code))).collect()
}

/// What a module names of others: `crate::…`, `super::…`, and of its children's all but what it hands on.
fn imports(modules: &BTreeMap<&str, &str>, module: &str, code: &str) -> BTreeSet<String> {
    let here: Vec<&str> = module.split('/').collect();
    let within = |target: &String| target.starts_with(&format!("{module}/"));
    let mut found = BTreeSet::new();
    let mut behind = 0;
    for start in path_starts(code) {
        // The paths within a group are parts of the one that the group ends.
        let whole = if start < behind { "" } else { with_group(&code[start..]) };
        behind = behind.max(start + whole.len());
        for path in paths(whole) {
            match path[0] {
                "crate" => found.extend(target(modules, path[1..].to_vec())),
                "super" => {
                    let up = path.iter().take_while(|name| **name == "super").count();
                    let above = &here[..here.len().saturating_sub(up)];
                    found.extend(target(modules, [above, &path[up..]].concat()));
                }
                _ if is_handed_on(&code[..start]) => {}
                first => {
                    let names = if first == "self" { &path[1..] } else { &path[..] };
                    found.extend(target(modules, [&here[..], names].concat()).filter(within));
                }
            }
        }
    }
    found.remove(module);
    found
}

fn is_of_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Where the paths of a code begin: names with `::` behind and none before.
fn path_starts(code: &str) -> BTreeSet<usize> {
    let start = |(at, _): (usize, &str)| {
        let name = code[..at].trim_end_matches(is_of_name);
        (name.len() < at && !name.ends_with(':')).then_some(name.len())
    };
    code.match_indices("::").filter_map(start).collect()
}

/// Whether the path after this code is what a `pub use` names.
fn is_handed_on(before: &str) -> bool {
    let line = before.rsplit(['\n', ';']).next().unwrap().trim_start();
    line.starts_with("pub") && line.ends_with("use ")
}

/// The path that a text starts with, with the group that may end it: `a::{b, c::d}`.
fn with_group(text: &str) -> &str {
    let end = text.find(|c| !is_of_name(c) && c != ':').unwrap_or(text.len());
    if !text[..end].ends_with("::") || !text[end..].starts_with('{') {
        return &text[..end];
    }
    let mut depth = 0;
    let closes = |(_, c): &(usize, char)| {
        depth += i32::from(*c == '{') - i32::from(*c == '}');
        depth == 0
    };
    let (length, _) = text[end..].char_indices().find(closes).unwrap();
    &text[..=end + length]
}

/// All paths of a path with a group: of `a::{b, c::d}` they are `a::b` and `a::c::d`.
fn paths(text: &str) -> Vec<Vec<&str>> {
    if let Some(group) = text.strip_prefix('{').and_then(|group| group.strip_suffix('}')) {
        let mut depth = 0;
        let parts = |c: char| {
            depth += i32::from(c == '{') - i32::from(c == '}');
            depth == 0 && c == ','
        };
        return group.split(parts).flat_map(|member| paths(member.trim())).collect();
    }
    let (name, rest) = text.split_at(text.find(|c| !is_of_name(c)).unwrap_or(text.len()));
    match rest.strip_prefix("::") {
        Some(rest) => paths(rest).into_iter().map(|path| [&[name], &path[..]].concat()).collect(),
        None => vec![vec![name]],
    }
}

/// The module that a path of names leads into, if it is one of the crate's.
fn target(modules: &BTreeMap<&str, &str>, mut path: Vec<&str>) -> Option<String> {
    while !path.is_empty() {
        let module = path.join("/");
        if modules.contains_key(module.as_str()) {
            return Some(module);
        }
        path.pop();
    }
    None
}

#[test]
fn every_way_of_importing_is_an_arrow() {
    let imported = |path: &str, code: &str| {
        let (a, b) = ("a/mod.rs", "a/b.rs");
        let others = ["a/b/c.rs", "d.rs", "d/e.rs", "f.rs", "lib.rs"].map(|path| (path, ""));
        let mut sources = made_up(&[&others[..], &[(a, ""), (b, "")]].concat());
        sources.insert(path.to_owned(), code.to_owned());
        let module = path.trim_end_matches(".rs").trim_end_matches("/mod");
        arrows(&sources)[module].iter().cloned().collect::<Vec<_>>().join(" ")
    };
    assert_eq!(
        imported("a/b.rs", "use crate::f;\nuse crate::{\n    d::{Y, e::{self, X as Z}},\n};"),
        "d d/e f"
    );
    assert_eq!(imported("a/b.rs", "fn g() { let x = f(crate::d::e::X, $crate::f::y::<A>()); }"), "d/e f");
    assert_eq!(imported("a/b.rs", "use super::X;\nuse super::super::f::*;"), "a f");
    assert_eq!(imported("a/mod.rs", "use super::{d, E};\npub use crate::f::X;"), "d f");
    assert_eq!(imported("a/b/c.rs", "use super::{super::X, Y};"), "a a/b");
    assert_eq!(imported("a/mod.rs", "mod b;\nuse b::X;"), "a/b");
    assert_eq!(imported("a/mod.rs", "mod b;\nfn g() { self::b::c::g(b::g()) }"), "a/b a/b/c");
    assert_eq!(imported("a/mod.rs", "mod b;\npub use b::X;\npub(crate) use b::{X, c::Y};"), "");
    assert_eq!(
        imported("a/mod.rs", "mod b;\nuse crate::{\n    b::X,\n    f::Y,\n};\nuse std::{b::X, Y};"),
        "f"
    );
    assert_eq!(imported("a/mod.rs", "use std::f::X;\nuse crate::X;\nfn g() { x::b::y(mycrate::f::x) }"), "");
}
