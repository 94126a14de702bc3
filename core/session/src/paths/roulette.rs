//! Russian roulette: ends of photons that are made up for by those that go on.

use crate::paths::photon::Photon;
use crate::paths::record::{PhotonRecord, add};
use glam::Vec3;

impl Photon {
    /// Ends it with a probability of 1 - `chance`, or makes up for the others that are ended. Returns `u`
    /// made uniform again, None if it is ended.
    ///
    /// - `u`: uniform.
    #[inline]
    pub(super) fn survive(&mut self, chance: f32, u: f32, out: &mut PhotonRecord) -> Option<f32> {
        let before = self.power;
        let lives = u < chance;
        self.power = if lives { before / chance } else { Vec3::ZERO };
        add(&mut out.energy.roulette, before - self.power);
        lives.then(|| u / chance)
    }

    /// The same, with the chance of its largest weight over its limit.
    #[inline]
    pub(super) fn survive_by_weight(&mut self, limit: Vec3, u: f32, out: &mut PhotonRecord) -> Option<f32> {
        self.survive((self.weights() / limit).max_element().min(1.0), u, out)
    }
}
