//! Objects in a scene file: their shapes, what they are made of and what is inside of them.

use super::fields::{Field, SceneError, Table};
use super::files::SceneFiles;
use super::material::read_material;
use super::medium::read_medium_name;
use super::shape::{read_corners, read_mesh, read_parallelogram};
use covbeam_session::scene::{Material, MediumDensity, MediumId, Object, SceneMedium, Shape};

pub(crate) fn read_object(
    table: &Table<'_>,
    media: &[SceneMedium],
    names: &[&str],
    files: &SceneFiles<'_>,
) -> Result<Object, SceneError> {
    let shape_field = table.required("shape")?;
    let shape = read_shape(&shape_field, table, files)?;
    let material_field = table.required("material")?;
    let material = read_material(&material_field)?;
    if material.index().is_some() && !shape.is_closed() {
        return Err(refuse_glass(&material_field, &shape));
    }
    let inside = read_inside(table, &material, media, names)?;
    let name = match table.optional("name") {
        Some(field) => field.text("a name in quotes")?.to_owned(),
        None => shape_field.path.trim_end_matches(".shape").to_owned(),
    };
    let priority = read_priority(table, &material)?;
    Ok(Object { name, shape, material, inside, priority, inner: Vec::new() })
}

/// The shape of an object whose table has no other fields than those of its kind.
fn read_shape(field: &Field<'_>, table: &Table<'_>, files: &SceneFiles<'_>) -> Result<Shape, SceneError> {
    let expected = "\"sphere\", \"rectangle\", \"box\" or \"mesh\"";
    let kind = field.text(expected)?;
    let own: &[&str] = match kind {
        "sphere" => &["center", "radius"],
        "rectangle" => &["corner", "edge_u", "edge_v"],
        "box" => &["min", "max"],
        "mesh" => &["file", "scale", "rotate", "translate", "smooth"],
        _ => return Err(field.refuse(expected)),
    };
    table.only(&[&["name", "shape", "material", "inside", "priority"], own].concat())?;
    Ok(match kind {
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
        _ => Shape::Mesh(read_mesh(table, files)?),
    })
}

/// Why a shape is not made of glass.
fn refuse_glass(field: &Field<'_>, shape: &Shape) -> SceneError {
    let why = match shape {
        Shape::Mesh(mesh) if mesh.open_edges() > 0 => {
            format!("this mesh has {} open edges", mesh.open_edges())
        }
        Shape::Mesh(_) => "this mesh encloses nothing".to_owned(),
        _ => "a rectangle is open".to_owned(),
    };
    field.refuse(format!("a dielectric only on a closed shape ({why})"))
}

/// The medium inside of an object.
fn read_inside(
    table: &Table<'_>,
    material: &Material,
    media: &[SceneMedium],
    names: &[&str],
) -> Result<Option<MediumId>, SceneError> {
    let Some(field) = table.optional("inside") else { return Ok(None) };
    let id = read_medium_name(&field, names)?;
    if material.index().is_none() {
        return Err(field.refuse("no medium inside an object that is not a dielectric"));
    }
    if !matches!(media[id as usize].density, MediumDensity::Uniform) {
        return Err(field.refuse("a medium without `density`: inside objects media are homogeneous"));
    }
    Ok(Some(id))
}

fn read_priority(table: &Table<'_>, material: &Material) -> Result<i32, SceneError> {
    match table.optional("priority") {
        Some(field) if material.index().is_none() => {
            Err(field.refuse("no priority of an object that is not a dielectric"))
        }
        Some(field) => {
            let expected = "a whole number in -1000..=1000";
            Ok(field.number(expected, |p| p.abs() <= 1000.0 && p.fract() == 0.0)? as i32)
        }
        None => Ok(0),
    }
}
