//! Commands of the program, by name, and what they have in common.

pub(crate) mod cli;
pub(crate) mod failure;
pub(crate) mod merge;
pub(crate) mod prepare;
pub(crate) mod render;
pub(crate) mod report;
pub(crate) mod spectrum;
mod stop;
