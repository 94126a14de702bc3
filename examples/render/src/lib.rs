//! The reference host of covbeam: scene, photon and eye tracing, output, comparison.

pub mod camera;
pub mod compare;
pub mod edges;
mod exr_format;
pub mod eye;
mod fields;
pub mod film;
pub mod fog;
pub mod geometry;
pub mod light;
mod medium_file;
pub mod mesh;
pub mod obj;
pub mod operators;
pub mod optics;
pub mod output;
pub mod pass;
pub mod photon;
pub mod random;
pub mod record;
pub mod render;
pub mod scene;
pub mod scene_file;
pub mod spectrum;
pub mod surface;
pub mod volume;
