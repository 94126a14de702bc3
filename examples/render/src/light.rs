//! Lights: how photons leave them and what they send straight to a surface.

use crate::disk;
use crate::random::{PathSampler, Random};
use crate::scene::Light;
use covbeam::{EVEN_LAMP, LightField};
use glam::Vec3;
use std::f32::consts::{FRAC_1_SQRT_2, PI, TAU};

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
        let place = sampler.uniform_pair();
        self.emit_at(place, sampler)
    }

    /// The photon of a place in the unit square, whose second number is an angle around the light's axis; of a disk, from a point of it
    /// that `sampler` draws.
    pub fn emit_at(&self, [a, b]: [f32; 2], sampler: &mut PathSampler) -> EmittedPhoton {
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
            Light::Point { .. } => LightField::point(photon.direction, EVEN_LAMP),
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

    /// Light that arrives straight from this light on a small ball at `point`, over the ball's cross section \[W/m²\], without the
    /// medium's transmittance; and where it comes from. `xi`, uniform in [0, 1), chooses the point of a disk that stands for the
    /// whole, by solid angle; (0, 0) is the middle of what is seen of it.
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
        }
    }

    /// The part of a ray's stretch `from..to` that the light shines on if nothing is in its way; None = no part.
    pub fn lit_stretch(&self, origin: Vec3, direction: Vec3, from: f32, to: f32) -> Option<(f32, f32)> {
        let (o, d) = (origin.as_dvec3(), direction.as_dvec3());
        match *self {
            Light::Point { .. } => (from < to).then_some((from, to)),
            Light::Spot { position, direction: axis, outer_angle, .. } => {
                let (m, axis) = (o - position.as_dvec3(), axis.as_dvec3());
                let cosine = f64::from(outer_angle).cos();
                let c2 = cosine * cosine;
                // (p·axis)² = c² |p|² for p = m + t d.
                let (md, dd) = (m.dot(axis), d.dot(axis));
                let a = dd * dd - c2 * d.length_squared();
                let b = md * dd - c2 * m.dot(d);
                let c = md * md - c2 * m.length_squared();
                let q = -(b + b.signum() * (b * b - a * c).max(0.0).sqrt());
                convex_part([q / a, c / q], from, to, |t| {
                    let p = m + t * d;
                    p.dot(axis) > cosine * p.length()
                })
            }
            Light::Disk { center, normal, .. } => {
                let (m, normal) = (o - center.as_dvec3(), normal.as_dvec3());
                let crossing = -m.dot(normal) / d.dot(normal);
                convex_part([crossing; 2], from, to, |t| (m + t * d).dot(normal) > 0.0)
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
            Light::Disk { .. } => {
                let (density, from) = self.flux_density(point, [random.uniform(), random.uniform()]);
                (density * (from - point).normalize_or_zero().dot(normal).max(0.0), from)
            }
        }
    }

    /// The length h for which light arrives about as 1/(s² + h²), s being the distance from [`Light::position`]. For a disk seen along its
    /// axis that is right at s = 0 and far away, and within 17 % between.
    pub fn softening(&self) -> f32 {
        match *self {
            Light::Point { .. } | Light::Spot { .. } => 0.0,
            Light::Disk { radius, .. } => FRAC_1_SQRT_2 * radius,
        }
    }
}

/// The part of `from..to` inside a convex body, which the line enters and leaves at the `cuts`, if at all.
fn convex_part(mut cuts: [f64; 2], from: f32, to: f32, inside: impl Fn(f64) -> bool) -> Option<(f32, f32)> {
    let (from, to) = (f64::from(from), f64::from(to));
    cuts.sort_by(f64::total_cmp);
    let [first, second] = cuts.map(|cut| if cut.is_nan() { from } else { cut.clamp(from, to) });
    let pieces = [(from, first), (first, second), (second, to)].into_iter().filter(|&(start, end)| {
        let middle = if end < f64::INFINITY { 0.5 * (start + end) } else { 2.0 * start.abs() + 1.0 };
        start < end && inside(middle)
    });
    let (from, to) = pieces.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
    let (from, to) = (from as f32, to as f32);
    (from < to).then_some((from, to))
}

/// Direction in proportion to the cosine with `normal`.
pub fn cosine_direction(normal: Vec3, [a, b]: [f32; 2]) -> Vec3 {
    let (e, f) = normal.any_orthonormal_pair();
    let (sin_phi, cos_phi) = (TAU * b).sin_cos();
    let r = a.sqrt();
    (r * cos_phi * e + r * sin_phi * f + (1.0 - a).max(1e-12).sqrt() * normal).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lights() -> [Light; 3] {
        let position = Vec3::new(0.3, 1.0, -0.2);
        let intensity = Vec3::new(3.0, 2.0, 1.0);
        let direction = Vec3::new(0.2, -1.0, 0.4).normalize();
        [
            Light::Point { position, intensity },
            Light::Spot { position, direction, intensity, inner_angle: 0.3, outer_angle: 0.6 },
            Light::Disk { center: position, normal: direction, radius: 0.2, radiance: intensity },
        ]
    }

    #[test]
    fn a_ball_catches_what_a_surface_that_faces_the_light_does() {
        let point = Vec3::new(0.7, -0.8, 0.3);
        for light in lights() {
            // Facing each point of a disk that is drawn; a surface with a fixed normal sees the same points at a slant.
            let (density, from) = light.flux_density(point, [0.0; 2]);
            let normal = (from - point).normalize();
            let count = 20_000;
            let mut random = Random::new([1, 2, 3, 4]);
            let mut sums = [Vec3::ZERO; 2];
            for _ in 0..count {
                sums[0] += light.irradiance(point, normal, &mut random).0;
                let (density, from) = light.flux_density(point, [random.uniform(), random.uniform()]);
                sums[1] += density * (from - point).normalize().dot(normal);
            }
            assert!(density.x > 0.0, "the point is in the light");
            // The disk is 10° wide: a sample varies by a tenth, its mean by 1e-3.
            assert!((sums[0] / sums[1] - 1.0).abs().max_element() < 5e-3, "{light:?}: {sums:?}");
        }
    }

    #[test]
    fn the_irradiance_of_a_disk_is_the_closed_form() {
        let (radius, radiance) = (0.2, Vec3::new(3.0, 2.0, 1.0));
        let disk = Light::Disk { center: Vec3::ZERO, normal: Vec3::Y, radius, radiance };
        let mut random = Random::new([9, 10, 11, 12]);
        for [aside, height] in [[0.0, 0.002], [0.19, 0.002], [0.21, 0.01], [0.3, 0.1], [0.1, 1.0], [2.0, 1.0]]
        {
            let count = 100_000;
            let point = Vec3::new(0.0, height, aside);
            let sum: f32 = (0..count).map(|_| disk.irradiance(point, -Vec3::Y, &mut random).0.x).sum();
            // On a surface that lies as the disk does: π L (1 - (x² + h² - r²)/√((x² + h² + r²)² - 4 x² r²))/2.
            let [x, h, r] = [aside, height, radius].map(f64::from);
            let root = ((x * x + h * h + r * r).powi(2) - 4.0 * x * x * r * r).sqrt();
            let exact = 3.0 * std::f64::consts::PI * (1.0 - (x * x + h * h - r * r) / root) / 2.0;
            let ratio = f64::from(sum) / f64::from(count) / exact;
            // Cosines vary by 60 % at most where the rim is near, 2e-3 of the mean.
            assert!((ratio - 1.0).abs() < 0.01, "{aside} {height}: {ratio}");
            assert_eq!(disk.irradiance(point, Vec3::Y, &mut random).0, Vec3::ZERO);
        }
    }

    #[test]
    fn the_lit_stretch_holds_all_places_with_light_and_no_others() {
        let mut random = Random::new([5, 6, 7, 8]);
        let mut seen = [0; 2];
        for _ in 0..2000 {
            let mut place = || Vec3::new(random.uniform(), random.uniform(), random.uniform()) * 4.0 - 2.0;
            let (origin, direction) = (place(), place().normalize());
            for light in lights() {
                let lit = light.lit_stretch(origin, direction, 0.5, 4.0);
                seen[usize::from(lit.is_some())] += 1;
                let (from, to) = lit.unwrap_or((f32::MAX, f32::MIN));
                for step in 0..50 {
                    let distance = 0.5 + 3.5 * (step as f32 + 0.5) / 50.0;
                    let found = light.flux_density(origin + distance * direction, [0.0; 2]).0.x;
                    // An angle from its f32 cosine is good to 1e-4 at the cone's edge, where the fall-off is below 1e-6.
                    let clear = (distance - from).abs().min((distance - to).abs()) > 1e-3;
                    assert!(
                        !clear || (found > 0.0) == (from..to).contains(&distance),
                        "{light:?} {distance}"
                    );
                }
            }
        }
        assert!(seen[0] > 500 && seen[1] > 500, "{seen:?}");
    }

    #[test]
    fn the_lit_stretch_of_a_ray_without_end_has_none_either_where_it_stays_in_the_light() {
        let [point, spot, disk] = lights();
        let down = Vec3::new(0.2, -1.0, 0.4).normalize();
        for light in [point, spot, disk] {
            let (_, to) = light.lit_stretch(Vec3::new(0.0, 3.0, 0.0), down, 0.0, f32::INFINITY).unwrap();
            assert_eq!(to, f32::INFINITY, "{light:?}");
        }
        assert!(spot.lit_stretch(Vec3::new(0.0, 3.0, 0.0), -down, 0.0, f32::INFINITY).is_none());
    }
}
