//! Where there is how much of a medium.

use crate::medium::volume::Volume;
use covbeam::ExponentialDensity;
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

/// Where of some points an exponential density is largest, and its logarithm there: below its origin it grows without end. None: no point.
pub fn densest(density: &ExponentialDensity, points: impl IntoIterator<Item = Vec3>) -> Option<(Vec3, f64)> {
    let height = |point: &Vec3| (point.as_dvec3() - density.origin.as_dvec3()).dot(density.up.as_dvec3());
    let lowest = points.into_iter().min_by(|a, b| height(a).total_cmp(&height(b)))?;
    Some((lowest, -height(&lowest) / f64::from(density.scale_height)))
}

/// The corner of a box where an exponential density is largest.
pub fn densest_corner(density: &ExponentialDensity, (min, max): (Vec3, Vec3)) -> Vec3 {
    Vec3::select(density.up.cmpgt(Vec3::ZERO), min, max)
}
