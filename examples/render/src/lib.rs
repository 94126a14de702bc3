//! The reference host of covbeam: scene, photon and eye tracing, output, comparison.
//!
//! The feature `files`, on by default, has all that reads and writes files, and the program. Tests need it.

#![cfg_attr(
    not(feature = "files"),
    allow(dead_code, reason = "reading files and measuring take more than tracing")
)]

pub mod camera;
#[cfg(feature = "files")]
mod camera_file;
mod clearance;
mod coincident;
pub mod compare;
pub mod defaults;
#[cfg(feature = "files")]
mod exr_format;
pub mod eye;
mod faint;
#[cfg(feature = "files")]
mod fields;
pub mod film;
mod first_hits;
pub mod fogs;
mod geometry;
pub mod glow;
#[cfg(feature = "files")]
mod glow_file;
mod grids;
mod guidance;
pub mod kind;
pub mod lamps;
pub mod light;
#[cfg(feature = "files")]
mod light_file;
#[cfg(feature = "files")]
pub mod maps;
pub mod march;
mod material;
#[cfg(feature = "files")]
mod material_file;
pub mod media;
#[cfg(feature = "files")]
mod medium_file;
pub mod memory;
mod near;
pub mod nesting;
pub mod operators;
pub mod optics;
mod origin;
#[cfg(feature = "files")]
pub mod output;
pub mod pass;
mod passage;
pub mod photon;
pub mod placed;
pub mod plan;
#[cfg(feature = "files")]
pub mod plot;
#[cfg(feature = "files")]
pub mod prepared;
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
#[cfg(feature = "files")]
mod scene_files;
#[cfg(feature = "files")]
pub mod shard;
pub mod shown;
pub mod sight;
#[cfg(feature = "files")]
mod sky_picture;
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
