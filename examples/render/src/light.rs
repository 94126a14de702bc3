//! Lights: how photons leave them and what they send straight to a surface.

use crate::random::{PathSampler, Random};
use crate::scene::Light;
use covbeam::LightField;
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// Angular variance of an isotropic point light's field \[cycles²/rad²\].
///
/// The fluence of a point light falls as 1/d²: a relative curvature of 2/d² across the ray, which a slice of
/// `variance / d²` reproduces with variance = 2/(4π²).
pub const POINT_ANGULAR_VARIANCE: f32 = 2.0 / (4.0 * PI * PI);

/// Angular variance of a diffuse emitter: the relative curvature of cos θ at its peak is 1.
const DIFFUSE_ANGULAR_VARIANCE: f32 = 1.0 / (4.0 * PI * PI);

/// A photon leaving a light.
#[derive(Clone, Copy, Debug)]
pub struct EmittedPhoton {
    /// Start.
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
    /// Flux of the light if all its light left like this photon \[W\]: emission / probability density.
    pub power: Vec3,
    /// Normal of the emitting surface, zero for a light without one.
    pub normal: Vec3,
}

/// Smooth fall-off of a spot between its two cones and the variance that this rim adds across it.
///
/// A smoothstep over the width w has a largest curvature of 6/w².
fn spot_falloff(cos_theta: f32, inner: f32, outer: f32) -> (f32, f32) {
    let theta = cos_theta.clamp(-1.0, 1.0).acos();
    if theta <= inner {
        return (1.0, 0.0);
    }
    if theta >= outer {
        return (0.0, 0.0);
    }
    let q = (outer - theta) / (outer - inner);
    let width = outer - inner;
    (q * q * (3.0 - 2.0 * q), 6.0 / (4.0 * PI * PI * width * width))
}

impl Light {
    /// Total flux \[W\] per channel, for choosing between lights (a spot counts its full cone).
    pub fn flux(&self) -> Vec3 {
        match *self {
            Light::Point { intensity, .. } => 4.0 * PI * intensity,
            Light::Spot { intensity, outer_angle, .. } => TAU * (1.0 - outer_angle.cos()) * intensity,
            Light::Disk { radius, radiance, .. } => PI * PI * radius * radius * radiance,
        }
    }

    /// A point of the light; which media it lies in is found from here.
    pub fn position(&self) -> Vec3 {
        match *self {
            Light::Point { position, .. } | Light::Spot { position, .. } => position,
            Light::Disk { center, normal, radius, .. } => center + 1e-4 * radius * normal,
        }
    }

    /// Draws a photon.
    pub fn emit(&self, sampler: &mut PathSampler) -> EmittedPhoton {
        let [a, b] = sampler.uniform_pair();
        match *self {
            Light::Point { position, intensity } => {
                let z = 1.0 - 2.0 * a;
                let (sin_phi, cos_phi) = (TAU * b).sin_cos();
                let r = (1.0 - z * z).max(0.0).sqrt();
                let direction = Vec3::new(r * cos_phi, z, r * sin_phi).normalize();
                EmittedPhoton { origin: position, direction, power: 4.0 * PI * intensity, normal: Vec3::ZERO }
            }
            Light::Spot { position, direction: axis, intensity, inner_angle, outer_angle } => {
                let height = 1.0 - outer_angle.cos();
                let z = 1.0 - a * height;
                let (sin_phi, cos_phi) = (TAU * b).sin_cos();
                let r = (1.0 - z * z).max(0.0).sqrt();
                let (e, f) = axis.any_orthonormal_pair();
                let direction = (r * cos_phi * e + r * sin_phi * f + z * axis).normalize();
                let (falloff, _) = spot_falloff(direction.dot(axis), inner_angle, outer_angle);
                let power = falloff * TAU * height * intensity;
                EmittedPhoton { origin: position, direction, power, normal: Vec3::ZERO }
            }
            Light::Disk { center, normal, radius, .. } => {
                let [c, d] = sampler.uniform_pair();
                let (e, f) = normal.any_orthonormal_pair();
                let (sin_psi, cos_psi) = (TAU * d).sin_cos();
                let rho = radius * c.sqrt();
                let origin = center + rho * (cos_psi * e + sin_psi * f) + 1e-5 * radius * normal;
                let direction = cosine_direction(normal, [a, b]);
                EmittedPhoton { origin, direction, power: self.flux(), normal }
            }
        }
    }

    /// The light field around a photon that [`Light::emit`] drew.
    pub fn light_field(&self, photon: &EmittedPhoton) -> LightField {
        match *self {
            Light::Point { .. } => LightField::point(photon.direction, POINT_ANGULAR_VARIANCE),
            Light::Spot { direction: axis, inner_angle, outer_angle, .. } => {
                let mut field = LightField::point(photon.direction, POINT_ANGULAR_VARIANCE);
                let (_, variance) = spot_falloff(photon.direction.dot(axis), inner_angle, outer_angle);
                if variance > 0.0 {
                    field.narrow(photon.direction - axis, variance);
                }
                field
            }
            Light::Disk { normal, radius, .. } => {
                LightField::disk(photon.direction, normal, radius, DIFFUSE_ANGULAR_VARIANCE)
            }
        }
    }

    /// Irradiance that arrives straight from this light at a surface point, without the medium's transmittance:
    /// (irradiance, point of the light that it came from). One random point of a disk stands for the whole.
    pub fn irradiance(&self, point: Vec3, normal: Vec3, random: &mut Random) -> (Vec3, Vec3) {
        match *self {
            Light::Point { position, intensity } => {
                let offset = position - point;
                let d2 = offset.length_squared();
                (intensity * (offset.dot(normal) / (d2 * d2.sqrt())).max(0.0), position)
            }
            Light::Spot { position, direction: axis, intensity, inner_angle, outer_angle } => {
                let offset = position - point;
                let d2 = offset.length_squared();
                let d = d2.sqrt();
                let (falloff, _) = spot_falloff(-offset.dot(axis) / d, inner_angle, outer_angle);
                (intensity * falloff * (offset.dot(normal) / (d2 * d)).max(0.0), position)
            }
            Light::Disk { center, normal: disk_normal, radius, radiance } => {
                let (e, f) = disk_normal.any_orthonormal_pair();
                let rho = radius * random.uniform().sqrt();
                let (sin_psi, cos_psi) = (TAU * random.uniform()).sin_cos();
                let position = center + rho * (cos_psi * e + sin_psi * f);
                let offset = position - point;
                let d2 = offset.length_squared();
                let cosines = offset.dot(normal).max(0.0) * (-offset.dot(disk_normal)).max(0.0);
                (radiance * (PI * radius * radius * cosines / (d2 * d2)), position)
            }
        }
    }
}

/// Direction in proportion to the cosine with `normal`.
pub fn cosine_direction(normal: Vec3, [a, b]: [f32; 2]) -> Vec3 {
    let (e, f) = normal.any_orthonormal_pair();
    let (sin_phi, cos_phi) = (TAU * b).sin_cos();
    let r = a.sqrt();
    (r * cos_phi * e + r * sin_phi * f + (1.0 - a).max(1e-12).sqrt() * normal).normalize()
}
