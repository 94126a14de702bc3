//! The native helper of covbeam's extension for Blender, called through ctypes by the module `covbeam_rays`: all of a render but
//! reading Blender's scene.
//!
//! - [`geometry`]: meshes and their instances, made ready on native threads ([`job`]) while the caller asks how it
//!   goes.
//! - [`cast`]: what rays hit of them, for those who look at what they have built.
//! - [`describe`]: all else that a scene is made of, checked and turned into what the renderer knows.
//! - [`session`]: passes and pictures of a scene, by covbeam-render.
//! - [`abi`]: the C interface, and all unsafe code.

pub mod abi;
pub mod cast;
pub mod describe;
pub mod failure;
pub mod geometry;
pub mod job;
pub mod mesh;
pub mod picture;
pub mod session;
pub mod threads;
