//! Photons on diffuse surfaces and the radiance that they make visible. Light straight from a lamp is looked
//! up by shadow rays; lamps themselves are invisible.

use crate::kind::{ByKind, Kind};
use covbeam::Curvature;
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

/// Photons count where the normal differs by less than this cosine: others lie on another surface.
const FLAT: f32 = 0.9;

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

    /// Irradiance \[W/m²\] at a point of a surface with this normal: 2D Epanechnikov kernel over distances, no wider than the surface is
    /// [`FLAT`]. On a sphere that is as even as on a plane: the part of it within a distance d of a point has the area πd².
    pub fn irradiance(&self, point: Vec3, normal: Vec3, curvature: &Curvature) -> ByKind {
        let mut sum = ByKind::default();
        // cos θ = 1 - d²/2 of points of a unit sphere at a distance of d.
        let widest = (2.0 * (1.0 - FLAT)).sqrt() / strongest(curvature);
        if self.photons.is_empty() {
            return sum;
        }
        self.hierarchy.point_traverse(point.into(), |hierarchy, node| {
            let leaf = &hierarchy.nodes[node as usize];
            let first = leaf.first_index as usize;
            for &index in &hierarchy.primitive_indices[first..first + leaf.prim_count as usize] {
                let photon = &self.photons[index as usize];
                let radius = if photon.caustic { self.caustic_radius } else { self.radius }.min(widest);
                let q2 = photon.position.distance_squared(point) / (radius * radius);
                if q2 < 1.0 && photon.normal.dot(normal) > FLAT {
                    let kind = if photon.caustic { Kind::Focused } else { Kind::Scattered };
                    sum[kind as usize] += photon.power * (2.0 * (1.0 - q2) / (PI * radius * radius));
                }
            }
            true
        });
        sum
    }
}

/// The larger of the two principal curvatures, in size.
fn strongest(curvature: &Curvature) -> f32 {
    let Curvature { along, across, twist, .. } = *curvature;
    (0.5 * (along + across)).abs() + (0.5 * (along - across)).hypot(twist)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use covbeam::Medium;

    /// A random unit vector.
    fn normal_of(random: &mut Random) -> Vec3 {
        // Isotropic.
        Medium::default().phase.sample(Vec3::Z, [random.uniform(), random.uniform()])
    }

    #[test]
    fn the_strongest_curvature_is_that_of_the_principal_axes() {
        // A cylinder of radius ½ with axes turned by φ: 2 cos²φ, 2 sin²φ, 2 sinφ cosφ; and a saddle.
        let (sin, cos) = 0.7_f32.sin_cos();
        let tensor = |along, across, twist| Curvature { along, across, twist, ..Curvature::default() };
        let cylinder = tensor(2.0 * cos * cos, 2.0 * sin * sin, 2.0 * sin * cos);
        assert!((strongest(&cylinder) - 2.0).abs() < 1e-6);
        assert_eq!(strongest(&tensor(-3.0, 1.0, 0.0)), 3.0);
        assert_eq!(strongest(&Curvature::default()), 0.0);
    }

    /// A ball lit evenly from all sides by a watt: 1/(4πρ²) everywhere, however wide the kernel.
    #[test]
    fn light_on_a_small_ball_is_all_there() {
        const PHOTONS: u32 = 40_000;
        let ball = 0.1;
        let photons = (0..PHOTONS).map(|index| {
            let mut random = Random::new([index, 0, 0, 0]);
            let normal = normal_of(&mut random);
            let power = Vec3::splat(1.0 / PHOTONS as f32);
            SurfacePhoton { position: ball * normal, normal, power, caustic: false }
        });
        let photons: Vec<SurfacePhoton> = photons.collect();
        let curvature = Curvature { along: 1.0 / ball, across: 1.0 / ball, ..Curvature::default() };
        for radius in [0.03, 0.05, 0.2] {
            let map = SurfaceMap::build(photons.clone(), radius, radius);
            let mut sum = 0.0;
            for index in 0..64 {
                let mut random = Random::new([index, 1, 0, 0]);
                let normal = normal_of(&mut random);
                sum += map.irradiance(ball * normal, normal, &curvature)[Kind::Scattered as usize].x / 64.0;
            }
            let expected = 1.0 / (4.0 * PI * ball * ball);
            // Each of 64 disks has 900 photons or more.
            assert!((sum / expected - 1.0).abs() < 0.02, "{sum} for {expected} with a radius of {radius}");
        }
    }
}
