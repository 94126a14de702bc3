//! A sphere seen from a place: points of it drawn by solid angle.

use glam::Vec3;
use std::f64::consts::TAU;

/// Draws a point of the side of a sphere that a place sees, by solid angle: what it stands for \[sr\], and the point. Places inside: 0.
pub(crate) fn sample(center: Vec3, radius: f32, place: Vec3, xi: [f32; 2]) -> (f32, Vec3) {
    let offset = center.as_dvec3() - place.as_dvec3();
    let (distance2, radius2) = (offset.length_squared(), f64::from(radius) * f64::from(radius));
    let sin2 = radius2 / distance2;
    if !(sin2 < 1.0) {
        return (0.0, center);
    }
    // 1 - cos of the cone that holds it.
    let height = sin2 / (1.0 + (1.0 - sin2).sqrt());
    let fall = f64::from(xi[0]) * height;
    let (distance, axis) = (distance2.sqrt(), offset / distance2.sqrt());
    let aside2 = fall * (2.0 - fall);
    let to = distance * (1.0 - fall) - (radius2 - distance2 * aside2).max(0.0).sqrt();
    let (e, f) = axis.any_orthonormal_pair();
    let (sin_phi, cos_phi) = libm::sincos(TAU * f64::from(xi[1]));
    let direction = aside2.sqrt() * (cos_phi * e + sin_phi * f) + (1.0 - fall) * axis;
    ((TAU * height) as f32, (place.as_dvec3() + to * direction).as_vec3())
}
