//! Lights of a host: it says what they send, and a described light that stands for them where that is enough.

use super::kinds::OwnLight;
use super::rays::{EmittedPhoton, LEAST_EXPECTED, expected};
use crate::random::PathSampler;
use covbeam::{EVEN_LAMP, LightField};
use glam::Vec3;

/// Most power of a photon, if all light left like this, over the flux that is described.
const MOST_POWER: f32 = 1e4;

impl OwnLight {
    /// As [`super::Light::emit_at`].
    pub(super) fn emit_at(&self, place: [f32; 2], sampler: &mut PathSampler) -> EmittedPhoton {
        // Of a point nobody draws one: those that paths draw next are the better ones.
        let xi = if self.described.has_size() { sampler.uniform_pair() } else { [0.5; 2] };
        let photon = self.host.emit(self.number, place, xi);
        // A path with more is followed in parts, each part in parts, and a pass would not end.
        let most = MOST_POWER * self.described.flux().max_element();
        EmittedPhoton {
            bandwidth: [photon.radius, photon.angular_variance],
            ..EmittedPhoton::new(
                photon.origin,
                photon.direction,
                photon.power.min(Vec3::splat(most)),
                photon.normal,
            )
        }
    }

    /// As [`super::Light::light_field`].
    pub(super) fn light_field(&self, photon: &EmittedPhoton) -> LightField {
        let [radius, angular] = photon.bandwidth;
        let angular = angular.max(EVEN_LAMP);
        match radius == 0.0 {
            true => LightField::point(photon.direction, angular),
            false => LightField::disk(photon.direction, photon.direction, radius, angular),
        }
    }

    /// As [`super::Light::flux_density`].
    pub(super) fn flux_density(&self, point: Vec3, xi: [f32; 2]) -> (Vec3, Vec3) {
        self.host.illuminate(self.number, point, xi)
    }

    /// As [`super::Light::expected`]: the mean of some points, and a little of what is described.
    pub(super) fn expected(&self, point: Vec3) -> (Vec3, Vec3) {
        let (described, from) = self.described.expected(point);
        let found = expected(self.described.has_size(), |xi| self.flux_density(point, xi).0);
        (found + LEAST_EXPECTED * described, from)
    }
}
