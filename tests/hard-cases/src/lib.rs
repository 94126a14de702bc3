//! The hard cases of the light field's arithmetic and the high-precision twin that judges them, for the tests and for `covbeam report`.

pub mod random;
pub mod stability;
pub mod twin;
