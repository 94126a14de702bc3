//! Triangle meshes. (contract stub)

/// A triangle mesh with smooth normals and its hierarchy.
#[derive(Clone, Debug)]
pub struct Mesh {}
