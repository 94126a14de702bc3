//! Collisions of guided paths with a medium: as many on a segment as what it scatters is worth, spread over
//! what is lost.

use super::{Branch, LEAST, MOST, Tree};
use crate::color::mean;
use crate::paths::events::scattered;
use crate::paths::fields::CarriedField;
use crate::paths::photon::Photon;
use crate::paths::record::{PhotonRecord, add};
use crate::paths::scattering::albedo;
use crate::paths::segment::Inside;
use crate::paths::weight::channel;
use crate::random::PathSampler;
use crate::scene::bounces::Bounce;
use glam::Vec3;

/// How collisions are drawn on a segment.
struct Collisions<'s> {
    inside: &'s Inside<'s>,
    /// The columns up to the first and to the last of them.
    ends: [f32; 2],
    /// What collides between these, by channel, over what starts there.
    gone: Vec3,
    /// Shares of the channels in the mixture of their densities, by which collisions are placed.
    mixture: Vec3,
    albedo: Vec3,
    /// How many there are on average, and this time.
    expected: f32,
    count: f32,
    /// Uniform.
    shift: f32,
}

impl Collisions<'_> {
    /// The column up to one of them.
    fn column(&self, index: u32, sampler: &mut PathSampler) -> f32 {
        let (channel, _) = channel(self.mixture, sampler.uniform());
        let u = ((index as f32 + self.shift) / self.count).min(1.0 - f32::EPSILON);
        if !self.inside.dims() {
            return self.ends[0] + u * (self.ends[1] - self.ends[0]);
        }
        -libm::log1pf(-u * self.gone[channel]) / self.inside.fog.extinction()[channel]
    }

    /// Of the power at the start, what one after a column scatters.
    fn power(&self, power: Vec3, column: f32) -> Vec3 {
        let fog = self.inside.fog;
        if !self.inside.dims() {
            return power * self.albedo * self.gone * self.inside.lit(self.inside.column.distance_at(column))
                / self.expected;
        }
        let density = fog.extinction() * fog.transmittance(column);
        let drawn = (self.mixture * density / self.gone.max(Vec3::splat(f32::MIN_POSITIVE))).element_sum();
        power * self.albedo * density / (drawn * self.expected)
    }
}

impl Tree<'_, '_> {
    /// What the medium scatters on a segment.
    ///
    /// - `field`: the photon's, along the segment; `end`: of its light; `visible`: as far as it is seen.
    pub(super) fn collide(
        &mut self,
        branch: &mut Branch,
        inside: &Inside,
        field: Option<&CarriedField>,
        [end, visible]: [f32; 2],
        out: &mut PhotonRecord,
    ) {
        let Branch { ref photon, ref mut sampler, depth } = *branch;
        let ends =
            [if inside.dims() { 0.0 } else { inside.column.at(photon.dark.min(end)) }, inside.column.at(end)];
        let gone = match inside.dims() {
            true => Vec3::ONE - inside.fog.transmittance(ends[1]),
            false => inside.fog.extinction() * (ends[1] - ends[0]),
        };
        if !inside.dims() {
            add(&mut out.energy.roulette, -photon.power * gone);
        }
        let scattered = scattered(inside.fog, photon.power * gone, out);
        if !self.is_scattered(photon, Bounce::Volume, scattered, out) {
            return;
        }
        let collisions = self.collisions(photon, (inside, ends), gone, visible, sampler, depth);
        for index in 0..collisions.count as u32 {
            let mut sampler = sampler.branch();
            let column = collisions.column(index, &mut sampler);
            let distance = inside.column.distance_at(column);
            if !(distance < end && distance >= photon.dark) {
                continue;
            }
            let mut photon = photon.clone();
            let place = photon.origin + distance * photon.direction;
            let collision = self.transport.collision(inside.fog, photon.direction, place);
            photon.power = collisions.power(photon.power, column);
            if !self.keeps_field(&mut photon, &mut sampler) {
                continue;
            }
            if let (Some(_), Some(field)) = (photon.field, field) {
                photon.field = Some(field.at(distance, out));
            }
            self.scatter(&mut Branch { photon, sampler, depth }, &collision, out);
        }
    }

    /// As many collisions as what is scattered is worth.
    fn collisions<'s>(
        &self,
        photon: &Photon,
        (inside, ends): (&'s Inside<'s>, [f32; 2]),
        gone: Vec3,
        visible: f32,
        sampler: &mut PathSampler,
        depth: u32,
    ) -> Collisions<'s> {
        let dark = photon.dark.min(visible);
        let from = photon.origin + dark * photon.direction;
        let importance = self.guidance.importance();
        let found = importance.of_segment(inside.fog, from, photon.direction, visible - dark);
        let albedo = albedo(inside.fog);
        // What is lost, by the most that a collision may have of it: with the sum of the channels none of
        // them has more.
        let lost = photon.power * gone * self.most(photon.origin, depth);
        let expected = (mean(photon.power) * found.scattered / self.unit(depth))
            .max(LEAST * gone.max_element())
            .min(MOST)
            .max(lost.element_sum() * albedo.max_element());
        let count = (expected + sampler.uniform()).floor();
        let (mixture, shift) = (lost / lost.element_sum(), sampler.uniform());
        Collisions { inside, ends, gone, mixture, albedo, expected, count, shift }
    }
}
