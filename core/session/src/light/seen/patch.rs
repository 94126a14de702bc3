//! Flat patches that shine: which side does, how large they are, their light fields, and where a parallelogram is seen.

pub(crate) mod triangle;

use crate::light::seen::patch::triangle::SeenTriangle;
use covbeam::LightField;
use glam::{DVec3, Vec3};
use std::f32::consts::PI;

/// Angular variance of a diffuse emitter: the relative curvature of cos θ/d² across the ray is 3/d², in the plane of the
/// normal and across it alike.
const DIFFUSE_ANGULAR_VARIANCE: f32 = 3.0 / (4.0 * PI * PI);

/// Radius of a disk as large as a square, over the square's side.
pub(crate) const FRAC_1_SQRT_PI: f32 = 0.564_189_6;

/// Light starts this far above patches that may lie on a scene's surfaces, in their sizes.
const LIFT: f64 = 1e-5;

/// And so far at least: more than the rounding of places there, in shares of the largest coordinate, and for the origin.
const CLEAR: f64 = 1.0 / 1_048_576.0;
const LEAST_CLEAR: f64 = 2e-9;

/// Unit normal of the side of a parallelogram that shines.
pub(crate) fn front(edge_u: Vec3, edge_v: Vec3) -> Vec3 {
    edge_u.as_dvec3().cross(edge_v.as_dvec3()).normalize().as_vec3().normalize()
}

/// Radius of a disk as large as a parallelogram.
pub(crate) fn equal_radius(edge_u: Vec3, edge_v: Vec3) -> f32 {
    FRAC_1_SQRT_PI * edge_u.as_dvec3().cross(edge_v.as_dvec3()).length().sqrt() as f32
}

/// A place on a patch, moved off it.
///
/// - `size`: of the light; `normal`: unit, to the side that it is moved to.
pub(crate) fn lifted(place: DVec3, size: f64, normal: DVec3) -> Vec3 {
    let clear = (CLEAR * place.abs().max_element()).max(LEAST_CLEAR);
    (place + (LIFT * size + clear) * normal).as_vec3()
}

fn halves(corner: Vec3, edge_u: Vec3, edge_v: Vec3, place: Vec3) -> [SeenTriangle; 2] {
    let far = corner + edge_u + edge_v;
    [[corner, corner + edge_u, far], [corner, far, corner + edge_v]]
        .map(|corners| SeenTriangle::new(corners, place))
}

/// Of a parallelogram's front \[sr\].
pub(crate) fn solid_angle(corner: Vec3, edge_u: Vec3, edge_v: Vec3, place: Vec3) -> f32 {
    halves(corner, edge_u, edge_v, place).iter().map(|half| half.solid_angle).sum::<f64>() as f32
}

/// Draws a point of a parallelogram's front as [`crate::light::seen::disk::sample`] does, to the same bound on what it stands for.
pub(crate) fn sample(corner: Vec3, edge_u: Vec3, edge_v: Vec3, place: Vec3, xi: [f32; 2]) -> (f32, Vec3) {
    let halves = halves(corner, edge_u, edge_v, place);
    let solid = halves[0].solid_angle + halves[1].solid_angle;
    if !(solid > 0.0) {
        return (0.0, corner + 0.5 * (edge_u + edge_v));
    }
    // (0, 0) is the middle of a side, and not a corner.
    let [u, v] = xi.map(|xi| (f64::from(xi) + 0.5).fract());
    let share = halves[0].solid_angle / solid;
    let (half, share, u) = match u < share {
        true => (&halves[0], share, u / share),
        false => (&halves[1], 1.0 - share, (u - share) / (1.0 - share)),
    };
    let (stands_for, point) = half.sample([u.min(1.0), v]);
    ((stands_for / share) as f32, (place.as_dvec3() + point).as_vec3())
}

/// Of a patch that shines as a Lambert surface.
pub(crate) fn diffuse_field(direction: Vec3, normal: Vec3, radius: f32) -> LightField {
    let mut field = LightField::disk(direction, normal, radius, DIFFUSE_ANGULAR_VARIANCE);
    // Beyond 60° the gradient of cos θ, tan² θ, outweighs the curvature.
    let cos_theta = direction.dot(normal);
    let tan2_theta = 1.0 / (cos_theta * cos_theta) - 1.0;
    field.narrow(normal, tan2_theta / (4.0 * PI * PI) - DIFFUSE_ANGULAR_VARIANCE);
    field
}
