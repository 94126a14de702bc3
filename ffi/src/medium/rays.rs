//! Rays in a medium: one, and arrays of them.

use crate::check::{unit, vector};
use crate::memory::{Element, Inputs, inputs};
use crate::status::Failure;
use glam::Vec3;

/// One ray in a medium.
pub(super) unsafe fn ray(origin: *const f32, direction: *const f32) -> Result<(Vec3, Vec3), Failure> {
    // SAFETY: by the caller's promise.
    let origin = vector(unsafe { Element::read(origin.cast(), "origin") }?)?;
    // SAFETY: by the caller's promise.
    let direction = unit(unsafe { Element::read(direction.cast(), "direction") }?)?;
    Ok((origin, direction))
}

/// The origins and the directions of an array of rays.
pub(super) struct Rays<'a> {
    origins: Inputs<'a, [f32; 3]>,
    directions: Inputs<'a, [f32; 3]>,
}

impl Rays<'_> {
    /// # Safety
    /// Both arrays are readable while this lives.
    pub(super) unsafe fn new(
        count: usize,
        origins: *const f32,
        origin_stride: usize,
        directions: *const f32,
        direction_stride: usize,
    ) -> Result<Self, Failure> {
        inputs!(count, origins: [f32; 3], origin_stride);
        inputs!(count, directions: [f32; 3], direction_stride);
        Ok(Self { origins, directions })
    }

    pub(super) fn get(&self, index: usize) -> Result<(Vec3, Vec3), Failure> {
        Ok((vector(self.origins.get(index))?, unit(self.directions.get(index))?))
    }
}
