//! Renders one pass. (contract stub: being written by the project's lead)

use crate::film::PassImage;
use crate::scene::Scene;

/// How the picture is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Plain progressive photon beams.
    Ppb,
    /// The thesis: the kernel is as wide as the covariance allows.
    Adaptive,
    /// Unbiased connections of every path vertex with the camera; blind to what is seen through glass.
    LightTrace,
}

/// Seconds (summed over threads) by part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassTimes {
    /// Photon paths.
    pub trace: f64,
    /// Light fields and edge probes.
    pub light_fields: f64,
    /// Grid deposits and resolve.
    pub grid: f64,
    /// Hierarchies over beams and surface photons.
    pub build: f64,
    /// Eye rays, gather and shading.
    pub gather: f64,
    /// Accepted beam-ray pairs (a count).
    pub pairs: u64,
}

/// Renders passes of one scene with one method. `pass(i)` is a pure function of (scene, method, photons, seed, i):
/// same bits for any number of threads and any order of passes. Uses rayon's current pool.
pub struct Renderer<'a> {
    scene: &'a Scene,
}

impl<'a> Renderer<'a> {
    /// `photons` = light paths a pass.
    pub fn new(scene: &'a Scene, method: Method, photons: u32, seed: u32) -> Self {
        let _ = (method, photons, seed);
        Self { scene }
    }

    /// Pass `index`, counted from 1. `cancelled` is polled a few hundred times a pass; None = cancelled.
    pub fn pass(&mut self, index: u32, cancelled: &(dyn Fn() -> bool + Sync)) -> Option<(PassImage, PassTimes)> {
        let _ = (index, cancelled, self.scene);
        todo!()
    }
}
