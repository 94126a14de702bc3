//! Kernels, their radii, and how both shrink over the passes.

pub(crate) mod options;
mod radius;
pub(crate) mod schedule;
pub(crate) mod shape;
#[cfg(test)]
mod tests;
