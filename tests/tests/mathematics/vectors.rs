//! `tests/vectors.txt` is what the core computes today, and leaves out no function of the C ABI.

use covbeam_tests::header::{headers, repository};
use covbeam_tests::vectors;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

fn committed() -> String {
    fs::read_to_string(repository().join("tests/vectors.txt")).unwrap()
}

/// Name, inputs and outputs of each line.
fn calls(text: &str) -> impl Iterator<Item = (&str, Vec<&str>, Vec<&str>)> {
    text.lines().filter(|line| !line.starts_with('#')).map(|line| {
        let (call, outputs) = line.split_once(" ->").unwrap();
        let mut words = call.split(' ');
        let name = words.next().unwrap();
        (name, words.collect(), outputs.split(' ').skip(1).collect())
    })
}

/// What a word says as an f32.
fn float(word: &str) -> f32 {
    f32::from_bits(u32::from_str_radix(word, 16).unwrap())
}

#[test]
fn the_committed_vectors_are_what_the_core_computes() {
    let (committed, computed) = (committed(), vectors::text());
    for (i, (old, new)) in committed.lines().zip(computed.lines()).enumerate() {
        assert!(
            old == new,
            "line {}: the core changed its answers; if that was meant: cargo run -p covbeam-tests --bin vectors\n\
             {old:.300}\n{new:.300}",
            i + 1
        );
    }
    assert_eq!(committed.len(), computed.len());
}

/// Functions without a line of their own, and why.
const WITHOUT_LINE: [(&str, &str); 31] = [
    ("abi_version", "asserted in tests/clients/abi.c"),
    ("version", "asserted in tests/clients/abi.c"),
    ("status_name", "asserted in tests/clients/abi.c"),
    ("last_error", "a message"),
    ("density_free", "a handle"),
    ("grid_free", "a handle"),
    ("beam_map_free", "a handle"),
    ("scratch_new", "a handle"),
    ("scratch_free", "a handle"),
    ("film_free", "a handle"),
    ("film_get_memory", "a number of bytes"),
    ("film_get_node_count", "asked for at each film_nodes"),
    ("film_verify", "called before each film_picture"),
    ("march_new", "a handle"),
    ("march_free", "a handle"),
    ("importance_free", "a handle"),
    ("importance_merge", "handles; vectors.c merges at each importance_resolve"),
    ("beam_map_get_count", "vectors.c asks after each beam_map_add"),
    ("beam_map_get_memory", "a number of bytes"),
    (
        "find_edges",
        "calls the host; find_edges.rs of the ABI compares it with the core's, and clients with a ball's silhouette",
    ),
    ("beam_map_gather_shaded", "calls the host; vectors.c counts its contacts at each beam_map_gather"),
    ("grid_new_in", "memory of the host's; vectors.c compares its means at each grid_resolve"),
    ("grid_get_layout", "vectors.c asks after each grid_new"),
    ("grid_get_cells", "pointers; vectors.c reads them at each grid_resolve"),
    ("grid_get_means", "pointers; vectors.c reads them at each grid_resolve"),
    ("grid_get_saved_size", "the first word of grid_save"),
    ("grid_load", "vectors.c loads the bytes of each grid_save"),
    ("grid_clear", "vectors.c clears at each grid_save"),
    ("grid_merge", "handles; vectors.c merges at each grid_save"),
    ("medium_column", "a view of memory; vectors.c makes one at each medium_tabulate and medium_column_at"),
    ("column_at", "see medium_column; column_distance_at likewise at each medium_distance_at"),
];

#[test]
fn every_function_of_the_abi_is_in_the_vectors_or_on_the_list_of_those_that_cannot_be() {
    let text = committed();
    let tested: BTreeSet<&str> = calls(&text).map(|(name, ..)| name).collect();
    // Lines have the name of the form for one element, where there is one.
    let functions: BTreeSet<String> = headers()
        .unwrap()
        .functions
        .into_iter()
        .map(|function| function.single.unwrap_or(function.name).replacen("covbeam_", "", 1))
        .collect();
    assert!(functions.len() > 100, "only {} functions", functions.len());
    let listed: BTreeSet<&str> =
        WITHOUT_LINE.iter().map(|(name, _)| *name).chain(["column_distance_at"]).collect();
    for name in &functions {
        let has_line = tested.contains(name.as_str());
        let is_listed = listed.contains(name.as_str());
        assert!(has_line != is_listed, "{name}: in the vectors {has_line}, on the list {is_listed}");
    }
    for name in tested.iter().chain(&listed) {
        assert!(functions.contains(*name), "{name} is no function of the ABI");
    }
}

#[test]
fn the_vectors_reach_all_kinds_and_both_answers_of_every_question() {
    let text = committed();
    let mut seen: BTreeMap<(&str, &str), BTreeSet<&str>> = BTreeMap::new();
    let (mut pairs, mut found_pairs) = (0, 0);
    for (name, inputs, outputs) in calls(&text) {
        let mut see = |what: &'static str, word| seen.entry((name, what)).or_default().insert(word);
        match name {
            "light_field_refract" | "cross" | "gather_pair" => _ = see("answer", outputs[0]),
            "filter_beams" => outputs.iter().for_each(|word| _ = see("answer", word)),
            "grid_look_up" => outputs.chunks(7).for_each(|found| _ = see("answer", found[0])),
            "phase_evaluate" | "phase_sample" => _ = see("kind", inputs[0]),
            "kernel_evaluate" | "kernel_radius_from_error" | "schedule_kernel" => _ = see("kind", inputs[0]),
            "medium_column_at" | "medium_distance_at" | "grid_deposit" | "beam_map_new" => {
                see("kind", inputs[8]);
            }
            "light_field_carry" => _ = see("kind", inputs[24]),
            "image_spectrum_along" => {
                see("kind", inputs[8]);
                see("grid", if outputs[3] == "00000000" { "silent" } else { "found" });
            }
            "film_picture" => outputs.chunks(8).for_each(|pixel| {
                see("answer", if pixel[6] == "00000000" { "own" } else { "filtered" });
            }),
            "film_regions" => outputs.iter().for_each(|word| {
                see("answer", if *word == "00000000" { "border" } else { "region" });
            }),
            "march_get_first_round" => {
                see("answer", if outputs[0] == "00000000" { "none" } else { "some" });
            }
            "march_refine" => {
                see("answer", if inputs[0] == "00000000" { "none" } else { "some" });
            }
            _ => {}
        }
        match name {
            "gather_pair" => _ = see("grid", inputs[0]),
            "kernel_radius_at" => _ = see("grid", inputs[0]),
            "medium_distance_at" if float(outputs[0]).is_infinite() => _ = see("end", "beyond"),
            "medium_distance_at" => _ = see("end", "reached"),
            "beam_map_gather" => {
                see("grid", inputs[0]);
                pairs += outputs.len() / 7;
                found_pairs += outputs
                    .chunks(7)
                    .map(|gathered| u32::from_str_radix(gathered[3], 16).unwrap())
                    .sum::<u32>();
            }
            _ => {}
        }
    }
    for ((name, what), words) in &seen {
        let expected = if *what == "kind" { 3 } else { 2 };
        assert_eq!(words.len(), expected, "{name}, {what}: only {words:?}");
    }
    assert_eq!(seen.len(), 25);
    // Rays that gather nothing would be equal however wrong.
    assert!(found_pairs as usize > 5 * pairs, "{found_pairs} pairs of {pairs} rays");
}

#[test]
fn the_vectors_hold_no_nan_and_can_be_committed() {
    let text = committed();
    for (name, inputs, outputs) in calls(&text) {
        if name == "march_place" || name == "march_refine" {
            // Halves of an f64 among them.
            continue;
        }
        for word in inputs.iter().chain(&outputs).filter(|word| word.len() == 8) {
            assert!(!float(word).is_nan(), "{name}: its bits may differ between machines");
        }
    }
    assert!(text.len() < 1_000_000, "{} bytes are too many for a file in git", text.len());
}
