//! Meshes and their instances.

use super::identity::Contents;
use super::{polled, refused};
use crate::handle::{Opaque, free, handle_to, run_on, shared};
use crate::heap::reserved;
use crate::memory::{Inputs, Slot, array, inputs, outputs, read_options};
use crate::session::fields::covbeam_surface_hit;
use crate::status::{Failure, covbeam_poll, covbeam_status, run};
use ::covbeam_session::describe::MeshArrays;
use ::covbeam_session::describe::cast::{HitRecord, cast};
use ::covbeam_session::describe::geometry::Geometry;
use core::ffi::c_void;

/// Meshes and where they are placed: first added, then built, then in any number of scenes.
pub struct covbeam_geometry(());

impl Opaque for covbeam_geometry {
    type Object = Kept;
    const TAG: u64 = u64::from_le_bytes(*b"cb-geome");
    const NAME: &'static str = "covbeam_geometry";
}

/// What a `covbeam_geometry` is.
#[derive(Default)]
pub(crate) struct Kept {
    pub(super) geometry: Geometry,
    pub(super) contents: Contents,
}

/// A mesh.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_mesh {
    /// sizeof(covbeam_mesh).
    pub struct_size: u32,
    /// How many materials: one, or one a triangle.
    pub material_count: u32,
    /// Numbers of materials of a description.
    pub materials: *const i32,
    /// How many vertices.
    pub position_count: usize,
    /// In the mesh's own space, three floats each, finite, up to 1e9.
    pub positions: *const f32,
    /// How many triangles.
    pub triangle_count: usize,
    /// Three numbers of vertices each, counter-clockwise seen from the front.
    pub triangles: *const i32,
    /// Unit normals of the three corners of each triangle, nine floats; NULL = shaded flat.
    pub normals: *const f32,
}

/// A mesh in one place.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_instance {
    /// By rows, affine, from the mesh's space to the world [m]. One that flattens is refused.
    pub matrix: [f64; 16],
    /// Number of the mesh: they count from 0, in the order in which they were added.
    pub mesh: u32,
    /// Number of its object in a description.
    pub object: i32,
    /// Number of the material of all of it; -1: those of its triangles.
    pub material: i32,
}

/// What has been built.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_geometry_info {
    /// Triangles of all meshes, each counted once however many instances it has.
    pub triangle_count: u64,
    /// Memory held [bytes].
    pub memory: u64,
    /// Lower corner of a box around all instances [m]; 0 without any.
    pub min: [f32; 3],
    /// Upper corner.
    pub max: [f32; 3],
}

impl From<HitRecord> for covbeam_surface_hit {
    fn from(hit: HitRecord) -> Self {
        let HitRecord { distance, position, geometric_normal, normal, material, object } = hit;
        Self { distance, position, geometric_normal, normal, material, object }
    }
}

/// Makes an empty geometry.
///
/// @param out the handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_geometry_new(out: *mut *mut covbeam_geometry) -> covbeam_status {
    run(|| {
        Slot::new(out, "out")?.set(handle_to(Kept::default())?);
        Ok(())
    })
}

/// Frees a geometry; scenes of it go on.
///
/// @param geometry NULL is fine.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_geometry_free(geometry: *mut covbeam_geometry) -> covbeam_status {
    // SAFETY: by the caller's promise.
    unsafe { free(geometry, "geometry") }
}

/// Copies a mesh. Triangles of no area are left out.
///
/// @param geometry one that has not been built.
/// @param mesh the arrays.
/// @param dropped receives the number of triangles that were left out; NULL is fine.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_geometry_add_mesh(
    geometry: *mut covbeam_geometry,
    mesh: *const covbeam_mesh,
    dropped: *mut usize,
) -> covbeam_status {
    let add = |kept: &mut Kept| {
        // SAFETY: by the caller's promise.
        let given = unsafe { read_options(mesh, size_of::<covbeam_mesh>(), "mesh") }?;
        // Before anything is added.
        let dropped = if dropped.is_null() { None } else { Some(Slot::new(dropped, "dropped")?) };
        let covbeam_mesh { material_count, position_count, triangle_count, .. } = given;
        // SAFETY: by the caller's promise.
        let arrays = unsafe {
            MeshArrays {
                positions: array(given.positions.cast(), position_count, "mesh.positions")?,
                triangles: array(given.triangles.cast(), triangle_count, "mesh.triangles")?,
                materials: array(given.materials, material_count as usize, "mesh.materials")?,
                normals: match given.normals.is_null() {
                    true => None,
                    false => Some(array(given.normals.cast(), triangle_count, "mesh.normals")?),
                },
            }
        };
        let (_, left_out) = kept.geometry.add_mesh(&arrays).map_err(refused)?;
        kept.contents.array(arrays.positions);
        kept.contents.array(arrays.triangles);
        kept.contents.array(arrays.materials);
        kept.contents.array(arrays.normals.unwrap_or_default());
        if let Some(dropped) = dropped {
            dropped.set(left_out);
        }
        Ok(())
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(geometry, "geometry", add) }
}

/// Places meshes. If one is refused, those before it are placed.
///
/// @param geometry one that has not been built.
/// @param count number of instances.
/// @param instances, instance_stride the instances.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_geometry_add_instances(
    geometry: *mut covbeam_geometry,
    count: usize,
    instances: *const covbeam_instance,
    instance_stride: usize,
) -> covbeam_status {
    let add = |kept: &mut Kept| {
        inputs!(count, instances, instance_stride);
        for index in 0..count {
            let one = instances.get(index).value;
            let covbeam_instance { ref matrix, mesh, object, material } = one;
            let added = kept.geometry.add_instance(mesh, matrix, object, material);
            added.map_err(|failure| refused(failure.of(&format!("instances[{index}]"))))?;
            kept.contents.note(&one);
        }
        Ok(())
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(geometry, "geometry", add) }
}

/// Builds the hierarchies, on native threads: once, after all meshes and instances.
///
/// @param geometry one that has not been built.
/// @param poll, user asked at least every 50 ms whether to go on; NULL: it always goes on. Where it is to stop, the geometry can
///     only be freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_geometry_build(
    geometry: *mut covbeam_geometry,
    poll: covbeam_poll,
    user: *mut c_void,
) -> covbeam_status {
    let build = |kept: &mut Kept| polled(poll, user, |go_on| kept.geometry.build(go_on));
    // SAFETY: by the caller's promise.
    unsafe { run_on(geometry, "geometry", build) }
}

/// What has been built.
///
/// @param geometry one that has been built.
/// @param info receives it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_geometry_get_info(
    geometry: *const covbeam_geometry,
    info: *mut covbeam_geometry_info,
) -> covbeam_status {
    run(|| {
        let info = Slot::new(info, "info")?;
        // SAFETY: by the caller's promise.
        let built = unsafe { shared(geometry, "geometry") }?.geometry.built().map_err(refused)?;
        let (min, max) = built.bounds();
        info.set(covbeam_geometry_info {
            triangle_count: built.triangle_count() as u64,
            memory: built.memory() as u64,
            min: min.to_array(),
            max: max.to_array(),
        });
        Ok(())
    })
}

/// The nearest hits of rays, to look at what was built.
///
/// @param geometry one that has been built.
/// @param count number of rays.
/// @param origins, origin_stride where they start, three floats each [m].
/// @param directions, direction_stride unit, three floats each.
/// @param hits, hit_stride receive what is hit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_geometry_cast(
    geometry: *const covbeam_geometry,
    count: usize,
    origins: *const f32,
    origin_stride: usize,
    directions: *const f32,
    direction_stride: usize,
    hits: *mut covbeam_surface_hit,
    hit_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let built = unsafe { shared(geometry, "geometry") }?.geometry.built().map_err(refused)?;
        inputs!(count, origins: [f32; 3], origin_stride);
        inputs!(count, directions: [f32; 3], direction_stride);
        outputs!(count, hits, hit_stride);
        let all = |vectors: &Inputs<[f32; 3]>| -> Result<Vec<[f32; 3]>, Failure> {
            let mut all = reserved(count)?;
            all.extend((0..count).map(|index| vectors.get(index).value));
            Ok(all)
        };
        let (origins, directions, mut found) = (all(&origins)?, all(&directions)?, reserved(count)?);
        found.resize(count, HitRecord::MISS);
        cast(&built, &origins, &directions, &mut found).map_err(refused)?;
        found.iter().enumerate().for_each(|(index, hit)| hits.set(index, (*hit).into()));
        Ok(())
    })
}
