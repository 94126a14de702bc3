//! Stretches of eye rays that a light may reach, and the light that is expected along them.

use super::guide::Guide;
use crate::color::luminance;
use crate::eye::segment::EyeSegment;
use crate::scene::media;
use crate::scene::{Light, Links, MediumDensity, Rays, Scene};
use covbeam::{Column, MARCH_KNOTS, MarchKnot, Medium};
use glam::Vec3;

/// A stretch of an eye ray that a light may reach.
pub(super) struct Stretch<'a> {
    pub(super) segment: EyeSegment,
    pub(super) fog: &'a Medium<'a>,
    pub(super) light: &'a Light,
    /// On what it falls.
    pub(super) links: Links,
    pub(super) from: f32,
    pub(super) to: f32,
    pub(super) knots: Vec<MarchKnot>,
    /// Luminance of the throughput.
    pub(super) share: f32,
    /// [`March::expected_error`](covbeam::March::expected_error) as the camera sees it.
    pub(super) error: f32,
}

impl<'a> Stretch<'a> {
    /// The part of a piece of an eye path that a light may reach; None: there is none.
    ///
    /// - `column`: of the piece in `fog`; `links`: on what the light falls, the medium among it.
    /// - `is_tabulated`: whether it is to have knots for a table of what is expected, and ends where the light's cone does.
    pub(super) fn new(
        segment: EyeSegment,
        fog: &'a Medium<'a>,
        column: &Column,
        (light, links): (&'a Light, Links),
        is_tabulated: bool,
    ) -> Option<Self> {
        let ray = segment.ray;
        let mut from = 0.0;
        let mut to = ray.length.min(media::opaque_distance(fog, ray.origin, ray.direction, column));
        if let Column::Knots(knots) = column {
            from = knots.first()?.distance.max(0.0);
            to = to.min(knots.last()?.distance);
        }
        if is_tabulated {
            (from, to) = light.lit_stretch(ray.origin, ray.direction, from, to)?;
        }
        let mut knots = vec![MarchKnot::default(); if is_tabulated { MARCH_KNOTS } else { 2 }];
        MarchKnot::lay(ray.origin, ray.direction, from, to, light.position(), &mut knots).ok()?;
        // What stands for infinity.
        to = knots[knots.len() - 1].distance;
        if !(from < to) || fog.scattering == Vec3::ZERO {
            return None;
        }
        let share = luminance(segment.throughput);
        Some(Self { segment, fog, light, links, from, to, knots, share, error: 0.0 })
    }

    /// Writes the table: the light that is expected along the stretch, and what a guide knows of it.
    ///
    /// - `number`: the light's.
    pub(super) fn tabulate(&mut self, scene: &Scene, column: &Column, number: usize, guide: Option<&Guide>) {
        let ray = self.segment.ray;
        let mut knots = std::mem::take(&mut self.knots);
        for knot in &mut knots {
            let place = ray.origin + knot.distance * ray.direction;
            let expected = self.light.expected(place);
            knot.radiance = luminance(self.scattered(scene, column, knot.distance, expected));
            if let (true, Some(guide)) = (knot.radiance > 0.0, guide) {
                guide.tell(number, place, ray.direction, knot);
            }
        }
        self.knots = knots;
    }

    /// Radiance that a metre of the stretch scatters to the ray's start if nothing is in the light's way.
    ///
    /// - `density`, `from`: the light's flux density there, and where it comes from.
    #[inline]
    pub(super) fn scattered(
        &self,
        scene: &Scene,
        column: &Column,
        distance: f32,
        (density, from): (Vec3, Vec3),
    ) -> Vec3 {
        let (fog, ray) = (self.fog, &self.segment.ray);
        let place = ray.origin + distance * ray.direction;
        if density == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let incoming = (place - from).normalize_or_zero();
        let phases = fog.phases(-incoming.dot(ray.direction));
        let amount = fog.scattering * (fog.density.at(place) * phases);
        // What other media on its way leave of light is found together with what stands there.
        let left = match self.may_be_seen_through(scene) {
            true => Vec3::ONE,
            false if scene.is_hidden(self.segment.medium, Rays::SHADOW) => Vec3::ONE,
            false => media::transmittance(fog, place, from),
        };
        density
            * self.links.falloff.at(place.distance(from))
            * amount
            * fog.transmittance(column.at(distance))
            * left
    }

    /// Whether something may let its light go straight on.
    pub(super) fn may_be_seen_through(&self, scene: &Scene) -> bool {
        self.links.passes_any() || scene.may_be_seen_through()
    }

    /// The greatest density along it.
    pub(super) fn greatest_density(&self, scene: &Scene) -> f32 {
        let ray = &self.segment.ray;
        match &scene.medium_of(self.segment.medium).density {
            MediumDensity::Uniform => 1.0,
            MediumDensity::Exponential(_) => {
                let at = |t: f32| self.fog.density.at(ray.origin + t * ray.direction);
                at(self.from).max(at(self.to))
            }
            MediumDensity::Grid(volume) => {
                volume.values.iter().fold(0.0, |most: f32, &value| most.max(value))
            }
        }
    }
}
