//! What hosts share that find out by themselves where rays meet surfaces: the reference renderer and the extension for
//! Blender.
//!
//! - [`hit`]: where a ray meets a surface.
//! - [`triangles`]: triangles in a local frame, with their hierarchy.
//! - [`mesh`]: a mesh placed in a scene, from the triangles of an [`obj`] file.

pub mod hit;
pub mod mesh;
pub mod obj;
pub mod triangles;

/// Largest magnitude of a coordinate in a scene, and the inverse of the smallest size of an object: squares and
/// products of lengths stay far inside the range of f32.
pub const MAX_COORDINATE: f32 = 1e9;
