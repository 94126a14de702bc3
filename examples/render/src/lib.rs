//! The reference host of covbeam: scene files, pictures and sums as files, and what judges pictures.
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod files;
pub mod progress;
pub mod scene_file;
#[allow(clippy::disallowed_methods)] // It draws plots, no pictures.
pub mod study;
