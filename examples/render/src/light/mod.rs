//! Lights: how photons leave them and what they send straight to a surface.

mod disk;
mod stretch;
mod sun;
mod triangle;

pub use sun::Sun;

use crate::geometry::{intersect_rectangle, intersect_sphere};
use crate::random::{PathSampler, Random};
use crate::scene::Light;
use covbeam::{EVEN_LAMP, LightField};
use glam::Vec3;
use std::f32::consts::{FRAC_1_SQRT_2, PI, TAU};
use stretch::{before, in_cone, outside_sphere};
use triangle::SeenTriangle;

/// Angular variance of a diffuse emitter: the relative curvature of cos θ/d² across the ray is 3/d², in the plane of the
/// normal and across it alike.
const DIFFUSE_ANGULAR_VARIANCE: f32 = 3.0 / (4.0 * PI * PI);

/// Radius of a disk as large as a square, over the square's side.
const FRAC_1_SQRT_PI: f32 = 0.564_189_6;

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
        return [EVEN_LAMP; 2];
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
            Light::Rectangle { edge_u, edge_v, radiance, .. } => {
                PI * edge_u.cross(edge_v).length() * radiance
            }
            Light::Sphere { radius, radiance, .. } => 4.0 * PI * PI * radius * radius * radiance,
            Light::Sun(sun) => sun.flux(),
        }
    }

    /// A point of the light, or ahead of it; which media it lies in is found from here.
    pub fn position(&self) -> Vec3 {
        match *self {
            Light::Point { position, .. } | Light::Spot { position, .. } => position,
            Light::Disk { center, normal, radius, .. } => center + 1e-4 * radius * normal,
            Light::Rectangle { corner, edge_u, edge_v, .. } => {
                corner + 0.5 * (edge_u + edge_v) + 1e-4 * equal_radius(edge_u, edge_v) * front(edge_u, edge_v)
            }
            Light::Sphere { center, .. } => center,
            Light::Sun(sun) => sun.position(),
        }
    }

    /// A box that a scene's own must hold: of a sun, what it shines on.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        match self {
            Light::Sun(sun) => sun.bounds(),
            _ => (self.position(), self.position()),
        }
    }

    /// Whether a photon that has met nothing yet may start there.
    pub(crate) fn may_have_sent(&self, origin: Vec3, direction: Vec3) -> bool {
        match *self {
            Light::Point { position, .. } | Light::Spot { position, .. } => origin == position,
            Light::Disk { center, radius, .. } | Light::Sphere { center, radius, .. } => {
                origin.distance(center) <= 1.001 * radius
            }
            Light::Rectangle { edge_u, edge_v, .. } => {
                origin.distance(self.position()) <= 0.501 * (edge_u.length() + edge_v.length())
            }
            Light::Sun(sun) => sun.may_have_sent(direction),
        }
    }

    /// Draws a photon.
    pub fn emit(&self, sampler: &mut PathSampler) -> EmittedPhoton {
        let place = sampler.uniform_pair();
        self.emit_at(place, sampler)
    }

    /// The photon of a place in the unit square, whose second number is an angle around the light's axis. It says where the photon goes;
    /// from which point of a light that has a size `sampler` draws. Of a sun it is the other way round.
    pub fn emit_at(&self, [a, b]: [f32; 2], sampler: &mut PathSampler) -> EmittedPhoton {
        match *self {
            Light::Point { position, intensity } => {
                let direction = even_direction([a, b]);
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
            Light::Rectangle { corner, edge_u, edge_v, .. } => {
                let [c, d] = sampler.uniform_pair();
                let normal = front(edge_u, edge_v);
                let lift = 1e-5 * equal_radius(edge_u, edge_v) * normal;
                let direction = cosine_direction(normal, [a, b]);
                let origin = corner + c * edge_u + d * edge_v + lift;
                EmittedPhoton { origin, direction, power: self.flux(), normal }
            }
            Light::Sphere { center, radius, .. } => {
                // In each direction it shines as a disk across it, evenly: the cosine foreshortens its surface.
                let direction = even_direction([a, b]);
                let [c, d] = sampler.uniform_pair();
                let (e, f) = direction.any_orthonormal_pair();
                let (sin_psi, cos_psi) = (TAU * d).sin_cos();
                let across = c.sqrt() * (cos_psi * e + sin_psi * f);
                let normal = (across + (1.0 - c).max(0.0).sqrt() * direction).normalize();
                let origin = center + (1.0 + 1e-5) * radius * normal;
                EmittedPhoton { origin, direction, power: self.flux(), normal }
            }
            Light::Sun(sun) => sun.emit_at([a, b], sampler),
        }
    }

    /// The light field around a photon that [`Light::emit`] drew.
    pub fn light_field(&self, photon: &EmittedPhoton) -> LightField {
        match *self {
            Light::Point { .. } => LightField::point(photon.direction, EVEN_LAMP),
            Light::Spot { direction: axis, inner_angle, outer_angle, .. } => {
                let theta = photon.direction.angle_between(axis);
                let variance = spot_angular_variance(theta, inner_angle, outer_angle);
                LightField::gaussian(photon.direction, axis, [f32::INFINITY; 2], variance)
            }
            Light::Disk { normal, radius, .. } => diffuse_field(photon.direction, normal, radius),
            Light::Rectangle { edge_u, edge_v, .. } => {
                // Of a disk as wide as its shorter side: along the other one it is smoother.
                let radius = FRAC_1_SQRT_PI * edge_u.length().min(edge_v.length());
                diffuse_field(photon.direction, front(edge_u, edge_v), radius)
            }
            // It looks the same from all sides: a disk across the ray.
            Light::Sphere { radius, .. } => {
                LightField::disk(photon.direction, photon.direction, radius, EVEN_LAMP)
            }
            Light::Sun(sun) => sun.light_field(photon.direction),
        }
    }

    /// Light that arrives straight from this light on a small ball at `point`, over the ball's cross section \[W/m²\], without the
    /// medium's transmittance; and where it comes from. `xi`, uniform in [0, 1), chooses the point that stands for the whole of a light that
    /// has a size, by solid angle; (0, 0) is the middle of what is seen of it, about.
    pub fn flux_density(&self, point: Vec3, xi: [f32; 2]) -> (Vec3, Vec3) {
        match *self {
            Light::Point { position, intensity } => {
                (intensity / (position - point).length_squared(), position)
            }
            Light::Spot { position, direction: axis, intensity, inner_angle, outer_angle } => {
                let offset = point - position;
                let d2 = offset.length_squared();
                let falloff = spot_falloff(offset.dot(axis) / d2.sqrt(), inner_angle, outer_angle);
                (intensity * (falloff / d2), position)
            }
            Light::Disk { center, normal, radius, radiance } => {
                let (solid_angle, position) = disk::sample(center, normal, radius, point, xi);
                (radiance * solid_angle, position)
            }
            Light::Rectangle { corner, edge_u, edge_v, radiance } => {
                let (solid_angle, position) = sample_rectangle(corner, edge_u, edge_v, point, xi);
                (radiance * solid_angle, position)
            }
            Light::Sphere { center, radius, radiance } => {
                let (solid_angle, position) = sample_sphere(center, radius, point, xi);
                (radiance * solid_angle, position)
            }
            Light::Sun(sun) => sun.flux_density(point, xi),
        }
    }

    /// The part of a ray's stretch `from..to` that the light shines on if nothing is in its way; None = no part.
    pub fn lit_stretch(&self, origin: Vec3, direction: Vec3, from: f32, to: f32) -> Option<(f32, f32)> {
        let (o, d) = (origin.as_dvec3(), direction.as_dvec3());
        match *self {
            Light::Point { .. } => (from < to).then_some((from, to)),
            Light::Spot { position, direction: axis, outer_angle, .. } => {
                let (m, axis) = (o - position.as_dvec3(), axis.as_dvec3());
                in_cone(m, d, axis, f64::from(outer_angle).cos(), [from, to])
            }
            Light::Disk { center, normal, .. } => {
                before(o - center.as_dvec3(), d, normal.as_dvec3(), [from, to])
            }
            Light::Rectangle { corner, edge_u, edge_v, .. } => {
                before(o - corner.as_dvec3(), d, edge_u.as_dvec3().cross(edge_v.as_dvec3()), [from, to])
            }
            Light::Sphere { center, radius, .. } => {
                outside_sphere(o - center.as_dvec3(), d, f64::from(radius), [from, to])
            }
            Light::Sun(sun) => sun.lit_stretch(o, d, [from, to]),
        }
    }

    /// Radiance of the light along a ray that meets nothing else before `reach`; 0 where it does not meet the light. Nothing meets a point, or a
    /// sun without an angle.
    pub(crate) fn seen_along(&self, origin: Vec3, direction: Vec3, reach: f32) -> Vec3 {
        let (o, d, reach) = (origin.as_dvec3(), direction.as_dvec3(), f64::from(reach));
        let (is_met, radiance) = match *self {
            Light::Point { .. } | Light::Spot { .. } => return Vec3::ZERO,
            Light::Disk { center, normal, radius, radiance } => {
                let slope = d.dot(normal.as_dvec3());
                let distance = (center.as_dvec3() - o).dot(normal.as_dvec3()) / slope;
                let aside = (o + distance * d).distance(center.as_dvec3());
                (slope < 0.0 && (0.0..reach).contains(&distance) && aside < f64::from(radius), radiance)
            }
            Light::Rectangle { corner, edge_u, edge_v, radiance } => {
                let edges = (edge_u.as_dvec3(), edge_v.as_dvec3());
                let distance = intersect_rectangle(corner.as_dvec3(), edges, o, d);
                let is_front = d.dot(edges.0.cross(edges.1)) < 0.0;
                (is_front && distance.is_some_and(|distance| (0.0..reach).contains(&distance)), radiance)
            }
            Light::Sphere { center, radius, radiance } => {
                let met = intersect_sphere(center.as_dvec3(), f64::from(radius), o, d);
                (met.is_some_and(|(near, _)| (0.0..reach).contains(&near)), radiance)
            }
            Light::Sun(sun) => (reach == f64::INFINITY, sun.seen_along(direction)),
        };
        if is_met { radiance } else { Vec3::ZERO }
    }

    /// Irradiance that arrives straight from this light at a surface point, without the medium's transmittance:
    /// (irradiance, point of the light that it came from). One random point of a light that has a size stands for the whole.
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
            _ => {
                let (density, from) = self.flux_density(point, [random.uniform(), random.uniform()]);
                (density * (from - point).normalize_or_zero().dot(normal).max(0.0), from)
            }
        }
    }

    /// Where light falls off from, and the length h for which it arrives about as 1/(s² + h²), s being the distance from there. For a disk seen
    /// along its axis that is right at s = 0 and far away, and within 17 % between; of a sun it is the same all over the scene, about.
    pub(crate) fn middle(&self) -> (Vec3, f32) {
        let softening = match *self {
            Light::Point { .. } | Light::Spot { .. } => 0.0,
            Light::Disk { radius, .. } | Light::Sphere { radius, .. } => FRAC_1_SQRT_2 * radius,
            Light::Rectangle { edge_u, edge_v, .. } => FRAC_1_SQRT_2 * equal_radius(edge_u, edge_v),
            Light::Sun(sun) => return sun.middle(),
        };
        (self.position(), softening)
    }

    /// Whether it is more than a point, so that shadows have soft borders.
    pub(crate) fn has_size(&self) -> bool {
        !matches!(self, Light::Point { .. } | Light::Spot { .. })
    }
}

/// Unit normal of the side of a rectangle that shines.
fn front(edge_u: Vec3, edge_v: Vec3) -> Vec3 {
    edge_u.as_dvec3().cross(edge_v.as_dvec3()).normalize().as_vec3().normalize()
}

/// Radius of a disk as large as a rectangle.
fn equal_radius(edge_u: Vec3, edge_v: Vec3) -> f32 {
    FRAC_1_SQRT_PI * edge_u.as_dvec3().cross(edge_v.as_dvec3()).length().sqrt() as f32
}

/// Draws a point of a rectangle's front as [`disk::sample`] does, to the same bound on what it stands for.
fn sample_rectangle(corner: Vec3, edge_u: Vec3, edge_v: Vec3, place: Vec3, xi: [f32; 2]) -> (f32, Vec3) {
    let far = corner + edge_u + edge_v;
    let halves = [[corner, corner + edge_u, far], [corner, far, corner + edge_v]]
        .map(|corners| SeenTriangle::new(corners, place));
    let solid = halves[0].solid_angle + halves[1].solid_angle;
    if !(solid > 0.0) {
        return (0.0, corner + 0.5 * (edge_u + edge_v));
    }
    // (0, 0) is a point on the diagonal between the halves, and not a corner.
    let [u, v] = xi.map(|xi| (f64::from(xi) + 0.5).fract());
    let share = halves[0].solid_angle / solid;
    let (half, share, u) = match u < share {
        true => (&halves[0], share, u / share),
        false => (&halves[1], 1.0 - share, (u - share) / (1.0 - share)),
    };
    let (stands_for, point) = half.sample([u.min(1.0), v]);
    ((stands_for / share) as f32, (place.as_dvec3() + point).as_vec3())
}

/// Draws a point of the side of a sphere that a place sees, by solid angle: what it stands for \[sr\], and the point. Places inside: 0.
fn sample_sphere(center: Vec3, radius: f32, place: Vec3, xi: [f32; 2]) -> (f32, Vec3) {
    let offset = center.as_dvec3() - place.as_dvec3();
    let (distance2, radius2) = (offset.length_squared(), f64::from(radius).powi(2));
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
    let (sin_phi, cos_phi) = (std::f64::consts::TAU * f64::from(xi[1])).sin_cos();
    let direction = aside2.sqrt() * (cos_phi * e + sin_phi * f) + (1.0 - fall) * axis;
    ((std::f64::consts::TAU * height) as f32, (place.as_dvec3() + to * direction).as_vec3())
}

/// Of a patch that shines as a Lambert surface.
fn diffuse_field(direction: Vec3, normal: Vec3, radius: f32) -> LightField {
    let mut field = LightField::disk(direction, normal, radius, DIFFUSE_ANGULAR_VARIANCE);
    // Beyond 60° the gradient of cos θ, tan² θ, outweighs the curvature.
    let cos_theta = direction.dot(normal);
    let tan2_theta = 1.0 / (cos_theta * cos_theta) - 1.0;
    field.narrow(normal, tan2_theta / (4.0 * PI * PI) - DIFFUSE_ANGULAR_VARIANCE);
    field
}

/// Direction evenly over the sphere.
fn even_direction([a, b]: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * a;
    let (sin_phi, cos_phi) = (TAU * b).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * cos_phi, z, r * sin_phi).normalize()
}

/// Direction in proportion to the cosine with `normal`.
pub fn cosine_direction(normal: Vec3, [a, b]: [f32; 2]) -> Vec3 {
    let (e, f) = normal.any_orthonormal_pair();
    let (sin_phi, cos_phi) = (TAU * b).sin_cos();
    let r = a.sqrt();
    (r * cos_phi * e + r * sin_phi * f + (1.0 - a).max(1e-12).sqrt() * normal).normalize()
}

#[cfg(test)]
mod tests;
