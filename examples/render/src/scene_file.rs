//! Reads a scene from TOML. `examples/scenes/glass-ball.toml` explains the format line by line.
//!
//! Lengths are in scene units, angles in degrees. Where a colour is expected, one number means grey.

mod camera;
pub(crate) mod fields;
mod files;
mod fingerprint;
mod glow;
mod light;
mod material;
mod medium;
mod object;
mod shape;
mod sky_picture;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use covbeam::KernelShape;

use self::camera::read_camera;
pub use self::fields::SceneError;
use self::fields::{Field, Source, Table};
use self::files::SceneFiles;
use self::fingerprint::fingerprint;
use self::glow::read_glows;
use self::light::{ShoneOn, read_light};
use self::medium::{check_exponential, read_media, read_medium_name};
use self::object::read_object;
use self::shape::read_corners;
use covbeam_session::pilot::defaults::{self, Cells, Given};
use covbeam_session::scene::nest;
use covbeam_session::scene::{GlowingFog, Light, MAX_PHOTONS, Object, Scene, Sees, Shown};

/// Most cells of the covariance grid.
pub const MAX_GRID_CELLS: u64 = 1 << 24;
/// Most bytes of a scene file.
const MAX_FILE_BYTES: u64 = 1 << 24;

/// Reads a scene file; mesh and volume files are looked up relative to it.
pub fn load(path: &Path) -> Result<Scene, SceneError> {
    Ok(load_with_fingerprint(path)?.0)
}

/// The same, and the scene's fingerprint.
pub fn load_with_fingerprint(path: &Path) -> Result<(Scene, String), SceneError> {
    let file = path.display().to_string();
    let text = read_text(path).map_err(|source| SceneError::Unreadable { file: file.clone(), source })?;
    parse_with_fingerprint(&text, &file, path.parent().unwrap_or(Path::new("")))
}

/// Reads a scene from `text`. `source_name` appears in errors; mesh and volume files are relative to `base_dir`.
///
/// The result is valid: finite, in range, every name resolved. Anything else is refused with file, line,
/// field, what was found and what was expected.
pub fn parse(text: &str, source_name: &str, base_dir: &Path) -> Result<Scene, SceneError> {
    parse_beside(text, source_name, &SceneFiles::beside(base_dir))
}

/// The same, and 64 hexadecimal digits that are others for every other scene: of its values, whatever their layout and comments, and of what
/// is in all of the files that were read for it. Passes, photons and seed do not count, which may change between two renders of a scene.
pub fn parse_with_fingerprint(
    text: &str,
    source_name: &str,
    base_dir: &Path,
) -> Result<(Scene, String), SceneError> {
    let files = SceneFiles::beside(base_dir);
    let scene = parse_beside(text, source_name, &files)?;
    let hashes = files
        .hashes()
        .map_err(|(path, source)| SceneError::Unreadable { file: path.display().to_string(), source })?;
    Ok((scene, fingerprint(Source { name: source_name, text }, &hashes)?))
}

fn parse_beside(text: &str, source_name: &str, files: &SceneFiles<'_>) -> Result<Scene, SceneError> {
    let source = Source { name: source_name, text };
    let document = source.parse()?;
    let root = Table::root(source, &document);
    root.only(&["outside_medium", "camera", "medium", "object", "light", "grid", "render"])?;
    let (mut media, names) = read_media(&root, files)?;
    let outside =
        root.optional("outside_medium").map(|field| read_medium_name(&field, &names)).transpose()?;
    let camera = read_camera(&root.required("camera")?.table()?)?;
    let mut objects: Vec<Object> = root
        .tables("object")?
        .iter()
        .map(|t| read_object(t, &media, &names, files))
        .collect::<Result<_, _>>()?;
    nest(&mut objects);
    read_glows(&root, &mut media, &objects, outside)?;
    let shone_on = ShoneOn { objects: &objects, media: &media, outside, files };
    let mut notes = Vec::new();
    let mut read = |table| read_light(table, &shone_on, &mut notes);
    let read: Vec<(Light, bool)> = root.tables("light")?.iter().map(&mut read).collect::<Result<_, _>>()?;
    let (mut lights, visible): (Vec<Light>, Vec<bool>) = read.into_iter().unzip();
    let shown = Shown::new(&lights, |number| visible[number]);
    lights.extend(GlowingFog::all(&media).map(Light::Glow));
    if lights.is_empty() {
        return Err(root.lacks("light", "at least one [[light]], or a [[medium]] with `emission`"));
    }
    let given = read_given(&root)?;
    check_exponential(&root, &media, outside, given.corners, &objects, &camera, &lights)?;
    let (grid, settings) = (defaults::NO_GRID, given.settings);
    let (placed, sees) = (None, Sees::Everything);
    let mut scene = Scene {
        objects,
        placed,
        lights,
        shown,
        links: Vec::new(),
        media,
        outside,
        camera,
        grid,
        settings,
        sees,
        notes,
    };
    scene.complete(&given);
    Ok(scene)
}
fn read_text(path: &Path) -> std::io::Result<String> {
    let mut text = String::new();
    // A device or a pipe may never end.
    let bytes = File::open(path)?.take(MAX_FILE_BYTES + 1).read_to_string(&mut text)?;
    if bytes as u64 > MAX_FILE_BYTES {
        return Err(std::io::Error::other(format!("longer than {MAX_FILE_BYTES} bytes")));
    }
    Ok(text)
}

/// What a file says of the grid and the render.
fn read_given(root: &Table<'_>) -> Result<Given, SceneError> {
    let mut given = Given::default();
    if let Some(field) = root.optional("grid") {
        read_grid(&field.table()?, &mut given)?;
    }
    if let Some(field) = root.optional("render") {
        read_settings(&field.table()?, &mut given)?;
    }
    Ok(given)
}

fn read_grid(table: &Table<'_>, given: &mut Given) -> Result<(), SceneError> {
    table.only(&["min", "max", "cells"])?;
    let has_corners = table.optional("min").is_some() || table.optional("max").is_some();
    given.corners = has_corners.then(|| read_corners(table)).transpose()?;
    given.cells = table.optional("cells").map(|field| read_cells(&field).map(Cells::Counts)).transpose()?;
    Ok(())
}

fn read_cells(field: &Field<'_>) -> Result<[u32; 3], SceneError> {
    let expected = "three numbers of cells [x, y, z]";
    let elements = field.elements(expected)?;
    let [x, y, z] = elements.as_slice() else { return Err(field.refuse(expected)) };
    let side = 1..MAX_GRID_CELLS + 1;
    let cells: [u32; 3] = [x.integer(side.clone())?, y.integer(side.clone())?, z.integer(side)?];
    // Two factors of at most 2^24 each fit in u64, the third might not.
    let plane = u64::from(cells[0]) * u64::from(cells[1]);
    if plane > MAX_GRID_CELLS || plane * u64::from(cells[2]) > MAX_GRID_CELLS {
        return Err(field.refuse(format!("at most {MAX_GRID_CELLS} cells together")));
    }
    Ok(cells)
}

fn read_settings(table: &Table<'_>, given: &mut Given) -> Result<(), SceneError> {
    let settings = &mut given.settings;
    table.only(&[
        "passes",
        "photons",
        "seed",
        "radius",
        "alpha",
        "error",
        "max_radius",
        "light_field_share",
        "kernel",
    ])?;
    if let Some(field) = table.optional("passes") {
        settings.passes = field.integer(1..1 << 32)?;
    }
    if let Some(field) = table.optional("photons") {
        given.photons = Some(field.integer(1..u64::from(MAX_PHOTONS) + 1)?);
    }
    if let Some(field) = table.optional("seed") {
        settings.seed = field.integer(0..1 << 32)?;
    }
    if let Some(field) = table.optional("radius") {
        given.radius = Some(field.size()?);
    }
    if let Some(field) = table.optional("alpha") {
        settings.schedule.alpha =
            field.number("a number between 0 and 1, both excluded", |a| a > 0.0 && a < 1.0)?;
    }
    if let Some(field) = table.optional("error") {
        settings.schedule.error = field.number("a number in 0.000001..=1", |e| (1e-6..=1.0).contains(&e))?;
    }
    if let Some(field) = table.optional("max_radius") {
        given.max_radius = Some(field.size()?);
    }
    if let Some(field) = table.optional("light_field_share") {
        settings.light_field_share = field.number("a number in 0.0001..=1", |s| (1e-4..=1.0).contains(&s))?;
    }
    if let Some(field) = table.optional("kernel") {
        let expected = "\"box\", \"epanechnikov\" or \"biweight\"";
        settings.schedule.shape = match field.text(expected)? {
            "box" => KernelShape::Box,
            "epanechnikov" => KernelShape::Epanechnikov,
            "biweight" => KernelShape::Biweight,
            _ => return Err(field.refuse(expected)),
        };
    }
    Ok(())
}
