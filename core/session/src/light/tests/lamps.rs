//! Lamps with a size, cones and patterns, by closed forms.

use super::*;
use std::f64::consts::{PI, TAU};

const RADIUS: f64 = 0.5;

fn lamp(soft: bool, cone: Option<Cone>, pattern: Option<Arc<Pattern>>) -> Lamp {
    let radius = RADIUS as f32;
    Lamp { position: Vec3::ZERO, intensity: Vec3::ONE, radius, soft, cone, pattern, glow: 0.5 }
}

fn narrow() -> Cone {
    Cone { axis: Vec3::new(0.6, 0.0, -0.8), cosine: 0.9, blend: 0.01 }
}

/// Power times length of the light in balls of some radii around the origin [W m].
fn energy_within(photons: &[EmittedPhoton], radius: f64) -> f64 {
    mean_of(photons, |photon| {
        let (origin, direction) = (photon.origin.as_dvec3(), photon.direction.as_dvec3());
        let along = origin.dot(direction);
        let half = (radius * radius - (origin - along * direction).length_squared()).max(0.0).sqrt();
        let (start, end) = (along + f64::from(photon.dark), along + f64::from(photon.until));
        f64::from(photon.power.x) * (end.min(half) - start.max(-half)).max(0.0)
    })
}

/// Integral of 4π d² times the fluence around a soft lamp, 2π L (1 - d/√(d² + R²)) with L = I/(π R²), up to a radius.
fn within_soft(radius: f64) -> f64 {
    let rest = (radius * radius - 2.0 * RADIUS * RADIUS) * radius.hypot(RADIUS) + 2.0 * RADIUS.powi(3);
    8.0 * PI / (RADIUS * RADIUS) * (radius.powi(3) - rest) / 3.0
}

/// The same of a ball: 4π L inside, 2π L (1 - √(1 - R²/d²)) outside.
fn within_ball(radius: f64) -> [f64; 2] {
    let (inside, far) = (radius.min(RADIUS), radius.max(RADIUS));
    let scale = 8.0 * PI / (3.0 * RADIUS * RADIUS);
    let outside = far.powi(3) - RADIUS.powi(3) - (far * far - RADIUS * RADIUS).powf(1.5);
    [2.0 * scale * inside.powi(3), scale * outside]
}

#[test]
fn photons_around_lamps_have_the_fluence_of_the_closed_forms() {
    let photons = [(true, None), (false, None), (false, Some(narrow()))]
        .map(|(soft, cone)| emitted(&Light::Lamp(lamp(soft, cone, None)), 1 << 17));
    for radius in [0.1, 0.25, 0.5, 0.75, 1.0, 2.0, 8.0] {
        let [soft, ball, spot] = photons.each_ref().map(|photons| energy_within(photons, radius));
        // One in a hundred lines meets the smallest ball, 400 of those that are lit inside of one: a net's error is well below their 5 %.
        let close = |found: f64, expected: f64| (found / expected - 1.0).abs() < 0.01;
        assert!(close(soft, within_soft(radius)), "{radius}: {soft} {}", within_soft(radius));
        let [inside, outside] = within_ball(radius);
        assert!(close(ball, inside + outside), "{radius}: {ball} {inside} {outside}");
        // All around, but from beyond the middle only.
        assert!(radius > RADIUS || close(spot, 0.5 * inside), "{radius}: {spot} {inside}");
    }
}

#[test]
fn shadow_rays_find_the_fluence_of_the_closed_forms() {
    let radiance = 1.0 / (PI * RADIUS * RADIUS);
    for distance in [0.0, 1e-4, 0.1, 0.3, 0.499, 0.501, 0.8, 3.0, 1e4] {
        let place = (distance * DVec3::new(0.48, 0.6, -0.64)).as_vec3();
        let away = f64::from(place.length());
        let half = |cosine: f64| TAU * radiance * (1.0 - cosine);
        for (soft, cone) in [(true, None), (false, None), (false, Some(narrow()))] {
            let light = Light::Lamp(lamp(soft, cone, None));
            let is_inside = away < RADIUS;
            let expected = match (soft, is_inside, cone) {
                // 1 - cos as sin²/(1 + cos), of which digits are left far away.
                (true, ..) => {
                    let far = away.hypot(RADIUS);
                    TAU * radiance * RADIUS * RADIUS / (far * (far + away))
                }
                (false, true, None) => half(-1.0),
                (false, true, Some(_)) => half(0.0),
                (false, false, None) => {
                    let sine2 = (RADIUS / away).powi(2);
                    TAU * radiance * sine2 / (1.0 + (1.0 - sine2).sqrt())
                }
                (false, false, Some(_)) => continue,
            };
            for k in 0..64 {
                let xi = [k % 8, k / 8].map(|index| (index as f32 + 0.5) / 8.0);
                let (density, from) = light.flux_density(place, xi);
                let name = format!("{distance} {soft} {cone:?} {xi:?}: {density} {from} {expected}");
                assert!((f64::from(density.x) / expected - 1.0).abs() < 1e-5, "{name}");
                // Soft light starts in the plane through the middle across it, and that of a ball at its surface.
                let start = from.as_dvec3();
                let direction = (place.as_dvec3() - start).normalize_or_zero();
                let slack = 1e-6 * (1.0 + away);
                match (soft, cone) {
                    (true, _) => {
                        assert!(start.length() < RADIUS + slack, "{name}");
                        assert!(start.dot(direction).abs() < slack, "{name}");
                    }
                    (false, None) => assert!((start.length() - RADIUS).abs() < slack, "{name}"),
                    (false, Some(_)) => assert!(start.dot(direction).abs() < slack, "{name}"),
                }
            }
        }
    }
}

/// Lambert's law: at every place of a ball the mean cosine of what leaves is 2/3.
#[test]
fn what_leaves_a_ball_is_even_and_leaves_its_surface_as_lambert_says() {
    let intensity = Vec3::new(1.0, 2.0, 3.0);
    let light = Light::Lamp(Lamp { intensity, ..lamp(false, None, None) });
    let photons = emitted(&light, 1 << 15);
    let leaving: Vec<EmittedPhoton> =
        photons.into_iter().filter(|photon| photon.until.is_infinite()).collect();
    // Two of three, by `glow`.
    let share = leaving.len() as f64 / f64::from(1 << 15);
    assert!((share - 2.0 / 3.0).abs() < 1e-3, "{share}");
    for axis in 0..3 {
        let power = mean_of(&leaving, |photon| f64::from(photon.power[axis])) * share;
        assert!((power / (4.0 * PI * f64::from(intensity[axis])) - 1.0).abs() < 2e-3, "{power}");
        let aside = mean_of(&leaving, |photon| f64::from(photon.direction[axis]));
        assert!(aside.abs() < 3e-3, "{aside}");
    }
    let cosine = mean_of(&leaving, |photon| f64::from(photon.normal.dot(photon.direction)));
    assert!((cosine - 2.0 / 3.0).abs() < 2e-3, "{cosine}");
    let off = leaving.iter().map(|photon| (photon.origin - 0.5 * photon.normal).length()).fold(0.0, f32::max);
    assert!(off < 1e-6, "{off}");
}

/// 2π times the integral of the smooth step over the cosine: half of the blend, and what is inside.
#[test]
fn a_cone_ends_as_a_smooth_step_of_the_cosine() {
    let cone = Cone { axis: Vec3::NEG_Z, cosine: 0.8, blend: 0.1 };
    for soft in [true, false] {
        let light = Light::Lamp(Lamp { radius: 0.0, ..lamp(soft, Some(cone), None) });
        let photons = emitted(&light, 1 << 15);
        let flux = mean_of(&photons, |photon| f64::from(photon.power.x));
        assert!((flux / (TAU * (0.05 + 0.2 - 0.1)) - 1.0).abs() < 1e-3, "{flux}");
        assert!(photons.iter().all(|photon| -photon.direction.z >= 0.8 - 1e-6));
        for (cosine, expected) in [(0.79, 0.0), (0.825, 0.156_25), (0.85, 0.5), (0.95, 1.0)] {
            let place = 2.0 * Vec3::new((1.0f32 - cosine * cosine).sqrt(), 0.0, -cosine);
            let found = light.flux_density(place, [0.3, 0.6]).0.x;
            assert!((found - 0.25 * expected).abs() < 1e-5, "{cosine}: {found}");
        }
    }
}

#[test]
fn a_pattern_is_seen_in_the_directions_of_its_cells() {
    let (rows, columns) = (6, 10);
    let values = cells(rows, columns);
    let axes = [0, 1, 2].map(|axis| turned().row(axis));
    let intensity = Vec3::new(1.0, 2.0, 3.0);
    let half = Cone { axis: axes[2], cosine: 0.3, blend: 0.7 };
    for (cone, reach) in [(None, PI as f32), (Some(half), 0.3f32.acos())] {
        let pattern = Pattern::new(values.clone(), columns, axes, reach, cone.as_ref()).map(Arc::new);
        let light = Light::Lamp(Lamp { radius: 0.0, intensity, ..lamp(false, cone, pattern) });
        let photons = emitted(&light, 1 << 16);
        // The midpoint rule in cosine and angle, in cells cut into 40 x 40.
        let mut expected = [DVec3::ZERO; 4];
        for row in 0..rows {
            let [upper, lower] =
                [row, row + 1].map(|row| (row as f64 / rows as f64 * f64::from(reach)).cos());
            for part in 0..40 {
                let cosine = upper + (f64::from(part) + 0.5) / 40.0 * (lower - upper);
                let rise = ((cosine - 0.3) / 0.7).clamp(0.0, 1.0);
                let falloff = if cone.is_some() { (3.0 - 2.0 * rise) * rise * rise } else { 1.0 };
                let area = falloff * (upper - lower) / 40.0 * (TAU / (40.0 * columns as f64));
                for turn in 0..40 * columns {
                    let phi = TAU * (turn as f64 + 0.5) / (40.0 * columns as f64);
                    let sine = (1.0 - cosine * cosine).sqrt();
                    let way = [sine * phi.cos(), sine * phi.sin(), cosine];
                    let light = area * values[row * columns + turn / 40].as_dvec3() * intensity.as_dvec3();
                    expected[0] += light;
                    (0..3).for_each(|axis| expected[1 + axis] += way[axis] * light);
                }
            }
        }
        let power = |moment: &dyn Fn(&EmittedPhoton) -> f32| {
            photons.iter().map(|photon| f64::from(moment(photon)) * photon.power.as_dvec3()).sum::<DVec3>()
                / photons.len() as f64
        };
        let mut found = vec![power(&|_| 1.0)];
        found.extend(axes.iter().map(|&axis| power(&|photon| photon.direction.dot(axis))));
        for (found, expected_moment) in found.iter().zip(expected) {
            // A net of 2^16 points in cells whose channels differ: 3e-3 and less.
            let error = ((*found - expected_moment) / expected[0]).abs().max_element();
            assert!(error < 5e-3, "{cone:?}: {found} {expected_moment}");
        }
        // In a direction, shadow rays find the factor of its cell.
        let direction = axes[0] * 0.6f32.sin() * 2.2f32.cos()
            + axes[1] * 0.6f32.sin() * 2.2f32.sin()
            + axes[2] * 0.6f32.cos();
        let cell =
            (0.6 / reach * rows as f32) as usize * columns + (2.2 / TAU as f32 * columns as f32) as usize;
        let rise = (0.6f32.cos() - 0.3) / 0.7;
        let falloff = if cone.is_some() { (3.0 - 2.0 * rise) * rise * rise } else { 1.0 };
        let found = light.flux_density(2.0 * direction, [0.0; 2]).0;
        let expected = 0.25 * falloff * intensity * values[cell];
        assert!((found - expected).length() < 1e-5, "{cone:?}: {found} {expected}");
    }
}

/// Light and dark halves: at an angle a from the border the picture is as fine as 1/a, to a factor.
#[test]
fn a_pattern_is_fine_beside_its_edges() {
    let (rows, columns) = (128, 256);
    let half: Vec<Vec3> = (0..rows * columns)
        .map(|cell| if cell % columns < columns / 2 { Vec3::ONE } else { Vec3::ZERO })
        .collect();
    let pattern = Pattern::new(half, columns, [Vec3::X, Vec3::Y, Vec3::Z], PI as f32, None).map(Arc::new);
    let light = Light::Lamp(Lamp { radius: 0.0, ..lamp(false, None, pattern) });
    for angle in [0.05f32, 0.1, 0.2, 0.4] {
        let direction = Vec3::new(angle.cos(), angle.sin(), 0.0);
        let mut field = light.light_field(&EmittedPhoton::new(Vec3::ZERO, direction, Vec3::ONE, Vec3::ZERO));
        // A metre away the angular variance is a spatial one.
        field.travel(1.0);
        let [variance, ..] = field.slice();
        let found = TAU as f32 * angle * variance.sqrt();
        assert!(found > 0.3 && found < 3.0, "{angle}: {found}");
    }
}

/// Beyond the border of a wide cone's blend and inside of it, against finite differences of I(θ)/d² across the ray.
#[test]
fn the_spectrum_beside_a_cone_is_that_of_its_curvature() {
    let cone = Cone { axis: Vec3::Z, cosine: 0.5, blend: 0.4 };
    let light = Light::Lamp(Lamp { radius: 0.0, ..lamp(false, Some(cone), None) });
    for angle in [0.2f64, 0.7, 0.9] {
        let at = |u: f64, v: f64| {
            let (sine, cosine) = angle.sin_cos();
            let place = DVec3::new(sine, 0.0, cosine) + u * DVec3::new(cosine, 0.0, -sine) + v * DVec3::Y;
            let rise = ((place.normalize().z - 0.5) / 0.4).clamp(0.0, 1.0);
            (3.0 - 2.0 * rise) * rise * rise / place.length_squared()
        };
        let step = 1e-3;
        let relative = |a: f64, b: f64| (a - 2.0 * at(0.0, 0.0) + b) / (step * step * at(0.0, 0.0));
        let slope = (at(step, 0.0) - at(-step, 0.0)) / (2.0 * step * at(0.0, 0.0));
        let expected = [
            relative(at(step, 0.0), at(-step, 0.0)).abs().max(slope * slope),
            relative(at(0.0, step), at(0.0, -step)).abs(),
        ];
        let direction = DVec3::new(angle.sin(), 0.0, angle.cos()).as_vec3();
        let mut field = light.light_field(&EmittedPhoton::new(Vec3::ZERO, direction, Vec3::ONE, Vec3::ZERO));
        field.travel(1.0);
        let towards = DVec3::new(-angle.cos(), 0.0, angle.sin()).as_vec3();
        let found = [towards, Vec3::Y].map(|way| field.fluence().variance_along(way));
        for (found, expected) in found.into_iter().zip(expected) {
            let expected = expected / (4.0 * PI * PI);
            // Differences over 1e-3 rad of curves that turn within .4: 1e-5; f32 roots: 1e-6.
            assert!((f64::from(found) / expected - 1.0).abs() < 2e-3, "{angle}: {found} {expected}");
        }
    }
}
