//! Directions of guided paths: of several that scattered light may take, those that are worth it.

use super::{Branch, LEAST, MOST, Tree};
use crate::color::mean;
use crate::paths::guidance::of_ray;
use crate::paths::photon::Photon;
use crate::paths::record::{PhotonRecord, Record, add};
use crate::paths::scattering::Scattering;
use crate::paths::transport::Transport;
use crate::random::{PathSampler, spread};
use covbeam::weight_window;
use glam::Vec3;
use smallvec::SmallVec;

/// Directions that are looked at for each that is expected to go on. With 8 or 16 beams are more alike, and
/// looking costs more than that is worth.
const CANDIDATES: f32 = 4.0;

/// Of a direction's expected worth, this share of the mean one's is taken for granted.
const FOR_GRANTED: f32 = 0.1;

/// Of the light fields that are scattered for the first time, this share goes on, and stands for the others:
/// scattered light is smooth, and its fields are most of what fields cost. Straight light has the edges, and
/// needs all.
const SCATTERED_FIELDS: f32 = 0.3;

impl Tree<'_, '_> {
    /// Draws directions for a photon that is scattered, and keeps those that are worth it.
    pub(super) fn scatter(&mut self, branch: &mut Branch, by: &Scattering, out: &mut PhotonRecord) {
        let Branch { ref photon, ref mut sampler, depth } = *branch;
        let place = by.place();
        let (unit, most) = (self.unit(depth), self.most(place, depth));
        let excess = (photon.power * most).max_element();
        let here = self.guidance.importance().at(place).scattered;
        let expected = CANDIDATES * mean(photon.power) * here / unit;
        let chance = expected.max(LEAST).max(excess).min(1.0);
        if sampler.uniform() >= chance {
            return;
        }
        // Each candidate goes on once at most, so that there are as many as the power asks for.
        let count = expected.min(MOST).max(excess).max(1.0).ceil().min(1e6) as usize;
        let power = photon.power / (chance * count as f32);
        let shift = sampler.uniform_pair();
        let candidates: SmallVec<[Vec3; 8]> =
            (0..count).map(|index| by.direction(spread(shift, index))).collect();
        let bounces = photon.bounces + 1;
        let importance = self.guidance.importance();
        let worth = |&direction: &Vec3| {
            let Transport { scene, ref fogs, .. } = *self.transport;
            of_ray(scene, fogs, &importance, (by.start(direction), direction), &photon.interior, bounces)
        };
        let mut factors: SmallVec<[f32; 8]> = candidates.iter().map(worth).collect();
        let granted = FOR_GRANTED * factors.iter().sum::<f32>() / count as f32;
        let least = (LEAST / count as f32).max((power * most).max_element());
        let number = |worth: f32| (mean(power) * (worth + granted) / unit).max(least).min(1.0);
        factors.iter_mut().for_each(|worth| *worth = number(*worth));
        weight_window(&mut factors, sampler.uniform());
        for (direction, factor) in candidates.into_iter().zip(factors) {
            if factor > 0.0 {
                let mut child = photon.clone();
                child.power = power * factor * by.weight(direction);
                child.scatter(self.transport.scene, by, direction);
                add(&mut out.energy.roulette, -child.power);
                self.wait(Branch { photon: child, sampler: sampler.branch(), depth }, out);
            }
        }
    }

    /// Drops the light field of most photons that are about to be scattered for the first time. False =
    /// without one the path is not wanted.
    pub(super) fn keeps_field(&self, photon: &mut Photon, sampler: &mut PathSampler) -> bool {
        if photon.field.is_none() || !photon.specular {
            return true;
        }
        if sampler.uniform() < SCATTERED_FIELDS {
            photon.stands_for /= SCATTERED_FIELDS;
        } else {
            photon.field = None;
        }
        photon.field.is_some() || self.record != Record::Field
    }
}
