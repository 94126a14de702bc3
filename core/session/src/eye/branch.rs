//! Branches of eye paths: straight pieces to the next surface, the ways on from there, and the roulette that ends them.

use crate::eye::facet::Facet;
use crate::eye::segment::{EyeSegment, FIRST};
use crate::eye::shown::Watch;
use crate::eye::starts::EyeStart;
use crate::paths::{GOING_ON, LONG_PATH};
use crate::random::{Random, mix};
use crate::scene::optics::Interior;
use crate::scene::{Rays, Scene};
use crate::surface::encounter::{Encounter, Lobe, Way};
use covbeam::EyeRay;
use covbeam_geometry::hit::Hit;
use glam::Vec3;

/// Paths lighter than this play roulette.
const LIGHT_PATH: f32 = 0.02;

/// Kinds of ways on from mirrors and boundaries of glass.
pub(super) const REFLECTED: u64 = 1;
pub(super) const REFRACTED: u64 = 2;

/// A branch of an eye path still to be followed.
pub(super) struct Branch {
    pub(super) origin: Vec3,
    pub(super) direction: Vec3,
    pub(super) throughput: Vec3,
    pub(super) interior: Interior,
    /// Surfaces met, but for those that only bound media.
    pub(super) depth: u32,
    /// Surfaces met.
    met: u32,
    signature: u64,
    /// By which it goes on from the first surface that it meets, if that is rough; None: it has met one, or any will do.
    pub(super) facet: Option<Facet>,
    pub(super) watch: Watch,
    /// Its kind.
    pub(super) ray: Rays,
}

impl Branch {
    pub(super) fn new(start: &EyeStart, is_apart: bool) -> Self {
        Self {
            origin: start.origin,
            direction: start.direction,
            throughput: Vec3::ONE,
            interior: start.interior,
            depth: 0,
            met: 0,
            signature: FIRST,
            facet: start.facet,
            watch: Watch::new(start.origin, is_apart),
            ray: Rays::CAMERA,
        }
    }

    /// Whether the branch is followed on, by roulette where it is light or long; what is gets the weight of what is not.
    #[inline]
    pub(super) fn goes_on(&mut self, random: &mut Random) -> bool {
        let weight = self.throughput.max_element();
        if weight < LIGHT_PATH {
            if random.uniform() * LIGHT_PATH >= weight {
                return false;
            }
            self.throughput *= LIGHT_PATH / weight;
        }
        // Total reflection can hold a path inside clear glass for ever.
        if self.met > LONG_PATH {
            if random.uniform() >= GOING_ON {
                return false;
            }
            self.throughput /= GOING_ON;
        }
        true
    }

    /// The way on through what only bounds media, into `interior`: as if nothing had been met.
    #[inline]
    pub(super) fn straight_on(self, hit: &Hit, interior: Interior) -> Self {
        Self { origin: hit.leave(self.direction), interior, met: self.met + 1, ..self }
    }

    /// The piece up to what is met, if it is in a medium.
    #[inline]
    pub(super) fn segment(&self, scene: &Scene, length: f32, pixel: u32) -> Option<EyeSegment> {
        let Self { origin, direction, throughput, interior, signature, .. } = *self;
        let ray = EyeRay { origin, direction, length };
        let medium = interior.medium(scene).filter(|&medium| !scene.is_hidden(medium, self.ray))?;
        Some(EyeSegment { ray, medium, throughput, pixel, interior, signature })
    }

    /// A way on from a surface of lobes.
    #[inline]
    pub(super) fn follow(&self, hit: &Hit, met: &Encounter, way: &Way) -> Self {
        // Ways by one facet go on about alike.
        let is_turned = met.is_rough() && way.lobe != Lobe::Transparent;
        let facet = self.facet.filter(|_| is_turned).map_or(0, |facet| facet.number);
        let kind = u64::from(facet) << 48 | (way.lobe as u64 + 1) << 40;
        let next = self.next(hit, way.direction, way.factor * met.narrowing(way.lobe), way.interior, kind);
        let watch = match way.lobe {
            Lobe::Transparent => self.watch,
            // Nobody asks lamps for it.
            lobe if met.is_drawn(lobe) => next.watch.of_all(),
            Lobe::GlassTransmission if met.is_rough() => next.watch.of_all(),
            _ if met.is_rough() => next.watch.of_none(),
            _ => next.watch,
        };
        let ray = way.lobe.sent_on(self.ray);
        Self { watch, ray, ..next }
    }

    /// A way on from a surface.
    ///
    /// - `weight`: of what goes on; `kind`: of the way, for the signature: [`REFLECTED`], [`REFRACTED`] or one of a lobe.
    #[inline]
    pub(super) fn next(
        &self,
        hit: &Hit,
        direction: Vec3,
        weight: Vec3,
        interior: Interior,
        kind: u64,
    ) -> Self {
        let origin = hit.leave(direction);
        Self {
            origin,
            direction,
            throughput: self.throughput * weight,
            interior,
            depth: self.depth + 1,
            met: self.met + 1,
            facet: None,
            signature: mix(self.signature ^ (u64::from(hit.object) << 2) ^ kind),
            watch: self.watch.from(origin),
            ray: if kind == REFRACTED { Rays::TRANSMISSION } else { Rays::GLOSSY },
        }
    }
}
