//! Where light from infinitely far away is wanted, and how its photons are aimed there.

use crate::medium::SceneMedium;
use crate::medium::density::MediumDensity;
use crate::object::Object;
use crate::object::placed::Placed;
use covbeam_geometry::MAX_COORDINATE;
use covbeam_geometry::shape::{intersect_box, unite};
use glam::{DVec3, Vec3};
use std::f32::consts::{PI, TAU};

/// Share of the photons that are sent to the media, where a scene is larger than these.
const AIMED: f32 = 0.75;

/// How much larger than the media a scene is for that.
const LARGER: f32 = 1.1;

/// Scale heights of a medium that thins with height, above which it is left out: 3e-4 of its depth.
pub(crate) const HEIGHTS: f32 = 8.0;

/// Light starts this share of the scene's diagonal ahead of it, so as not to start on its sides.
const AHEAD: f32 = 1e-3;

/// A ball around something, for aiming at what is in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Centre.
    pub center: Vec3,
    /// > 0.
    pub radius: f32,
}

impl Ball {
    /// Around a box.
    pub fn around(min: Vec3, max: Vec3) -> Self {
        Self { center: 0.5 * (min + max), radius: 0.5 * (max - min).length() }
    }

    fn bounds(self) -> (Vec3, Vec3) {
        (self.center - self.radius, self.center + self.radius)
    }
}

/// What light from far away shines on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Aim {
    /// Of both disks across the light.
    center: Vec3,
    /// Around the media; what is beyond gets few photons.
    inner: f32,
    /// Around all.
    outer: f32,
    /// Box of all that the scene has.
    min: Vec3,
    max: Vec3,
}

impl Aim {
    /// A scene's objects, and its media where they are; `outside`: the one that is outside of objects. None: nothing that light could shine on.
    pub(super) fn at(
        objects: &[Object],
        placed: Option<&Placed>,
        media: &[SceneMedium],
        outside: Option<u32>,
    ) -> Option<Self> {
        let all = objects.iter().map(|object| object.shape.bounds());
        let all = all.chain(placed.and_then(Placed::bounds)).reduce(unite);
        let filled = objects.iter().filter(|object| object.inside.is_some());
        let filled = filled.map(|object| object.shape.bounds());
        let filled = filled.chain(placed.and_then(Placed::filled_bounds)).reduce(unite);
        // Of what is outside of objects: where it is, and all that the light meets of it.
        let (outer_medium, met) = match outside.map(|id| &media[id as usize].density) {
            Some(MediumDensity::Grid(volume)) => {
                let bounds = (volume.layout.min, volume.layout.max);
                (Some(bounds), Some(bounds))
            }
            Some(MediumDensity::Exponential(density)) => {
                let up = HEIGHTS * density.scale_height * density.up;
                let around = all.unwrap_or((density.origin, density.origin));
                (Some(around), Some(unite(around, (around.0 + up, around.1 + up))))
            }
            Some(MediumDensity::Uniform) | None => (None, None),
        };
        let (min, max) = all.into_iter().chain(met).reduce(unite)?;
        let (low, high) = filled.into_iter().chain(outer_medium).reduce(unite).unwrap_or((min, max));
        let (margin, min, max) = with_margin(min, max);
        let center = 0.5 * (low + high);
        let outer = (center - min).abs().max((max - center).abs()).length();
        let inner = 0.5 * (high - low).length() + margin;
        Some(Self::of(center, inner, outer, (min, max)))
    }

    /// A ball with all media, and one with all that a scene has.
    pub(super) fn around(media: Ball, scene: Ball) -> Self {
        let (min, max) = unite(media.bounds(), scene.bounds());
        let (margin, min, max) = with_margin(min, max);
        let outer = media.radius.max(media.center.distance(scene.center) + scene.radius) + margin;
        Self::of(media.center, media.radius + margin, outer, (min, max))
    }

    fn of(center: Vec3, inner: f32, outer: f32, (min, max): (Vec3, Vec3)) -> Self {
        let inner = if LARGER * inner < outer { inner } else { outer };
        Self { center, inner, outer, min, max }
    }

    /// Box of all that it shines on.
    pub(super) fn bounds(&self) -> (Vec3, Vec3) {
        (self.min, self.max)
    }

    /// Middle of what it shines on, and how far that reaches.
    pub(super) fn middle(&self) -> (Vec3, f32) {
        (self.center, 2.0 * self.outer)
    }

    /// Around all, from the middle.
    pub(super) fn outer(&self) -> f32 {
        self.outer
    }

    /// A point ahead of the scene, of light along `direction`.
    pub(super) fn ahead(&self, direction: Vec3) -> Vec3 {
        self.center - 4.0 * self.outer * direction
    }

    /// Share of the photons that are aimed at the media.
    fn aimed(&self) -> f32 {
        if self.inner < self.outer { AIMED } else { 1.0 }
    }

    /// What turns light across its direction into what the photons have that are sent to the media \[m²\]; all light that the scene gets may
    /// be far more.
    pub(super) fn area(&self) -> f32 {
        PI * self.inner * self.inner / self.aimed()
    }

    /// Where a photon of some direction starts: ahead of all, on a line that the numbers choose, with the probability density of that line
    /// across the light \[1/m²\].
    pub(super) fn start(&self, direction: DVec3, [a, b]: [f32; 2]) -> (Vec3, f32) {
        let Aim { center, inner, outer, min, max } = *self;
        let aimed = self.aimed();
        let (radius, density) = if a < aimed {
            (inner * (a / aimed).sqrt(), aimed / (PI * inner * inner))
        } else {
            let ring = (outer - inner) * (outer + inner);
            let share = ((a - aimed) / (1.0 - aimed)).min(1.0);
            ((inner * inner + ring * share).sqrt(), (1.0 - aimed) / (PI * ring))
        };
        let (e, f) = direction.any_orthonormal_pair();
        let (sin_phi, cos_phi) = libm::sincos(f64::from(TAU) * f64::from(b));
        let across = center.as_dvec3() + f64::from(radius) * (cos_phi * e + sin_phi * f);
        // Where it enters the scene's box; on the disk around all where it misses the box.
        let box_hit = intersect_box(min.as_dvec3(), max.as_dvec3(), across, direction);
        let entry = box_hit.map_or(-f64::from(outer), |(near, _)| near);
        ((across + entry * direction).as_vec3(), density)
    }

    /// Whether light of some direction is sent to a place, and a point ahead of the scene that it comes from.
    pub(super) fn reaches(&self, place: Vec3, direction: DVec3) -> (bool, Vec3) {
        let offset = place.as_dvec3() - self.center.as_dvec3();
        let along = offset.dot(direction);
        let outer = f64::from(self.outer);
        let is_lit = (offset - along * direction).length_squared() < outer * outer;
        // All that the scene has is within `outer` of its middle.
        let back = (along + 2.0 * outer).max(outer);
        (is_lit, (place.as_dvec3() - back * direction).as_vec3())
    }

    /// Whether a place lies ahead of the scene or at its border, where light without a history may start.
    pub(super) fn is_ahead(&self, place: Vec3) -> bool {
        let margin = 0.5 * AHEAD * (self.max - self.min).length();
        !(place.cmpgt(self.min + margin).all() && place.cmplt(self.max - margin).all())
    }
}

/// A box that is a bit larger, and by how much.
fn with_margin(min: Vec3, max: Vec3) -> (f32, Vec3, Vec3) {
    let margin = (AHEAD * (max - min).length()).max(1.0 / MAX_COORDINATE);
    (margin, min - margin, max + margin)
}
