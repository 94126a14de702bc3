//! Debts: circles of imports, long files, long functions and full folders. `debts.txt` lists all that may be.

use crate::circles::circles;
use crate::imports::arrows;
use crate::rooms::{CRATES, Sources, code, made_up, sources};
use crate::sizes::{full_folders, long_files, long_functions};
use std::collections::BTreeSet;

/// A line of the list: what it is of, and modules of a circle or a number.
#[derive(Clone, Debug, PartialEq)]
struct Debt {
    of: String,
    modules: BTreeSet<String>,
    number: usize,
}

impl Debt {
    fn circle(name: &str, modules: BTreeSet<String>) -> Self {
        Self { of: format!("circle {name}"), modules, number: 0 }
    }

    fn size(of: String, number: usize) -> Self {
        Self { of, modules: BTreeSet::new(), number }
    }

    fn parse(line: &str) -> Self {
        let words: Vec<&str> = line.split(' ').collect();
        match words[..] {
            ["circle", name, ref modules @ ..] if modules.len() > 1 => {
                Self::circle(name, modules.iter().map(|&module| module.to_owned()).collect())
            }
            ["file" | "folder", _, number] | ["function", _, _, number] => {
                Self::size(words[..words.len() - 1].join(" "), number.parse().expect(line))
            }
            _ => panic!("no debt: {line}"),
        }
    }

    fn line(&self) -> String {
        let Self { of, modules, number } = self;
        if modules.is_empty() {
            format!("{of} {number}")
        } else {
            format!("{of} {}", Vec::from_iter(modules.iter().map(String::as_str)).join(" "))
        }
    }

    fn is_less_than(&self, other: &Self) -> bool {
        self.of == other.of && self.number <= other.number && self.modules.is_subset(&other.modules)
    }
}

/// All debts of a crate.
fn debts(name: &str, folder: &str, sources: &Sources) -> Vec<Debt> {
    let code = code(sources);
    let of = |what: &str, sizes: Vec<(String, usize)>| {
        let line = |path: &str| format!("{what} {folder}/{path}").trim_end_matches('/').to_owned();
        sizes.into_iter().map(|(path, number)| Debt::size(line(&path), number)).collect::<Vec<_>>()
    };
    let circles = circles(&arrows(&code)).into_iter().map(|circle| Debt::circle(name, circle));
    [
        circles.collect(),
        of("file", long_files(sources)),
        of("folder", full_folders(sources)),
        of("function", long_functions(&code)),
    ]
    .concat()
}

/// What is wrong: nothing only where the debts that there are and those that are listed are the same.
fn complaints(there: &[Debt], listed: &[Debt]) -> Vec<String> {
    let mut gone = listed.to_vec();
    let mut new = Vec::new();
    for debt in there {
        match gone.iter().position(|listed| listed == debt) {
            Some(at) => drop(gone.remove(at)),
            None => new.push(debt),
        }
    }
    let off = gone.iter().filter(|listed| !new.iter().any(|debt| listed.is_less_than(debt)));
    let off = off.map(|listed| format!("has shrunk or is gone, take off the list: {}", listed.line()));
    let of_new = new.iter().map(|debt| {
        let shrunk = gone.iter().any(|listed| debt.is_less_than(listed));
        let what = if shrunk { "is left of it, write down instead" } else { "is more than the list allows" };
        format!("{what}: {}", debt.line())
    });
    off.chain(of_new).collect()
}

#[test]
fn debts_are_those_of_the_list_which_only_shrinks() {
    let lines: Vec<&str> = include_str!("debts.txt").lines().filter(|line| !line.starts_with('#')).collect();
    assert!(lines.is_sorted(), "debts.txt is not sorted");
    let listed: Vec<Debt> = lines.into_iter().map(Debt::parse).collect();
    let there: Vec<Debt> =
        CRATES.iter().flat_map(|(name, folder)| debts(name, folder, &sources(folder))).collect();
    let complaints = complaints(&there, &listed);
    assert!(complaints.is_empty(), "tests/tests/house/debts.txt:\n{}", complaints.join("\n"));
}

#[test]
fn core_has_no_debts() {
    assert_eq!(debts("core", "core/src", &sources("core/src")), []);
}

#[test]
fn each_debt_of_a_made_up_crate_is_found() {
    let long =
        format!("use crate::b::{{X, Y}};\nfn f() {{\n{}}}\n{}", "    x;\n".repeat(59), "// c\n".repeat(500));
    let texts = [("lib.rs", "mod a;\nmod b;\nmod c;"), ("a.rs", &long), ("b.rs", "use super::c::C;")];
    let mut sources = made_up(&texts);
    sources.insert("c.rs".into(), "use crate::a;".into());
    sources.extend((0..21).map(|i| (format!("d/e{i}.rs"), String::new())));
    let lines: Vec<String> = debts("x", "x/src", &sources).iter().map(Debt::line).collect();
    let all = ["circle x a b c", "file x/src/a.rs 562", "folder x/src/d 21", "function x/src/a.rs f 61"];
    assert_eq!(lines, all);
    assert_eq!(all.map(|line| Debt::parse(line).line()), all);
    sources.extend((4..21).map(|i| (format!("e{i}.rs"), String::new())));
    assert!(debts("x", "x/src", &sources).contains(&Debt::parse("folder x/src 21")));
}

#[test]
fn debts_that_grow_and_debts_that_are_paid_are_complained_of() {
    let complaints = |there: &[&str], listed: &[&str]| {
        let [there, listed] =
            [there, listed].map(|lines| lines.iter().map(|line| Debt::parse(line)).collect::<Vec<_>>());
        complaints(&there, &listed)
    };
    let off = |line: &str| format!("has shrunk or is gone, take off the list: {line}");
    let left = |line: &str| format!("is left of it, write down instead: {line}");
    let much = |line: &str| format!("is more than the list allows: {line}");
    let all =
        ["circle x a b c", "file x/a.rs 600", "folder x 21", "function x/a.rs f 61", "function x/a.rs f 61"];
    assert!(complaints(&all, &all).is_empty());
    for (at, line) in all.iter().enumerate() {
        let others = [&all[..at], &all[at + 1..]].concat();
        assert_eq!(complaints(&others, &all), [off(line)]);
        assert_eq!(complaints(&all, &others), [much(line)]);
    }
    for (small, large) in [
        ("circle x a b", "circle x a b c"),
        ("file x/a.rs 599", "file x/a.rs 600"),
        ("function x/a.rs f 61", "function x/a.rs f 62"),
        ("folder x 21", "folder x 22"),
    ] {
        assert_eq!(complaints(&[small], &[large]), [off(large), left(small)]);
        assert_eq!(complaints(&[large], &[small]), [much(large)]);
    }
    // Of one circle two may be left; that two are one, or that modules change places, is more.
    let (whole, halves) = ("circle x a b c d", ["circle x a b", "circle x c d"]);
    assert_eq!(complaints(&halves, &[whole]), [off(whole), left(halves[0]), left(halves[1])]);
    assert_eq!(complaints(&[whole], &halves), [much(whole)]);
    assert_eq!(complaints(&["circle x a e"], &[halves[0]]), [off(halves[0]), much("circle x a e")]);
    assert_eq!(complaints(&["circle y a b"], &["circle x a b"]).len(), 2, "of another crate");
}
