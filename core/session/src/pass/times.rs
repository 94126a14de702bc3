//! Time that passes take, by part.

use std::ops::AddAssign;
use std::time::Instant;

/// Core-seconds by part, and what they bought.
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
    /// The spectrum of the picture; and in the first pass, what light is worth in it.
    pub plan: f64,
    /// Eye rays, gather and shading.
    pub gather: f64,
    /// Accepted beam-ray pairs.
    pub pairs: u64,
    /// Shadow rays of the method `march`, and the rays from the lights that guide them.
    pub shadow_rays: u64,
}

impl PassTimes {
    /// Core-seconds of all parts.
    pub fn total(&self) -> f64 {
        self.trace + self.light_fields + self.grid + self.build + self.plan + self.gather
    }
}

impl AddAssign for PassTimes {
    fn add_assign(&mut self, other: Self) {
        self.trace += other.trace;
        self.light_fields += other.light_fields;
        self.grid += other.grid;
        self.build += other.build;
        self.plan += other.plan;
        self.gather += other.gather;
        self.pairs += other.pairs;
        self.shadow_rays += other.shadow_rays;
    }
}

/// What `run` returns, and the seconds that it took.
pub(super) fn timed<T>(run: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = run();
    (result, start.elapsed().as_secs_f64())
}
