//! Fingerprints: another scene has another one, whatever differs, in its text or in any file that it reads.

use crate::scene_file::{SMOKE, VALID, meshes, volume};
use covbeam_render::files::output::{RenderInfo, write_exr};
use covbeam_render::scene_file;
use covbeam_session::film::Picture;
use glam::Vec3;
use std::path::Path;

/// A medium of another file, a light of one, and a sky.
const MORE: &str = "[[light]]\nkind = \"mesh\"\nfile = \"lamp.obj\"\nradiance = 1\n[[light]]\nkind = \"sky\"\nradiance = 1\npicture = \"sky.exr\"\n\
    [[light]]\nkind = \"area\"\ncenter = [0, 1, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = 1\n\
    [[light]]\nkind = \"lamp\"\nposition = [0, 1, 0]\nintensity = 1\ncone = { look_at = [0, 0, 0], angle = 30, blend = 0.5 }\n";

fn write_sky(path: &Path, value: f32) {
    let (width, height) = (4, 2);
    let picture = Picture { width, height, radiance: vec![Vec3::splat(value); 8], ..Picture::default() };
    let info = RenderInfo { method: "ppb".into(), passes: 1, photons: 1, seed: 1, scene: "sky".into() };
    write_exr(path, &picture, &info).expect("written");
}

/// A folder with all files that the scene of [`text`] names.
fn folder() -> tempfile::TempDir {
    let folder = meshes();
    let path = |name: &str| folder.path().join(name);
    std::fs::copy(path("tetrahedron.obj"), path("lamp.obj")).expect("copied");
    std::fs::write(path("smoke.vol"), volume([2, 2, 2], &[9; 8])).expect("written");
    std::fs::write(path("other"), "one").expect("written");
    write_sky(&path("sky.exr"), 1.0);
    folder
}

/// A scene with every struct that a scene file has; a sky's fog has an end.
fn text() -> String {
    [VALID.replace("outside_medium = \"fog\"\n", "").as_str(), SMOKE, MORE].concat()
}

fn fingerprint(text: &str, folder: &Path) -> Result<String, String> {
    let read = scene_file::parse_with_fingerprint(text, "scene.toml", folder);
    read.map(|(_, fingerprint)| fingerprint).map_err(|error| error.to_string())
}

#[test]
fn it_changes_with_every_value_and_not_with_what_is_no_value() {
    let folder = folder();
    let of = |text: &str| fingerprint(text, folder.path()).expect("valid");
    let text = text();
    let first = of(&text);
    assert_eq!(first.len(), 64);
    let laid_out =
        text.replace("seed = 7\n", "seed = 0x8 # more\n\n").replace("radius = 0.5", "radius = 5e-1");
    assert_eq!(of(&laid_out), first);
    assert_eq!(of(&text.replace("passes = 3\nphotons = 1000\n", "")), first);
    for (from, to) in [("width = 64", "width = 65"), ("alpha = 0.6", "alpha = 0.7"), ("\"ball\"", "\"bull\"")]
    {
        assert_ne!(of(&text.replace(from, to)), first, "{to}");
    }
}

#[test]
fn it_changes_with_every_file() {
    let folder = folder();
    let of = || fingerprint(&text(), folder.path()).expect("valid");
    let mut seen = vec![of()];
    let path = |name: &str| folder.path().join(name);
    let tetrahedron = std::fs::read_to_string(path("tetrahedron.obj")).expect("there");
    std::fs::write(path("tetrahedron.obj"), tetrahedron.replace("v 1 0 0", "v 2 0 0")).expect("written");
    seen.push(of());
    std::fs::write(path("lamp.obj"), tetrahedron.replace("v 0 0 1", "v 0 0 2")).expect("written");
    seen.push(of());
    std::fs::write(path("smoke.vol"), volume([2, 2, 2], &[9, 9, 9, 9, 9, 9, 9, 8])).expect("written");
    seen.push(of());
    write_sky(&path("sky.exr"), 2.0);
    seen.push(of());
    let count = seen.len();
    seen.sort();
    seen.dedup();
    assert_eq!(seen.len(), count);
}

/// A field more in every table of a scene, which names a file: it is an unknown field, or what is in the file counts.
#[test]
fn no_table_takes_a_file_that_is_left_out() {
    let folder = folder();
    let whole: toml::Table = text().parse().expect("valid");
    let places = tables(&toml::Value::Table(whole.clone()));
    assert!(places.len() > 25, "{places:?}");
    let (mut refused, mut hashed) = (0, 0);
    for place in &places {
        for key in ["file", "picture", "pattern", "texture", "include"] {
            let mut scene = toml::Value::Table(whole.clone());
            let at = place.iter().fold(&mut scene, |at, step| match step {
                Step::Key(key) => &mut at[key.as_str()],
                Step::Index(index) => &mut at[*index],
            });
            let table = at.as_table_mut().expect("a table");
            // Of fields that are there the files are those of the test above.
            if table.insert(key.to_owned(), "other".into()).is_some() {
                continue;
            }
            let text = toml::to_string(&scene).expect("a scene");
            std::fs::write(folder.path().join("other"), "one").expect("written");
            let Ok(one) = fingerprint(&text, folder.path()) else {
                refused += 1;
                continue;
            };
            std::fs::write(folder.path().join("other"), "two").expect("written");
            let two = fingerprint(&text, folder.path()).expect("as before");
            assert_ne!(one, two, "{place:?}.{key}");
            hashed += 1;
        }
    }
    println!("{} tables: {refused} fields refused, {hashed} hashed", places.len());
}

#[derive(Clone, Debug)]
enum Step {
    Key(String),
    Index(usize),
}

/// Where tables are in a value, itself included.
fn tables(value: &toml::Value) -> Vec<Vec<Step>> {
    let below = |step: Step, value: &toml::Value| {
        let after = tables(value).into_iter();
        after.map(|rest| [vec![step.clone()], rest].concat()).collect::<Vec<_>>()
    };
    match value {
        toml::Value::Table(table) => {
            let of_fields = table.iter().flat_map(|(key, value)| below(Step::Key(key.clone()), value));
            [vec![]].into_iter().chain(of_fields).collect()
        }
        toml::Value::Array(values) => {
            values.iter().enumerate().flat_map(|(index, value)| below(Step::Index(index), value)).collect()
        }
        _ => Vec::new(),
    }
}
