//! Directions and places that two uniform numbers choose evenly.

use glam::{DVec3, Vec3};
use std::f32::consts::TAU;

/// Direction evenly over the sphere.
pub(super) fn even_direction([a, b]: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * a;
    let (sin_phi, cos_phi) = libm::sincosf(TAU * b);
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * cos_phi, z, r * sin_phi).normalize()
}

/// Direction in proportion to the cosine with `normal`.
pub fn cosine_direction(normal: Vec3, [a, b]: [f32; 2]) -> Vec3 {
    let (e, f) = normal.any_orthonormal_pair();
    let (sin_phi, cos_phi) = libm::sincosf(TAU * b);
    let r = a.sqrt();
    (r * cos_phi * e + r * sin_phi * f + (1.0 - a).max(1e-12).sqrt() * normal).normalize()
}

/// Direction evenly over the cap of some height that a cone around `axis` cuts from the unit sphere.
pub(super) fn cone_direction(axis: Vec3, height: f32, [a, b]: [f32; 2]) -> Vec3 {
    let fall = a * height;
    let (sin_phi, cos_phi) = libm::sincosf(TAU * b);
    let r = (fall * (2.0 - fall)).sqrt();
    let (e, f) = axis.any_orthonormal_pair();
    (r * cos_phi * e + r * sin_phi * f + (1.0 - fall) * axis).normalize()
}

/// The same in double precision: (0, 0) is the axis.
pub(super) fn cap_direction(axis: DVec3, height: f64, [u, v]: [f32; 2]) -> DVec3 {
    let fall = f64::from(u) * height;
    let sine = (fall * (2.0 - fall)).sqrt();
    let (sin_phi, cos_phi) = libm::sincos(f64::from(TAU) * f64::from(v));
    let (e, f) = axis.any_orthonormal_pair();
    (sine * cos_phi * e + sine * sin_phi * f + (1.0 - fall) * axis).normalize()
}

/// Place in the unit disk across `axis`, evenly.
pub(super) fn across(axis: Vec3, [c, d]: [f32; 2]) -> Vec3 {
    let (e, f) = axis.any_orthonormal_pair();
    let (sin_psi, cos_psi) = libm::sincosf(TAU * d);
    c.sqrt() * (cos_psi * e + sin_psi * f)
}
