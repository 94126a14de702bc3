//! Mixtures of phase functions: where media overlap, light is scattered by any of them.

use super::{Medium, PhaseFunction};
use glam::Vec3;

/// A phase function beside a medium's own, and how much of what is scattered is spread by it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseShare {
    /// How that is spread.
    pub phase: PhaseFunction,
    /// Share of the scattering coefficient, per channel, in \[0, 1\]; all of a medium sum to no more than 1.
    pub share: Vec3,
}

impl Medium<'_> {
    /// The mean of the medium's phase functions, by their shares \[1/sr\]: per channel.
    ///
    /// - `cos_theta`: as [`PhaseFunction::evaluate`] takes it.
    ///
    /// ```
    /// use covbeam::{Medium, PhaseFunction, PhaseKind, PhaseShare, Vec3};
    /// let phase = PhaseFunction { kind: PhaseKind::Rayleigh, asymmetry: 0.0 };
    /// let haze = [PhaseShare { phase, share: Vec3::new(0.0, 0.5, 1.0) }];
    /// let medium = Medium { more: &haze, ..Medium::homogeneous(1.0, 0.0) };
    /// let [grey, blue] = [PhaseFunction::ISOTROPIC, phase].map(|phase| phase.evaluate(0.25));
    /// let found = medium.phases(0.25);
    /// assert!((found - Vec3::new(grey, 0.5 * (grey + blue), blue)).abs().max_element() < 1e-7);
    /// ```
    #[inline]
    pub fn phases(&self, cos_theta: f32) -> Vec3 {
        let own = Vec3::splat(self.phase.evaluate(cos_theta));
        if self.more.is_empty() {
            return own;
        }
        let add = |sum: Vec3, more: &PhaseShare| sum + more.share * more.phase.evaluate(cos_theta);
        self.more.iter().fold(own * self.own_share(), add)
    }

    /// Samples a direction of propagation after scattering, by the mean of the channels of [`Medium::phases`]: divided by that, these are the
    /// weight of each channel ([`Medium::sampling_weight`]).
    ///
    /// - `direction`, `xi`: as of [`PhaseFunction::sample`].
    pub fn sample_direction(&self, direction: Vec3, [first, second]: [f32; 2]) -> Vec3 {
        let mut left = first;
        for more in self.more {
            let share = mean(more.share);
            if left < share {
                return more.phase.sample(direction, [below_one(left / share), second]);
            }
            left -= share;
        }
        let own = if self.more.is_empty() { 1.0 } else { mean(self.own_share()) };
        let first = if own < 1.0 { below_one(left / own.max(f32::MIN_POSITIVE)) } else { left };
        self.phase.sample(direction, [first, second])
    }

    /// What light of each channel weighs that goes on along a direction of [`Medium::sample_direction`]: 1 on average, and 1 always where the
    /// shares of all channels are the same; at most 3.
    ///
    /// - `cos_theta`: of the direction, as [`PhaseFunction::evaluate`] takes it.
    #[inline]
    pub fn sampling_weight(&self, cos_theta: f32) -> Vec3 {
        if self.more.is_empty() {
            return Vec3::ONE;
        }
        let phases = self.phases(cos_theta);
        phases / mean(phases).max(f32::MIN_POSITIVE)
    }

    /// Variance of the angular spectrum that scattering imposes \[cycles²/rad²\], [`PhaseFunction::angular_variance`]: of light that has gone on at
    /// an angle the mean of the lobes, by how much of it each has sent there.
    ///
    /// - `cos_theta`: as [`PhaseFunction::evaluate`] takes it.
    pub fn angular_variance(&self, cos_theta: f32) -> f32 {
        if self.more.is_empty() {
            return self.phase.angular_variance();
        }
        let own = mean(self.own_share()) * self.phase.evaluate(cos_theta);
        let add = |[sum, all]: [f32; 2], more: &PhaseShare| {
            let part = mean(more.share) * more.phase.evaluate(cos_theta);
            [sum + part * more.phase.angular_variance(), all + part]
        };
        let [sum, all] = self.more.iter().fold([own * self.phase.angular_variance(), own], add);
        sum / all.max(f32::MIN_POSITIVE)
    }

    /// What is left for the medium's own phase function.
    fn own_share(&self) -> Vec3 {
        (Vec3::ONE - self.more.iter().map(|more| more.share).sum::<Vec3>()).max(Vec3::ZERO)
    }
}

fn mean(channels: Vec3) -> f32 {
    channels.element_sum() / 3.0
}

/// A share of a uniform number, as such a number.
fn below_one(number: f32) -> f32 {
    number.clamp(0.0, 1.0 - f32::EPSILON / 2.0)
}
