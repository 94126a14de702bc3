//! What checks covbeam from outside: the naive high-precision twin, hard cases, statistics.

pub mod random;
pub mod regions;
pub mod stability;
pub mod statistics;
pub mod twin;
