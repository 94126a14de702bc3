//! Triangle meshes, instances and exact shapes, met by rays.
//!
//! - [`hit`]: where a ray meets a surface.
//! - [`triangles`]: triangles in a local frame, four side by side, under a hierarchy of eight boxes a node.
//! - [`shape`]: spheres, rectangles, boxes and meshes, met by lines in double precision.
//! - [`mesh`]: a mesh placed in a scene, from the triangles of an [`obj`] file.
//! - [`instances`]: many [`model`]s, each placed by any number of [`instance`]s, under one such hierarchy.
#![doc = include_str!("../README.md")]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod four;
pub mod hit;
pub mod instance;
pub mod instances;
pub mod mesh;
pub mod model;
pub mod obj;
mod ray;
pub mod shape;
pub mod triangles;
mod wide;

/// Largest magnitude of a coordinate in a scene, and the inverse of the smallest size of an object: squares and
/// products of lengths stay far inside the range of f32.
pub const MAX_COORDINATE: f32 = 1e9;
