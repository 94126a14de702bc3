//! `covbeam spectrum` as a user meets it: what it writes, says and returns.

use super::common::{self, assert_contains};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A folder with `ball.toml`: the glass ball with few photons, and a grid over all of its room.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let scene = include_str!("../../../scenes/glass-ball.toml").replace("# photons = 5000", "photons = 500");
    assert!(scene.contains("\nphotons = 500 "));
    let scene = scene + "\n[grid]\nmin = [-4.0, -1.5, -6.0]\nmax = [4.0, 4.5, 4.0]\ncells = [32, 32, 32]\n";
    fs::write(folder.path().join("ball.toml"), scene).unwrap();
    folder
}

/// `covbeam spectrum` in the folder.
fn said(folder: &Path, arguments: &[&str], code: i32) -> String {
    common::said(folder, &[&["spectrum"], arguments].concat(), code)
}

#[test]
fn it_writes_a_table_a_summary_and_plots_and_prints_the_summary() {
    let folder = folder();
    let text = said(folder.path(), &["ball.toml", "--photons", "20000", "--grid", "12", "--passes", "2"], 0);
    assert_contains(
        &text,
        &["12 x 12 x 12 voxels", "2 passes of 50 light", "20000 other light paths", "both bounds, by number"],
    );
    let out = folder.path().join("ball-spectrum");
    let read = |name: &str| fs::read_to_string(out.join(name)).unwrap();
    assert!(text.contains(read("summary.txt").trim_end()));
    let table = read("table.csv");
    let rows: Vec<&str> = table.lines().filter(|line| !line.starts_with('#')).collect();
    assert_eq!(rows.len(), 1 + 12 * 12 * 12);
    let columns = rows[0].split(',').count();
    assert!(rows.iter().all(|row| row.split(',').count() == columns));
    for plot in ["lines.svg", "gaussians.svg", "slice-x.svg", "slice-y.svg", "slice-z.svg"] {
        let svg = read(plot);
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{plot}");
        assert!(!svg.contains("NaN"), "{plot}");
    }
    assert_eq!(fs::read_dir(&out).unwrap().count(), 7, "no temporary file is left");
}

#[test]
fn lines_and_points_are_the_users() {
    let folder = folder();
    let options = ["--photons", "1600", "--grid", "8", "--passes", "1", "--share", "1", "--out", "deep/down"];
    let places = ["--line", "-3,0.5,0:3,0.5,0", "--line", "0,-1,0:0,4,0", "--point", "1,1,1.5"];
    said(folder.path(), &[&["ball.toml"], &options[..], &places[..]].concat(), 0);
    let read = |name: &str| fs::read_to_string(folder.path().join("deep/down").join(name)).unwrap();
    let lines = read("lines.svg");
    assert_contains(&lines, &["from (-3.00, 0.50, 0.00) to (3.00, 0.50, 0.00)", "from (0.00, -1.00, 0.00)"]);
    assert_contains(&read("gaussians.svg"), &["at (1, 1, 1.5)"]);
}

#[test]
fn bad_input_is_refused_with_what_was_expected_and_nothing_is_written() {
    let folder = folder();
    for (arguments, code, parts) in [
        (&["--photons", "3"][..], 2, &["--photons"][..]),
        (&["--grid", "1"], 2, &["--grid", "2..=128"]),
        (&["--share", "0"], 2, &["above 0 and at most 1"]),
        (&["--passes", "0"], 2, &["--passes"]),
        (&["--line", "0,0,0"], 2, &["x0,y0,z0:x1,y1,z1"]),
        (&["--line", "0,0,0:0,0,0"], 2, &["no length"]),
        (&["--line", "0,0,0:0,0,nan"], 2, &["three finite numbers"]),
        (&["--point", "0,0"], 2, &["three finite numbers"]),
        (&["--point", "0,0,40"], 2, &["[0, 0, 40]", "outside the scene's grid", "[-4, -1.5, -6]"]),
        (&["--line", "0,0,0:0,9,0"], 2, &["[0, 9, 0]", "outside the scene's grid"]),
        (&["--out", "ball.toml"], 1, &["ball.toml", "--out"]),
    ] {
        let text = said(folder.path(), &[&["ball.toml"], arguments].concat(), code);
        assert_contains(&text, parts);
    }
    assert_contains(&said(folder.path(), &["none.toml"], 3), &["none.toml"]);
    assert_contains(&said(folder.path(), &[], 2), &["SCENE.toml"]);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "only the scene is there");
}

#[test]
fn a_grid_that_is_too_large_for_the_test_is_refused_before_it_is_measured() {
    let folder = folder();
    let scene = fs::read_to_string(folder.path().join("ball.toml")).unwrap();
    let large = scene.replace("cells = [32, 32, 32]", "cells = [250, 250, 250]");
    assert_ne!(large, scene);
    fs::write(folder.path().join("large.toml"), large).unwrap();
    let text = said(folder.path(), &["large.toml"], 3);
    assert_contains(&text, &["large.toml", "250 x 250 x 250", "--grid"]);
}

#[test]
fn help_says_what_is_compared_and_what_is_written() {
    let folder = folder();
    let text = said(folder.path(), &["--help"], 0);
    assert_contains(
        &text,
        &["table.csv", "summary.txt", "too small", "--line", "--point", "Examples:", "Ctrl-C"],
    );
}
