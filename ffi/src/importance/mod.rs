//! Importance: where the picture needs light paths, and what follows from it for a path.

mod add;
mod handle;
pub(crate) mod look_up;
mod merge;
#[cfg(test)]
mod tests;
mod weight_window;
