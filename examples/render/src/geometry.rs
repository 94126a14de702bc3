//! Where a ray meets the scene. (contract stub: the real one is being written)

use crate::scene::Scene;
use covbeam::Curvature;
use glam::Vec3;

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Along the ray, > 0.
    pub distance: f32,
    /// The point, moved onto the surface.
    pub position: Vec3,
    /// Unit geometric normal, outward (see Shape), not flipped towards the ray.
    pub geometric_normal: Vec3,
    /// Unit shading normal (smooth on meshes), on the same side as `geometric_normal`.
    pub normal: Vec3,
    /// Of the shading normal field at the hit, positive = convex towards `normal`.
    pub curvature: Curvature,
    /// Index into `Scene::objects`.
    pub object: u32,
}

impl Scene {
    /// Nearest hit with distance in (0, max_distance). Self-intersection is avoided by the caller starting at
    /// [`Hit::leave`].
    pub fn intersect(&self, origin: Vec3, direction: Vec3, max_distance: f32) -> Option<Hit> {
        let _ = (origin, direction, max_distance);
        todo!()
    }

    /// True if anything lies strictly between the two points (shadow ray).
    pub fn occluded(&self, from: Vec3, to: Vec3) -> bool {
        let _ = (from, to);
        todo!()
    }

    /// The closed dielectric objects that contain `point`, outermost first.
    pub fn containing(&self, point: Vec3) -> Vec<u32> {
        let _ = point;
        todo!()
    }
}

impl Hit {
    /// A start point for a ray that leaves this surface along `direction`, offset just enough that it cannot
    /// hit the same surface again at distance ~0.
    pub fn leave(&self, direction: Vec3) -> Vec3 {
        let _ = direction;
        todo!()
    }
}
