//! Renders in pieces, stopped and gone on with, and merged: the same bits as in one go, or a refusal by name.

use super::common::{assert_contains, said};
use covbeam_render::files::shard::Shard;
use covbeam_session::film::Film;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;

const PASSES: u32 = 12;

/// A scene's text in a few pixels, with few light paths.
fn small(scene: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(format!("{scene}.toml"));
    let text = fs::read_to_string(path).unwrap();
    let lines = text.lines().map(|line| match line.split('=').next().unwrap_or_default().trim() {
        "width" => "width = 24".to_owned(),
        "height" => "height = 20".to_owned(),
        "passes" => String::new(),
        _ => line.to_owned(),
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// A folder with `ball.toml`, and the same with another medium as `thin.toml`.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let ball = small("glass-ball");
    let thin = ball.replacen("scattering = ", "scattering = 0.9 # ", 1);
    assert_ne!(thin, ball);
    fs::write(folder.path().join("ball.toml"), ball).unwrap();
    fs::write(folder.path().join("thin.toml"), thin).unwrap();
    folder
}

/// Renders with 300 light paths a pass.
fn render(folder: &Path, more: &[&str], code: i32) -> String {
    said(folder, &[&["render", "--photons", "300"], more].concat(), code)
}

fn piece(folder: &Path, passes: &str, out: &str, more: &[&str]) {
    render(folder, &[&["ball.toml", "--passes", passes, "--out", out], more].concat(), 0);
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// The picture and its preview.
fn bytes(folder: &Path, name: &str) -> [Vec<u8>; 2] {
    ["exr", "png"].map(|ending| fs::read(folder.join(format!("{name}.{ending}"))).unwrap())
}

#[test]
fn pieces_in_any_order_and_groups_are_the_picture_of_one_render() {
    let passes = PASSES.to_string();
    for (scene, flags) in [
        ("glass-ball", &["--method", "adaptive"][..]),
        ("glass-ball", &["--method", "adaptive", "--light-passes"]),
        ("glass-ball", &["--method", "adaptive", "--every-pixel"]),
        ("shaft", &["--method", "ppb"]),
        ("shaft", &["--method", "march", "--samples", "2"]),
        ("penumbra", &["--method", "light-trace"]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        fs::write(folder.join("ball.toml"), small(scene)).unwrap();
        piece(folder, &passes, "one.exr", flags);
        let one = bytes(folder, "one");

        // The last first: what a pass needs of earlier ones is not there.
        let pieces = [(9, 12), (0, 1), (5, 9), (1, 5)];
        let shards = pieces.map(|(start, end)| {
            let out = format!("{start}.shard");
            piece(folder, &format!("{start}..{end}"), &out, &[flags, &["--threads", "1"]].concat());
            out
        });
        let [a, b, c, d] = &shards;
        let merge = |more: &[&str]| said(folder, &[&["merge"], more].concat(), 0);
        merge(&[a, b, c, d, "--out", "flat.exr"]);
        merge(&[a, d, "--out", "ad.shard"]);
        merge(&[c, b, "--out", "cb.shard"]);
        merge(&["cb.shard", "ad.shard", "--out", "tree.exr", "--passes", &passes]);
        assert!(bytes(folder, "flat") == one && bytes(folder, "tree") == one, "{scene} {flags:?}");
        // The sums beside the picture are a shard like others.
        let beside = fs::read(folder.join("one.shard")).unwrap();
        merge(&["cb.shard", "ad.shard", "--out", "all.shard"]);
        assert!(fs::read(folder.join("all.shard")).unwrap() == beside, "{scene} {flags:?}");
    }
}

#[test]
fn light_fields_from_a_file_give_the_same_passes() {
    for flags in
        [&["--method", "adaptive"][..], &["--light-passes"], &["--method", "march", "--samples", "2"]]
    {
        let folder = folder();
        let folder = folder.path();
        let prepare = |more: &[&str], code: i32| {
            said(folder, &[&["prepare", "ball.toml", "--photons", "300"], flags, more].concat(), code)
        };
        assert_contains(&prepare(&["--passes", "20", "--out", "a.fields"], 0), &["9 passes", "0..20"]);
        for (number, passes) in ["0..1", "1..3", "8..9", "15..18", "19..20"].into_iter().enumerate() {
            let (own, read) = (format!("{number}.shard"), format!("{number}-read.shard"));
            piece(folder, passes, &own, flags);
            piece(folder, passes, &read, &[flags, &["--fields", "a.fields"]].concat());
            let bytes = |name: &str| fs::read(folder.join(name)).unwrap();
            assert!(bytes(&own) == bytes(&read), "{flags:?} {passes}");
        }
        let refused = |more: &[&str], parts: &[&str]| {
            let out = ["ball.toml", "--out", "no.shard", "--fields", "a.fields"];
            assert_contains(&render(folder, &[&out, flags, more].concat(), 3), parts);
            assert!(!folder.join("no.shard").exists());
        };
        refused(&["--passes", "21..22"], &["a.fields", "serves passes 0..20", "covbeam prepare"]);
        refused(&["--passes", "3..4", "--seed", "2"], &["a.fields", "seed 1, not 2"]);
        // A bit of each part that is read.
        let good = fs::read(folder.join("a.fields")).unwrap();
        for at in [3, 9, 13, 17, 40, good.len() - 5] {
            let mut bad = good.clone();
            bad[at] ^= 4;
            fs::write(folder.join("a.fields"), bad).unwrap();
            refused(&["--passes", "19..20"], &["a.fields"]);
        }
    }
    let folder = folder();
    let text = said(folder.path(), &["prepare", "ball.toml", "--method", "ppb"], 2);
    assert_contains(&text, &["ppb", "nothing to prepare"]);
}

#[test]
fn a_finished_piece_is_done_at_once_and_a_begun_one_is_gone_on_with() {
    let folder = folder();
    let folder = folder.path();
    piece(folder, "2..5", "whole.shard", &[]);
    let whole = fs::read(folder.join("whole.shard")).unwrap();
    let text = render(folder, &["ball.toml", "--passes", "2..5", "--out", "whole.shard"], 0);
    assert_contains(&text, &["whole.shard", "nothing is left to do"]);
    assert!(!text.contains("pass 1"), "{text}");

    piece(folder, "2..3", "part.shard", &[]);
    let text = render(folder, &["ball.toml", "--passes", "2..5", "--out", "part.shard"], 0);
    assert_contains(&text, &["1 pass is there already", "sums of passes 2..5"]);
    assert!(fs::read(folder.join("part.shard")).unwrap() == whole);

    // A damaged one is as good as none.
    fs::write(folder.join("part.shard"), &whole[..whole.len() / 2]).unwrap();
    let text = render(folder, &["ball.toml", "--passes", "2..5", "--out", "part.shard"], 0);
    assert_contains(&text, &["part.shard", "cut off", "rendered now"]);
    assert!(fs::read(folder.join("part.shard")).unwrap() == whole);
}

#[test]
fn two_renders_do_not_write_one_shard() {
    let folder = folder();
    let folder = folder.path();
    piece(folder, "0..3", "later.shard", &[]);
    let mut child = Command::new(env!("CARGO_BIN_EXE_covbeam"))
        .args(["render", "ball.toml", "--photons", "300", "--passes", "0..100000", "--checkpoint", "0"])
        .args(["--out", "a.shard"])
        .current_dir(folder)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    while !folder.join("a.shard").exists() {
        std::thread::sleep(Duration::from_millis(5));
    }
    // As an atomic writer does.
    fs::rename(folder.join("later.shard"), folder.join("a.shard")).unwrap();
    let mut text = String::new();
    std::io::Read::read_to_string(&mut child.stderr.take().unwrap(), &mut text).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(1), "{text}");
    assert_contains(&text, &["a.shard", "another render", "--out"]);
    assert_eq!(Shard::open(&folder.join("a.shard")).unwrap().passes().count(), 3);
}

#[test]
fn a_finished_picture_goes_on_with_more_passes() {
    let folder = folder();
    let folder = folder.path();
    piece(folder, "9", "one.exr", &[]);
    piece(folder, "4", "more.exr", &["--resume"]);
    let text = render(folder, &["ball.toml", "--passes", "9", "--out", "more.exr", "--resume"], 0);
    assert_contains(&text, &["4 passes are there already", "9 passes"]);
    assert!(bytes(folder, "more") == bytes(folder, "one"));
    // It has all, and writes the picture that somebody lost.
    fs::remove_file(folder.join("more.exr")).unwrap();
    piece(folder, "9", "more.exr", &["--resume"]);
    assert!(bytes(folder, "more") == bytes(folder, "one"));
}

#[test]
fn passes_of_another_render_are_refused_by_name_and_stay() {
    let folder = folder();
    let folder = folder.path();
    piece(folder, "0..2", "a.shard", &[]);
    piece(folder, "2", "picture.exr", &[]);
    let before = fs::read(folder.join("a.shard")).unwrap();
    let into_a = ["--out", "a.shard"];
    for (scene, more, parts) in [
        ("ball.toml", &["--passes", "0..2", "--seed", "7"][..], &["seed 1, not 7"][..]),
        ("ball.toml", &["--passes", "0..2", "--method", "ppb"], &["method adaptive, not ppb"]),
        ("ball.toml", &["--passes", "0..2", "--light-passes"], &["--light-passes no, not yes"]),
        ("ball.toml", &["--passes", "0..2", "--photons", "301"], &["light paths a pass 300, not 301"]),
        ("ball.toml", &["--passes", "1..2"], &["0..2", "1..2"]),
        ("ball.toml", &["--passes", "0..1"], &["0..2", "0..1"]),
        ("thin.toml", &["--passes", "0..2"], &["scene ball, not thin", "fingerprint"]),
    ] {
        let photons: &[&str] = if more.contains(&"--photons") { &[] } else { &["--photons", "300"] };
        let text = said(folder, &[&["render", scene], photons, more, &into_a].concat(), 3);
        assert_contains(&text, parts);
        assert_contains(&text, &["a.shard", "delete it, or choose another --out"]);
    }
    assert!(fs::read(folder.join("a.shard")).unwrap() == before);
    let text = render(folder, &["ball.toml", "--seed", "7", "--resume", "--out", "picture.exr"], 3);
    assert_contains(&text, &["picture.shard", "seed 1, not 7", "--resume"]);
    fs::write(folder.join("picture.shard"), "no shard").unwrap();
    let text = render(folder, &["ball.toml", "--resume", "--out", "picture.exr"], 3);
    assert_contains(&text, &["picture.shard", "is no shard"]);
}

#[test]
fn what_cannot_be_merged_is_refused_by_name_and_nothing_is_written() {
    let folder = folder();
    let folder = folder.path();
    piece(folder, "0..2", "a.shard", &[]);
    piece(folder, "2..4", "b.shard", &[]);
    piece(folder, "6..8", "d.shard", &[]);
    piece(folder, "3..5", "twice.shard", &[]);
    piece(folder, "2..4", "seed.shard", &["--seed", "2"]);
    render(folder, &["thin.toml", "--passes", "2..4", "--out", "thin.shard"], 0);
    let wide = fs::read_to_string(folder.join("ball.toml")).unwrap().replace("width = 24", "width = 25");
    fs::create_dir(folder.join("wide")).unwrap();
    fs::write(folder.join("wide/ball.toml"), wide).unwrap();
    render(folder, &["wide/ball.toml", "--passes", "2..4", "--out", "wide.shard"], 0);
    let bytes = fs::read(folder.join("b.shard")).unwrap();
    // In the header, which a sum guards: another text of the same length.
    let changed = |field: &str| {
        let at = bytes.windows(field.len()).position(|window| window == field.as_bytes()).unwrap();
        let mut other = bytes.clone();
        let first = &mut other[at + field.len()];
        *first = if *first == b'9' { b'8' } else { b'9' };
        with_header_crc(other)
    };
    fs::write(folder.join("version.shard"), changed("\"version\":\"")).unwrap();
    fs::write(folder.join("libm.shard"), changed("\"arithmetic\":\"")).unwrap();
    let before = names(folder);

    let refused = |shards: &[&str], parts: &[&str]| {
        let text = said(folder, &[&["merge"], shards, &["--out", "out.exr"]].concat(), 3);
        assert_contains(&text, parts);
        assert_eq!(names(folder), before);
    };
    refused(&["a.shard", "seed.shard"], &["'seed.shard' is not of", "'a.shard'", "seed 1, not 2"]);
    refused(&["a.shard", "thin.shard"], &["'thin.shard'", "scene ball, not thin", "fingerprint"]);
    refused(&["a.shard", "wide.shard"], &["'wide.shard'", "24 x 20 pixels, not 25 x 20", "fingerprint"]);
    refused(&["a.shard", "version.shard"], &["'version.shard'", "version"]);
    refused(&["a.shard", "libm.shard"], &["'libm.shard'", "arithmetic (libm)"]);
    refused(&["a.shard", "b.shard", "twice.shard"], &["3..4", "'b.shard'", "'twice.shard'"]);
    refused(&["a.shard", "a.shard"], &["0..2", "'a.shard'"]);
    refused(&["a.shard", "b.shard", "d.shard"], &["4..6", "--allow-gaps"]);
    refused(&["b.shard"], &["0..2", "--allow-gaps"]);
    refused(&["a.shard", "b.shard", "--passes", "6"], &["4..6"]);
    refused(&["a.shard", "b.shard", "--passes", "3"], &["0..4", "--passes 3"]);
    refused(&["a.shard", "none.shard"], &["none.shard"]);
    refused(&["a.shard", "ball.toml"], &["ball.toml", "is no shard"]);
    let text = said(folder, &["merge", "a.shard", "--out", "x.shard", "--allow-gaps"], 2);
    assert_contains(&text, &["--allow-gaps", "pictures"]);

    let text = said(folder, &["merge", "d.shard", "a.shard", "--allow-gaps", "--out", "gaps.exr"], 0);
    assert_contains(&text, &["without the passes 2..6"]);
    assert!(folder.join("gaps.exr").exists());
}

/// A shard's bytes with the right sum over its header.
fn with_header_crc(mut bytes: Vec<u8>) -> Vec<u8> {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let crc = crc32(&bytes[20..20 + length]);
    bytes[16..20].copy_from_slice(&crc.to_le_bytes());
    bytes
}

/// CRC-32 by its definition, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for byte in bytes {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
        }
    }
    !crc
}

#[test]
fn a_thousand_damaged_shards_are_refused_by_name() {
    let folder = folder();
    let folder = folder.path();
    piece(folder, "0..3", "a.shard", &["--light-passes"]);
    let good = fs::read(folder.join("a.shard")).unwrap();
    let path = folder.join("mutant.shard");
    let add = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        let mut film: Option<Film> = None;
        let added = Shard::open(&path).and_then(|shard| shard.add_to(film.insert(shard.film())));
        (added.map_err(|error| error.to_string()), film)
    };
    add(&good).0.unwrap();
    // A fixed sequence: each failure can be seen again.
    let mut state = 1_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for number in 0..1000 {
        let mut mutant = good.clone();
        match number % 5 {
            0 | 1 => mutant[random(good.len())] ^= 1 << random(8),
            2 => mutant.truncate(random(good.len())),
            3 => mutant.extend(std::iter::repeat_n(0, 1 + random(9))),
            _ => {
                let (from, to) = (random(good.len() - 64), random(good.len() - 64));
                mutant.copy_within(from..from + 64, to);
            }
        }
        if mutant == good {
            continue;
        }
        let message = add(&mutant).0.expect_err("a damaged file");
        assert!(message.contains("mutant.shard"), "{message}");
    }
}

/// Starts a render that is killed with -9 at a random moment until it comes to its end.
fn survive(folder: &Path, arguments: &[&str], kills: u32) -> u32 {
    let start = || {
        Command::new(env!("CARGO_BIN_EXE_covbeam"))
            .args(arguments)
            .current_dir(folder)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap()
    };
    let mut killed = 0;
    for number in 0..kills {
        let mut child = start();
        // Moments that do not follow the passes' rhythm.
        std::thread::sleep(Duration::from_millis(u64::from(40 + 97 * number % 331)));
        if child.try_wait().unwrap().is_none() {
            child.kill().unwrap();
            killed += 1;
        }
        child.wait().unwrap();
    }
    assert!(start().wait().unwrap().success());
    killed
}

#[cfg(unix)]
#[test]
fn a_render_that_is_killed_again_and_again_ends_with_the_same_bits() {
    let folder = folder();
    let folder = folder.path();
    for (method, ending) in [("adaptive", "exr"), ("ppb", "shard")] {
        let passes = if ending == "exr" { "40" } else { "0..40" };
        let [one, other] = ["one", "other"].map(|name| format!("{method}-{name}.{ending}"));
        let flags = ["--method", method, "--checkpoint", "0"];
        piece(folder, passes, &one, &flags);
        let resume: &[&str] = if ending == "exr" { &["--resume"] } else { &[] };
        let arguments = ["render", "ball.toml", "--photons", "300", "--passes", passes, "--out", &other];
        let killed = survive(folder, &[&arguments, &flags[..], resume].concat(), 6);
        assert!(killed > 0, "{method} was never killed");
        let read = |name: &str| fs::read(folder.join(name)).unwrap();
        assert!(read(&one) == read(&other), "{method}");
        if ending == "exr" {
            let png = |name: &str| read(&PathBuf::from(name).with_extension("png").to_string_lossy());
            assert!(png(&one) == png(&other));
        }
    }
}
