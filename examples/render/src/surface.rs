//! Photons on diffuse surfaces and the radiance that they make visible. Light straight from a lamp is looked
//! up by shadow rays; lamps themselves are invisible.

use crate::kind::{ByKind, Kind};
use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use std::f32::consts::PI;
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

struct Disk {
    center: Vec3A,
    radius: f32,
}

impl Boundable for Disk {
    fn aabb(&self) -> Aabb {
        Aabb::new(self.center - self.radius, self.center + self.radius)
    }
}

/// The surface photons of a pass.
pub struct SurfaceMap {
    photons: Vec<SurfacePhoton>,
    hierarchy: Bvh2,
    radius: f32,
    caustic_radius: f32,
}

impl SurfaceMap {
    /// `radius` for light that arrives diffusely, `caustic_radius` for caustics.
    pub fn build(photons: Vec<SurfacePhoton>, radius: f32, caustic_radius: f32) -> Self {
        let disks: Vec<Disk> = photons
            .iter()
            .map(|p| Disk {
                center: p.position.into(),
                radius: if p.caustic { caustic_radius } else { radius },
            })
            .collect();
        let hierarchy = if disks.is_empty() {
            Bvh2::default()
        } else {
            build_bvh2(&disks, BvhBuildParams::fastest_build(), &mut Duration::default())
        };
        Self { photons, hierarchy, radius, caustic_radius }
    }

    /// Irradiance \[W/m²\] at a point of a surface with this normal: 2D Epanechnikov kernel over the tangent plane.
    pub fn irradiance(&self, point: Vec3, normal: Vec3) -> ByKind {
        let mut sum = ByKind::default();
        if self.photons.is_empty() {
            return sum;
        }
        self.hierarchy.point_traverse(point.into(), |hierarchy, node| {
            let leaf = &hierarchy.nodes[node as usize];
            let first = leaf.first_index as usize;
            for &index in &hierarchy.primitive_indices[first..first + leaf.prim_count as usize] {
                let photon = &self.photons[index as usize];
                let radius = if photon.caustic { self.caustic_radius } else { self.radius };
                let q2 = photon.position.distance_squared(point) / (radius * radius);
                if q2 < 1.0 && photon.normal.dot(normal) > 0.9 {
                    let kind = if photon.caustic { Kind::Focused } else { Kind::Scattered };
                    sum[kind as usize] += photon.power * (2.0 * (1.0 - q2) / (PI * radius * radius));
                }
            }
            true
        });
        sum
    }
}
