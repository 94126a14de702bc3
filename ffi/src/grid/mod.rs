//! Covariance grids: what photons leave in them, and what a gather looks up.

pub(crate) mod cells;
mod contents;
pub(crate) mod deposit;
pub(crate) mod handle;
pub(crate) mod look_up;
pub(crate) mod merge;
mod saved;
