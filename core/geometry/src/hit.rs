//! Where a ray meets a surface, whatever the surface is.

use covbeam::{Curvature, ProbeHit};
use glam::Vec3;

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Along the ray, > 0.
    pub distance: f32,
    /// The point, moved onto the surface.
    pub position: Vec3,
    /// Unit geometric normal, outward on closed surfaces, not flipped towards the ray.
    pub geometric_normal: Vec3,
    /// Unit shading normal (smooth on meshes), on the same side as `geometric_normal`.
    pub normal: Vec3,
    /// Of the shading normal field at the hit, positive = convex towards `normal`.
    pub curvature: Curvature,
    /// Number of the object that was hit, as its host counts.
    pub object: u32,
    /// Number of the material that was hit, as its host counts.
    pub material: u32,
    /// What a host that casts rays itself wants to find the place by when it is asked what is there: a triangle and where in it.
    pub mark: [u32; 3],
    /// Whether whoever looked for it knows that the ray meets no other surface there.
    pub is_alone: bool,
    /// How far [`Hit::leave`] moves off the surface \[scene unit\]: more than rounding can have moved `position`.
    pub offset: f32,
}

impl Hit {
    /// A start point for a ray that leaves this surface along `direction`, offset just enough that it cannot
    /// hit the same surface again at distance ~0.
    pub fn leave(&self, direction: Vec3) -> Vec3 {
        let side = if direction.dot(self.geometric_normal) < 0.0 { -self.offset } else { self.offset };
        self.position + side * self.geometric_normal
    }

    /// Whether a place lies in the surface's plane at the hit, as rounding has it: within twice [`Hit::offset`].
    pub fn lies_in_plane(&self, place: Vec3) -> bool {
        (place - self.position).dot(self.geometric_normal).abs() <= 2.0 * self.offset
    }
}

impl From<&Hit> for ProbeHit {
    fn from(hit: &Hit) -> Self {
        Self { distance: hit.distance, normal: hit.geometric_normal, offset: hit.offset }
    }
}
