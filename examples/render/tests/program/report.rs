//! `covbeam report` as a user meets it: what it writes, says and returns, and whether its numbers are right.

use super::common::{self, assert_contains};
use base64::Engine;
use covbeam_render::files::output::{RenderInfo, read_picture, write_exr};
use covbeam_render::scene_file;
use covbeam_render::study::compare::compare;
use covbeam_render::study::report::{METHODS, Options, Reference, Subject, Watch, csv, measure};
use covbeam_session::film::{Film, Picture};
use covbeam_session::pass::Renderer;
use covbeam_session::settings::{Method, Settings};
use glam::Vec3;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

const SIZE: u32 = 24;

/// A folder with `ball.toml`: the glass ball with few photons.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    // Kernels that are wide enough for spectra to be looked up, and shown.
    let scene = include_str!("../../../scenes/glass-ball.toml")
        .replace("# photons = 5000", "photons = 500")
        .replace("# max_radius = 0.03", "max_radius = 0.3");
    fs::write(folder.path().join("ball.toml"), scene).unwrap();
    folder
}

/// `covbeam report` in the folder.
fn said(folder: &Path, arguments: &[&str], code: i32) -> String {
    common::said(folder, &[&["report"], arguments].concat(), code)
}

/// A picture of values around 1, another one for each `seed`.
fn noise(seed: u32) -> Picture {
    let value = |i: u32| {
        (i.wrapping_mul(2_654_435_761).wrapping_add(seed.wrapping_mul(40_503_001)) >> 8) as f32
            / (1 << 24) as f32
    };
    let pixel = |i: u32| Vec3::new(0.5 + value(3 * i), 0.5 + value(3 * i + 1), 0.5 + value(3 * i + 2));
    let radiance = (0..SIZE * SIZE).map(pixel).collect();
    Picture { width: SIZE, height: SIZE, radiance, ..Picture::default() }
}

fn mean(a: &Picture, b: &Picture) -> Picture {
    let radiance = a.radiance.iter().zip(&b.radiance).map(|(a, b)| 0.5 * (*a + *b)).collect();
    Picture { radiance, ..a.clone() }
}

fn write(path: PathBuf, picture: &Picture) {
    let info = RenderInfo { method: "made up".into(), passes: 1, photons: 1, seed: 1, scene: "ball".into() };
    write_exr(&path, picture, &info).unwrap();
}

struct Row {
    method: String,
    seed: u32,
    passes: u32,
    region: String,
    rel_mse: f64,
    bias: f64,
}

fn rows(csv: &str) -> Vec<Row> {
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("scene,method,seed,passes,cpu_seconds,region,rel_mse,bias,standard_error"));
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let [_, method, seed, passes, _, region, rel_mse, bias, _] = cells[..] else { panic!("{line}") };
        Row {
            method: method.to_owned(),
            seed: seed.parse().unwrap(),
            passes: passes.parse().unwrap(),
            region: region.to_owned(),
            rel_mse: rel_mse.parse().unwrap(),
            bias: bias.parse().unwrap(),
        }
    };
    lines.map(row).collect()
}

/// What is between `start` and the next `end`, for each `start`.
fn between<'a>(text: &'a str, start: &str, end: &str) -> Vec<&'a str> {
    text.split(start).skip(1).map(|rest| rest.split(end).next().unwrap()).collect()
}

#[test]
fn it_writes_a_page_numbers_and_a_figure_that_agree() {
    let folder = folder();
    fs::copy(folder.path().join("ball.toml"), folder.path().join("a,<b>.toml")).unwrap();
    let arguments =
        ["ball.toml", "a,<b>.toml", "--quick", "--width", "24", "--budget", "0.05", "--out", "deep/down"];
    let text = said(folder.path(), &arguments, 0);
    assert_contains(
        &text,
        &["report.html", "report.json", "results.csv", "figure.svg", "deep/down", "CPU-seconds"],
    );
    let out = folder.path().join("deep/down");
    let read = |name: &str| fs::read_to_string(out.join(name)).unwrap();
    assert_eq!(fs::read_dir(&out).unwrap().count(), 4, "no temporary file is left");

    let json: Value = serde_json::from_str(&read("report.json")).unwrap();
    assert_eq!(
        json["command"],
        "covbeam report ball.toml 'a,<b>.toml' --quick --width 24 --budget 0.05 --out deep/down"
    );
    assert_eq!(json["stopped"], Value::Null);
    assert_eq!(json["scenes"].as_array().unwrap().len(), 2);
    assert_eq!(json["scenes"][1]["name"], "a,<b>");
    assert_eq!(json["features"].as_array().unwrap().len(), 14);

    // A line of the table is a point and region of the numbers, in the same order.
    let csv = read("results.csv");
    assert!(csv.contains("\n\"a,<b>\",plain,1,1,"), "a name with a comma is quoted");
    let table = rows(&csv.replace("\"a,<b>\"", "quoted"));
    let mut left = table.iter();
    for scene in json["scenes"].as_array().unwrap() {
        for run in scene["runs"].as_array().unwrap() {
            for point in run["points"].as_array().unwrap() {
                for (region, error) in
                    scene["regions"].as_array().unwrap().iter().zip(point["errors"].as_array().unwrap())
                {
                    let row = left.next().unwrap();
                    assert_eq!(
                        (run["method"].as_str(), run["seed"].as_u64()),
                        (Some(&*row.method), Some(row.seed.into()))
                    );
                    assert_eq!(
                        (point["passes"].as_u64(), region["name"].as_str()),
                        (Some(row.passes.into()), Some(&*row.region))
                    );
                    // The reader of numbers rounds to the last bit but one.
                    for (name, expected) in [("rel_mse", row.rel_mse), ("bias", row.bias)] {
                        let found = error[name].as_f64().unwrap();
                        assert!(
                            (found - expected).abs() <= 2.0 * f64::EPSILON * expected.abs(),
                            "{found} {expected}"
                        );
                    }
                }
            }
        }
    }
    assert!(left.next().is_none());
    let methods = json["methods"].as_array().unwrap();
    for (method, seed) in methods.iter().flat_map(|method| [1, 2].map(|seed| (method, seed))) {
        assert!(
            table.iter().any(|row| row.method == method.as_str().unwrap() && row.seed == seed),
            "{method} {seed}"
        );
    }

    let html = read("report.html");
    assert!(html.starts_with("<!DOCTYPE html>") && html.trim_end().ends_with("</html>"));
    assert_contains(
        &html,
        &[
            "<h2>ball</h2>",
            "<h2>a,&lt;b&gt;</h2>",
            "name=\"viewport\"",
            "optimisation level",
            "--budget 0.05",
            "rustc ",
        ],
    );
    assert!(
        !html.contains("<script")
            && !html.contains("NaN,")
            && !html.contains(folder.path().to_str().unwrap())
    );
    let links = [between(&html, "src=\"", "\""), between(&html, "href=\"", "\"")].concat();
    assert!(
        links.len() > 20 && links.iter().all(|link| link.starts_with('#') || link.starts_with("data:")),
        "{links:?}"
    );
    let anchors = between(&html, "href=\"#", "\"");
    assert!(anchors.iter().all(|anchor| html.contains(&format!("id=\"{anchor}\""))), "{anchors:?}");
    // 2 plots a region, 1 of the time a scene; 1 at a glance, 1 of features.
    let regions = |scene: &Value| scene["regions"].as_array().unwrap().len();
    let plots: usize = json["scenes"].as_array().unwrap().iter().map(|scene| 2 * regions(scene) + 1).sum();
    assert_eq!(html.matches("<svg role=\"img\"").count(), plots + 2);
    assert_eq!(html.matches("</svg>").count(), plots + 2);
    let pictures = between(&html, "data:image/png;base64,", "\"");
    // Reference and methods, their errors, four maps and the filters, in each scene.
    assert_eq!(pictures.len(), 2 * (1 + 2 * methods.len() + 5));
    for picture in pictures {
        let bytes = base64::engine::general_purpose::STANDARD.decode(picture).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width % SIZE, info.height % SIZE), (0, 0));
    }
    let figure = read("figure.svg");
    assert!(figure.starts_with("<svg") && figure.trim_end().ends_with("</svg>") && !figure.contains("NaN"));
    methods.iter().for_each(|method| assert_contains(&figure, &[method.as_str().unwrap()]));
}

/// The metric, straight from its definition: mean of (I - R₁)(I - R₂) / (R² + (0.01 mean R)²), on luminance.
/// Also the bias, and the standard error of that mean.
fn product(picture: &Picture, halves: [&Picture; 2]) -> (f64, f64, f64) {
    let grey = |p: &Picture, i: usize| {
        let c = p.radiance[i].as_dvec3();
        0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z
    };
    let pixels = (SIZE * SIZE) as usize;
    let reference = |i: usize| 0.5 * (grey(halves[0], i) + grey(halves[1], i));
    let mean = (0..pixels).map(reference).sum::<f64>() / pixels as f64;
    let term = |i: usize| {
        let differences = (grey(picture, i) - grey(halves[0], i)) * (grey(picture, i) - grey(halves[1], i));
        differences / (reference(i).powi(2) + 1e-4 * mean * mean)
    };
    let error = (0..pixels).map(term).sum::<f64>() / pixels as f64;
    let variance = (0..pixels).map(|i| (term(i) - error).powi(2)).sum::<f64>() / pixels as f64;
    let found = (0..pixels).map(|i| grey(picture, i)).sum::<f64>() / pixels as f64;
    (error, found / mean - 1.0, (variance / pixels as f64).sqrt())
}

fn subject(folder: &Path) -> Subject {
    Subject { name: "ball".into(), scene: scene_file::load(&folder.join("ball.toml")).unwrap() }
}

fn options(references: &Path) -> Options {
    Options {
        methods: Vec::new(),
        seeds: 1,
        budget: 1.0,
        reference_budget: 1.0,
        width: None,
        usual_width: 99,
        references: Some(references.to_owned()),
        quick: true,
        features: false,
    }
}

fn prepared(folder: &Path) -> (Subject, Reference) {
    let mut subject = subject(folder);
    let reference = options(folder).prepare(&mut subject).unwrap().unwrap();
    assert_eq!(
        (subject.scene.camera.width, subject.scene.camera.height),
        (SIZE, SIZE),
        "the reference's size"
    );
    (subject, reference)
}

#[test]
fn errors_are_free_of_the_noise_of_a_reference_of_two_runs() {
    let folder = folder();
    let (first, second, picture) = (noise(1), noise(2), noise(3));
    write(folder.path().join("ball.exr"), &mean(&first, &second));
    write(folder.path().join("ball-half.exr"), &first);
    let (_, reference) = prepared(folder.path());
    let found = reference.errors(&picture);
    let (error, bias, standard_error) = product(&picture, [&first, &second]);
    // The mean of two runs is rounded to f32: 6e-8 of about 1, against differences of about 0.3.
    assert!((found[0].rel_mse - error).abs() < 1e-6 * error.abs(), "{} {error}", found[0].rel_mse);
    assert!((found[0].bias - bias).abs() < 1e-6);
    assert!((found[0].standard_error / standard_error - 1.0).abs() < 1e-6);
    // Uniform noise: luminance has a variance v = (0.2126² + 0.7152² + 0.0722²)/12, of which R has half: noise v/2, and the true error of
    // an independent picture is v + v/2 against R, v against the truth. 576 pixels, spread of the squares 10 %: three deviations.
    let of_mean = compare(&picture, &mean(&first, &second), |_, _| true).unwrap().rel_mse;
    let noise = reference.noise.as_ref().unwrap()[0];
    assert!(
        (found[0].rel_mse - (of_mean - noise)).abs() < 1e-6 * of_mean,
        "what the noise adds is taken off"
    );
    assert!((noise / of_mean * 3.0 - 1.0).abs() < 0.3, "{noise} {of_mean}");
    assert!(
        first.radiance != second.radiance && reference.errors(&first)[0].rel_mse.abs() < 1e-6,
        "R₁ - R₁ is nothing"
    );
}

#[test]
fn the_table_holds_the_errors_of_the_very_passes() {
    let folder = folder();
    write(folder.path().join("ball.exr"), &noise(1));
    let (subject, reference) = prepared(folder.path());
    assert_eq!(reference.noise, None);
    let arguments = [
        "ball.toml",
        "--quick",
        "--references",
        ".",
        "--methods",
        "plain,thesis",
        "--seeds",
        "2",
        "--budget",
        "0.2",
    ];
    said(folder.path(), &arguments, 0);
    let table = rows(&fs::read_to_string(folder.path().join("covbeam-report/results.csv")).unwrap());
    for (name, method) in [("plain", Method::Plain), ("thesis", Method::Thesis)] {
        for seed in [1, 2] {
            let mut renderer = Renderer::new(&subject.scene, Settings::of(method, 500, seed));
            let mut film = Film::new(SIZE, SIZE);
            for pass in 1..=2 {
                film.add(&renderer.pass(pass, &|| false).unwrap().0).unwrap();
                let expected = compare(&film.picture(), &noise(1), |_, _| true).unwrap();
                let row = table.iter().find(|row| {
                    (&*row.method, row.seed, row.passes, &*row.region) == (name, seed, pass, "whole")
                });
                let row =
                    row.unwrap_or_else(|| panic!("{name}, seed {seed}, pass {pass} is not in the table"));
                // The same formula in another order of sums.
                assert!(
                    (row.rel_mse / expected.rel_mse - 1.0).abs() < 1e-9,
                    "{} {}",
                    row.rel_mse,
                    expected.rel_mse
                );
                assert!((row.bias - expected.bias).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn errors_do_not_depend_on_the_number_of_threads() {
    let folder = folder();
    write(folder.path().join("ball.exr"), &noise(1));
    // Without the costs of features, which take longer than all else.
    let table = |threads: usize| {
        let (subject, reference) = prepared(folder.path());
        let options =
            Options { methods: METHODS.iter().collect(), seeds: 2, budget: 0.1, ..options(folder.path()) };
        let (scene, watch) = (subject.scene.clone(), Watch::new(1.0, &|| false, &|_, _| ()));
        let (subjects, command) = (vec![(subject, Some(reference))], "test".to_owned());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        rows(&csv(&pool.install(|| measure(subjects, &scene, &options, command, &watch)).unwrap()))
    };
    let [one, two] = [1, 2].map(table);
    let mut shared = 0;
    for a in &one {
        let same =
            |b: &&Row| (&a.method, a.seed, a.passes, &a.region) == (&b.method, b.seed, b.passes, &b.region);
        if let Some(b) = two.iter().find(same) {
            assert_eq!((a.rel_mse, a.bias), (b.rel_mse, b.bias));
            shared += 1;
        }
    }
    // Five methods, two seeds, three regions, at least one pass.
    assert!(shared >= 30, "{shared}");
}

#[cfg(unix)]
#[test]
fn a_signal_stops_it_and_keeps_what_is_measured() {
    use std::io::BufRead;
    let folder = folder();
    write(folder.path().join("ball.exr"), &noise(1));
    let mut child = Command::new(env!("CARGO_BIN_EXE_covbeam"))
        .args(["report", "ball.toml", "--references", ".", "--budget", "0.5", "--seeds", "64"])
        .current_dir(folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = std::io::BufReader::new(child.stderr.take().unwrap()).lines();
    let later = lines
        .map(Result::unwrap)
        .find(|line| line.contains("seed") && line.contains("left") && !line.contains("seed 1,"));
    assert!(later.is_some(), "no progress was shown");
    // Unlike SIGINT, shells do not have it ignored by what they run in the background.
    assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(143));
    let read = |name: &str| fs::read_to_string(folder.path().join("covbeam-report").join(name)).unwrap();
    assert_contains(&read("report.html"), &["Not complete", "at the scene ball", "</html>"]);
    assert_contains(&read("report.json"), &["\"stopped\": \"stopped by the user at the scene ball\""]);
    assert!(rows(&read("results.csv")).iter().any(|row| row.seed == 1));
}

#[test]
fn bad_input_is_refused_with_what_was_expected_and_nothing_is_written() {
    let folder = folder();
    let path = folder.path();
    for name in ["small", "nan", "black", "half", "empty"] {
        fs::create_dir(path.join(name)).unwrap();
    }
    write(
        path.join("small/ball.exr"),
        &Picture { width: SIZE, height: 1, radiance: vec![Vec3::ONE; 24], ..Picture::default() },
    );
    let mut broken = noise(1);
    broken.radiance[30] = Vec3::NAN;
    write(path.join("nan/ball.exr"), &broken);
    write(path.join("black/ball.exr"), &Picture { radiance: vec![Vec3::ZERO; 576], ..noise(1) });
    write(path.join("half/ball.exr"), &noise(1));
    write(path.join("half/ball-half.exr"), &Picture { width: 48, height: 12, ..noise(1) });
    fs::write(path.join("bad.toml"), "[camera\n").unwrap();
    fs::create_dir(path.join("good")).unwrap();
    write(path.join("good/ball.exr"), &noise(1));
    let before = fs::read_dir(path).unwrap().count();
    for (arguments, code, parts) in [
        (&["none.toml"][..], 3, &["none.toml"][..]),
        (&["bad.toml"], 3, &["bad.toml", "1"]),
        (&["empty"], 3, &["empty", "holds no scene", ".toml"]),
        (&["ball.toml", "--out", "ball.toml"], 1, &["ball.toml", "--out"]),
        (&["ball.toml", "--out", "bad.toml/below"], 1, &["bad.toml/below", "--out"]),
        (&["ball.toml", "--references", "nowhere"], 2, &["nowhere", "--references"]),
        (&["ball.toml", "--references", "small"], 3, &["small/ball.exr", "24 x 1", "24 x 24"]),
        (
            &["ball.toml", "--references", "good", "--width", "32"],
            3,
            &["good/ball.exr", "24 x 24", "--width 32", "leave --width out"],
        ),
        (&["ball.toml", "--references", "nan"], 3, &["nan/ball.exr", "NaN", "(6, 1)", "--references"]),
        (&["ball.toml", "--references", "black"], 3, &["black/ball.exr", "black everywhere"]),
        (&["ball.toml", "--references", "half"], 3, &["half/ball-half.exr", "48 x 12", "24 x 24"]),
        (&["--methods", "plain,best"], 2, &["best", "plain, thesis, covbeam"]),
        (&["--seeds", "0"], 2, &["--seeds"]),
        (&["--budget", "-1"], 2, &["seconds above 0"]),
        (&["--width", "0"], 2, &["--width"]),
    ] {
        assert_contains(&said(path, arguments, code), parts);
    }
    assert_eq!(fs::read_dir(path).unwrap().count(), before, "nothing is written");
    assert_eq!(read_picture(&path.join("good/ball.exr")).unwrap(), noise(1), "references stay as they are");
}

#[test]
fn a_picture_of_one_pixel_has_a_report() {
    let folder = folder();
    said(folder.path(), &["ball.toml", "--quick", "--width", "1", "--budget", "0.02", "--seeds", "1"], 0);
    let html = fs::read_to_string(folder.path().join("covbeam-report/report.html")).unwrap();
    assert_contains(&html, &["1 × 1 pixels", "</html>"]);
}

#[test]
fn help_says_what_is_compared_and_what_is_written() {
    let folder = folder();
    let text = said(folder.path(), &["--help"], 0);
    assert_contains(
        &text,
        &["report.html", "results.csv", "figure.svg", "--references", "NAME-half.exr", "Examples:", "Ctrl-C"],
    );
}
