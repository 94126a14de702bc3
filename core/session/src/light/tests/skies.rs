//! Light from infinitely far away, by sums over the sphere.

use super::*;
use std::f64::consts::{PI, TAU};

const MEDIA: Ball = Ball { center: Vec3::new(1.0, 0.0, 0.0), radius: 1.0 };
const SCENE: Ball = Ball { center: Vec3::ZERO, radius: 4.0 };

fn sky_of(values: Vec<Vec3>, columns: usize, turn: Mat3) -> Light {
    Light::Sky(Sky::around(values, columns, turn, MEDIA, SCENE).expect("light"))
}

/// Cells that differ a thousandfold, one of them as a sun.
fn uneven() -> (Vec<Vec3>, [usize; 2]) {
    let (rows, columns) = (6, 10);
    let mut values: Vec<Vec3> = cells(rows, columns).into_iter().map(|value| value * value).collect();
    values[columns + 7] = Vec3::splat(300.0);
    (4 * columns..4 * columns + 5).for_each(|cell| values[cell] = Vec3::ZERO);
    (values, [rows, columns])
}

#[test]
fn the_sky_shines_into_the_scene_with_its_radiance() {
    let (values, [rows, columns]) = uneven();
    let turn = turned();
    let light = sky_of(values.clone(), columns, turn);
    // Light and its mean direction, by sums over the sphere that are finer than the cells.
    let fine = 600;
    let (mut all, mut mean) = (DVec3::ZERO, [DVec3::ZERO; 3]);
    for k in 0..fine * fine {
        let [down, along] = [k / fine, k % fine].map(|i| (i as f64 + 0.5) / fine as f64);
        let (theta, azimuth) = (PI * down, PI * (1.0 - 2.0 * along));
        let cell = (down * rows as f64) as usize * columns + (along * columns as f64) as usize;
        let value = values[cell].as_dvec3() * (theta.sin() * (PI / fine as f64) * (TAU / fine as f64));
        let from = DVec3::new(theta.sin() * azimuth.cos(), theta.sin() * azimuth.sin(), theta.cos());
        let way = -(turn.as_dmat3().transpose() * from);
        all += value;
        (0..3).for_each(|axis| mean[axis] += value * way[axis]);
    }
    let photons = emitted(&light, 1 << 16);
    // All of it crosses a disk around all.
    let (middle, size) = light.middle();
    let disk = PI * (0.5 * f64::from(size)).powi(2);
    let power = |moment: &dyn Fn(&EmittedPhoton) -> f32| {
        photons.iter().map(|photon| f64::from(moment(photon)) * photon.power.as_dvec3()).sum::<DVec3>()
            / (photons.len() as f64 * disk)
    };
    assert!((power(&|_| 1.0) / all - 1.0).abs().max_element() < 5e-3, "{} {all}", power(&|_| 1.0));
    for (axis, expected) in mean.into_iter().enumerate() {
        let found = power(&|photon| photon.direction[axis]);
        assert!(((found - expected) / all).abs().max_element() < 5e-3, "{axis}: {found} {expected}");
    }
    // Three of four are aimed at the media, and all start ahead of everything.
    let aside = |photon: &EmittedPhoton| {
        let offset = photon.origin - middle;
        (offset - offset.dot(photon.direction) * photon.direction).length()
    };
    let aimed = mean_of(&photons, |photon| f64::from(u8::from(aside(photon) < 1.01 * MEDIA.radius)));
    assert!((aimed - 0.75).abs() < 0.01, "{aimed}");
    let is_ahead = |photon: &EmittedPhoton| {
        let far = |ball: Ball| {
            let offset = photon.origin - ball.center;
            offset.length() > ball.radius || offset.dot(photon.direction) > 0.0
        };
        far(MEDIA) && far(SCENE)
    };
    assert!(photons.iter().all(is_ahead));
}

#[test]
fn shadow_rays_find_the_sky_in_the_directions_of_its_cells() {
    let (values, [_, columns]) = uneven();
    let turn = turned();
    let light = sky_of(values.clone(), columns, turn);
    let place = Vec3::new(0.4, 0.3, -0.5);
    let mut random = Random::new([2, 7, 1, 8]);
    let (mut sums, mut means) = (vec![Vec3::ZERO; values.len()], DVec3::ZERO);
    let count = 200_000;
    for _ in 0..count {
        let (density, from) = light.flux_density(place, [random.uniform(), random.uniform()]);
        let towards = turn * (from - place).normalize();
        let row = (towards.z.acos() * (6.0 / PI as f32)) as usize;
        let column = ((1.0 - towards.y.atan2(towards.x) / PI as f32) * 5.0) as usize;
        sums[row.min(5) * columns + column.min(9)] += density / count as f32;
        means += density.as_dvec3() / f64::from(count);
    }
    for (cell, (sum, value)) in sums.iter().zip(&values).enumerate() {
        let [upper, lower] = [cell / columns, cell / columns + 1].map(|row| (row as f64 * PI / 6.0).cos());
        let expected = value.as_dvec3() * ((upper - lower) * TAU / 10.0);
        // Each cell is drawn by its share of the light: 1/√n of that is noise.
        let noise = 5.0 * (expected.max_element() * means.max_element() / f64::from(count)).sqrt();
        assert!((sum.as_dvec3() - expected).abs().max_element() <= noise + 1e-6, "{cell}: {sum} {expected}");
    }
}

#[test]
fn an_even_sky_is_the_same_from_everywhere_and_lights_each_surface_alike() {
    for [rows, columns] in [[1, 1], [8, 16]] {
        let light = sky_of(vec![Vec3::splat(2.0); rows * columns], columns, turned());
        let mut random = Random::new([1, 4, 1, 4]);
        let place = Vec3::new(0.4, 0.3, -0.5);
        for _ in 0..100 {
            let (density, from) = light.flux_density(place, [random.uniform(), random.uniform()]);
            assert!((density.x / (8.0 * PI as f32) - 1.0).abs() < 1e-5, "{density}");
            assert!(from.length() > SCENE.radius, "{from}");
        }
        let count = 100_000;
        let normal = Vec3::new(0.48, 0.6, 0.64);
        let sum: f32 = (0..count).map(|_| light.irradiance(place, normal, &mut random).0.x).sum();
        // π L; the cosine varies by .65 of its mean: 2e-3.
        assert!((sum / count as f32 / (2.0 * PI as f32) - 1.0).abs() < 8e-3, "{sum}");
    }
}

#[test]
fn a_skys_picture_is_seen_upright() {
    // Rows from +Z, columns from -X by way of +Y, +X and -Y.
    let values: Vec<Vec3> = (1..=8).map(|value| Vec3::splat(value as f32)).collect();
    let light = sky_of(values, 4, Mat3::IDENTITY);
    for (direction, expected) in [
        ([-1.0, 0.1, 0.1], 1.0),
        ([0.1, 1.0, 0.1], 2.0),
        ([1.0, -0.1, 0.1], 3.0),
        ([-0.1, -1.0, 0.1], 4.0),
        ([-0.1, 1.0, -0.1], 5.0),
        ([1.0, -0.1, -0.1], 7.0),
    ] {
        let direction = Vec3::from_array(direction).normalize();
        assert_eq!(seen_along(&light, Vec3::ZERO, direction, f32::INFINITY).x, expected, "{direction}");
        assert_eq!(seen_along(&light, Vec3::ZERO, direction, 10.0), Vec3::ZERO);
    }
    for (values, columns) in
        [(vec![], 4), (vec![Vec3::ONE; 3], 2), (vec![Vec3::ZERO; 4], 2), (vec![-Vec3::ONE], 1)]
    {
        assert!(Sky::around(values, columns, Mat3::IDENTITY, MEDIA, SCENE).is_none());
    }
}

/// A sky that is dark but for one small cell is a sun: a disk of its solid angle.
#[test]
fn a_small_bright_cell_has_the_spectrum_of_a_sun() {
    let columns = 128;
    let mut values = vec![Vec3::ZERO; 64 * columns];
    values[32 * columns + 5] = Vec3::ONE;
    let light = sky_of(values, columns, Mat3::IDENTITY);
    let photon = emitted(&light, 1)[0];
    let variance = f64::from(light.light_field(&photon).root[0].powi(2));
    let solid_angle = (PI / 64.0) * (TAU / 128.0);
    let disk = 1.0 / (PI * solid_angle);
    // The cell's neighbours are dark: three times the mean, over the cell's width.
    let gradient = (3.0 * 64.0 / PI).powi(2) / (4.0 * PI * PI);
    assert!((variance / disk.max(gradient) - 1.0).abs() < 0.02, "{variance} {disk} {gradient}");
}

#[test]
fn a_sun_aimed_by_two_balls_has_its_irradiance_in_both() {
    let axis = Vec3::new(0.6, 0.0, -0.8);
    let light = Light::Sun(Sun::around(axis, 0.01, Vec3::splat(2.0), MEDIA, SCENE));
    let photons = emitted(&light, 1 << 15);
    // In the media's ball, and in a ring that reaches into the scene's: power over area. The density is known to 1/√n.
    for (low, high, tolerance) in [(0.0, 0.9, 0.01), (1.5, 4.5, 0.03)] {
        let power = mean_of(&photons, |photon| {
            let offset = photon.origin - MEDIA.center;
            let aside = (offset - offset.dot(axis) * axis).length();
            if (low..high).contains(&aside) { f64::from(photon.power.x) } else { 0.0 }
        });
        let irradiance = power / (PI * f64::from(high * high - low * low));
        assert!((irradiance / 2.0 - 1.0).abs() < tolerance, "{low}: {irradiance}");
    }
}
