//! Rays of lights: photons that leave them, and rays that meet them.

use crate::random::spread;
use glam::Vec3;
use smallvec::SmallVec;
use std::f32::consts::PI;

/// A relative curvature [1/rad²] as an angular variance \[cycles²/rad²\].
pub(super) const CURVATURE: f32 = 1.0 / (4.0 * PI * PI);

/// Light that is not expected at a place, over what a light would send there that shines alike on all that it may reach.
pub(super) const LEAST_EXPECTED: f32 = 0.02;

/// A photon leaving a light.
#[derive(Clone, Copy, Debug)]
pub struct EmittedPhoton {
    /// Start.
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
    /// Flux of the light if all its light left like this photon \[W\]: emission / probability density.
    pub power: Vec3,
    /// Normal of the emitting surface, zero for a light without one.
    pub normal: Vec3,
    /// How far along its way its light begins, >= 0; what it meets before is not lit, but dims it.
    pub dark: f32,
    /// And how far along its way its light ends, > 0; infinity: nowhere.
    pub until: f32,
    /// Of lights of a host: how large it looks from along its way, and its angular variance.
    pub(super) bandwidth: [f32; 2],
}

/// Points of a light that tell what to expect of it.
const EXPECTED_POINTS: usize = 4;

/// The mean of what a light of a size or none sends to a place.
///
/// - `sends`: from the point of it that two numbers choose.
pub(super) fn expected(has_size: bool, sends: impl Fn([f32; 2]) -> Vec3) -> Vec3 {
    let points = if has_size { EXPECTED_POINTS } else { 1 };
    (0..points).map(|index| sends(spread([0.5; 2], index))).sum::<Vec3>() / points as f32
}

impl EmittedPhoton {
    /// A photon whose light is all along its way.
    pub(super) fn new(origin: Vec3, direction: Vec3, power: Vec3, normal: Vec3) -> Self {
        Self { origin, direction, power, normal, dark: 0.0, until: f32::INFINITY, bandwidth: [0.0; 2] }
    }
}

/// Places where a ray meets lamps: distance, and radiance.
pub(crate) type Meetings = SmallVec<[(f64, Vec3); 4]>;
