//! Reads a `[[light]]` of a scene file.

use covbeam_geometry::MAX_COORDINATE;
use glam::{Mat3, Vec3};

use super::shape::{read_edges, read_mesh, read_parallelogram};
use crate::files::output::read_picture_up_to;
use crate::scene_file::fields::{Field, SceneError, Table};
use crate::scene_file::files::SceneFiles;
use crate::scene_file::sky_picture::{find_bad, repaired};
use covbeam_geometry::shape::unite;
use covbeam_session::scene::{
    Area, Cone, Lamp, Light, MediumDensity, MediumId, Object, SceneMedium, ShiningMesh, Sky, Sun,
};

/// Widest angle that a sun is seen under \[degrees\]: wider ones are no light of one direction.
const WIDEST_SUN: f32 = 90.0;

/// Narrowest honeycomb \[degrees\]: 5e-4 rad.
const LEAST_SPREAD: f32 = 0.03;

/// Narrowest fall-off of a cone, by the cosine: a jump in single precision.
const LEAST_BLEND: f32 = 1e-6;

/// Most pixels of a picture of the sky.
const MOST_PIXELS: u64 = 1 << 23;

/// What lights shine on, and where their files are.
pub(crate) struct ShoneOn<'a> {
    pub(crate) objects: &'a [Object],
    pub(crate) media: &'a [SceneMedium],
    pub(crate) outside: Option<MediumId>,
    pub(crate) files: &'a SceneFiles<'a>,
}

/// A light, and whether it is seen.
///
/// - `notes`: gets what was changed of what the files say.
pub(crate) fn read_light(
    table: &Table<'_>,
    shone_on: &ShoneOn,
    notes: &mut Vec<String>,
) -> Result<(Light, bool), SceneError> {
    let light = read_kind(table, shone_on, notes)?;
    let is_visible = read_visible(table, &light)?;
    Ok((light, is_visible))
}

/// What has a surface is seen, and a sky, unless the file says otherwise; a sun with an angle where it says so.
fn read_visible(table: &Table<'_>, light: &Light) -> Result<bool, SceneError> {
    let can_be = light.brightest().is_some();
    let Some(field) = table.optional("visible") else { return Ok(can_be && !matches!(light, Light::Sun(_))) };
    let is_visible = field.boolean()?;
    if is_visible && !can_be {
        return Err(field.refuse(match light {
            Light::Sun(_) => "false for a sun without `angle`, which is a point in the sky: give it one to see it",
            _ => {
                "false for a light that has no surface: to see one use kind = \"sphere\", \"disk\", \"rectangle\", \"area\" or \"mesh\""
            }
        }));
    }
    Ok(is_visible)
}

fn read_kind(table: &Table<'_>, shone_on: &ShoneOn, notes: &mut Vec<String>) -> Result<Light, SceneError> {
    let kind_field = table.required("kind")?;
    let expected = "\"point\", \"spot\", \"disk\", \"rectangle\", \"sphere\", \"sun\", \"lamp\", \"area\", \"mesh\" or \"sky\"";
    let kind = kind_field.text(expected)?;
    let own: &[&str] = match kind {
        "point" => &["position", "intensity"],
        "spot" => &["position", "look_at", "intensity", "inner_angle", "outer_angle"],
        "disk" => &["center", "normal", "radius", "radiance"],
        "rectangle" => &["corner", "edge_u", "edge_v", "radiance"],
        "sphere" => &["center", "radius", "radiance"],
        "sun" => &["direction", "angle", "irradiance"],
        "lamp" => &["position", "intensity", "radius", "soft", "cone"],
        "area" => &["center", "edge_u", "edge_v", "round", "spread", "radiance"],
        "mesh" => &["file", "scale", "rotate", "translate", "radiance"],
        "sky" => &["radiance", "picture", "turn", "repair"],
        _ => return Err(kind_field.refuse(expected)),
    };
    table.only(&[&["kind", "visible"], own].concat())?;
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
        "lamp" => read_lamp(table, power("intensity")?, shone_on),
        "area" => read_area(table, power("radiance")?),
        "mesh" => read_shining_mesh(table, power("radiance")?, shone_on),
        "sky" => read_sky(table, power("radiance")?, shone_on, notes),
        _ => Ok(Light::Disk {
            center: table.required("center")?.vector()?,
            normal: table.required("normal")?.direction()?,
            radius: table.required("radius")?.size()?,
            radiance: power("radiance")?,
        }),
    }
}

fn read_sun(table: &Table<'_>, irradiance: Vec3, shone_on: &ShoneOn) -> Result<Light, SceneError> {
    let &ShoneOn { objects, media, outside, .. } = shone_on;
    let direction_field = table.required("direction")?;
    let direction = direction_field.direction()?;
    let expected = "an angle in 0..=90 degrees";
    let angle = match table.optional("angle") {
        Some(field) => field.number(expected, |angle| (0.0..=WIDEST_SUN).contains(&angle))?,
        None => 0.0,
    };
    match outside.map(|id| &media[id as usize]) {
        Some(SceneMedium { medium, density: MediumDensity::Uniform, .. })
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
    let sun = Sun::new((direction, (0.5 * angle).to_radians(), irradiance), objects, None, media, outside);
    sun.map(Light::Sun).ok_or_else(|| {
        direction_field.refuse("an object, or a medium with an end, that the sun could shine on")
    })
}

fn read_spot(table: &Table<'_>, intensity: Vec3) -> Result<Light, SceneError> {
    let position = table.required("position")?.vector()?;
    let direction = read_axis(&table.required("look_at")?, position)?;
    let inner =
        table.required("inner_angle")?.number("an angle in 0..90 degrees", |a| (0.0..90.0).contains(&a))?;
    let outer_field = table.required("outer_angle")?;
    let outer = outer_field
        .number(&format!("an angle above inner_angle = {inner} and below 90 degrees"), |a| {
            a > inner && a < 90.0
        })?;
    Ok(Light::Spot {
        position,
        direction,
        intensity,
        inner_angle: inner.to_radians(),
        outer_angle: outer.to_radians(),
    })
}

fn read_lamp(table: &Table<'_>, intensity: Vec3, shone_on: &ShoneOn) -> Result<Light, SceneError> {
    let position = table.required("position")?.vector()?;
    let radius = match table.optional("radius") {
        Some(field) => field.size_or_zero()?,
        None => 0.0,
    };
    let soft = table.optional("soft").map_or(Ok(false), |field| field.boolean())?;
    let cone = table.optional("cone").map(|field| read_cone(&field.table()?, position)).transpose()?;
    // About as far as light goes that the picture is of.
    let around = shone_on.objects.iter().map(|object| object.shape.bounds()).reduce(unite);
    let far = around.map_or(10.0 * radius, |(min, max)| 0.5 * (max - min).length());
    let glow = Lamp::glow_of(radius, cone.is_some(), far);
    Ok(Light::Lamp(Lamp { position, intensity, radius, soft, cone, pattern: None, glow }))
}

fn read_cone(table: &Table<'_>, position: Vec3) -> Result<Cone, SceneError> {
    table.only(&["look_at", "angle", "blend"])?;
    let axis = read_axis(&table.required("look_at")?, position)?;
    let expected = "an angle above 0 and up to 90 degrees";
    let angle = table.required("angle")?.number(expected, |angle| angle > 0.0 && angle <= 90.0)?;
    let blend = table.required("blend")?.number("a number in 0..=1", |blend| (0.0..=1.0).contains(&blend))?;
    // 1 - cos, of which f32 has the digits.
    let sine = libm::sinf(0.5 * angle.to_radians());
    let height = 2.0 * sine * sine;
    Ok(Cone { axis, cosine: 1.0 - height, blend: (blend * height).max(LEAST_BLEND) })
}

/// From a light's position to a point.
fn read_axis(look_at: &Field<'_>, position: Vec3) -> Result<Vec3, SceneError> {
    (look_at.vector()?.as_dvec3() - position.as_dvec3())
        .try_normalize()
        .map(|axis| axis.as_vec3().normalize())
        .ok_or_else(|| look_at.refuse("a point other than the light's position"))
}

fn read_area(table: &Table<'_>, radiance: Vec3) -> Result<Light, SceneError> {
    let (edge_u, edge_v) = read_edges(table)?;
    let spread = match table.optional("spread") {
        Some(field) => {
            field.number("an angle in 0.03..=90 degrees", |a| (LEAST_SPREAD..=90.0).contains(&a))?
        }
        None => 90.0,
    };
    Ok(Light::Area(Area {
        center: table.required("center")?.vector()?,
        edge_u,
        edge_v,
        round: table.optional("round").map_or(Ok(false), |field| field.boolean())?,
        spread: spread.to_radians(),
        radiance,
    }))
}

fn read_shining_mesh(table: &Table<'_>, radiance: Vec3, shone_on: &ShoneOn) -> Result<Light, SceneError> {
    let mesh = read_mesh(table, shone_on.files)?;
    let shining = ShiningMesh::new(&mesh.placed_corners(), radiance);
    shining.map(Light::Mesh).ok_or_else(|| {
        let expected = "a mesh of which triangles have an area in single precision";
        table.required("file").map_or_else(|error| error, |field| field.refuse(expected))
    })
}

fn read_sky(
    table: &Table<'_>,
    radiance: Vec3,
    shone_on: &ShoneOn,
    notes: &mut Vec<String>,
) -> Result<Light, SceneError> {
    let &ShoneOn { objects, media, outside, files } = shone_on;
    let kind = table.required("kind")?;
    if let Some(SceneMedium {
        medium, density: MediumDensity::Uniform | MediumDensity::Exponential(_), ..
    }) = outside.map(|id| &media[id as usize])
        && medium.extinction() != Vec3::ZERO
    {
        return Err(kind.refuse(
            "no sky where outside_medium has no end, as its light would not get through: put the medium inside a box of \
             { dielectric = { index = 1 } }",
        ));
    }
    let turn = match table.optional("turn") {
        Some(field) => field.number("an angle in -360..=360 degrees", |angle| angle.abs() <= 360.0)?,
        None => 0.0,
    };
    let picture = table.optional("picture");
    let repair = table.optional("repair");
    if let (Some(field), None) = (&repair, &picture) {
        return Err(field.refuse("no such field without `picture`"));
    }
    let repairs = repair.map_or(Ok(false), |field| field.boolean())?;
    let (cells, columns) = match &picture {
        Some(field) => read_sky_picture(field, files, repairs, notes)?,
        None => (vec![Vec3::ONE], 1),
    };
    let cells: Vec<Vec3> = cells.into_iter().map(|cell| radiance * cell).collect();
    if cells.iter().all(|cell| *cell == Vec3::ZERO) {
        return Err(picture.unwrap_or(kind).refuse("a sky that is not dark"));
    }
    // Upright in a scene whose y axis points up: x in the middle, z to its right.
    let upright = Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y);
    let turn = upright * Mat3::from_rotation_y(-turn.to_radians());
    let sky = Sky::new((cells, columns, turn), objects, media, outside);
    sky.map(Light::Sky)
        .ok_or_else(|| kind.refuse("an object, or a medium with an end, that the sky could shine on"))
}

/// Radiance of the cells of a sky, and how many a row has.
///
/// - `repairs`: whether bad pixels are replaced, which `notes` then says.
fn read_sky_picture(
    field: &Field<'_>,
    files: &SceneFiles<'_>,
    repairs: bool,
    notes: &mut Vec<String>,
) -> Result<(Vec<Vec3>, usize), SceneError> {
    let path = files.path(field, "an EXR file")?;
    // A device or a pipe may never end.
    if !path.is_file() {
        return Err(field.refuse("a regular file"));
    }
    let picture = read_picture_up_to(&path, MOST_PIXELS)
        .map_err(|error| field.refuse(format!("an EXR picture, but {error}")))?;
    let columns = picture.width as usize;
    let Some(bad) = find_bad(&picture.radiance, columns) else { return Ok((picture.radiance, columns)) };
    let [x, y] = bad.at;
    let found = format!("{} is {} at pixel ({x}, {y}) of {}", bad.channel, bad.value, path.display());
    if !repairs {
        return Err(field.refuse(format!(
            "a picture of numbers in 0..=1e9, but {found}; {} of its pixels have such numbers: `repair = true` replaces \
             them from what is around them",
            bad.pixels
        )));
    }
    let cells = repaired(&picture.radiance, columns).ok_or_else(|| {
        field.refuse(format!("sound numbers within 8 pixels of all that are not in 0..=1e9, but {found}"))
    })?;
    notes.push(format!(
        "{}: {} pixels have numbers that are not in 0..=1e9 (the first: {found}): replaced from what is around them",
        field.path, bad.pixels
    ));
    Ok((cells, columns))
}
