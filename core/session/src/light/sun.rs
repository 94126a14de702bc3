//! A disk infinitely far away: the sun, the moon, or a light that is as good as parallel.

use super::aim::{Aim, Ball};
use super::directions::cap_direction;
use super::rays::EmittedPhoton;
use super::stretch::{in_cone, in_cylinder};
use crate::medium::SceneMedium;
use crate::object::Object;
use crate::object::placed::Placed;
use crate::random::PathSampler;
use covbeam::LightField;
use glam::{DVec3, Vec3};
use std::f32::consts::PI;

/// A sun. Its light fills a cylinder around all that the scene has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// In which the light of its middle travels, unit.
    pub direction: Vec3,
    /// Half of the angle that it is seen under \[rad\], in [0, π/2].
    pub angle: f32,
    /// W/m² per channel, across `direction`.
    pub irradiance: Vec3,
    aim: Aim,
}

impl Sun {
    /// A sun that shines on a scene's objects, and on its media where they are; `outside`: the one that is outside of objects. None where
    /// there is nothing of either.
    pub fn new(
        (direction, angle, irradiance): (Vec3, f32, Vec3),
        objects: &[Object],
        placed: Option<&Placed>,
        media: &[SceneMedium],
        outside: Option<u32>,
    ) -> Option<Self> {
        Some(Self { direction, angle, irradiance, aim: Aim::at(objects, placed, media, outside)? })
    }

    /// A sun for a scene whose media are all in one ball, and all that its light can meet in another. Three of four photons are sent to the
    /// media.
    ///
    /// - `direction`: in which the light of its middle travels, unit.
    /// - `angle`: half of the angle that it is seen under \[rad\], in [0, π/2].
    /// - `irradiance`: across `direction` \[W/m²\].
    pub fn around(direction: Vec3, angle: f32, irradiance: Vec3, media: Ball, scene: Ball) -> Self {
        Self { direction, angle, irradiance, aim: Aim::around(media, scene) }
    }

    /// Box of all that it shines on.
    pub(super) fn bounds(&self) -> (Vec3, Vec3) {
        self.aim.bounds()
    }

    /// What the photons have that are sent to the media; all light that the cylinder holds may be far more.
    pub(super) fn flux(&self) -> Vec3 {
        self.irradiance * self.aim.area()
    }

    /// Middle of what it shines on, and how far that reaches.
    pub(super) fn middle(&self) -> (Vec3, f32) {
        self.aim.middle()
    }

    /// A point ahead of the scene.
    pub(super) fn position(&self) -> Vec3 {
        self.aim.ahead(self.direction)
    }

    /// A direction of the light, evenly over the disk that the sun is; (0, 0): of its middle.
    fn direction(&self, [u, v]: [f32; 2]) -> DVec3 {
        // The height of the cap is 2 sin²(angle/2), of which 1 - cos would leave little.
        let sine = libm::sin(0.5 * f64::from(self.angle));
        let height = 2.0 * sine * sine;
        cap_direction(self.direction.as_dvec3().normalize(), height, [u, v])
    }

    /// Light that crosses a small ball over the ball's cross section: directions lie aslant to the axis, by (1 + cos)/2 on average.
    fn flux_across(&self) -> Vec3 {
        self.irradiance * (2.0 / (1.0 + libm::cosf(self.angle)))
    }

    /// The photon of a place in the unit square, which says where on the disks across the light; its direction is drawn by `sampler`.
    pub(super) fn emit_at(&self, place: [f32; 2], sampler: &mut PathSampler) -> EmittedPhoton {
        let direction = self.direction(sampler.uniform_pair());
        let (origin, density) = self.aim.start(direction, place);
        let power = self.flux_across() / density;
        EmittedPhoton::new(origin, direction.as_vec3().normalize(), power, Vec3::ZERO)
    }

    /// As [`super::Light::flux_density`]: light comes from ahead of the scene.
    pub(super) fn flux_density(&self, place: Vec3, xi: [f32; 2]) -> (Vec3, Vec3) {
        let (is_lit, from) = self.aim.reaches(place, self.direction(xi));
        (if is_lit { self.flux_across() } else { Vec3::ZERO }, from)
    }

    /// As [`super::Light::lit_stretch`].
    pub(super) fn lit_stretch(&self, origin: DVec3, direction: DVec3, ends: [f32; 2]) -> Option<(f32, f32)> {
        let axis = self.direction.as_dvec3().normalize();
        let (center, outer) = (self.aim.middle().0.as_dvec3(), f64::from(self.aim.outer()));
        let (sine, cosine) = libm::sincos(f64::from(self.angle));
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
        let width = PI * self.angle.max(1e-6);
        LightField::gaussian(direction, Vec3::ZERO, [0.0; 2], [1.0 / (width * width); 2])
    }

    /// Its radiance in a direction of view; 0 beside it, and of a sun without an angle.
    pub(super) fn seen_along(&self, direction: Vec3) -> Vec3 {
        let sine = libm::sinf(self.angle);
        // In the cross product small angles have digits that the cosine loses.
        let is_seen = direction.dot(self.direction) < 0.0
            && direction.cross(self.direction).length_squared() < sine * sine;
        if is_seen { self.radiance() } else { Vec3::ZERO }
    }

    /// Of a sun with an angle [W/(m² sr)].
    pub(super) fn radiance(&self) -> Vec3 {
        let sine = libm::sinf(self.angle);
        self.irradiance / (PI * sine * sine)
    }

    /// Whether a photon without a history may have left it in this direction.
    pub(super) fn may_have_sent(&self, direction: Vec3) -> bool {
        direction.angle_between(self.direction) <= self.angle + 1e-3
    }
}
