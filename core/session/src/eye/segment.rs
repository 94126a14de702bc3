//! Pieces of eye paths inside a medium.

use crate::scene::optics::Interior;
use covbeam::EyeRay;
use glam::Vec3;

/// Signature of paths that have met no surface.
pub(crate) const FIRST: u64 = 0;

/// A straight piece of an eye path inside a medium.
#[derive(Clone, Copy, Debug)]
pub struct EyeSegment {
    /// The piece.
    pub ray: EyeRay,
    /// Its medium.
    pub medium: u32,
    /// What the camera sees of radiance that arrives at the piece's start.
    pub throughput: Vec3,
    /// The pixel it belongs to, as the caller numbers them.
    pub pixel: u32,
    /// What it is inside of.
    pub interior: Interior,
    /// Equal for paths that have met the same surfaces in the same way; those that only bound media do not count.
    pub signature: u64,
}

impl EyeSegment {
    /// Whether it lies before the first surface that is more than a bound of media.
    pub fn is_first(&self) -> bool {
        self.signature == FIRST
    }

    /// Equal for pieces in one medium that have met the same surfaces in the same way: what lies around them is alike.
    pub(crate) fn path(&self) -> (u32, u64) {
        (self.medium, self.signature)
    }
}
