//! How the light of spots falls off beside their axis, and the bandwidth of that.

use super::rays::CURVATURE;
use covbeam::EVEN_LAMP;
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// Where the light of a lamp ends, and how: smoothly, by the cosine of the angle from the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Unit.
    pub axis: Vec3,
    /// Of the half-angle at which the light ends, in [-1, 1).
    pub cosine: f32,
    /// How far the cosine rises inside until the light is full, > 0.
    pub blend: f32,
}

impl Cone {
    fn cosine_of(&self, direction: Vec3) -> f64 {
        direction.as_dvec3().dot(self.axis.as_dvec3()).clamp(-1.0, 1.0)
    }

    /// Where on the fall-off a cosine is: 0 at its end, 1 where the light is full.
    fn rise(&self, cosine: f64) -> f64 {
        ((cosine - f64::from(self.cosine)) / f64::from(self.blend)).clamp(0.0, 1.0)
    }

    /// Factor on the light of a unit direction.
    pub(super) fn falloff(&self, direction: Vec3) -> f32 {
        self.falloff_at(self.cosine_of(direction)) as f32
    }

    /// The same by the cosine from the axis.
    pub(super) fn falloff_at(&self, cosine: f64) -> f64 {
        let q = self.rise(cosine);
        q * q * (3.0 - 2.0 * q)
    }

    /// Solid angle \[sr\].
    pub(super) fn solid_angle(&self) -> f32 {
        TAU * self.height()
    }

    /// Of the cap that it cuts from the unit sphere.
    pub(crate) fn height(&self) -> f32 {
        1.0 - self.cosine
    }

    /// As [`spot_angular_variance`], and the axis that the first of both runs along.
    pub(super) fn angular_variance(&self, direction: Vec3) -> (Vec3, [f32; 2]) {
        let cosine = self.cosine_of(direction);
        let q = self.rise(cosine);
        if q <= 1e-3 || q >= 1.0 {
            return (direction.any_orthonormal_vector(), [EVEN_LAMP; 2]);
        }
        let sine2 = 1.0 - cosine * cosine;
        let (blend, falloff) = (f64::from(self.blend), q * q * (3.0 - 2.0 * q));
        // By the cosine: I' and I''; by the angle: -sin I', and sin² I'' - cos I'.
        let slope = 6.0 * q * (1.0 - q) / (blend * falloff);
        let curvature = (6.0 - 12.0 * q) / (blend * blend * falloff);
        let towards = (sine2 * curvature - cosine * slope - 2.0).abs().max(sine2 * slope * slope);
        let around = (cosine * slope + 2.0).abs();
        (self.axis, [towards, around].map(|relative| relative as f32 * CURVATURE))
    }
}

/// 1 - cosine of an angle, to single precision however small it is.
pub(crate) fn cap_height(angle: f32) -> f32 {
    let sine = libm::sinf(0.5 * angle);
    2.0 * sine * sine
}

/// Angle between a direction of any length and the axis, to a few 1e-7: as an arc cosine it would be to 3e-4 in narrow cones.
pub(super) fn angle_from(axis: Vec3, direction: Vec3) -> f32 {
    libm::atan2f(axis.cross(direction).length(), axis.dot(direction))
}

/// Smooth fall-off of a spot between its two cones, in a direction of any length.
pub(super) fn spot_falloff(axis: Vec3, direction: Vec3, inner: f32, outer: f32) -> f32 {
    let theta = angle_from(axis, direction);
    let q = ((outer - theta) / (outer - inner)).clamp(0.0, 1.0);
    q * q * (3.0 - 2.0 * q)
}

/// Angular variance of a spot's field in the direction `theta` off its axis: towards the axis, and around it.
///
/// The Hessian of I(θ)/d² across the ray, over I/d²: I''/I - 2 and I' cot θ/I - 2. Where the fall-off has its
/// inflection the gradient speaks.
pub(super) fn spot_angular_variance(theta: f32, inner: f32, outer: f32) -> [f32; 2] {
    if theta <= inner || theta >= outer {
        return [EVEN_LAMP; 2];
    }
    let width = outer - inner;
    let q = (outer - theta) / width;
    let falloff = q * q * (3.0 - 2.0 * q);
    let slope = -6.0 * q * (1.0 - q) / (width * falloff);
    let curvature = (6.0 - 12.0 * q) / (width * width * falloff);
    let towards = (curvature - 2.0).abs().max(slope * slope);
    let around = 2.0 - slope / libm::tanf(theta);
    [towards, around].map(|relative| relative / (4.0 * PI * PI))
}
