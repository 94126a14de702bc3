//! The reference host of covbeam: scene, photon and eye tracing, output, comparison.
//!
//! The feature `files`, on by default, has all that reads and writes files, and the program. Tests need it.

#![cfg_attr(
    not(feature = "files"),
    allow(dead_code, reason = "reading files and measuring take more than tracing")
)]

pub mod camera;
mod coincident;
pub mod color;
pub mod compare;
pub mod defaults;
#[cfg(feature = "files")]
mod exr_format;
pub mod eye;
pub mod film;
pub mod fogs;
mod geometry;
pub mod glow;
mod grids;
mod guidance;
pub mod kind;
pub mod lamps;
pub mod light;
#[cfg(feature = "files")]
pub mod maps;
pub mod march;
mod material;
pub mod media;
pub mod memory;
pub mod nesting;
pub mod operators;
pub mod optics;
mod origin;
#[cfg(feature = "files")]
pub mod output;
pub mod pass;
mod passage;
pub mod photon;
mod pilot;
pub mod placed;
pub mod plan;
#[cfg(feature = "files")]
pub mod plot;
#[cfg(feature = "files")]
pub mod prepared;
#[cfg(feature = "files")]
pub mod preview;
#[cfg(feature = "files")]
pub mod progress;
pub mod radius;
pub mod random;
pub mod record;
#[cfg(feature = "files")]
pub mod regions;
pub mod render;
#[cfg(feature = "files")]
pub mod report;
pub mod samples;
pub mod scene;
#[cfg(feature = "files")]
pub mod scene_file;
pub mod settings;
#[cfg(feature = "files")]
pub mod shard;
pub mod shown;
pub mod sight;
#[cfg(feature = "files")]
pub mod spectrum;
pub mod starts;
#[cfg(feature = "files")]
pub mod stored;
mod straight;
pub mod surface;
mod survey;
mod view;
pub mod volume;
