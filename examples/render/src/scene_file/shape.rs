//! Shapes in scene files: what objects and lamps have in common.

use super::fields::{Field, SceneError, Table};
use super::files::SceneFiles;
use covbeam_geometry::MAX_COORDINATE;
use covbeam_geometry::mesh::{Mesh, Placement};
use glam::{Quat, Vec3};

/// `edge_u` and `edge_v`.
pub(crate) fn read_edges(table: &Table<'_>) -> Result<(Vec3, Vec3), SceneError> {
    let (edge_u, v_field) = (table.required("edge_u")?, table.required("edge_v")?);
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
    Ok((edge_u, edge_v))
}

pub(crate) fn read_mesh(table: &Table<'_>, files: &SceneFiles<'_>) -> Result<Mesh, SceneError> {
    let file = table.required("file")?;
    let path = files.path(&file, "an OBJ file")?;
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

/// `corner`, `edge_u` and `edge_v` of an object or of a light.
pub(crate) fn read_parallelogram(table: &Table<'_>) -> Result<(Vec3, Vec3, Vec3), SceneError> {
    let corner = table.required("corner")?.vector()?;
    let (edge_u, edge_v) = read_edges(table)?;
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
