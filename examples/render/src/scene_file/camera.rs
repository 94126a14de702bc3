//! The camera of a scene file.

use crate::scene_file::fields::{Field, SceneError, Table};
use covbeam_geometry::MAX_COORDINATE;
use covbeam_session::camera::{Camera, Frame, Lens, Projection};
use covbeam_session::scene::MAX_IMAGE_SIDE;
use glam::Vec3;

/// Most corners of a lens' opening.
const MOST_BLADES: u32 = 1024;

pub(crate) fn read_camera(table: &Table<'_>) -> Result<Camera, SceneError> {
    let given = table.optional("projection");
    let expected = "\"perspective\", \"orthographic\", \"equirectangular\" or \"fisheye\"";
    let projection = match given.as_ref().map_or(Ok("perspective"), |field| field.text(expected))? {
        "perspective" => Projection::Perspective,
        "orthographic" => Projection::Orthographic,
        "equirectangular" => Projection::Equirectangular,
        "fisheye" => Projection::Fisheye { widest: std::f32::consts::PI },
        _ => return Err(given.expect("the default is known").refuse(expected)),
    };
    let size = if projection == Projection::Orthographic { "vertical_size" } else { "vertical_fov" };
    table.only(&["position", "look_at", "up", "projection", size, "width", "height", "near", "lens"])?;
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
    let side = 1..u64::from(MAX_IMAGE_SIDE) + 1;
    let (width, height) = (table.required("width")?, table.required("height")?);
    let pixels = [width.integer(side.clone())?, height.integer(side)?];
    let near = table.optional("near").map_or(Ok(0.0), |field| {
        field.number("a length in 0..=1e9", |near| (0.0..=MAX_COORDINATE).contains(&near))
    })?;
    Ok(Camera {
        is_own: false,
        position,
        forward: forward.as_vec3().normalize(),
        right: right.as_vec3().normalize(),
        up: right.cross(forward).as_vec3().normalize(),
        projection,
        frame: Frame::Middle { half_height: read_half_height(table, projection, pixels)? },
        width: pixels[0],
        height: pixels[1],
        near,
        lens: table.optional("lens").map(|field| read_lens(&field)).transpose()?,
    })
}

/// Half of what the picture shows from bottom to top, in the projection's unit.
fn read_half_height(
    table: &Table<'_>,
    projection: Projection,
    [width, height]: [u32; 2],
) -> Result<f32, SceneError> {
    let aspect = f64::from(width) / f64::from(height);
    let angle = |field: &Field<'_>, expected: &str, most: f64| {
        let angle = field.number(expected, |angle| (0.001..=most + 1e-4).contains(&f64::from(angle)))?;
        Ok(0.5 * f64::from(angle).to_radians())
    };
    match projection {
        Projection::Perspective => {
            let field = table.required("vertical_fov")?;
            let expected = "an angle in 0.001..=179 degrees";
            let fov = field.number(expected, |fov| (0.001..=179.0).contains(&fov))?;
            Ok(libm::tan((0.5 * f64::from(fov)).to_radians()) as f32)
        }
        Projection::Orthographic => Ok(0.5 * table.required("vertical_size")?.size()?),
        Projection::Equirectangular => {
            let most = (360.0 / aspect).min(180.0);
            let why = format!(
                "an angle in 0.001..={most:.4} degrees: up to 180 from bottom to top, and 360 all around (the default is 180)"
            );
            match table.optional("vertical_fov") {
                Some(field) => Ok(angle(&field, &why, most)? as f32),
                None if most < 180.0 => Err(table.lacks("vertical_fov", why)),
                None => Ok(std::f32::consts::FRAC_PI_2),
            }
        }
        Projection::Fisheye { .. } => {
            let most = 360.0 / libm::hypot(1.0_f64, aspect);
            let why = format!("an angle in 0.001..={most:.4} degrees: in the corners it is 360");
            Ok(angle(&table.required("vertical_fov")?, &why, most)? as f32)
        }
    }
}

fn read_lens(field: &Field<'_>) -> Result<Lens, SceneError> {
    let table = field.table()?;
    table.only(&["radius", "focus_distance", "blades", "rotation", "ratio"])?;
    let blades_field = table.optional("blades");
    let blades = blades_field.as_ref().map_or(Ok(0), |field| field.integer(0..u64::from(MOST_BLADES) + 1))?;
    if let (Some(field), 1 | 2) = (&blades_field, blades) {
        return Err(field.refuse("at least 3 blades, or 0 for a disk"));
    }
    let rotation = table.optional("rotation").map_or(Ok(0.0), |field| {
        field.number("an angle in -360..=360 degrees", |angle| angle.abs() <= 360.0)
    })?;
    Ok(Lens {
        radius: table.required("radius")?.size()?,
        focus_distance: table.required("focus_distance")?.size()?,
        blades,
        rotation: rotation.to_radians(),
        ratio: table.optional("ratio").map_or(Ok(1.0), |field| {
            field.number("a number in 0.01..=100", |ratio| (0.01..=100.0).contains(&ratio))
        })?,
    })
}
