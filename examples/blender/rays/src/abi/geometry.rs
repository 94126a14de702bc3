//! Meshes and instances.

use super::memory::{array, array_mut, fits, free, new_handle, object, set};
use super::run;
use crate::cast::{HitRecord, cast};
use crate::geometry::Geometry;
use crate::mesh::MeshArrays;
use core::ffi::c_void;
use std::time::Duration;

/// Of handles.
pub(super) const GEOMETRY: u64 = u64::from_ne_bytes(*b"geometry");

/// Makes an empty geometry.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_geometry_new(out: *mut *mut c_void) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe { new_handle(GEOMETRY, Geometry::default(), out) })
}

/// Frees a geometry, at once even while it is built; NULL is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_geometry_free(geometry: *mut c_void) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe { free::<Geometry>(geometry, GEOMETRY, "geometry") })
}

/// Copies a mesh: `positions` 3 floats each, `triangles` 3 numbers each, `materials` one number a triangle or one for
/// all, `normals` 9 floats a triangle or NULL. Gives the mesh's number, and how many triangles of no area were
/// dropped.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_geometry_add_mesh(
    geometry: *const c_void,
    position_count: usize,
    positions: *const [f32; 3],
    triangle_count: usize,
    triangles: *const [i32; 3],
    material_count: usize,
    materials: *const i32,
    normals: *const [[f32; 3]; 3],
    mesh: *mut u32,
    dropped: *mut usize,
) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        fits(mesh, 1, "mesh")?;
        fits(dropped, 1, "dropped")?;
        let arrays = MeshArrays {
            positions: array(positions, position_count, "positions")?,
            triangles: array(triangles, triangle_count, "triangles")?,
            materials: array(materials, material_count, "materials")?,
            normals: match normals.is_null() {
                true => None,
                false => Some(array(normals, triangle_count, "normals")?),
            },
        };
        let (number, count) = object::<Geometry>(geometry, GEOMETRY, "geometry")?.add_mesh(&arrays)?;
        set(mesh, number, "mesh")?;
        set(dropped, count, "dropped")
    })
}

/// Places a mesh: `matrix` is 4x4 by rows, mesh to world; `material` -1 leaves the triangles theirs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_geometry_add_instance(
    geometry: *const c_void,
    mesh: u32,
    matrix: *const f64,
    object_number: i32,
    material: i32,
) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        let geometry = object::<Geometry>(geometry, GEOMETRY, "geometry")?;
        let mut rows = [0.0; 16];
        rows.copy_from_slice(array(matrix, 16, "matrix")?);
        geometry.add_instance(mesh, &rows, object_number, material)
    })
}

/// Starts building.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_geometry_build(geometry: *const c_void) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe { object::<Geometry>(geometry, GEOMETRY, "geometry")?.build() })
}

/// Waits for the build, at most so long; `done` becomes 1 if it has ended.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_geometry_wait(
    geometry: *const c_void,
    milliseconds: u32,
    done: *mut u32,
) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        fits(done, 1, "done")?;
        let longest = Duration::from_millis(milliseconds.into());
        let ended = object::<Geometry>(geometry, GEOMETRY, "geometry")?.wait(longest)?;
        set(done, ended.into(), "done")
    })
}

/// Stops a build without waiting for its threads. The geometry can only be freed then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_geometry_cancel(geometry: *const c_void) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        object::<Geometry>(geometry, GEOMETRY, "geometry")?.cancel();
        Ok(())
    })
}

/// What has been built.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct covbeam_rays_info {
    /// Triangles of all meshes.
    triangle_count: u64,
    /// Memory held \[bytes\].
    memory: u64,
    /// Lower corner of all instances.
    min: [f32; 3],
    /// Upper corner.
    max: [f32; 3],
}

/// What has been built.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_geometry_info(
    geometry: *const c_void,
    info: *mut covbeam_rays_info,
) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        let scene = object::<Geometry>(geometry, GEOMETRY, "geometry")?.built()?;
        let (min, max) = scene.bounds();
        let value = covbeam_rays_info {
            triangle_count: scene.triangle_count() as u64,
            memory: scene.memory() as u64,
            min: min.to_array(),
            max: max.to_array(),
        };
        set(info, value, "info")
    })
}

/// Casts rays: 3 floats each of `origins` and `directions`, of length 1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_geometry_cast(
    geometry: *const c_void,
    count: usize,
    origins: *const [f32; 3],
    directions: *const [f32; 3],
    hits: *mut HitRecord,
) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        let geometry = object::<Geometry>(geometry, GEOMETRY, "geometry")?.built()?;
        let (origins, directions) =
            (array(origins, count, "origins")?, array(directions, count, "directions")?);
        cast(&geometry, origins, directions, array_mut(hits, count, "hits")?)
    })
}
