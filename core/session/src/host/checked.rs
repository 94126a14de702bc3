//! A host's answers, checked.

use super::{HostPhoton, HostScene, HostWay, HostWays};
use crate::material::{Asks, Lobes, Material, SMOOTH};
use covbeam_geometry::MAX_COORDINATE;
use covbeam_geometry::hit::Hit;
use glam::{DVec3, Vec3};
use std::f32::consts::PI;
use std::sync::Arc;

/// How far the squared length of a unit vector may be from 1.
const UNIT: f32 = 1e-3;

/// No two places are farther apart: single precision holds the squares.
const FARTHEST: f32 = 4.0 * MAX_COORDINATE;

/// A host, and the numbers that its hits may bear. Sound, whatever it says.
#[derive(Clone, Debug)]
pub struct Host {
    scene: Arc<dyn HostScene>,
    /// Below this.
    objects: usize,
    /// And below this.
    materials: usize,
}

/// Of the same host.
impl PartialEq for Host {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.scene, &other.scene)
            && (self.objects, self.materials) == (other.objects, other.materials)
    }
}

impl Host {
    /// - `objects`, `materials`: how many numbers of each hits may bear.
    pub(crate) fn new(scene: Arc<dyn HostScene>, objects: usize, materials: usize) -> Self {
        Self { scene, objects, materials }
    }

    /// A box around all of it; None: it is no box.
    pub(crate) fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let (min, max) = self.scene.bounds();
        (min.is_finite() && max.is_finite() && min.cmple(max).all()).then_some((min, max))
    }

    /// What the host finds, if it can be a hit.
    pub(crate) fn cast(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<Hit> {
        if !is_ray(origin, direction, reach) {
            return None;
        }
        let hit = self.scene.cast(origin, direction, reach)?;
        let curvature = hit.curvature;
        let numbers =
            [curvature.along, curvature.across, curvature.twist, curvature.tangent.length_squared()];
        let is_sound = hit.distance > 0.0
            && f64::from(hit.distance) < reach
            && hit.distance <= FARTHEST
            && is_place(hit.position)
            && is_unit(hit.geometric_normal)
            && is_unit(hit.normal)
            && hit.normal.dot(hit.geometric_normal) >= 0.0
            && numbers.iter().all(|number| number.is_finite())
            && hit.offset >= 0.0
            && hit.offset <= MAX_COORDINATE
            && (hit.object as usize) < self.objects
            && (hit.material as usize) < self.materials;
        let least = f32::EPSILON * origin.abs().max_element() as f32;
        // One that does not move off the surface would be met again and again.
        let offset = if hit.offset > 0.0 { hit.offset } else { least.max(f32::MIN_POSITIVE) };
        is_sound.then_some(Hit { offset, is_alone: false, ..hit })
    }

    /// Whether anything is in the way.
    pub(crate) fn is_blocked(&self, origin: DVec3, direction: DVec3, reach: f64) -> bool {
        if !is_ray(origin, direction, reach) {
            return false;
        }
        let blocked = self.scene.is_blocked(origin, direction, reach);
        blocked.unwrap_or_else(|| self.cast(origin, direction, reach).is_some())
    }

    /// A material that asks, at a hit.
    pub(crate) fn material(&self, hit: &Hit, described: &Lobes) -> Material {
        let there = self.scene.lobes(hit, described);
        let alpha = if (0.0..=1.0).contains(&there.alpha) { there.alpha } else { described.alpha };
        let alpha = if alpha < SMOOTH { 0.0 } else { alpha };
        let cut = |there: Vec3, most: Vec3| positive(there).min(most);
        let lobes = Lobes {
            diffuse: cut(there.diffuse, described.diffuse),
            translucent: cut(there.translucent, described.translucent),
            metal: cut(there.metal, described.metal),
            edge: cut(there.edge, described.edge),
            glass_reflection: cut(there.glass_reflection, described.glass_reflection),
            glass_transmission: cut(there.glass_transmission, described.glass_transmission),
            coat: cut(there.coat, described.coat),
            transparent: cut(there.transparent, described.transparent),
            alpha,
            ..*described
        };
        match described.asks {
            Asks::Ways => Material::Lobes(lobes),
            _ => Material::of_lobes(Lobes { asks: Asks::Nothing, ..lobes }),
        }
    }

    /// Ways that all together send on no more than `most`.
    pub(crate) fn ways(&self, hit: &Hit, direction: Vec3, xi: [f32; 2], most: Vec3) -> HostWays {
        let ways = self.scene.ways(hit, direction, xi);
        let way = |way: HostWay| {
            let is_there = is_unit(way.direction) && way.factor != Vec3::ZERO;
            let deviation = if way.deviation > 0.0 { way.deviation.min(PI) } else { 0.0 };
            let factor = if is_there { positive(way.factor).min(Vec3::ONE) } else { Vec3::ZERO };
            HostWay { factor, deviation, direction: way.direction.normalize_or_zero() }
        };
        let (diffuse, translucent) = (positive(ways.diffuse), positive(ways.translucent));
        let (reflected, refracted) = (ways.reflected.map(way), way(ways.refracted));
        let sum =
            diffuse + translucent + refracted.factor + reflected.iter().map(|way| way.factor).sum::<Vec3>();
        let scale = most / sum.max(most).max(Vec3::splat(f32::MIN_POSITIVE));
        let scaled = |way: HostWay| HostWay { factor: scale * way.factor, ..way };
        HostWays {
            diffuse: scale * diffuse,
            translucent: scale * translucent,
            reflected: reflected.map(scaled),
            refracted: scaled(refracted),
        }
    }

    /// A photon of a light; one without power where there is none.
    pub(crate) fn emit(&self, light: u32, place: [f32; 2], xi: [f32; 2]) -> HostPhoton {
        let photon = self.scene.emit(light, place, xi);
        let is_sound = is_place(photon.origin) && is_unit(photon.direction);
        let is_surface = is_unit(photon.normal);
        let number = |value: f32| if value > 0.0 { value } else { 0.0 };
        HostPhoton {
            origin: if is_sound { photon.origin } else { Vec3::ZERO },
            direction: if is_sound { photon.direction.normalize() } else { Vec3::Z },
            power: if is_sound { positive(photon.power) } else { Vec3::ZERO },
            normal: if is_surface { photon.normal } else { Vec3::ZERO },
            radius: number(photon.radius).min(MAX_COORDINATE),
            angular_variance: number(photon.angular_variance).min(1e12),
        }
    }

    /// As [`HostScene::illuminate`].
    pub(crate) fn illuminate(&self, light: u32, place: Vec3, xi: [f32; 2]) -> (Vec3, Vec3) {
        let (density, from) = self.scene.illuminate(light, place, xi);
        if is_place(from) { (positive(density), from) } else { (Vec3::ZERO, place) }
    }

    /// As [`HostScene::eye`].
    pub(crate) fn eye(&self, place: [f32; 2], lens: [f32; 2]) -> Option<(Vec3, Vec3)> {
        let (origin, direction) = self.scene.eye(place, lens)?;
        (is_place(origin) && is_unit(direction)).then(|| (origin, direction.normalize()))
    }
}

/// Whether hosts are asked about it: one that is cut to nothing meets nothing, and casters may end the process where they meet a NaN.
fn is_ray(origin: DVec3, direction: DVec3, reach: f64) -> bool {
    origin.is_finite() && direction.is_finite() && reach > 0.0
}

fn is_unit(vector: Vec3) -> bool {
    (vector.length_squared() - 1.0).abs() <= UNIT
}

fn is_place(place: Vec3) -> bool {
    place.abs().max_element() <= MAX_COORDINATE && !place.is_nan()
}

/// Light: what is not a number >= 0 that single precision holds is none.
fn positive(light: Vec3) -> Vec3 {
    let number = |value: f32| if value > 0.0 && value.is_finite() { value } else { 0.0 };
    Vec3::new(number(light.x), number(light.y), number(light.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A host that ends the process where it is asked about what is no ray.
    #[derive(Debug)]
    struct Strict;

    impl HostScene for Strict {
        fn bounds(&self) -> (Vec3, Vec3) {
            (Vec3::NEG_ONE, Vec3::ONE)
        }

        fn cast(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<Hit> {
            assert!(origin.is_finite() && direction.is_normalized() && reach > 0.0);
            None
        }

        fn is_blocked(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<bool> {
            self.cast(origin, direction, reach).map(|_| true).or(Some(true))
        }
    }

    #[test]
    fn hosts_are_asked_about_rays_alone() {
        let host = Host::new(Arc::new(Strict), 1, 1);
        assert!(
            host.is_blocked(DVec3::ZERO, DVec3::X, 1.0)
                && host.cast(DVec3::ZERO, DVec3::X, f64::INFINITY).is_none()
        );
        let nowhere = DVec3::ZERO / 0.0;
        let none = [
            (DVec3::ZERO, nowhere, 1.0),
            (nowhere, DVec3::X, 1.0),
            (DVec3::ZERO, DVec3::X, 0.0),
            (DVec3::ZERO, DVec3::X, f64::NAN),
        ];
        for (origin, direction, reach) in none {
            assert!(
                host.cast(origin, direction, reach).is_none() && !host.is_blocked(origin, direction, reach)
            );
        }
    }
}
