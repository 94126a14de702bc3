//! A ray in the frame of what it is tested against.

use glam::Vec3;

/// A ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) origin: Vec3,
    /// Unit, as single precision has it.
    pub(crate) direction: Vec3,
    /// Where it ends: what it meets is nearer.
    pub(crate) end: f32,
}

impl Ray {
    /// One by each coordinate of the direction, of one that is too small as if it were 2^-23: never infinite.
    pub(crate) fn inverse(&self) -> Vec3 {
        let of = |d: f32| 1.0 / d.abs().max(f32::EPSILON).copysign(d);
        Vec3::new(of(self.direction.x), of(self.direction.y), of(self.direction.z))
    }
}
