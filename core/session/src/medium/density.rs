//! Where there is how much of a medium.

use crate::medium::volume::Volume;
use covbeam::ExponentialDensity;

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
