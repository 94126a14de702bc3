//! The native helper of covbeam's extension for Blender, called through ctypes by the module `covbeam_rays`: what would
//! be a loop in Python for each ray.
//!
//! - [`geometry`]: meshes and their instances, made ready on native threads ([`job`]) while the caller asks how it
//!   goes.
//! - [`scene`]: nearest hits, and silhouettes beside rays, found by covbeam-geometry's triangles and edges.
//! - [`tasks`]: calls of covbeam's C functions on all threads.
//! - [`abi`]: the C interface, and all unsafe code.

pub mod abi;
pub mod failure;
pub mod geometry;
pub mod instance;
pub mod job;
pub mod mesh;
pub mod records;
pub mod scene;
pub mod tasks;
pub mod threads;
pub mod wide;
