//! The program as a user meets it: what it writes, says and returns.

use super::common::{assert_contains, said};
use covbeam_render::files::output::{RenderInfo, read_picture, write_exr};
use covbeam_session::film::Picture;
use covbeam_session::kind::Kind;
use glam::Vec3;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use tempfile::TempDir;

const GLASS_BALL: &str = include_str!("../../../scenes/glass-ball.toml");

/// A folder with `ball.toml`: the glass ball in 24 x 16 pixels and few photons.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let small = GLASS_BALL
        .replace("width = 256", "width = 24")
        .replace("height = 256", "height = 16")
        .replace("passes = 256", "passes = 3")
        .replace("# photons = 5000", "photons = 200");
    assert!(
        small.contains("width = 24") && small.contains("passes = 3") && small.contains("\nphotons = 200")
    );
    fs::write(folder.path().join("ball.toml"), small).unwrap();
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn write_grey(path: &Path, width: u32, values: &[f32]) {
    let radiance = values.iter().map(|v| Vec3::splat(*v)).collect();
    let picture = Picture { width, height: values.len() as u32 / width, radiance, ..Picture::default() };
    let info = RenderInfo { method: "ppb".into(), passes: 1, photons: 1, seed: 1, scene: "test".into() };
    write_exr(path, &picture, &info).unwrap();
}

#[test]
fn a_render_writes_both_pictures_and_says_what_to_do_next() {
    let folder = folder();
    let text = said(folder.path(), &["render", "ball.toml"], 0);
    assert_contains(
        &text,
        &["ball-adaptive.exr", "ball-adaptive.png", "3 passes", "gather", "core-seconds", "next"],
    );
    assert_eq!(
        names(folder.path()),
        ["ball-adaptive.exr", "ball-adaptive.png", "ball-adaptive.shard", "ball.toml"]
    );
    let picture = read_picture(&folder.path().join("ball-adaptive.exr")).unwrap();
    assert_eq!((picture.width, picture.height), (24, 16));
    assert!(picture.radiance.iter().any(|v| v.x > 0.0));
    assert!(picture.layers.unwrap().samples.iter().any(|n| *n > 0.0));
}

#[test]
fn maps_of_the_eye_rays_are_written_beside_the_picture() {
    let folder = folder();
    let text = said(folder.path(), &["render", "ball.toml", "--maps"], 0);
    assert_contains(&text, &["ball-adaptive-density.png", "ball-adaptive-filters.png"]);
    let files = [
        "ball-adaptive-density.png",
        "ball-adaptive-filters.png",
        "ball-adaptive.exr",
        "ball-adaptive.png",
        "ball-adaptive.shard",
        "ball.toml",
    ];
    assert_eq!(names(folder.path()), files);
    let maps =
        read_picture(&folder.path().join("ball-adaptive.exr")).unwrap().maps.expect("planned eye rays");
    assert_eq!(maps.layers.len(), 1);
    assert!(maps.density().iter().all(|density| *density > 0.0 && *density <= 1.0));

    said(folder.path(), &["render", "ball.toml", "--every-pixel", "--out", "all.exr"], 0);
    assert!(read_picture(&folder.path().join("all.exr")).unwrap().maps.is_none());
}

#[test]
fn light_passes_add_up_to_the_picture() {
    let folder = folder();
    for every_pixel in [&[][..], &["--every-pixel"]] {
        let flags = ["render", "ball.toml", "--light-passes", "--out", "kinds.exr"];
        said(folder.path(), &[&flags[..], every_pixel].concat(), 0);
        let picture = read_picture(&folder.path().join("kinds.exr")).unwrap();
        let kinds: Vec<Kind> = picture.kinds.iter().map(|(kind, _)| *kind).collect();
        // The ball is of glass.
        assert_eq!(kinds, Kind::ALL);
        for (pixel, all) in picture.radiance.iter().enumerate() {
            let sum: Vec3 = picture.kinds.iter().map(|(_, light)| light[pixel]).sum();
            // Each was rounded for itself.
            assert!((sum - *all).abs().max_element() <= 1e-5 * all.max_element(), "{pixel}: {sum} {all}");
        }
        for (kind, light) in &picture.kinds {
            assert!(light.iter().any(|light| light.max_element() > 0.0), "{kind:?}");
        }
    }
}

#[test]
fn flags_that_a_method_has_no_use_for_are_refused() {
    let folder = folder();
    let refused = |flags: &[&str], words: &[&str]| {
        let text = said(folder.path(), &[&["render", "ball.toml"], flags].concat(), 2);
        assert_contains(&text, words);
        assert_eq!(names(folder.path()), ["ball.toml"]);
    };
    refused(&["--method", "ppb", "--maps"], &["--maps", "ppb", "adaptive"]);
    refused(&["--method", "light-trace", "--every-pixel"], &["--every-pixel", "light-trace", "adaptive"]);
    refused(&["--method", "ppb", "--light-passes"], &["--light-passes", "ppb", "adaptive"]);
    refused(&["--samples", "8"], &["--samples", "adaptive", "march"]);
}

#[test]
fn the_same_seed_gives_the_same_bytes_for_any_number_of_threads() {
    let folder = folder();
    for threads in ["1", "2", "7"] {
        let out = format!("{threads}.exr");
        said(folder.path(), &["render", "ball.toml", "--threads", threads, "--out", &out], 0);
    }
    let bytes = |threads: &str| fs::read(folder.path().join(format!("{threads}.exr"))).unwrap();
    assert!(bytes("1") == bytes("2") && bytes("1") == bytes("7"));
    said(folder.path(), &["render", "ball.toml", "--seed", "2", "--out", "seed.exr"], 0);
    let radiance = |name: &str| read_picture(&folder.path().join(name)).unwrap().radiance;
    assert_ne!(radiance("seed.exr"), radiance("1.exr"));
}

#[test]
fn a_time_limit_is_kept() {
    let folder = folder();
    let start = std::time::Instant::now();
    said(folder.path(), &["render", "ball.toml", "--time", "0.5", "--method", "ppb"], 0);
    // Half a second, the start of the program and a busy machine.
    assert!(start.elapsed().as_secs_f64() < 10.0);
    assert!(folder.path().join("ball-ppb.exr").exists());
}

#[cfg(unix)]
#[test]
fn a_signal_stops_a_render_and_keeps_its_picture() {
    for (signal, code) in [("-INT", 130), ("-TERM", 143), ("-HUP", 129)] {
        let folder = folder();
        let program = env!("CARGO_BIN_EXE_covbeam");
        // Tests that run under nohup hand down that SIGHUP is ignored; only GNU's env takes that back.
        let words: &[&str] =
            if cfg!(target_os = "linux") { &["env", "--default-signal", program] } else { &[program] };
        let mut child = Command::new(words[0])
            .args(&words[1..])
            .args(["render", "ball.toml", "--passes", "1000000"])
            .current_dir(folder.path())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // The first line of progress appears after the first pass.
        let mut stderr = std::io::BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        while !line.contains("pass 1 of") {
            line.clear();
            assert_ne!(
                std::io::BufRead::read_line(&mut stderr, &mut line).unwrap(),
                0,
                "no progress was shown"
            );
        }
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(code));
        assert_eq!(
            names(folder.path()),
            ["ball-adaptive.exr", "ball-adaptive.png", "ball-adaptive.shard", "ball.toml"]
        );
        read_picture(&folder.path().join("ball-adaptive.exr")).unwrap();
    }
}

/// Runs a shell's line in which `covbeam` is the program; returns its exit code, and what was said on standard output.
#[cfg(unix)]
fn shell(folder: &Path, line: &str) -> (Option<i32>, String) {
    let program = Path::new(env!("CARGO_BIN_EXE_covbeam"));
    let path = std::env::join_paths(
        std::iter::once(program.parent().unwrap().to_owned())
            .chain(std::env::split_paths(&std::env::var_os("PATH").unwrap())),
    );
    let shell = Command::new("bash")
        .args(["-o", "pipefail", "-c", line])
        .env("PATH", path.unwrap())
        .current_dir(folder)
        .output()
        .unwrap();
    (shell.status.code(), String::from_utf8(shell.stdout).unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn what_cannot_be_said_costs_no_render() {
    for line in [
        "covbeam render ball.toml 2>/dev/full >/dev/full",
        "covbeam render ball.toml 2>&1 | head -c 1 >/dev/null",
        "covbeam render ball.toml --progress json | head -c 1 >/dev/null",
        "covbeam render ball.toml >&- 2>&-",
    ] {
        let folder = folder();
        assert_eq!(shell(folder.path(), line).0, Some(0), "{line}");
        read_picture(&folder.path().join("ball-adaptive.exr")).unwrap();
    }
    // Of a comparison, the words are all.
    let folder = folder();
    write_grey(&folder.path().join("a.exr"), 1, &[1.0]);
    assert_eq!(shell(folder.path(), "covbeam compare a.exr a.exr >/dev/full").0, Some(1));
}

#[cfg(unix)]
#[test]
fn a_program_reads_progress_on_standard_output() {
    let folder = folder();
    let (code, text) = shell(folder.path(), "covbeam render ball.toml --passes 5 --progress json");
    assert_eq!(code, Some(0));
    let lines: Vec<serde_json::Value> =
        text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|_| panic!("{line}"))).collect();
    let (last, progress) = lines.split_last().unwrap();
    assert!(progress.iter().all(|line| line["event"] == "progress" && line["passes"] == 5), "{text}");
    assert!(progress[0]["share"].as_f64().is_some_and(|share| share > 0.0 && share <= 1.0), "{text}");
    assert_eq!((&last["event"], &last["passes"]), (&"done".into(), &serde_json::json!([0, 5])));
    assert_eq!(last["files"][0], "ball-adaptive.exr");

    let (code, text) = shell(folder.path(), "covbeam render none.toml --progress json");
    let line: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!((code, &line["event"], &line["code"]), (Some(3), &"failed".into(), &3.into()));
    assert_contains(line["message"].as_str().unwrap(), &["none.toml"]);

    let (code, text) = shell(folder.path(), "covbeam render ball.toml --passes 0..3 --progress openjd");
    assert_eq!(code, Some(0));
    assert_contains(
        &text,
        &["openjd_progress: 100\n", "openjd_status: pass 1 of 3", "openjd_status: done: wrote"],
    );
    assert!(text.lines().all(|line| line.starts_with("openjd_")), "{text}");
    // It goes on, and the share is that of the whole piece.
    let (_, text) = shell(
        folder.path(),
        "covbeam render ball.toml --passes 0..10 --out ball-adaptive-0-3.shard --progress openjd",
    );
    assert_contains(&text, &["openjd_progress: 40.0\nopenjd_status: pass 4 of 10"]);
    let line =
        "covbeam render ball.toml --passes 0..100000 --progress json & sleep 0.3; kill -TERM $!; wait $!";
    let (code, text) = shell(folder.path(), line);
    let last: serde_json::Value = serde_json::from_str(text.lines().last().unwrap_or_default()).unwrap();
    assert_eq!((code, &last["event"]), (Some(143), &"stopped".into()), "{text}");
    let (_, text) = shell(folder.path(), "covbeam merge none.shard --out a.exr --progress openjd");
    assert!(text.starts_with("openjd_fail: 'none.shard'"), "{text}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_signal_that_is_to_be_ignored_is() {
    let folder = folder();
    let line = "trap '' HUP; covbeam render ball.toml --passes 0..40 & sleep 0.3; kill -HUP $!; wait $!";
    assert_eq!(shell(folder.path(), line).0, Some(0));
    assert!(folder.path().join("ball-adaptive-0-40.shard").exists());
}

/// A file may grow to nothing, as on a full disk; the signal that would end the program is ignored as a shell can.
#[cfg(unix)]
#[test]
fn a_file_that_cannot_grow_is_reported_and_nothing_is_left() {
    let folder = folder();
    let script =
        format!("trap '' XFSZ; ulimit -f 0; exec '{}' render ball.toml", env!("CARGO_BIN_EXE_covbeam"));
    let output = Command::new("sh").args(["-c", &script]).current_dir(folder.path()).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert_contains(&String::from_utf8_lossy(&output.stderr), &["ball-adaptive.exr", "--out"]);
    assert_eq!(names(folder.path()), ["ball.toml"]);
}

#[test]
fn a_scene_that_is_missing_or_wrong_is_named() {
    let folder = folder();
    assert_contains(&said(folder.path(), &["render", "missing.toml"], 3), &["missing.toml"]);
    fs::write(folder.path().join("bad.toml"), "[camera\n").unwrap();
    assert_contains(&said(folder.path(), &["render", "bad.toml"], 3), &["bad.toml", "1"]);
    assert_eq!(names(folder.path()), ["bad.toml", "ball.toml"]);
}

#[test]
fn light_is_not_connected_with_a_camera_that_is_no_pinhole() {
    let folder = folder();
    let path = folder.path().join("ball.toml");
    let ball = fs::read_to_string(&path).unwrap();
    for fields in [
        "vertical_fov = 35.0\nnear = 0.1",
        "vertical_fov = 35.0\nlens = { radius = 0.1, focus_distance = 5 }",
        "projection = \"orthographic\"\nvertical_size = 3",
    ] {
        fs::write(&path, ball.replace("vertical_fov = 35.0", fields)).unwrap();
        let text = said(folder.path(), &["render", "ball.toml", "--method", "light-trace"], 3);
        assert_contains(&text, &["light-trace", "pinhole", "camera.lens", "camera.near", "--method"]);
        assert_eq!(names(folder.path()), ["ball.toml"]);
        said(folder.path(), &["render", "ball.toml", "--passes", "1"], 0);
        for beside in ["exr", "png", "shard"] {
            fs::remove_file(folder.path().join(format!("ball-adaptive.{beside}"))).unwrap();
        }
    }
}

#[test]
fn an_output_that_cannot_be_written_is_refused_before_rendering() {
    let folder = folder();
    let refused = |out: &str, parts: &[&str]| {
        let text = said(folder.path(), &["render", "ball.toml", "--passes", "1000000", "--out", out], 3);
        assert_contains(&text, parts);
        assert!(!text.contains("pass 1"), "rendered before the check: {text}");
    };
    refused("no/a.exr", &["no/a.exr", "does not exist"]);
    fs::create_dir(folder.path().join("a.exr")).unwrap();
    refused("a.exr", &["a.exr", "not a regular file"]);
    fs::create_dir(folder.path().join("b.png")).unwrap();
    refused("b.exr", &["b.png", "not a regular file"]);
}

#[test]
fn wrong_flags_are_refused_with_what_was_expected() {
    let folder = folder();
    let render = |more: &[&str]| said(folder.path(), &[&["render", "ball.toml"], more].concat(), 2);
    assert_contains(
        &render(&["--maps", "--every-pixel"]),
        &["--maps", "--every-pixel", "cannot be used with"],
    );
    assert_contains(&render(&["--until", "2"]), &["--until", "0.02 for 2 %"]);
    assert_contains(&render(&["--passes", "0"]), &["--passes", "above 0, or A..B"]);
    assert_contains(&render(&["--photons", "0"]), &["--photons", "0 is not in"]);
    for time in ["0", "-1", "nan", "inf", "soon"] {
        assert_contains(&render(&["--time", time]), &["--time", "seconds above 0"]);
    }
    assert_contains(&render(&["--method", "magic"]), &["ppb", "adaptive", "light-trace"]);
    assert_contains(&render(&["--out", "a.png"]), &["--out", ".exr"]);
    assert_contains(&render(&["--seed", "-1"]), &["-1"]);
    assert_contains(&said(folder.path(), &["paint"], 2), &["paint", "covbeam"]);
    assert_eq!(names(folder.path()), ["ball.toml"]);
}

#[test]
fn the_help_teaches_by_examples() {
    let folder = folder();
    assert_contains(&said(folder.path(), &["--help"], 0), &["Examples:", "covbeam compare", "Ctrl-C"]);
    assert_contains(
        &said(folder.path(), &["render", "--help"], 0),
        &["--method", "light-trace", "[default: adaptive]", "The picture:", "How long, and which passes:"],
    );
}

#[test]
fn a_comparison_prints_the_metric_of_every_region() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    write_grey(&path("a.exr"), 2, &[1.0, 2.0, 3.0, 6.0]);
    write_grey(&path("r.exr"), 2, &[2.0; 4]);
    let text = said(
        folder.path(),
        &["compare", "a.exr", "r.exr", "--region", "left=0,0,1,2", "--region", "0,1,2,2"],
        0,
    );
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split_whitespace().collect()).collect();
    // By hand: squared errors 1, 0, 1, 16 over 4.0004, in all, in the left column and in the lower row.
    assert_eq!(rows[1], ["whole", "1.125e0", "+50.000", "%", "3.00000e0", "2.00000e0"]);
    assert_eq!(rows[2], ["left", "2.500e-1", "+0.000", "%", "2.00000e0", "2.00000e0"]);
    assert_eq!(rows[3], ["0,1,2,2", "2.125e0", "+125.000", "%", "4.50000e0", "2.00000e0"]);
}

#[test]
fn pictures_that_cannot_be_compared_are_refused() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    write_grey(&path("a.exr"), 2, &[1.0; 4]);
    write_grey(&path("wide.exr"), 4, &[1.0; 4]);
    let compare = |more: &[&str], code| said(folder.path(), &[&["compare"], more].concat(), code);
    assert_contains(&compare(&["a.exr", "wide.exr"], 3), &["2 x 2", "4 x 1", "same size"]);
    assert_contains(&compare(&["a.exr", "missing.exr"], 3), &["missing.exr"]);
    assert_contains(&compare(&["a.exr", "ball.toml"], 3), &["ball.toml", "OpenEXR"]);
    assert_contains(&compare(&["a.exr", "a.exr", "--region", "0,0,3,1"], 2), &["0,0,3,1", "2 x 2"]);
    assert_contains(&compare(&["a.exr", "a.exr", "--region", "1,1,1,2"], 2), &["empty"]);
    assert_contains(&compare(&["a.exr", "a.exr", "--region", "-1,0,1,2"], 2), &["x0,y0,x1,y1"]);
    assert_contains(&compare(&["a.exr"], 2), &["R.exr"]);
}

#[test]
fn an_error_that_is_asked_for_ends_the_render_or_is_said_not_to_be_reached() {
    let folder = folder();
    let text = said(folder.path(), &["render", "ball.toml", "--until", "0.9"], 0);
    assert_contains(&text, &["4 passes", "median relative error"]);
    let picture = read_picture(&folder.path().join("ball-adaptive.exr")).unwrap();
    assert!(picture.error.unwrap().iter().any(|error| *error > 0.0));
    let text = said(folder.path(), &["render", "ball.toml", "--until", "0.000001", "--passes", "6"], 0);
    assert_contains(&text, &["6 passes", "is not reached", "after 4 passes"]);
}

#[test]
fn a_render_without_light_says_so_when_an_error_is_asked_for() {
    let folder = folder();
    let scene = fs::read_to_string(folder.path().join("ball.toml")).unwrap();
    // The camera is outside the room and sees its black wall.
    let dark = scene
        .replace("position = [0.0, 0.5, -5.0]", "position = [0.0, 0.5, -50.0]")
        .replace("outside_medium = \"fog\"", "");
    assert_ne!(dark, scene);
    fs::write(folder.path().join("dark.toml"), dark).unwrap();
    let text = said(folder.path(), &["render", "dark.toml", "--until", "0.02"], 0);
    assert_contains(&text, &["64 passes", "no light reaches the picture"]);
}

#[test]
fn a_picture_that_memory_cannot_hold_is_refused_before_the_work() {
    if !cfg!(target_os = "linux") {
        return;
    }
    let folder = folder();
    let scene = fs::read_to_string(folder.path().join("ball.toml")).unwrap();
    let huge = scene.replace("width = 24", "width = 16384").replace("height = 16", "height = 16384");
    fs::write(folder.path().join("huge.toml"), huge).unwrap();
    // 16384² pixels need some 70 GB; a machine that has them lends this process 8.
    let program = env!("CARGO_BIN_EXE_covbeam");
    let script = format!("ulimit -v 8000000; exec '{program}' render huge.toml --passes 1");
    let output = Command::new("sh").args(["-c", &script]).current_dir(folder.path()).output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{text}");
    assert_contains(&text, &["16384 x 16384", "GB of memory", "available", "camera.width"]);
    assert!(!folder.path().join("huge-adaptive.exr").exists());
}
