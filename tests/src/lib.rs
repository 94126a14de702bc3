//! What checks covbeam from outside: the naive high-precision twin, hard cases, statistics.

pub mod brute_force;
pub mod energy;
pub mod figures;
pub mod fleet;
pub mod golden;
pub mod header;
pub mod kernel;
pub mod random;
pub mod rows;
pub mod session_picture;
pub mod single_scatter;
pub mod stability;
pub mod statistics;
pub mod twin;
pub mod vectors;

pub use covbeam_render::study::regions;

/// The README's example, as a test.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;
