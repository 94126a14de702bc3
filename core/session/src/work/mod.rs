//! Work on native threads, which a caller waits for and may stop, and how it ends.

pub mod arithmetic;
pub mod failure;
pub(crate) mod job;
pub mod threads;

/// Asked at least every 50 ms, on the thread that has called, whether to go on.
pub type GoOn<'a> = &'a mut dyn FnMut() -> bool;
