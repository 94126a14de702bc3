//! Light fields, and the operators on strided arrays of them.

pub(crate) mod field;
mod fluence;
mod losses;
mod scatter;
pub(crate) mod smooth_surface;
mod sources;
mod travel;
