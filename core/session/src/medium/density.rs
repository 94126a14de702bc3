//! Where there is how much of a medium.

use crate::medium::volume::{MAX_DENSITY, Volume};
use covbeam::{ExponentialDensity, Medium};
use glam::Vec3;

/// How the relative density of a medium varies.
#[derive(Clone, Debug)]
pub enum MediumDensity {
    /// 1 everywhere.
    Uniform,
    /// Falls exponentially with height.
    Exponential(ExponentialDensity),
    /// Given by voxels; nothing outside their box.
    Grid(Volume),
}

/// Largest extinction of the channels, where the density is 1.
pub fn largest_extinction(medium: &Medium) -> f64 {
    (medium.scattering.as_dvec3() + medium.absorption.as_dvec3()).max_element()
}

/// Of some points the one where a medium that thins with height is densest, and the logarithm of its density there, if that or its product with the
/// extinction is more than [`MAX_DENSITY`]: below its origin a density grows without end.
pub fn too_dense(
    medium: &Medium,
    density: &ExponentialDensity,
    points: impl Iterator<Item = Vec3>,
) -> Option<(Vec3, f64)> {
    let height = |point: &Vec3| (point.as_dvec3() - density.origin.as_dvec3()).dot(density.up.as_dvec3());
    let lowest = points.min_by(|a, b| height(a).total_cmp(&height(b)))?;
    let logarithm = -height(&lowest) / f64::from(density.scale_height);
    let most = f64::from(MAX_DENSITY) / largest_extinction(medium).max(1.0);
    (logarithm > libm::log(most)).then_some((lowest, logarithm))
}

/// The corner of a box where an exponential density is largest.
pub fn densest_corner(density: &ExponentialDensity, (min, max): (Vec3, Vec3)) -> Vec3 {
    Vec3::select(density.up.cmpgt(Vec3::ZERO), min, max)
}
