//! Surfaces of lights seen from a place: points of them drawn by solid angle.

pub(crate) mod disk;
pub(crate) mod patch;
pub(crate) mod sphere;
