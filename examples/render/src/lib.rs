//! The reference host of covbeam: scene files, pictures and sums as files, and what judges pictures.

pub mod files;
pub mod progress;
pub mod scene_file;
pub mod study;
