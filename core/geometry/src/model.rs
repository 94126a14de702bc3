//! Triangles in a space of their own, with their materials: what instances place in a scene.

use crate::triangles::Triangles;

/// A mesh that instances place.
pub struct Model {
    triangles: Option<Triangles>,
    /// One a triangle, or one for all.
    materials: Vec<u32>,
}

impl Model {
    /// - `triangles`: None if no triangle has an area.
    /// - `materials`: the numbers that hits bear, of each triangle in the order in which [`Triangles::new`] got them, or one for all.
    pub fn new(triangles: Option<Triangles>, materials: Vec<u32>) -> Self {
        Self { triangles, materials }
    }

    /// None: there is nothing to hit.
    pub fn triangles(&self) -> Option<&Triangles> {
        self.triangles.as_ref()
    }

    /// The number given with a triangle.
    pub(crate) fn material(&self, triangle: usize) -> u32 {
        if self.materials.len() == 1 { self.materials[0] } else { self.materials[triangle] }
    }

    /// Of all that were given.
    pub(crate) fn largest_material(&self) -> u32 {
        self.materials.iter().copied().max().unwrap_or(0)
    }

    /// Memory held \[bytes\].
    pub fn memory(&self) -> usize {
        self.triangles.as_ref().map_or(0, Triangles::memory) + size_of_val(&self.materials[..])
    }
}
