//! Generators of the data that the example scenes use: a church with a rose window, and a plume of smoke.
//!
//! The same bytes come out on every machine: transcendental functions come from `libm`, everything else is IEEE
//! arithmetic, and everything runs in one thread in a fixed order. README.md beside the scenes says which command
//! writes which file.

pub mod church;
pub mod fluid;
pub mod outline;
pub mod plume;
pub mod solid;
pub mod volume;
