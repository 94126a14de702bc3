//! Media: what they are made of, and what they do to light on its way.

pub(crate) mod column;
pub(crate) mod density;
mod flight;
pub(crate) mod kept;
pub(crate) mod knots;
pub(crate) mod options;
pub(crate) mod phase;
mod rays;
mod reach;
#[cfg(test)]
pub(crate) mod samples;
mod transmittance;
mod voxel_density;
