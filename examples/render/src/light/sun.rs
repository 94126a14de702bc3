//! A disk infinitely far away: the sun, the moon, or a light that is as good as parallel.

use super::EmittedPhoton;
use super::stretch::{in_cone, in_cylinder};
use crate::geometry::{intersect_box, unite};
use crate::random::PathSampler;
use crate::scene::{MediumDensity, Object, SceneMedium};
use covbeam::LightField;
use covbeam_geometry::MAX_COORDINATE;
use glam::{DVec3, Vec3};
use std::f32::consts::{PI, TAU};

/// Share of the photons that are sent to the media, where a scene is larger than these.
const AIMED: f32 = 0.75;

/// How much larger than the media a scene is for that.
const LARGER: f32 = 1.1;

/// Scale heights of a medium that thins with height, above which it is left out: 3e-4 of its depth.
const HEIGHTS: f32 = 8.0;

/// Light starts this share of the scene's diagonal ahead of it, so as not to start on its sides.
const AHEAD: f32 = 1e-3;

/// A sun. Its light fills a cylinder around all that the scene has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// In which the light of its middle travels, unit.
    pub direction: Vec3,
    /// Half of the angle that it is seen under \[rad\], in [0, π/4].
    pub angle: f32,
    /// W/m² per channel, across `direction`.
    pub irradiance: Vec3,
    aim: Aim,
}

/// What a sun shines on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Aim {
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
    /// None: nothing that a sun could shine on.
    fn at(objects: &[Object], media: &[SceneMedium], outside: Option<u32>) -> Option<Self> {
        let all = objects.iter().map(|object| object.shape.bounds()).reduce(unite);
        let filled = objects.iter().filter(|object| object.inside.is_some());
        let filled = filled.map(|object| object.shape.bounds()).reduce(unite);
        // Of what is outside of objects: where it is, and all that the sun's light meets of it.
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
        let diagonal = (max - min).length();
        let margin = (AHEAD * diagonal).max(1.0 / MAX_COORDINATE);
        let (min, max) = (min - margin, max + margin);
        let center = 0.5 * (low + high);
        let outer = (center - min).abs().max((max - center).abs()).length();
        let inner = 0.5 * (high - low).length() + margin;
        let inner = if LARGER * inner < outer { inner } else { outer };
        Some(Self { center, inner, outer, min, max })
    }
}

impl Sun {
    /// A sun that shines on a scene's objects, and on its media where they are; `outside`: the one that is outside of objects. None where
    /// there is nothing of either.
    pub(crate) fn new(
        (direction, angle, irradiance): (Vec3, f32, Vec3),
        objects: &[Object],
        media: &[SceneMedium],
        outside: Option<u32>,
    ) -> Option<Self> {
        Some(Self { direction, angle, irradiance, aim: Aim::at(objects, media, outside)? })
    }

    /// Box of all that it shines on.
    pub(super) fn bounds(&self) -> (Vec3, Vec3) {
        (self.aim.min, self.aim.max)
    }

    /// Share of the photons that are aimed at the media.
    fn aimed(&self) -> f32 {
        if self.aim.inner < self.aim.outer { AIMED } else { 1.0 }
    }

    /// What the photons have that are sent to the media; all light that the cylinder holds may be far more.
    pub(super) fn flux(&self) -> Vec3 {
        self.irradiance * (PI * self.aim.inner * self.aim.inner / self.aimed())
    }

    /// Middle of what it shines on, and how far that reaches.
    pub(super) fn middle(&self) -> (Vec3, f32) {
        (self.aim.center, 2.0 * self.aim.outer)
    }

    /// A point ahead of the scene.
    pub(super) fn position(&self) -> Vec3 {
        self.aim.center - 4.0 * self.aim.outer * self.direction
    }

    /// A direction of the light, evenly over the disk that the sun is; (0, 0): of its middle.
    fn direction(&self, [u, v]: [f32; 2]) -> DVec3 {
        // The height of the cap is 2 sin²(angle/2), of which 1 - cos would leave little.
        let fall = f64::from(u) * 2.0 * (0.5 * f64::from(self.angle)).sin().powi(2);
        let sine = (fall * (2.0 - fall)).sqrt();
        let (sin_phi, cos_phi) = (f64::from(TAU) * f64::from(v)).sin_cos();
        let axis = self.direction.as_dvec3().normalize();
        let (e, f) = axis.any_orthonormal_pair();
        (sine * cos_phi * e + sine * sin_phi * f + (1.0 - fall) * axis).normalize()
    }

    /// Light that crosses a small ball over the ball's cross section: directions lie aslant to the axis, by (1 + cos)/2 on average.
    fn flux_across(&self) -> Vec3 {
        self.irradiance * (2.0 / (1.0 + self.angle.cos()))
    }

    /// The photon of a place in the unit square, which says where on the disks across the light; its direction is drawn by `sampler`.
    pub(super) fn emit_at(&self, [a, b]: [f32; 2], sampler: &mut PathSampler) -> EmittedPhoton {
        let Aim { center, inner, outer, min, max } = self.aim;
        let aimed = self.aimed();
        let (radius, density) = if a < aimed {
            (inner * (a / aimed).sqrt(), aimed / (PI * inner * inner))
        } else {
            let ring = (outer - inner) * (outer + inner);
            let share = ((a - aimed) / (1.0 - aimed)).min(1.0);
            ((inner * inner + ring * share).sqrt(), (1.0 - aimed) / (PI * ring))
        };
        let direction = self.direction(sampler.uniform_pair());
        let (e, f) = direction.any_orthonormal_pair();
        let (sin_phi, cos_phi) = (f64::from(TAU) * f64::from(b)).sin_cos();
        let across = center.as_dvec3() + f64::from(radius) * (cos_phi * e + sin_phi * f);
        // Where it enters the scene's box; on the disk around all where it misses the box.
        let box_hit = intersect_box(min.as_dvec3(), max.as_dvec3(), across, direction);
        let entry = box_hit.map_or(-f64::from(outer), |(near, _)| near);
        let origin = across + entry * direction;
        EmittedPhoton {
            origin: origin.as_vec3(),
            direction: direction.as_vec3().normalize(),
            power: self.flux_across() / density,
            normal: Vec3::ZERO,
        }
    }

    /// As [`super::Light::flux_density`]: light comes from ahead of the scene.
    pub(super) fn flux_density(&self, place: Vec3, xi: [f32; 2]) -> (Vec3, Vec3) {
        let direction = self.direction(xi);
        let offset = place.as_dvec3() - self.aim.center.as_dvec3();
        let along = offset.dot(direction);
        let outer = f64::from(self.aim.outer);
        let is_lit = (offset - along * direction).length_squared() < outer * outer;
        // All that the scene has is within `outer` of its middle.
        let back = (along + 2.0 * outer).max(outer);
        let from = (place.as_dvec3() - back * direction).as_vec3();
        (if is_lit { self.flux_across() } else { Vec3::ZERO }, from)
    }

    /// As [`super::Light::lit_stretch`].
    pub(super) fn lit_stretch(&self, origin: DVec3, direction: DVec3, ends: [f32; 2]) -> Option<(f32, f32)> {
        let axis = self.direction.as_dvec3().normalize();
        let (center, outer) = (self.aim.center.as_dvec3(), f64::from(self.aim.outer));
        let (sine, cosine) = f64::from(self.angle).sin_cos();
        if sine == 0.0 {
            return in_cylinder(origin - center, direction, axis, outer, ends);
        }
        // Cylinders along all its directions lie in a double cone that narrows to the disk from both sides: two cones that are wide there.
        let tip = outer / sine;
        let part = |axis: DVec3| in_cone(origin - (center - tip * axis), direction, axis, cosine, ends);
        match (part(axis), part(-axis)) {
            (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
            (one, other) => one.or(other),
        }
    }

    /// As [`super::Light::light_field`]: uniform in space; its directions fill a disk.
    pub(super) fn light_field(&self, direction: Vec3) -> LightField {
        // Below a microradian it is parallel for any scene.
        let variance = 1.0 / (PI * self.angle.max(1e-6)).powi(2);
        LightField::gaussian(direction, Vec3::ZERO, [0.0; 2], [variance; 2])
    }

    /// Its radiance in a direction of view; 0 beside it, and of a sun without an angle.
    pub(super) fn seen_along(&self, direction: Vec3) -> Vec3 {
        let sine2 = self.angle.sin().powi(2);
        // In the cross product small angles have digits that the cosine loses.
        let is_seen =
            direction.dot(self.direction) < 0.0 && direction.cross(self.direction).length_squared() < sine2;
        if is_seen { self.irradiance / (PI * sine2) } else { Vec3::ZERO }
    }

    /// Whether a photon without a history may have left it in this direction.
    pub(super) fn may_have_sent(&self, direction: Vec3) -> bool {
        direction.angle_between(self.direction) <= self.angle + 1e-3
    }
}
