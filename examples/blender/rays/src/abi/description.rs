//! Scenes, from the plain structs that describe one.

use super::geometry::GEOMETRY;
use super::memory::{array, free, new_handle, object};
use super::run;
use crate::describe::{CameraFields, Description, Light, LightFields, MaterialFields, Volume, VolumeFields};
use crate::failure::Result;
use crate::geometry::Geometry;
use core::ffi::c_void;
use covbeam_session::scene::Scene;
use std::sync::Arc;

/// Of handles.
pub(super) const SCENE: u64 = u64::from_ne_bytes(*b"scenery\0");

/// A volume with its arrays.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_rays_volume {
    /// All that is a number.
    pub fields: VolumeFields,
    /// Density, one number a voxel, x first, then y, then z; NULL = 1 everywhere.
    pub densities: *const f32,
    /// Emission coefficients, one colour a voxel, in the same order; NULL = it is dark.
    pub glow: *const [f32; 3],
    /// How many volumes this is the sum of.
    pub part_count: usize,
    /// Their numbers.
    pub parts: *const i32,
}

/// A light with its arrays.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_rays_light {
    /// All that is a number.
    pub fields: LightFields,
    /// Triangles of a mesh.
    pub triangle_count: usize,
    /// Their corners \[m\].
    pub triangles: *const [[f32; 3]; 3],
    /// Cells of the pattern or the sky, row by row; NULL = none.
    pub cells: *const [f32; 3],
}

/// A whole scene.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_rays_description {
    /// How many materials.
    pub material_count: usize,
    /// What the materials of hits are numbers of.
    pub materials: *const MaterialFields,
    /// How many objects.
    pub object_count: usize,
    /// Of each, the number of the volume that fills it, or -1.
    pub object_volumes: *const i32,
    /// Of each, not 0 if it has an inside.
    pub object_closed: *const u8,
    /// How many volumes.
    pub volume_count: usize,
    /// The volumes.
    pub volumes: *const covbeam_rays_volume,
    /// How many lights.
    pub light_count: usize,
    /// The lights.
    pub lights: *const covbeam_rays_light,
    /// Number of the volume outside of all objects, or -1.
    pub world_volume: i32,
    /// The camera.
    pub camera: CameraFields,
}

/// Makes a scene of a geometry, which has been built, and a description, which is copied.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_scene_new(
    geometry: *const c_void,
    description: *const covbeam_rays_description,
    out: *mut *mut c_void,
) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        let geometry = object::<Geometry>(geometry, GEOMETRY, "geometry")?.built()?;
        let given = array(description, 1, "description")?[0];
        let volumes = array(given.volumes, given.volume_count, "volumes")?.iter().enumerate();
        let lights = array(given.lights, given.light_count, "lights")?.iter().enumerate();
        let description = Description {
            materials: array(given.materials, given.material_count, "materials")?,
            object_volumes: array(given.object_volumes, given.object_count, "object_volumes")?,
            object_closed: array(given.object_closed, given.object_count, "object_closed")?,
            volumes: volumes.map(|(number, given)| volume(given, number)).collect::<Result<_>>()?,
            world_volume: given.world_volume,
            lights: lights.map(|(number, given)| light(given, number)).collect::<Result<_>>()?,
            camera: given.camera,
        };
        new_handle(SCENE, Arc::new(description.scene(geometry)?), out)
    })
}

/// # Safety
/// The contract of this module.
unsafe fn volume<'a>(given: &covbeam_rays_volume, number: usize) -> Result<Volume<'a>> {
    let fields = given.fields;
    let (is_even, is_dark) = (given.densities.is_null(), given.glow.is_null());
    let count = if is_even { 0 } else { product(&fields.cells) };
    let glow_count = if is_dark { 0 } else { product(&fields.glow_cells) };
    // SAFETY: the contract of this module.
    let (densities, glow, parts) = unsafe {
        (
            array(given.densities, count, &format!("volumes[{number}].density"))?,
            array(given.glow, glow_count, &format!("volumes[{number}].glow"))?,
            array(given.parts, given.part_count, &format!("volumes[{number}].parts"))?,
        )
    };
    Ok(Volume { fields, densities: (!is_even).then_some(densities), glow: (!is_dark).then_some(glow), parts })
}

/// # Safety
/// The contract of this module.
unsafe fn light<'a>(given: &covbeam_rays_light, number: usize) -> Result<Light<'a>> {
    let fields = given.fields;
    let is_even = given.cells.is_null();
    let count = if is_even { 0 } else { product(&[fields.rows, fields.columns]) };
    // SAFETY: the contract of this module.
    let (triangles, cells) = unsafe {
        (
            array(given.triangles, given.triangle_count, &format!("lights[{number}].triangles"))?,
            array(given.cells, count, &format!("lights[{number}].cells"))?,
        )
    };
    Ok(Light { fields, triangles, cells: (!is_even).then_some(cells) })
}

/// Of counts; what is too large is refused by `array`.
fn product(counts: &[u32]) -> usize {
    counts.iter().fold(1_usize, |product, count| product.saturating_mul(*count as usize))
}

/// Frees a scene; sessions of it go on. NULL is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_scene_free(scene: *mut c_void) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe { free::<Arc<Scene>>(scene, SCENE, "scene") })
}
