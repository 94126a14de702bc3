//! Reads a scene from TOML. `examples/scenes/glass-ball.toml` explains the format line by line.
//!
//! Lengths are in scene units, angles in degrees. Where a colour is expected, one number means grey.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use covbeam::{GridLayout, KernelShape, Schedule};
use covbeam_geometry::MAX_COORDINATE;
use covbeam_geometry::mesh::{Mesh, Placement};
use glam::{Quat, Vec3};

use crate::camera::Camera;
use crate::defaults;
pub use crate::fields::SceneError;
use crate::fields::{Field, Source, Table};
use crate::material_file::read_material;
use crate::medium_file::{check_exponential, read_media, read_medium_name};
use crate::scene::{Light, MediumDensity, MediumId, Object, Scene, SceneMedium, Settings, Shape, Sun};
use crate::survey::Survey;

/// Most pixels along one side of the picture.
pub const MAX_IMAGE_SIDE: u32 = 16384;
/// Most light paths a pass.
pub const MAX_PHOTONS: u32 = 1 << 28;
/// Most cells of the covariance grid.
pub const MAX_GRID_CELLS: u64 = 1 << 24;
/// Most bytes of a scene file.
const MAX_FILE_BYTES: u64 = 1 << 24;

impl Scene {
    /// Reads a scene file; mesh and volume files are looked up relative to it.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        Ok(Self::load_with_text(path)?.0)
    }

    /// The same, and the text of the file.
    pub fn load_with_text(path: &Path) -> Result<(Self, String), SceneError> {
        let file = path.display().to_string();
        let text = read_text(path).map_err(|source| SceneError::Unreadable { file: file.clone(), source })?;
        Ok((Self::parse(&text, &file, path.parent().unwrap_or(Path::new("")))?, text))
    }

    /// Reads a scene from `text`. `source_name` appears in errors; mesh and volume files are relative to `base_dir`.
    ///
    /// The result is valid: finite, in range, every name resolved. Anything else is refused with file, line,
    /// field, what was found and what was expected.
    pub fn parse(text: &str, source_name: &str, base_dir: &Path) -> Result<Self, SceneError> {
        let source = Source { name: source_name, text };
        let document = source.parse()?;
        let root = Table::root(source, &document);
        root.only(&["outside_medium", "camera", "medium", "object", "light", "grid", "render"])?;
        let (media, names) = read_media(&root, base_dir)?;
        let outside =
            root.optional("outside_medium").map(|field| read_medium_name(&field, &names)).transpose()?;
        let camera = read_camera(&root.required("camera")?.table()?)?;
        let objects: Vec<Object> = root
            .tables("object")?
            .iter()
            .map(|t| read_object(t, &media, &names, base_dir))
            .collect::<Result<_, _>>()?;
        let shone_on = ShoneOn { objects: &objects, media: &media, outside };
        let lights: Vec<Light> =
            root.tables("light")?.iter().map(|t| read_light(t, &shone_on)).collect::<Result<_, _>>()?;
        if lights.is_empty() {
            return Err(root.lacks("light", "at least one [[light]]"));
        }
        let given = (read_grid(&root)?, read_settings(&root)?);
        check_exponential(&root, &media, outside, given.0.corners, &objects, &camera, &lights)?;
        // The survey that the defaults come from looks at neither.
        let grid = GridLayout { min: Vec3::ZERO, max: Vec3::ONE, cells: [1; 3] };
        let settings = defaults::settings();
        let mut scene = Self { objects, lights, media, outside, camera, grid, settings };
        complete(&mut scene, given)?;
        Ok(scene)
    }
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

fn read_camera(table: &Table<'_>) -> Result<Camera, SceneError> {
    table.only(&["position", "look_at", "up", "vertical_fov", "width", "height"])?;
    let position = table.required("position")?.vector()?;
    let look_at = table.required("look_at")?;
    let forward = (look_at.vector()?.as_dvec3() - position.as_dvec3())
        .try_normalize()
        .ok_or_else(|| look_at.refuse("a point other than the camera's position"))?;
    let up_field = table.optional("up");
    let up = up_field.as_ref().map_or(Ok(Vec3::Y), Field::direction)?.as_dvec3();
    let right = forward.cross(up);
    // Below this the picture's roll would be rounding noise.
    if right.length() < 1e-3 {
        let field = up_field.unwrap_or(look_at);
        return Err(field.refuse("an up direction that is not along the view (the default is [0, 1, 0])"));
    }
    let right = right.normalize();
    let fov = table
        .required("vertical_fov")?
        .number("an angle in 0.001..=179 degrees", |fov| (0.001..=179.0).contains(&fov))?;
    let side = 1..u64::from(MAX_IMAGE_SIDE) + 1;
    Ok(Camera {
        position,
        forward: forward.as_vec3().normalize(),
        right: right.as_vec3().normalize(),
        up: right.cross(forward).as_vec3().normalize(),
        tan_half_height: (0.5 * f64::from(fov)).to_radians().tan() as f32,
        width: table.required("width")?.integer(side.clone())?,
        height: table.required("height")?.integer(side)?,
    })
}

fn read_object(
    table: &Table<'_>,
    media: &[SceneMedium],
    names: &[&str],
    base_dir: &Path,
) -> Result<Object, SceneError> {
    let shape_field = table.required("shape")?;
    let expected = "\"sphere\", \"rectangle\", \"box\" or \"mesh\"";
    let kind = shape_field.text(expected)?;
    let own: &[&str] = match kind {
        "sphere" => &["center", "radius"],
        "rectangle" => &["corner", "edge_u", "edge_v"],
        "box" => &["min", "max"],
        "mesh" => &["file", "scale", "rotate", "translate", "smooth"],
        _ => return Err(shape_field.refuse(expected)),
    };
    table.only(&[&["name", "shape", "material", "inside"], own].concat())?;
    let shape = match kind {
        "sphere" => Shape::Sphere {
            center: table.required("center")?.vector()?,
            radius: table.required("radius")?.size()?,
        },
        "rectangle" => {
            let (corner, edge_u, edge_v) = read_parallelogram(table)?;
            Shape::Rectangle { corner, edge_u, edge_v }
        }
        "box" => {
            let (min, max) = read_corners(table)?;
            Shape::Box { min, max }
        }
        _ => Shape::Mesh(read_mesh(table, base_dir)?),
    };
    let material_field = table.required("material")?;
    let material = read_material(&material_field)?;
    if material.index().is_some() && !shape.is_closed() {
        let why = match &shape {
            Shape::Mesh(mesh) if mesh.open_edges() > 0 => {
                format!("this mesh has {} open edges", mesh.open_edges())
            }
            Shape::Mesh(_) => "this mesh encloses nothing".to_owned(),
            _ => format!("a {kind} is open"),
        };
        return Err(material_field.refuse(format!("a dielectric only on a closed shape ({why})")));
    }
    let inside_field = table.optional("inside");
    let inside = inside_field.as_ref().map(|field| read_medium_name(field, names)).transpose()?;
    if let (Some(field), false) = (&inside_field, material.index().is_some()) {
        return Err(field.refuse("no medium inside an object that is not a dielectric"));
    }
    if let (Some(field), Some(id)) = (&inside_field, inside)
        && !matches!(media[id as usize].density, MediumDensity::Uniform)
    {
        return Err(field.refuse("a medium without `density`: inside objects media are homogeneous"));
    }
    let name = match table.optional("name") {
        Some(field) => field.text("a name in quotes")?.to_owned(),
        None => shape_field.path.trim_end_matches(".shape").to_owned(),
    };
    Ok(Object { name, shape, material, inside })
}

/// `corner`, `edge_u` and `edge_v` of an object or of a light.
fn read_parallelogram(table: &Table<'_>) -> Result<(Vec3, Vec3, Vec3), SceneError> {
    let (corner, edge_u, v_field) =
        (table.required("corner")?.vector()?, table.required("edge_u")?, table.required("edge_v")?);
    let edge = |field: &Field<'_>| {
        let vector = field.vector()?;
        let long_enough = vector.length() >= 1.0 / MAX_COORDINATE;
        if long_enough { Ok(vector) } else { Err(field.refuse("an edge longer than 1e-9")) }
    };
    let (edge_u, edge_v) = (edge(&edge_u)?, edge(&v_field)?);
    let (u, v) = (edge_u.as_dvec3().normalize(), edge_v.as_dvec3().normalize());
    // The sine of the angle between the edges.
    if u.cross(v).length() < 1e-6 {
        return Err(v_field.refuse("an edge that is not parallel to edge_u"));
    }
    Ok((corner, edge_u, edge_v))
}

/// `min` and `max` of a box, of the grid or of a volume.
pub(crate) fn read_corners(table: &Table<'_>) -> Result<(Vec3, Vec3), SceneError> {
    let (min, max_field) = (table.required("min")?.vector()?, table.required("max")?);
    let max = max_field.vector()?;
    let size = max.as_dvec3() - min.as_dvec3();
    if size.min_element() < f64::from(1.0 / MAX_COORDINATE) {
        return Err(max_field.refuse(format!("each coordinate above that of min = {min} by at least 1e-9")));
    }
    Ok((min, max))
}

fn read_mesh(table: &Table<'_>, base_dir: &Path) -> Result<Mesh, SceneError> {
    let file = table.required("file")?;
    let path = base_dir.join(file.text("the path of an OBJ file in quotes, relative to the scene file")?);
    let rotation = match table.optional("rotate") {
        None => Quat::IDENTITY,
        Some(field) => {
            let rotate = field.table()?;
            rotate.only(&["axis", "degrees"])?;
            let axis = rotate.required("axis")?.direction()?;
            let angle =
                rotate.required("degrees")?.number("an angle in -360..=360 degrees", |a| a.abs() <= 360.0)?;
            Quat::from_axis_angle(axis, angle.to_radians())
        }
    };
    let placement = Placement {
        scale: table.optional("scale").map_or(Ok(1.0), |field| field.size())?,
        rotation,
        translation: table.optional("translate").map_or(Ok(Vec3::ZERO), |field| field.vector())?,
    };
    let smooth = table.optional("smooth").map_or(Ok(true), |field| field.boolean())?;
    Mesh::load(&path, &placement, smooth)
        .map_err(|source| file.refuse_mesh(path.display().to_string(), source))
}

/// What a sun shines on.
struct ShoneOn<'a> {
    objects: &'a [Object],
    media: &'a [SceneMedium],
    outside: Option<MediumId>,
}

fn read_light(table: &Table<'_>, shone_on: &ShoneOn) -> Result<Light, SceneError> {
    let kind_field = table.required("kind")?;
    let expected = "\"point\", \"spot\", \"disk\", \"rectangle\", \"sphere\" or \"sun\"";
    let kind = kind_field.text(expected)?;
    table.only(match kind {
        "point" => &["kind", "position", "intensity"],
        "spot" => &["kind", "position", "look_at", "intensity", "inner_angle", "outer_angle"],
        "disk" => &["kind", "center", "normal", "radius", "radiance"],
        "rectangle" => &["kind", "corner", "edge_u", "edge_v", "radiance"],
        "sphere" => &["kind", "center", "radius", "radiance"],
        "sun" => &["kind", "direction", "angle", "irradiance"],
        _ => return Err(kind_field.refuse(expected)),
    })?;
    let power = |key| {
        let field = table.required(key)?;
        let color = field.color("a number in 0..=1e9", |value| (0.0..=MAX_COORDINATE).contains(&value))?;
        if color == Vec3::ZERO { Err(field.refuse("a light that is not dark")) } else { Ok(color) }
    };
    match kind {
        "point" => Ok(Light::Point {
            position: table.required("position")?.vector()?,
            intensity: power("intensity")?,
        }),
        "spot" => read_spot(table, power("intensity")?),
        "rectangle" => {
            let (corner, edge_u, edge_v) = read_parallelogram(table)?;
            Ok(Light::Rectangle { corner, edge_u, edge_v, radiance: power("radiance")? })
        }
        "sphere" => Ok(Light::Sphere {
            center: table.required("center")?.vector()?,
            radius: table.required("radius")?.size()?,
            radiance: power("radiance")?,
        }),
        "sun" => read_sun(table, power("irradiance")?, shone_on),
        _ => Ok(Light::Disk {
            center: table.required("center")?.vector()?,
            normal: table.required("normal")?.direction()?,
            radius: table.required("radius")?.size()?,
            radiance: power("radiance")?,
        }),
    }
}

/// Widest angle that a sun is seen under \[degrees\]: wider ones are no light of one direction.
const WIDEST_SUN: f32 = 90.0;

fn read_sun(table: &Table<'_>, irradiance: Vec3, shone_on: &ShoneOn) -> Result<Light, SceneError> {
    let &ShoneOn { objects, media, outside } = shone_on;
    let direction_field = table.required("direction")?;
    let direction = direction_field.direction()?;
    let expected = "an angle in 0..=90 degrees";
    let angle = match table.optional("angle") {
        Some(field) => field.number(expected, |angle| (0.0..=WIDEST_SUN).contains(&angle))?,
        None => 0.0,
    };
    match outside.map(|id| &media[id as usize]) {
        Some(SceneMedium { medium, density: MediumDensity::Uniform })
            if medium.extinction() != Vec3::ZERO =>
        {
            return Err(table.required("kind")?.refuse(
                "no sun where outside_medium has no end, as its light would not get through: put the medium inside a box of \
                 { dielectric = { index = 1 } }, or let its density fall with height",
            ));
        }
        Some(SceneMedium { density: MediumDensity::Exponential(density), .. })
            if direction.dot(density.up) >= 0.0 =>
        {
            return Err(direction_field.refuse(
                "a direction that comes from where outside_medium is thin: down, if its density falls with height",
            ));
        }
        _ => {}
    }
    let sun = Sun::new((direction, (0.5 * angle).to_radians(), irradiance), objects, media, outside);
    sun.map(Light::Sun).ok_or_else(|| {
        direction_field.refuse("an object, or a medium with an end, that the sun could shine on")
    })
}

fn read_spot(table: &Table<'_>, intensity: Vec3) -> Result<Light, SceneError> {
    let position = table.required("position")?.vector()?;
    let look_at = table.required("look_at")?;
    let direction = (look_at.vector()?.as_dvec3() - position.as_dvec3())
        .try_normalize()
        .ok_or_else(|| look_at.refuse("a point other than the light's position"))?;
    let inner =
        table.required("inner_angle")?.number("an angle in 0..90 degrees", |a| (0.0..90.0).contains(&a))?;
    let outer_field = table.required("outer_angle")?;
    let outer = outer_field
        .number(&format!("an angle above inner_angle = {inner} and below 90 degrees"), |a| {
            a > inner && a < 90.0
        })?;
    Ok(Light::Spot {
        position,
        direction: direction.as_vec3().normalize(),
        intensity,
        inner_angle: inner.to_radians(),
        outer_angle: outer.to_radians(),
    })
}

/// What a file says of the grid.
struct GivenGrid {
    corners: Option<(Vec3, Vec3)>,
    cells: Option<[u32; 3]>,
}

fn read_grid(root: &Table<'_>) -> Result<GivenGrid, SceneError> {
    let Some(field) = root.optional("grid") else { return Ok(GivenGrid { corners: None, cells: None }) };
    let table = field.table()?;
    table.only(&["min", "max", "cells"])?;
    let has_corners = table.optional("min").is_some() || table.optional("max").is_some();
    let corners = has_corners.then(|| read_corners(&table)).transpose()?;
    let cells = table.optional("cells").map(|field| read_cells(&field)).transpose()?;
    Ok(GivenGrid { corners, cells })
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

/// What a file says of the render. What does not depend on the scene has its default.
struct GivenSettings {
    settings: Settings,
    photons: Option<u32>,
    radius: Option<f32>,
    max_radius: Option<f32>,
}

fn read_settings(root: &Table) -> Result<GivenSettings, SceneError> {
    let mut given =
        GivenSettings { settings: defaults::settings(), photons: None, radius: None, max_radius: None };
    let settings = &mut given.settings;
    let Some(field) = root.optional("render") else { return Ok(given) };
    let table = field.table()?;
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
    Ok(given)
}

/// Gives a scene its grid and settings: those of the file, and for the rest what the scene asks for.
fn complete(scene: &mut Scene, (grid, given): (GivenGrid, GivenSettings)) -> Result<(), SceneError> {
    let is_complete = grid.corners.is_some() && given.radius.is_some() && given.photons.is_some();
    let survey = (!is_complete).then(|| Survey::new(scene));
    let survey = || survey.expect("made where a number is missing");
    let (min, max) = grid.corners.unwrap_or_else(|| (survey().min, survey().max));
    let cells = grid.cells.unwrap_or_else(|| defaults::cells(min, max));
    scene.grid = GridLayout { min, max, cells };
    let radius = given.radius.unwrap_or_else(|| defaults::radius(&survey()));
    let max_radius = given.max_radius.unwrap_or_else(|| defaults::max_radius(&scene.grid));
    let photons = given.photons.unwrap_or_else(|| defaults::photons(scene, &survey(), radius));
    let guided_photons = given.photons.unwrap_or_else(|| defaults::guided_photons(scene, photons));
    let schedule = Schedule { radius, max_radius, ..given.settings.schedule };
    scene.settings = Settings { photons, guided_photons, schedule, ..given.settings };
    Ok(())
}
