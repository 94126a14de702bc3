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

/// How wide the kernels of a pass' surface photons are \[m\].
#[derive(Clone, Copy, Debug)]
pub struct Disks {
    /// For light that arrives diffusely.
    pub diffuse: f32,
    /// For caustics.
    pub caustic: f32,
    /// Some: these are the widest. Light that arrives diffusely is taken to be no smoother than other surfaces are far, and a caustic's disk
    /// ends at the photon after so many, at most [`CROWD`].
    pub crowd: Option<usize>,
}

/// Most photons of a caustic that a disk may be asked to end after.
pub const CROWD: usize = 8;

/// Where a photon's disk may reach.
struct Extent {
    center: Vec3A,
    radius: f32,
}

impl Boundable for Extent {
    fn aabb(&self) -> Aabb {
        Aabb::new(self.center - self.radius, self.center + self.radius)
    }
}

/// The surface photons of a pass.
pub struct SurfaceMap {
    photons: Vec<SurfacePhoton>,
    hierarchy: Bvh2,
    disks: Disks,
}

impl SurfaceMap {
    /// Of a pass' photons.
    pub fn build(photons: Vec<SurfacePhoton>, disks: Disks) -> Self {
        let extents: Vec<Extent> = photons
            .iter()
            .map(|p| Extent {
                center: p.position.into(),
                radius: if p.caustic { disks.caustic } else { disks.diffuse },
            })
            .collect();
        let hierarchy = if extents.is_empty() {
            Bvh2::default()
        } else {
            build_bvh2(&extents, BvhBuildParams::fastest_build(), &mut Duration::default())
        };
        Self { photons, hierarchy, disks }
    }

    /// Without photons.
    pub fn empty() -> Self {
        Self::build(Vec::new(), Disks { diffuse: 0.0, caustic: 0.0, crowd: None })
    }

    /// How far other surfaces narrow disks from; None: they never do.
    pub fn reach(&self) -> Option<f32> {
        (self.disks.crowd.is_some() && !self.photons.is_empty()).then_some(self.disks.diffuse)
    }

    /// Irradiance \[W/m²\] at a point of a surface with this normal: 2D Epanechnikov kernel over distances, no wider than the surface is
    /// [`FLAT`]. On a sphere that is as even as on a plane: the part of it within a distance d of a point has the area πd².
    ///
    /// - `clear`: how far other surfaces are \[m\]; counts up to [`SurfaceMap::reach`].
    pub fn irradiance(&self, point: Vec3, normal: Vec3, curvature: &Curvature, clear: f32) -> ByKind {
        let mut sum = ByKind::default();
        if self.photons.is_empty() {
            return sum;
        }
        // cos θ = 1 - d²/2 of points of a unit sphere at a distance of d.
        let widest = (2.0 * (1.0 - FLAT)).sqrt() / strongest(curvature);
        let Disks { diffuse, caustic, crowd } = self.disks;
        let diffuse = diffuse.min(clear.max(caustic)).min(widest);
        let caustic = caustic.min(widest);
        let mut nearest = crowd.map(Nearest::new);
        self.hierarchy.point_traverse(point.into(), |hierarchy, node| {
            let leaf = &hierarchy.nodes[node as usize];
            let first = leaf.first_index as usize;
            for &index in &hierarchy.primitive_indices[first..first + leaf.prim_count as usize] {
                let photon = &self.photons[index as usize];
                let radius2 = if photon.caustic { caustic * caustic } else { diffuse * diffuse };
                let distance2 = photon.position.distance_squared(point);
                if !(distance2 < radius2 && photon.normal.dot(normal) > FLAT) {
                    continue;
                }
                if !photon.caustic {
                    sum[Kind::Scattered as usize] += disk(radius2, distance2, photon.power);
                } else if let Some(nearest) = &mut nearest {
                    nearest.add(distance2, photon.power);
                } else {
                    sum[Kind::Focused as usize] += disk(radius2, distance2, photon.power);
                }
            }
            true
        });
        if let Some(nearest) = nearest {
            sum[Kind::Focused as usize] += nearest.irradiance(caustic * caustic);
        }
        sum
    }
}

/// What a photon adds within a disk around it, by their squared sizes.
fn disk(radius2: f32, distance2: f32, power: Vec3) -> Vec3 {
    power * (2.0 * (1.0 - distance2 / radius2) / (PI * radius2))
}

/// The nearest photons of a caustic, and the next one.
struct Nearest {
    crowd: usize,
    count: usize,
    /// Squared distances and powers, the nearest first.
    photons: [(f32, Vec3); CROWD + 1],
}

impl Nearest {
    fn new(crowd: usize) -> Self {
        Self { crowd: crowd.clamp(1, CROWD), count: 0, photons: Default::default() }
    }

    fn add(&mut self, distance2: f32, power: Vec3) {
        let mut at = self.count;
        if at > self.crowd {
            at = self.crowd;
            if distance2 >= self.photons[at].0 {
                return;
            }
        } else {
            self.count += 1;
        }
        while at > 0 && self.photons[at - 1].0 > distance2 {
            self.photons[at] = self.photons[at - 1];
            at -= 1;
        }
        self.photons[at] = (distance2, power);
    }

    /// Of the nearest in a disk that ends at the next one; if there is none, of all in the whole disk. Unbiased where photons are evenly
    /// spread, since how many are in a disk says nothing of where in it they are.
    fn irradiance(&self, radius2: f32) -> Vec3 {
        let count = self.count.min(self.crowd);
        let radius2 = if self.count > self.crowd { self.photons[self.crowd].0 } else { radius2 };
        self.photons[..count].iter().map(|&(distance2, power)| disk(radius2, distance2, power)).sum()
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
            let map =
                SurfaceMap::build(photons.clone(), Disks { diffuse: radius, caustic: radius, crowd: None });
            let mut sum = 0.0;
            for index in 0..64 {
                let mut random = Random::new([index, 1, 0, 0]);
                let normal = normal_of(&mut random);
                sum += map.irradiance(ball * normal, normal, &curvature, radius)[Kind::Scattered as usize].x
                    / 64.0;
            }
            let expected = 1.0 / (4.0 * PI * ball * ball);
            // Each of 64 disks has 900 photons or more.
            assert!((sum / expected - 1.0).abs() < 0.02, "{sum} for {expected} with a radius of {radius}");
        }
    }
}
