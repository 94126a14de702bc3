//! Shadow rays from places of a stretch to its light.

use super::stretch::Stretch;
use crate::scene::Scene;
use crate::scene::passage::{Looks, passage};
use covbeam::{Column, Medium};
use glam::Vec3;

/// Shadow rays from places of a stretch to its light.
pub(super) struct ShadowRays<'a> {
    pub(super) scene: &'a Scene,
    pub(super) fogs: &'a [Medium<'a>],
    pub(super) stretch: &'a Stretch<'a>,
    /// Of the eye ray.
    pub(super) column: &'a Column<'a>,
    /// How many there were.
    pub(super) count: u32,
}

impl ShadowRays<'_> {
    /// Radiance that a metre of the stretch scatters to the ray's start, of the light from a point of the lamp, if nothing is in its way; and
    /// the share of it that arrives, without a shadow ray where there is none.
    ///
    /// - `xi`: uniform, for the point of the lamp.
    #[inline]
    pub(super) fn ask(&mut self, distance: f32, xi: [f32; 2]) -> (Vec3, Vec3) {
        let Stretch { segment, light, .. } = self.stretch;
        let place = segment.ray.origin + distance * segment.ray.direction;
        let sent = light.flux_density(place, xi);
        let light = self.stretch.scattered(self.scene, self.column, distance, sent);
        if light == Vec3::ZERO {
            return (light, Vec3::ZERO);
        }
        self.count += 1;
        let from = sent.1;
        let arrives = match self.stretch.may_be_seen_through(self.scene) {
            true => {
                let looks = Looks::For(&self.stretch.links);
                passage(self.scene, self.fogs, segment.interior, [place, from], looks)
            }
            false if self.scene.occluded(place, from) => Vec3::ZERO,
            false => Vec3::ONE,
        };
        (light, arrives)
    }
}
