//! Descriptions of scenes.

use super::fields::*;
use super::identity::Contents;
use crate::memory::array;
use crate::status::{Failure, covbeam_status::*, fail};
use ::covbeam_geometry::shape::Shape;
use ::covbeam_session::camera::{Frame, Projection};
use ::covbeam_session::describe::{
    CameraFields, Description, Light, LightFields, LightKind, LobeFields, MaterialFields, ObjectFields,
    ShapeFields, Volume, VolumeFields,
};
use ::covbeam_session::material::Asks;
use ::covbeam_session::scene::{Rays, Sees};
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

/// The values of covbeam_rays are the bits of the session's.
const _: () = {
    use covbeam_rays::*;
    assert!(COVBEAM_RAYS_CAMERA as u32 == Rays::CAMERA.bits());
    assert!(COVBEAM_RAYS_DIFFUSE as u32 == Rays::DIFFUSE.bits());
    assert!(COVBEAM_RAYS_GLOSSY as u32 == Rays::GLOSSY.bits());
    assert!(COVBEAM_RAYS_TRANSMISSION as u32 == Rays::TRANSMISSION.bits());
    assert!(COVBEAM_RAYS_VOLUME as u32 == Rays::VOLUME.bits());
    assert!(COVBEAM_RAYS_SHADOW as u32 == Rays::SHADOW.bits());
};

/// All that a scene is made of but its placed meshes.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_description {
    /// sizeof(covbeam_description).
    pub struct_size: u32,
    /// Number of the volume outside of all objects and shapes, or -1.
    pub world_volume: i32,
    /// Not 0: pictures show the light that fog scatters into the camera and nothing else: surfaces are black, and hide or mirror the fog that is
    /// behind them.
    pub fog_alone: u32,
    /// How many materials.
    pub material_count: u32,
    /// What materials of meshes, instances and shapes are numbers of.
    pub materials: *const covbeam_material,
    /// How many objects.
    pub object_count: usize,
    /// What objects of instances are numbers of.
    pub objects: *const covbeam_object,
    /// How many shapes.
    pub shape_count: usize,
    /// Spheres, boxes and rectangles.
    pub shapes: *const covbeam_shape,
    /// How many volumes; of those that fill objects up to 64.
    pub volume_count: usize,
    /// Media and where they are.
    pub volumes: *const covbeam_volume,
    /// How many lights.
    pub light_count: usize,
    /// Lights.
    pub lights: *const covbeam_light,
    /// The camera.
    pub camera: covbeam_camera,
}

/// What the session takes; arrays stay where they are.
///
/// # Safety
/// All arrays that it names are readable while the result lives.
pub(super) unsafe fn described<'a>(
    given: &covbeam_description,
    contents: &mut Contents,
) -> Result<Description<'a>, Failure> {
    // SAFETY: by this function's contract.
    let (materials, objects, shapes, volumes, lights) = unsafe {
        (
            array(given.materials, given.material_count as usize, "description.materials")?,
            array(given.objects, given.object_count, "description.objects")?,
            array(given.shapes, given.shape_count, "description.shapes")?,
            array(given.volumes, given.volume_count, "description.volumes")?,
            array(given.lights, given.light_count, "description.lights")?,
        )
    };
    materials.iter().for_each(|material| contents.note(material));
    objects.iter().for_each(|object| contents.note(object));
    shapes.iter().for_each(|shape| contents.note(shape));
    contents.note(&(given.world_volume, given.fog_alone != 0, &given.camera));
    let shape = |(index, fields)| shape(index, fields);
    let volume = |(index, fields): (usize, &covbeam_volume)| {
        // SAFETY: by this function's contract.
        let volume = unsafe { volume(index, fields) }?;
        contents.note(&volume.fields);
        contents.array(volume.densities.unwrap_or_default());
        contents.array(volume.glow.unwrap_or_default());
        contents.array(volume.parts);
        contents.note(&volume.lobes);
        Ok(volume)
    };
    let volumes = volumes.iter().enumerate().map(volume).collect::<Result<_, Failure>>()?;
    let light = |(index, fields): (usize, &covbeam_light)| {
        // SAFETY: by this function's contract.
        let light = unsafe { light(index, fields) }?;
        contents.note(&light.fields);
        contents.array(light.triangles);
        contents.array(light.cells.unwrap_or_default());
        Ok(light)
    };
    Ok(Description {
        materials: materials.iter().enumerate().map(asking).collect::<Result<_, _>>()?,
        objects: objects.iter().map(object).collect(),
        shapes: shapes.iter().enumerate().map(shape).collect::<Result<_, _>>()?,
        lights: lights.iter().enumerate().map(light).collect::<Result<_, Failure>>()?,
        volumes,
        world_volume: given.world_volume,
        camera: camera(&given.camera)?,
        sees: if given.fog_alone == 0 { Sees::Everything } else { Sees::FogAlone },
    })
}

/// Of a material that asks nothing.
pub(super) fn material(given: &covbeam_material) -> MaterialFields {
    let covbeam_material { diffuse, translucent, metal, edge, coat, transparent, ior, alpha, .. } = *given;
    MaterialFields {
        asks: Asks::Nothing,
        diffuse,
        translucent,
        metal,
        edge,
        glass_reflection: given.glass_reflection,
        glass_transmission: given.glass_transmission,
        coat,
        transparent,
        shadow: (given.has_shadow != 0).then_some(given.shadow),
        ior: if ior == 0.0 { 1.5 } else { ior },
        roughness: alpha,
    }
}

fn asking((index, given): (usize, &covbeam_material)) -> Result<MaterialFields, Failure> {
    use covbeam_asks::*;
    let all = [
        (COVBEAM_ASKS_NOTHING, Asks::Nothing),
        (COVBEAM_ASKS_LOBES, Asks::Lobes),
        (COVBEAM_ASKS_WAYS, Asks::Ways),
    ];
    let known = all.into_iter().find(|(known, _)| *known as u32 == given.asks);
    let unknown = || no(format_args!("materials[{index}].asks: {} is no covbeam_asks", given.asks));
    known.map(|(_, asks)| MaterialFields { asks, ..material(given) }).ok_or_else(unknown)
}

fn object(given: &covbeam_object) -> ObjectFields {
    let covbeam_object { volume, hidden_from, light_set, shadow_set, .. } = *given;
    ObjectFields { volume, is_closed: given.is_closed != 0, hidden_from, light_set, shadow_set }
}

fn shape(index: usize, given: &covbeam_shape) -> Result<ShapeFields, Failure> {
    let covbeam_shape { kind, material, volume, priority, a, b, c, radius } = *given;
    let shape = match kind {
        k if k == covbeam_shape_kind::COVBEAM_SHAPE_SPHERE as u32 => {
            Shape::Sphere { center: a.into(), radius }
        }
        k if k == covbeam_shape_kind::COVBEAM_SHAPE_BOX as u32 => Shape::Box { min: a.into(), max: b.into() },
        k if k == covbeam_shape_kind::COVBEAM_SHAPE_RECTANGLE as u32 => {
            Shape::Rectangle { corner: a.into(), edge_u: b.into(), edge_v: c.into() }
        }
        other => return Err(no(format_args!("shapes[{index}].kind: {other} is no covbeam_shape_kind"))),
    };
    Ok(ShapeFields { shape, material, volume, priority })
}

fn no(message: core::fmt::Arguments) -> Failure {
    fail(COVBEAM_INVALID_VALUE, message)
}

/// # Safety
/// All arrays that it names are readable while the result lives.
unsafe fn volume<'a>(index: usize, given: &covbeam_volume) -> Result<Volume<'a>, Failure> {
    let covbeam_volume { density, glow, parts, density_cells, glow_cells, part_count, .. } = *given;
    let covbeam_volume { lobes, lobe_count, .. } = *given;
    let (is_even, is_dark) = (density.is_null(), glow.is_null());
    let named = |name: &str| format!("volumes[{index}].{name}");
    // SAFETY: by this function's contract.
    let (densities, glow, parts, lobes) = unsafe {
        (
            array(density, if is_even { 0 } else { product(&density_cells) }, &named("density"))?,
            array(glow.cast(), if is_dark { 0 } else { product(&glow_cells) }, &named("glow"))?,
            array(parts, part_count as usize, &named("parts"))?,
            array(lobes, lobe_count as usize, &named("lobes"))?,
        )
    };
    let lobe = |given: &covbeam_phase_lobe| LobeFields {
        phase: given.phase,
        asymmetry: given.asymmetry,
        share: given.share,
    };
    let lobes = lobes.iter().map(lobe).collect();
    let fields = VolumeFields {
        scattering: given.scattering,
        absorption: given.absorption,
        min: given.min,
        max: given.max,
        asymmetry: given.asymmetry,
        density_min: given.density_min,
        density_max: given.density_max,
        glow_min: given.glow_min,
        glow_max: given.glow_max,
        cells: density_cells,
        glow_cells,
        phase: given.phase,
        scale_height: given.scale_height,
        origin: given.origin,
        up: given.up,
        hidden_from: given.hidden_from,
        light_set: given.light_set,
        shadow_set: given.shadow_set,
    };
    Ok(Volume {
        fields,
        densities: (!is_even).then_some(densities),
        glow: (!is_dark).then_some(glow),
        parts,
        lobes,
    })
}

/// Of counts; what is too large no array has.
fn product(counts: &[u32]) -> usize {
    counts.iter().fold(1_usize, |product, count| product.saturating_mul(*count as usize))
}

/// # Safety
/// All arrays that it names are readable while the result lives.
unsafe fn light<'a>(index: usize, given: &covbeam_light) -> Result<Light<'a>, Failure> {
    /// Sharper than single precision knows.
    const SHARP: f64 = 1e-6;
    let covbeam_light { rows, columns, triangle_count, triangles, cells, .. } = *given;
    let is_even = cells.is_null();
    let count = if is_even { 0 } else { product(&[rows, columns]) };
    // SAFETY: by this function's contract.
    let (triangles, cells) = unsafe {
        (
            array(triangles.cast(), triangle_count, &format!("lights[{index}].triangles"))?,
            array(cells.cast(), count, &format!("lights[{index}].cells"))?,
        )
    };
    let kind = light_kind(given.kind)
        .ok_or_else(|| no(format_args!("lights[{index}].kind: {} is no covbeam_light_kind", given.kind)))?;
    let or = |value: f64, default: f64| if value == 0.0 { default } else { value };
    let fields = LightFields {
        position: given.position,
        axis: given.axis,
        u: given.u,
        v: given.v,
        intensity: given.intensity,
        radiance: given.radiance,
        irradiance: given.irradiance,
        axes: given.axes,
        radius: given.radius,
        cosine: given.cosine,
        blend: or(given.blend, SHARP),
        spread: or(given.spread, FRAC_PI_2),
        angle: given.angle,
        reach: given.reach,
        kind,
        soft: given.is_soft,
        round: given.is_round,
        rows,
        columns,
        is_visible: given.is_visible != 0,
        is_own: given.is_own != 0,
        unlit: given.unlit,
        unshadowed: given.unshadowed,
        hidden_from: given.hidden_from,
        most_events: given.most_events,
        falloff: given.falloff,
        smooth: given.smooth,
    };
    Ok(Light { fields, triangles, cells: (!is_even).then_some(cells) })
}

fn light_kind(kind: u32) -> Option<LightKind> {
    use covbeam_light_kind::*;
    let kinds = [
        (COVBEAM_LIGHT_POINT, LightKind::Point),
        (COVBEAM_LIGHT_SPOT, LightKind::Spot),
        (COVBEAM_LIGHT_AREA, LightKind::Area),
        (COVBEAM_LIGHT_SUN, LightKind::Sun),
        (COVBEAM_LIGHT_MESH, LightKind::Mesh),
        (COVBEAM_LIGHT_SKY, LightKind::Sky),
    ];
    kinds.into_iter().find(|(known, _)| *known as u32 == kind).map(|(_, kind)| kind)
}

fn projection(given: &covbeam_camera) -> Result<Projection, Failure> {
    use covbeam_projection::*;
    let projections = [
        (COVBEAM_PROJECTION_PERSPECTIVE, Projection::Perspective),
        (COVBEAM_PROJECTION_ORTHOGRAPHIC, Projection::Orthographic),
        (COVBEAM_PROJECTION_EQUIRECTANGULAR, Projection::Equirectangular),
        (COVBEAM_PROJECTION_FISHEYE, Projection::Fisheye { widest: given.widest as f32 }),
    ];
    let known = projections.into_iter().find(|(known, _)| *known as u32 == given.projection);
    let unknown = || no(format_args!("camera.projection: {} is no covbeam_projection", given.projection));
    known.map(|(_, projection)| projection).ok_or_else(unknown)
}

fn camera(given: &covbeam_camera) -> Result<CameraFields, Failure> {
    /// Below this the picture's roll would be rounding noise.
    const ALONG: f64 = 1e-3;
    let unit = |name: &str, vector: [f64; 3]| {
        let direction = DVec3::from(vector).try_normalize();
        direction.ok_or_else(|| no(format_args!("camera.{name}: {vector:?} has no direction")))
    };
    let (forward, upwards) = (unit("forward", given.forward)?, unit("up", given.up)?);
    let across = forward.cross(upwards);
    if !(across.length() >= ALONG) {
        return Err(no(format_args!("camera.up: {:?} is along forward; give another direction", given.up)));
    }
    let right = across.normalize();
    let [left, top, half_height] = [given.left, given.top, given.half_height].map(|number| number as f32);
    let step = given.step.map(|number| number as f32);
    Ok(CameraFields {
        position: given.position,
        right: right.to_array(),
        up: right.cross(forward).to_array(),
        forward: forward.to_array(),
        frame: match half_height == 0.0 {
            true => Frame::Part { left, top, step },
            false => Frame::Middle { half_height },
        },
        near: given.near,
        aperture: given.aperture,
        focus: given.focus,
        rotation: given.rotation,
        ratio: given.ratio,
        blades: given.blades,
        projection: projection(given)?,
        width: given.width,
        height: given.height,
        is_own: given.is_own != 0,
    })
}
