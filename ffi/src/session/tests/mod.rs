//! Arguments that no host should pass: each is refused by a status and a message that says what is wrong and where.

mod border;
mod hosts;
mod meshes;
mod scenes;
mod sessions;

use super::fields::*;
use super::geometry::*;
use crate::status::covbeam_last_error;
use crate::status::covbeam_status::{self, *};
use core::ffi::CStr;
use std::ptr::{null, null_mut};

const POSITIONS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const TRIANGLES: [[i32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];
const IDENTITY: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// Of the thread's latest call that failed.
fn message() -> String {
    // SAFETY: never NULL, and ends with NUL.
    unsafe { CStr::from_ptr(covbeam_last_error()) }.to_str().expect("UTF-8").to_owned()
}

/// A call must end with this status, and a message that has all these parts.
#[track_caller]
fn refused(status: covbeam_status, wanted: covbeam_status, parts: &[&str]) {
    let message = message();
    assert_eq!(status, wanted, "{message}");
    assert!(parts.iter().all(|part| message.contains(part)), "{message} lacks one of {parts:?}");
}

fn geometry() -> *mut covbeam_geometry {
    let mut geometry = null_mut();
    // SAFETY: a local.
    assert_eq!(unsafe { covbeam_geometry_new(&mut geometry) }, COVBEAM_OK);
    geometry
}

fn mesh(
    positions: &[[f32; 3]],
    triangles: &[[i32; 3]],
    materials: &[i32],
    normals: Option<&[[[f32; 3]; 3]]>,
) -> covbeam_mesh {
    covbeam_mesh {
        struct_size: size_of::<covbeam_mesh>() as u32,
        material_count: materials.len() as u32,
        materials: materials.as_ptr(),
        position_count: positions.len(),
        positions: positions.as_ptr().cast(),
        triangle_count: triangles.len(),
        triangles: triangles.as_ptr().cast(),
        normals: normals.map_or(null(), |normals| normals.as_ptr().cast()),
    }
}

fn add(
    geometry: *mut covbeam_geometry,
    positions: &[[f32; 3]],
    triangles: &[[i32; 3]],
    materials: &[i32],
    normals: Option<&[[[f32; 3]; 3]]>,
) -> covbeam_status {
    // SAFETY: a live handle, and arrays as long as they say.
    unsafe {
        covbeam_geometry_add_mesh(geometry, &mesh(positions, triangles, materials, normals), null_mut())
    }
}

fn place(geometry: *mut covbeam_geometry, mesh: u32, matrix: [f64; 16]) -> covbeam_status {
    let instance = covbeam_instance { matrix, mesh, object: 0, material: -1 };
    // SAFETY: a live handle and a local.
    unsafe { covbeam_geometry_add_instances(geometry, 1, &instance, 0) }
}

fn built() -> *mut covbeam_geometry {
    let geometry = geometry();
    assert_eq!(add(geometry, &POSITIONS, &TRIANGLES, &[0], None), COVBEAM_OK);
    assert_eq!(place(geometry, 0, IDENTITY), COVBEAM_OK);
    // SAFETY: a live handle.
    assert_eq!(unsafe { covbeam_geometry_build(geometry, None, null_mut()) }, COVBEAM_OK);
    geometry
}
