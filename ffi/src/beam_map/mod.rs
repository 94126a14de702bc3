//! Beam maps: the beams of a pass, and what eye rays gather of them.

mod gather;
pub(crate) mod handle;
#[cfg(test)]
mod overhead;
mod scratch;
pub(crate) mod shaded;
