//! Areas and meshes, by closed forms and quadrature.

use super::*;
use std::f64::consts::PI;

fn area(spread: f32, round: bool) -> Area {
    let (edge_u, edge_v) = (2.0 * Vec3::X, 3.0 * Vec3::Y);
    Area { center: Vec3::ZERO, edge_u, edge_v, round, spread, radiance: Vec3::ONE }
}

#[test]
fn an_areas_flux_and_cosines_are_lamberts() {
    let photons = emitted(&Light::Area(area(FRAC_PI_2, false)), 1 << 15);
    let flux = mean_of(&photons, |photon| f64::from(photon.power.x));
    assert!((flux / (6.0 * PI) - 1.0).abs() < 1e-5, "{flux}");
    let cosine = mean_of(&photons, |photon| f64::from(photon.direction.z));
    assert!((cosine - 2.0 / 3.0).abs() < 1e-3, "{cosine}");
    let far = photons.iter().map(|photon| photon.origin.abs()).fold(Vec3::ZERO, Vec3::max);
    assert!((far.x - 1.0).abs() < 1e-3 && (far.y - 1.5).abs() < 1e-3, "{far}");
    // Variance of a uniform number in -1 to 1: 1/3.
    let variance = mean_of(&photons, |photon| f64::from(photon.origin.x).powi(2));
    assert!((variance - 1.0 / 3.0).abs() < 2e-3, "{variance}");
}

#[test]
fn a_spread_keeps_the_flux_and_narrows_it() {
    for spread in [0.05f64, 0.5, 1.2] {
        let photons = emitted(&Light::Area(area(spread as f32, true)), 1 << 16);
        let flux = mean_of(&photons, |photon| f64::from(photon.power.x));
        // PI/4 of a square's area.
        assert!((flux / (PI * PI * 6.0 / 4.0) - 1.0).abs() < 3e-3, "{spread}: {flux}");
        assert!(photons.iter().all(|photon| f64::from(photon.direction.z) > spread.cos() - 1e-5));
        // Weighted by power, the mean of tan x: with L ~ tan a - tan x, both integrals by the midpoint rule.
        let (mut sum, mut expected) = (0.0, 0.0);
        for step in 0..10_000 {
            let x = (f64::from(step) + 0.5) / 10_000.0 * spread;
            let density = (spread.tan() - x.tan()) * x.cos() * x.sin();
            sum += density;
            expected += density * x.tan();
        }
        let tangent =
            |photon: &EmittedPhoton| f64::from(photon.direction.truncate().length() / photon.direction.z);
        let found = mean_of(&photons, |photon| tangent(photon) * f64::from(photon.power.x)) / flux;
        assert!((found / (expected / sum) - 1.0).abs() < 5e-3, "{spread}: {found} {}", expected / sum);
    }
}

/// Radiance x cosine / distance², over all of the light.
#[test]
fn shadow_rays_find_an_areas_light_by_quadrature() {
    let places = [[0.3, -0.2, 0.05], [0.9, 1.4, 0.3], [0.0, 0.0, 2.0], [2.5, -1.0, 1.0], [30.0, 10.0, 50.0]];
    for (spread, round) in [(FRAC_PI_2, true), (1.2, false), (0.5, true), (0.02, false), (0.02, true)] {
        let light = Light::Area(area(spread, round));
        for place in places.map(DVec3::from_array) {
            // A square around the place's foot is all that a narrow honeycomb shows of the light.
            let reach = if spread < 0.1 { place.z * f64::from(spread).tan() } else { 100.0 };
            let low = [(place.x - reach).max(-1.0), (place.y - reach).max(-1.5)];
            let high = [(place.x + reach).min(1.0), (place.y + reach).min(1.5)];
            let steps = 1000;
            let mut exact = 0.0;
            for k in 0..steps * steps {
                let at = |axis: usize, step: i32| {
                    low[axis] + (f64::from(step) + 0.5) / f64::from(steps) * (high[axis] - low[axis])
                };
                let (x, y) = (at(0, k % steps), at(1, k / steps));
                if round && x * x + y * y / 2.25 > 1.0 {
                    continue;
                }
                let offset = place - DVec3::new(x, y, 0.0);
                let tangent = offset.truncate().length() / offset.z;
                let a = f64::from(spread);
                let factor =
                    if spread < FRAC_PI_2 { (a.tan() - tangent).max(0.0) / (a.tan() - a) } else { 1.0 };
                exact += factor * offset.z / offset.length().powi(3);
            }
            let cell = (high[0] - low[0]).max(0.0) * (high[1] - low[1]).max(0.0) / f64::from(steps * steps);
            let exact = exact * cell;
            let found = arriving(&light, place.as_vec3(), [400; 2]);
            // The grid's cells are cut by the ellipse and by the honeycomb's border: 1/400 of what is drawn there at most; f32's tan a - a
            // has 1e-4 of it, and the quadrature 1e-3 at the nearest place.
            assert!((found - exact).abs() < 5e-3 * exact + 1e-9, "{spread} {round} {place}: {found} {exact}");
        }
        assert_eq!(light.flux_density(Vec3::new(0.1, 0.1, -0.5), [0.3, 0.6]).0, Vec3::ZERO);
    }
}

#[test]
fn a_shining_mesh_shines_on_both_sides_by_area() {
    let flat = |size: f32, z: f32| [[0.0, 0.0, z], [size, 0.0, z], [0.0, size, z]].map(Vec3::from_array);
    let light =
        ShiningMesh::new(&[flat(1.0, 0.0), flat(0.0, 2.0), flat(2.0, 5.0)], Vec3::ONE).expect("areas");
    let photons = emitted(&Light::Mesh(light), 1 << 15);
    let share =
        |test: fn(&EmittedPhoton) -> bool| mean_of(&photons, |photon| f64::from(u8::from(test(photon))));
    let flux = mean_of(&photons, |photon| f64::from(photon.power.x));
    assert!((flux / (2.0 * PI * 2.5) - 1.0).abs() < 1e-5, "{flux}");
    assert!((share(|photon| photon.origin.z > 2.5) - 0.8).abs() < 2e-3);
    assert!((share(|photon| photon.direction.z > 0.0) - 0.5).abs() < 2e-3);
    let cosine = mean_of(&photons, |photon| f64::from(photon.direction.z.abs()));
    assert!((cosine - 2.0 / 3.0).abs() < 1e-3, "{cosine}");
    // It starts on the side that it leaves.
    let side = |photon: &EmittedPhoton| photon.normal.dot(photon.direction) > 0.0;
    assert!(photons.iter().all(side));
    let lifted = |photon: &EmittedPhoton| {
        let height = if photon.origin.z > 2.5 { photon.origin.z - 5.0 } else { photon.origin.z };
        height * photon.direction.z > 0.0 && height.abs() < 1e-4
    };
    assert!(photons.iter().all(lifted));
    assert!(ShiningMesh::new(&[flat(0.0, 1.0)], Vec3::ONE).is_none());
    assert!(ShiningMesh::new(&[flat(f32::NAN, 1.0)], Vec3::ONE).is_none());
}

/// Each triangle from both of its sides, by the midpoint rule over its area.
#[test]
fn shadow_rays_find_a_meshs_light_by_quadrature() {
    let triangles = [
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.2]],
        [[0.0, 0.0, 0.0], [0.0, 1.0, 0.2], [-0.3, 0.4, 0.9]],
        [[3.0, 0.0, 1.0], [3.1, 0.0, 1.0], [3.0, 0.1, 1.3]],
    ]
    .map(|corners| corners.map(Vec3::from_array));
    let light = Light::Mesh(ShiningMesh::new(&triangles, Vec3::ONE).expect("areas"));
    for place in [[0.2, 0.2, 0.5], [0.2, 0.2, -0.3], [2.9, 0.1, 1.1], [-8.0, 3.0, 1.0]].map(DVec3::from_array)
    {
        let mut exact = 0.0;
        for [a, b, c] in triangles.map(|corners| corners.map(|corner| corner.as_dvec3())) {
            let steps = 600;
            let across = 0.5 * (b - a).cross(c - a);
            for k in 0..steps * steps {
                let [u, v] = [k % steps, k / steps].map(|i| (f64::from(i) + 0.5) / f64::from(steps));
                let root = u.sqrt();
                let offset = place - (a + root * (1.0 - v) * (b - a) + root * v * (c - a));
                exact += offset.dot(across).abs() / offset.length().powi(3) / f64::from(steps * steps);
            }
        }
        let found = arriving(&light, place.as_vec3(), [20_000, 60]);
        assert!((found / exact - 1.0).abs() < 5e-3, "{place}: {found} {exact}");
    }
}

/// A ball of some 8,000 triangles: its light arrives from the side before a place and from the far one, each as from the whole ball.
#[test]
fn few_shadow_rays_find_the_light_of_many_triangles() {
    let (around, down) = (128, 64);
    let at = |row: usize, column: usize| {
        let (theta, phi) = (PI * row as f64 / f64::from(down), 2.0 * PI * column as f64 / f64::from(around));
        DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()).as_vec3()
    };
    let quads = (0..down as usize * around as usize).map(|k| (k / around as usize, k % around as usize));
    let triangles: Vec<[Vec3; 3]> = quads
        .flat_map(|(row, column)| {
            let corners =
                [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
            [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
        })
        .collect();
    let light = Light::Mesh(ShiningMesh::new(&triangles, Vec3::ONE).expect("areas"));
    let mut random = Random::new([3, 3, 3, 7]);
    for distance in [1.02, 1.3, 3.0, 30.0] {
        let place = (distance * DVec3::new(0.48, 0.6, -0.64)).as_vec3();
        let exact = 4.0 * PI * (1.0 - (1.0 - 1.0 / (distance * distance)).sqrt());
        let count = 40_000;
        let (mut mean, mut square) = (0.0, 0.0);
        for _ in 0..count {
            let found = f64::from(light.flux_density(place, [random.uniform(), random.uniform()]).0.x);
            mean += found / f64::from(count);
            square += found * found / f64::from(count);
        }
        let deviation = (square / (mean * mean) - 1.0).sqrt();
        println!("{distance} radii: {:.4}, deviation {deviation:.2}", mean / exact);
        // The ball's facets cut 1e-3 of its radius off, which next to it is a few per cent of what is seen.
        let facets = if distance < 1.1 { 0.03 } else { 0.005 };
        assert!((mean / exact - 1.0).abs() < facets + 4.0 * deviation / 200.0, "{distance}: {mean} {exact}");
        // Drawn by area it would be 17 next to the ball.
        assert!(deviation < 2.0, "{distance}: {deviation}");
    }
}

/// Triangles two of whose corners lie a rounding apart, in the plane that places are near to: cosines to both are rounded to more than 1.
#[test]
fn slivers_send_finite_light_everywhere() {
    let sliver = [[0.5, 0.0, -0.5], [0.5, 0.03, 0.5], [0.5, -4.371139e-8, -0.5]].map(Vec3::from_array);
    let thin = [[0.1, 0.2, 0.3], [0.1, 0.2, 0.300_000_1], [0.4, 0.2, 0.3]].map(Vec3::from_array);
    let light = Light::Mesh(ShiningMesh::new(&[sliver, thin], Vec3::ONE).expect("areas"));
    let mut random = Random::new([7, 7, 7, 8]);
    for number in 0..200_000 {
        let at = Vec3::new(random.uniform(), random.uniform(), random.uniform());
        // All around, in front of a wall as in a scene that panicked, and next to the first one's plane.
        let place = match number % 3 {
            0 => 4.0 * at - 2.0,
            1 => Vec3::new(12.0 * at.x - 6.0, 12.0 * at.y - 6.0, -11.0 + 0.5 * at.z),
            _ => Vec3::new(0.5 + 1e-6 * (at.x - 0.5), at.y - 0.5, 2.0 * at.z - 1.0),
        };
        let (density, from) = light.flux_density(place, [random.uniform(), random.uniform()]);
        assert!(density.is_finite() && density.min_element() >= 0.0, "{place}: {density}");
        assert!(from.is_finite(), "{place}: {from}");
    }
}

/// A place is in the light of an area where a thousand of its points say so; there `expected` is above 0, and on average it is what they send.
#[test]
fn what_is_expected_of_lamps_is_about_what_they_send_and_nowhere_nothing() {
    let mut random = Random::new([7, 7, 7, 9]);
    for light in lights() {
        let mut ratios = Vec::new();
        for _ in 0..300 {
            let mut number = || random.uniform();
            // Within what sun and sky shine on.
            let place = 0.9 * Vec3::new(2.0 * number() - 1.0, 2.0 * number() - 1.5, 2.0 * number() - 1.0);
            let count = 256;
            let mut look = || light.flux_density(place, [number(), number()]).0.element_sum();
            let sent = (0..count).map(|_| look()).sum::<f32>();
            let expected = light.expected(place).0.element_sum();
            if sent > 0.0 {
                // A pattern's dark cells are left out, and cones that are all but missed.
                assert!(expected > 0.0, "{light:?}, {place}: {sent}");
                ratios.push(f64::from(expected * count as f32 / sent));
            }
        }
        ratios.sort_by(f64::total_cmp);
        if ratios.is_empty() {
            continue;
        }
        let median = ratios[ratios.len() / 2];
        println!("{median:.2} of {}", ratios.len());
        // It places shadow rays, which are divided by it: a factor of 3 is noise.
        assert!((0.3..3.0).contains(&median), "{light:?}: {median}");
    }
}
