//! The reference host of covbeam: scene, photon and eye tracing, output, comparison.

pub mod camera;
pub mod compare;
pub mod edges;
pub mod eye;
pub mod film;
pub mod geometry;
pub mod light;
pub mod mesh;
pub mod output;
pub mod pass;
pub mod photon;
pub mod random;
pub mod scene;
pub mod surface;
