//! Media that glow, as lights: their photons start anywhere in them.

use super::directions::even_direction;
use super::rays::EmittedPhoton;
use crate::medium::glow::Glow;
use crate::medium::{MediumId, SceneMedium};
use crate::random::PathSampler;
use covbeam::{EVEN_LAMP, LightField};
use glam::Vec3;
use std::sync::Arc;

/// A medium that glows. What arrives of its light has no bound next to where it starts, and is left to photons: there are no shadow rays to it.
/// Its light counts as scattered from the start.
#[derive(Clone, Debug, PartialEq)]
pub struct GlowingFog {
    medium: MediumId,
    glow: Arc<Glow>,
}

impl GlowingFog {
    /// Those of a scene's media.
    pub fn all(media: &[SceneMedium]) -> impl Iterator<Item = Self> {
        let numbered = media.iter().zip(0..);
        numbered.filter_map(|(medium, number)| Some(Self { medium: number, glow: medium.glow.clone()? }))
    }

    /// The medium: no photon starts elsewhere in the box.
    pub(crate) fn medium(&self) -> MediumId {
        self.medium
    }

    /// As [`super::Light::flux`]; of the whole box.
    pub(super) fn flux(&self) -> Vec3 {
        self.glow.flux()
    }

    pub(super) fn bounds(&self) -> (Vec3, Vec3) {
        self.glow.bounds()
    }

    pub(super) fn position(&self) -> Vec3 {
        let (min, max) = self.bounds();
        0.5 * (min + max)
    }

    /// As [`super::Light::emit_at`].
    pub(super) fn emit_at(&self, place: [f32; 2], sampler: &mut PathSampler) -> EmittedPhoton {
        let offset = [sampler.uniform(), sampler.uniform(), sampler.uniform()];
        let (origin, power) = self.glow.draw(sampler.uniform_pair(), offset);
        EmittedPhoton::new(origin, even_direction(place), power, Vec3::ZERO)
    }

    /// As [`super::Light::light_field`]: that of a ball as large as what glows.
    pub(super) fn light_field(&self, direction: Vec3) -> LightField {
        LightField::disk(direction, direction, self.glow.radius(), EVEN_LAMP)
    }

    /// As [`super::Light::middle`].
    pub(super) fn softening(&self) -> f32 {
        self.glow.radius()
    }
}
