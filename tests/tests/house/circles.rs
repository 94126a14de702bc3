//! Circles of imports: modules of which each leads to each other.

use crate::imports::{Arrows, arrows};
use crate::rooms::{code, made_up, sources};
use std::collections::BTreeSet;

pub(crate) fn circles(arrows: &Arrows) -> Vec<BTreeSet<String>> {
    let mut found: Vec<BTreeSet<String>> = Vec::new();
    for module in arrows.keys() {
        if found.iter().any(|circle| circle.contains(module)) {
            continue;
        }
        let mut circle = reached(arrows, module);
        circle.retain(|other| reached(arrows, other).contains(module));
        if !circle.is_empty() {
            found.push(circle);
        }
    }
    found
}

/// What imports of imports lead to; the module itself only where it is part of a circle.
fn reached<'a>(arrows: &'a Arrows, module: &'a String) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut left = vec![module];
    while let Some(module) = left.pop() {
        left.extend(arrows[module].iter().filter(|import| found.insert((*import).clone())));
    }
    found
}

#[test]
fn circles_are_found_and_what_leads_to_them_is_not_part_of_them() {
    let of = |texts: &[(&str, &str)]| {
        let circles = circles(&arrows(&code(&made_up(texts))));
        circles.into_iter().map(|circle| Vec::from_iter(circle).join(" ")).collect::<Vec<_>>()
    };
    let open = [
        ("a.rs", "use crate::b::X;"),
        ("b.rs", "use crate::c::X;"),
        ("c.rs", "use crate::{d::X, C};\n#[cfg(test)]\nmod tests {\n    use crate::a;\n}"),
        ("d.rs", "mod e;\npub use e::X;\n// use crate::a;"),
        ("d/e.rs", "use super::Y;"),
    ];
    assert!(of(&open).is_empty());
    let mut closed = open;
    closed[2].1 = "use crate::{C, d::X};\nuse crate::b;";
    assert_eq!(of(&closed), ["b c"]);
    closed[3].1 = "mod e;\nuse e::X;";
    assert_eq!(of(&closed), ["b c", "d d/e"]);
    closed[4].1 = "use super::super::a;";
    assert_eq!(of(&closed), ["a b c d d/e"]);
}

#[test]
fn the_arrows_of_core_are_seen() {
    let arrows = arrows(&code(&sources("core/src")));
    assert!(arrows.len() > 30, "{arrows:?}");
    assert!(
        arrows["pair"].contains("kernel") && arrows["beam_map/eight"].contains("beam_map/simd"),
        "{arrows:?}"
    );
}
