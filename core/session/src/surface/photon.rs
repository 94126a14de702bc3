//! Photons on surfaces, and hierarchies over their disks.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use std::time::Duration;

/// A photon that arrived on a diffuse surface other than straight from a light.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePhoton {
    /// Where.
    pub position: Vec3,
    /// Surface normal on the side of arrival.
    pub normal: Vec3,
    /// Flux per channel \[W\].
    pub power: Vec3,
    /// True if it came through specular surfaces only: its light may be a caustic and gets the narrow kernel.
    pub caustic: bool,
}

/// Where a photon counts at most.
struct Extent {
    center: Vec3A,
    radius: f32,
}

impl Boundable for Extent {
    fn aabb(&self) -> Aabb {
        Aabb::new(self.center - self.radius, self.center + self.radius)
    }
}

/// Over balls, by their centers and radii.
pub(super) fn hierarchy(balls: impl Iterator<Item = (Vec3, f32)>) -> Bvh2 {
    let extents: Vec<Extent> =
        balls.map(|(center, radius)| Extent { center: center.into(), radius }).collect();
    if extents.is_empty() {
        return Bvh2::default();
    }
    build_bvh2(&extents, BvhBuildParams::fastest_build(), &mut Duration::default())
}
