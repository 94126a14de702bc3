//! A disk seen from a place: points of it drawn by solid angle.

use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Beyond so many radii points drawn by area do as well: the solid angle that one stands for is at most 1.5 times the mean.
const FAR: f32 = 8.0;

/// Places nearer to the disk's plane are taken to be at this height, in radii; its square is a number too.
const LEAST_HEIGHT: f32 = 1e-12;

/// Draws a point of a disk's front, by solid angle as seen from `place`.
///
/// - `normal`: unit, on the side of the front; `radius`: > 0.
/// - `xi`: uniform in \[0, 1)²; (0, 0) gives the point in the middle of what is seen.
///
/// Returns the solid angle that the point stands for, 1 / its probability density \[sr\], and the point. The mean over `xi` is the disk's
/// solid angle, and no value is above 1.5 times that, however near the place is. Places in the disk's plane and behind it: 0.
pub(crate) fn sample(center: Vec3, normal: Vec3, radius: f32, place: Vec3, xi: [f32; 2]) -> (f32, Vec3) {
    // In units of the radius, along the normal and across it.
    let offset = (place - center) / radius;
    let height = offset.dot(normal);
    let (e, f) = normal.any_orthonormal_pair();
    let across = Vec2::new(offset.dot(e), offset.dot(f));
    let distance2 = offset.length_squared();
    let (solid_angle, point) = if height <= 0.0 {
        (0.0, Vec2::ZERO)
    } else if distance2 > FAR * FAR {
        let point = xi[0].sqrt() * Vec2::from_angle(TAU * xi[1]);
        let distance2 = height * height + across.distance_squared(point);
        (PI * (height / distance2.sqrt()) / distance2, point)
    } else {
        by_solid_angle(height.max(LEAST_HEIGHT), across, xi)
    };
    (solid_angle, center + radius * (point.x * e + point.y * f))
}

/// [`sample`] of the unit disk from a place `height` > 0 above the plane point `across`; no value is above 1.07 times the mean.
///
/// The directions to the disk are an elliptic cone, whose half-angles α and β have closed forms. Lambert's azimuthal equal-area map makes of
/// them nearly an ellipse, by which the azimuth is drawn; the angle from the cone's axis is drawn by solid angle up to the true border.
fn by_solid_angle(height: f32, across: Vec2, [u, v]: [f32; 2]) -> (f32, Vec2) {
    let height2 = height * height;
    let aside = across.length();
    // The product of the distances of the rim's nearest and farthest point, times cos 2α; and the product.
    let cosine_part = (aside - 1.0) * (aside + 1.0) + height2;
    let product = (cosine_part * cosine_part + 4.0 * height2).sqrt();
    // The product times cos² α and times sin² α, without a difference of numbers that are nearly equal.
    let large = 0.5 * (cosine_part.abs() + product);
    let small = height2 / large;
    let (near, far) = if cosine_part > 0.0 { (large, small) } else { (small, large) };
    // The square of the mean of the two distances, 1/sin² β.
    let mean2 = near + 1.0;
    let cos2 = Vec2::new(near / product, near / mean2);
    let sin2 = Vec2::new(far / product, 1.0 / mean2);
    let cosines = Vec2::new(cos2.x.sqrt(), cos2.y.sqrt());

    // Squared semi-axes of the ellipse, 2(1 - cos), and a point of its border; cot2 / reach2 = cot² of the cone's border in that direction.
    let halves = 2.0 / (1.0 + cosines);
    let axes2 = sin2 * halves;
    let psi = Vec2::from_angle(TAU * v);
    let reach2 = axes2.dot(psi * psi);
    let cot2 = (cos2 * halves).dot(psi * psi);
    let cos_border = (cot2 / (reach2 + cot2)).sqrt();
    let per_area = 1.0 / ((reach2 + cot2) * (1.0 + cos_border));
    let solid_angle = TAU * (axes2.x * axes2.y).sqrt() * per_area;

    // On a plane across the cone the disk is an ellipse: the point in units of its semi-axes, by the tangents.
    let versine = u * reach2 * per_area;
    let share2 = u * (2.0 - versine) / ((1.0 + cos_border) * cot2);
    let length = cos_border / (1.0 - versine);
    let seen = length * psi * cosines * Vec2::new((halves.x * share2).sqrt(), (halves.y * share2).sqrt());
    // The projective map of the unit disk to itself that takes its centre to where the cone's axis meets the disk.
    let axis = (aside / mean2).min(1.0 - 1e-6);
    let on_disk = Vec2::new(seen.x + axis, seen.y * (cosines.y / cosines.x)) / (1.0 + axis * seen.x);
    let toward = if aside > 0.0 { across / aside } else { Vec2::X };
    (solid_angle, toward.rotate(on_disk))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::f64::consts::TAU;

    const CENTER: Vec3 = Vec3::new(0.4, 1.5, -0.7);
    const RADIUS: f32 = 0.3;

    fn normal() -> Vec3 {
        Vec3::new(0.3, -1.0, 0.5).normalize()
    }

    /// Places in radii, across and above: at distances from the middle and from the rim, square to the disk to nearly in its plane.
    fn places() -> Vec<[f64; 2]> {
        let mut places = Vec::new();
        for distance in [0.01f64, 0.1, 1.0, 7.9, 8.1, 10.0, 300.0] {
            for angle in [0f64, 30.0, 60.0, 85.0, 89.5] {
                let (s, c) = angle.to_radians().sin_cos();
                places.extend(
                    [[0.0, 1.0], [1.0, 1.0], [1.0, -1.0]]
                        .map(|[rim, side]| [rim + side * distance * s, distance * c]),
                );
            }
        }
        places
    }

    fn place([across, above]: [f64; 2]) -> Vec3 {
        let normal = normal();
        let sideways = normal.any_orthonormal_vector().rotate_axis(normal, 0.7);
        CENTER + RADIUS * (across as f32 * sideways + above as f32 * normal)
    }

    /// Solid angle of a disk of some radius, from a point `height` above its plane and `aside` from its axis: in each direction around the
    /// point's foot the disk covers 1/√(1 + (r/h)²), from where it starts to where it ends.
    fn solid_angle(aside: f64, height: f64, radius: f64) -> f64 {
        let steps = 200_000;
        // From a foot outside the disk it is seen within ± widest; sin φ = (radius/aside) sin t makes its borders smooth.
        let outside = aside > radius;
        let cover = |r: f64| height / height.hypot(r);
        let at = |k: i32| {
            let t = (f64::from(k) + 0.5) / f64::from(steps) * TAU / 2.0;
            if outside {
                let sine = radius / aside * t.cos();
                let cosine = (1.0 - sine * sine).sqrt();
                let (foot, half) = (aside * cosine, radius * t.sin());
                (cover(foot - half) - cover(foot + half)) * radius / aside * t.sin() / cosine
            } else {
                let end = aside * t.cos() + (radius * radius - (aside * t.sin()).powi(2)).sqrt();
                2.0 * (1.0 - cover(end))
            }
        };
        (0..steps).map(at).sum::<f64>() / f64::from(steps) * TAU / 2.0
    }

    /// Mean direction of a disk's light times its solid angle, by Stokes' theorem: ½ ∮ r × dr / r² around the rim.
    fn vector(place: DVec3) -> DVec3 {
        let normal = normal().as_dvec3().normalize();
        let (e, f) = normal.any_orthonormal_pair();
        let steps = 20_000;
        let at = |k: i32| {
            let (s, c) = (TAU * f64::from(k) / f64::from(steps)).sin_cos();
            let radius = f64::from(RADIUS);
            let rim = CENTER.as_dvec3() + radius * (c * e + s * f) - place;
            // Seen from the front the rim runs clockwise around the normal.
            -rim.cross(radius * (c * f - s * e)) / rim.length_squared()
        };
        (0..steps).map(at).sum::<DVec3>() * (0.5 * TAU / f64::from(steps))
    }

    fn grid(count: u32) -> impl Iterator<Item = [f32; 2]> {
        (0..count * count).map(move |k| [k % count, k / count].map(|i| (i as f32 + 0.5) / count as f32))
    }

    #[test]
    fn the_mean_is_the_solid_angle_and_no_value_is_far_above_it() {
        for at in places() {
            let [aside, height] = [at[0].abs(), at[1]];
            let exact = solid_angle(aside, height, 1.0);
            let bound = if aside.hypot(height) < f64::from(FAR) { 1.07 } else { 1.5 };
            let (mut sum, mut most) = (0.0, 0f64);
            for xi in grid(64) {
                let weight = f64::from(sample(CENTER, normal(), RADIUS, place(at), xi).0);
                sum += weight / 4096.0;
                most = most.max(weight);
            }
            // f32 knows the height above the plane to 1e-7 of the scene, 3e-7 radii.
            assert!((sum / exact - 1.0).abs() < 1e-4 + 1e-6 / height, "{at:?}: {sum} {exact}");
            assert!(most < bound * exact, "{at:?}: {most} {exact}");
        }
    }

    #[test]
    fn points_are_in_the_disk_and_fill_it_by_solid_angle() {
        for at in places() {
            let origin = place(at);
            let exact = solid_angle(at[0].abs(), at[1], 1.0);
            let parts = [0.3, 0.7, 0.9];
            let mut within = [0.0; 3];
            let mut mean = DVec3::ZERO;
            for xi in grid(256) {
                let (weight, point) = sample(CENTER, normal(), RADIUS, origin, xi);
                let weight = f64::from(weight) / 65536.0;
                let from_center = point - CENTER;
                assert!(from_center.length() < 1.00001 * RADIUS, "{at:?} {xi:?}");
                assert!(from_center.dot(normal()).abs() < 1e-6, "{at:?} {xi:?}");
                mean += weight * (point - origin).as_dvec3().normalize();
                for (sum, part) in within.iter_mut().zip(parts) {
                    *sum += if from_center.length() < part * RADIUS { weight } else { 0.0 };
                }
            }
            let error = (mean - vector(origin.as_dvec3())).length() / exact;
            assert!(error < 1e-3, "{at:?}: {error}");
            for (sum, part) in within.into_iter().zip(parts) {
                let share = solid_angle(at[0].abs(), at[1], f64::from(part)) / exact;
                assert!((sum / exact - share).abs() < 0.01, "{at:?} {part}: {} {share}", sum / exact);
            }
        }
    }

    #[test]
    fn nothing_is_seen_from_the_plane_and_from_behind() {
        for xi in [[0.0, 0.0], [0.3, 0.8]] {
            for place in [[0.0, -0.1], [3.0, -1e-3], [40.0, -2.0], [0.0, -300.0]].map(place) {
                assert_eq!(sample(CENTER, normal(), RADIUS, place, xi).0, 0.0);
            }
            for place in [Vec3::X, Vec3::ZERO, 0.5 * Vec3::Z, 50.0 * Vec3::X] {
                assert_eq!(sample(Vec3::ZERO, Vec3::Y, 1.0, place, xi), (0.0, Vec3::ZERO));
            }
        }
    }

    #[test]
    fn disks_of_any_size_are_seen_from_any_distance() {
        for radius in [1e-12f32, 1e-3, 1.0, 1e12] {
            for distance in [1e-15f32, 1e-6, 1.0, 100.0, 1e12] {
                for direction in [Vec3::Y, Vec3::new(0.6, 0.8, 0.0), Vec3::new(1.0, 1e-6, 0.0)] {
                    for xi in grid(8).chain([[0.0, 0.0], [1.0 - f32::EPSILON; 2]]) {
                        let place = radius * distance * direction;
                        let (weight, point) = sample(Vec3::ZERO, Vec3::Y, radius, place, xi);
                        let name = format!("{radius} {distance} {direction} {xi:?}: {weight} {point}");
                        assert!(weight > 0.0 && f64::from(weight) < 1.000_001 * TAU, "{name}");
                        assert!(point.length() < 1.00001 * radius && point.y == 0.0, "{name}");
                    }
                }
            }
        }
    }
}
