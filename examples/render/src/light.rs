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

/// Angular variance of a diffuse emitter: the relative curvature of cos θ/d² across the ray is 3/d², in the plane of the
/// normal and across it alike.
const DIFFUSE_ANGULAR_VARIANCE: f32 = 3.0 / (4.0 * PI * PI);

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

/// Smooth fall-off of a spot between its two cones.
fn spot_falloff(cos_theta: f32, inner: f32, outer: f32) -> f32 {
    let theta = cos_theta.clamp(-1.0, 1.0).acos();
    let q = ((outer - theta) / (outer - inner)).clamp(0.0, 1.0);
    q * q * (3.0 - 2.0 * q)
}

/// Angular variance of a spot's field in the direction `theta` off its axis: towards the axis, and around it.
///
/// The Hessian of I(θ)/d² across the ray, over I/d²: I''/I - 2 and I' cot θ/I - 2. Where the fall-off has its
/// inflection the gradient speaks.
fn spot_angular_variance(theta: f32, inner: f32, outer: f32) -> [f32; 2] {
    if theta <= inner || theta >= outer {
        return [POINT_ANGULAR_VARIANCE; 2];
    }
    let width = outer - inner;
    let q = (outer - theta) / width;
    let falloff = q * q * (3.0 - 2.0 * q);
    let slope = -6.0 * q * (1.0 - q) / (width * falloff);
    let curvature = (6.0 - 12.0 * q) / (width * width * falloff);
    let towards = (curvature - 2.0).abs().max(slope * slope);
    let around = 2.0 - slope / theta.tan();
    [towards, around].map(|relative| relative / (4.0 * PI * PI))
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
                let falloff = spot_falloff(direction.dot(axis), inner_angle, outer_angle);
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
                let theta = photon.direction.angle_between(axis);
                let variance = spot_angular_variance(theta, inner_angle, outer_angle);
                LightField::gaussian(photon.direction, axis, [f32::INFINITY; 2], variance)
            }
            Light::Disk { normal, radius, .. } => {
                let mut field = LightField::disk(photon.direction, normal, radius, DIFFUSE_ANGULAR_VARIANCE);
                // Beyond 60° the gradient of cos θ, tan² θ, outweighs the curvature.
                let cos_theta = photon.direction.dot(normal);
                let tan2_theta = 1.0 / (cos_theta * cos_theta) - 1.0;
                field.narrow(normal, tan2_theta / (4.0 * PI * PI) - DIFFUSE_ANGULAR_VARIANCE);
                field
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
                let falloff = spot_falloff(-offset.dot(axis) / d, inner_angle, outer_angle);
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
