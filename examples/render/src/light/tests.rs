use super::*;
use crate::random::Emission;
use crate::scene::Scene;
use glam::DVec3;
use std::path::Path;

const AXIS: Vec3 = Vec3::new(0.2, -1.0, 0.4);
const RADIANCE: Vec3 = Vec3::new(3.0, 2.0, 1.0);

fn sun(angle: f32) -> Light {
    let scene = format!(
        "[camera]\nposition = [0, 0, -9]\nlook_at = [0, 0, 0]\nvertical_fov = 40\nwidth = 8\nheight = 8\n\
         [[medium]]\nname = \"fog\"\nscattering = 0.1\nabsorption = 0\n\
         [[object]]\nshape = \"box\"\nmin = [-1, -1.5, -1]\nmax = [1, 1, 1]\nmaterial = {{ dielectric = {{ index = 1 }} }}\ninside = \"fog\"\n\
         [[object]]\nshape = \"rectangle\"\ncorner = [-4, -2, -4]\nedge_u = [0, 0, 8]\nedge_v = [8, 0, 0]\nmaterial = \"black\"\n\
         [[light]]\nkind = \"sun\"\ndirection = [{}, {}, {}]\nangle = {angle}\nirradiance = [3, 2, 1]\n",
        AXIS.x, AXIS.y, AXIS.z
    );
    Scene::parse(&scene, "sun", Path::new("")).expect("a valid scene").lights[0]
}

fn lights() -> [Light; 7] {
    let position = Vec3::new(0.3, 1.0, -0.2);
    let direction = AXIS.normalize();
    let (edge_u, edge_v) = (Vec3::new(0.5, 0.1, 0.0), Vec3::new(0.1, 0.05, 0.3));
    let corner = position - 0.5 * (edge_u + edge_v);
    [
        Light::Point { position, intensity: RADIANCE },
        Light::Spot { position, direction, intensity: RADIANCE, inner_angle: 0.3, outer_angle: 0.6 },
        Light::Disk { center: position, normal: direction, radius: 0.2, radiance: RADIANCE },
        Light::Rectangle { corner, edge_u, edge_v, radiance: RADIANCE },
        Light::Sphere { center: position, radius: 0.2, radiance: RADIANCE },
        sun(0.0),
        sun(30.0),
    ]
}

/// What photons carry through a ball is what shadow rays from inside of it find: power x chord over the ball's volume, and the mean of the
/// flux density over its places.
#[test]
fn photons_bring_the_light_that_shadow_rays_find() {
    let (center, radius) = (Vec3::new(0.4, -0.5, 0.1), 0.3f32);
    for (number, light) in lights().into_iter().enumerate() {
        let mut random = Random::new([1, 2, 3, number as u32]);
        let count = 400_000;
        let (mut carried, mut squares) = (0.0, 0.0);
        for index in 0..count {
            let mut sampler = PathSampler::new(Emission::Independent, 7, 0, index);
            let photon = light.emit(&mut sampler);
            let offset = center - photon.origin;
            let along = offset.dot(photon.direction);
            let aside2 = (offset - along * photon.direction).length_squared();
            if along > 0.0 && aside2 < radius * radius {
                let chord = 2.0 * (radius * radius - aside2).sqrt();
                let brings = f64::from(photon.power.x * chord / (4.0 / 3.0 * PI * radius.powi(3)));
                carried += brings;
                squares += brings * brings;
            }
        }
        let places = 40_000;
        let mut found = 0.0;
        for _ in 0..places {
            let place = loop {
                let at = Vec3::new(random.uniform(), random.uniform(), random.uniform()) * 2.0 - 1.0;
                if at.length_squared() < 1.0 {
                    break center + radius * at;
                }
            };
            found += f64::from(light.flux_density(place, [random.uniform(), random.uniform()]).0.x);
        }
        let (carried, error) = (carried / f64::from(count), squares.sqrt() / f64::from(count));
        let found = found / f64::from(places);
        assert!(error < 0.02 * carried, "{light:?}: too few to tell, {error} of {carried}");
        // 1 % for the noise of the places: near them light varies by half, which 40,000 bring to 3e-3.
        assert!((carried - found).abs() < 4.0 * error + 0.01 * found, "{light:?}: {carried} {error} {found}");
    }
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
    let (radius, radiance) = (0.2, RADIANCE);
    let disk = Light::Disk { center: Vec3::ZERO, normal: Vec3::Y, radius, radiance };
    let mut random = Random::new([9, 10, 11, 12]);
    for [aside, height] in [[0.0, 0.002], [0.19, 0.002], [0.21, 0.01], [0.3, 0.1], [0.1, 1.0], [2.0, 1.0]] {
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

/// Mean direction of a polygon's light times its solid angle, from a place (J. Lambert 1760): ½ Σ angle of each side x normal of its plane.
fn lambert(corners: &[DVec3], place: DVec3) -> DVec3 {
    let rays: Vec<DVec3> = corners.iter().map(|corner| (*corner - place).normalize()).collect();
    let sides = rays.iter().zip(rays.iter().cycle().skip(1));
    let sum = sides.map(|(a, b)| a.cross(*b).normalize_or_zero() * a.angle_between(*b)).sum::<DVec3>();
    // Seen from the front they run clockwise.
    -0.5 * sum
}

/// Places before the rectangle of [`lights`]: next to it, above a corner, aslant, far, very far.
fn before_rectangle() -> ([DVec3; 3], Vec<DVec3>) {
    let Light::Rectangle { corner, edge_u, edge_v, .. } = lights()[3] else { panic!("a rectangle") };
    let [corner, u, v] = [corner, edge_u, edge_v].map(|v| v.as_dvec3());
    let normal = u.cross(v).normalize();
    let mut places = Vec::new();
    for [a, b] in [[0.5, 0.5], [0.02, 0.97], [0.0, 0.0], [1.4, 0.3], [-3.0, 2.0]] {
        for height in [1e-3, 0.03, 0.3, 3.0, 100.0] {
            places.push(corner + a * u + b * v + height * normal);
        }
    }
    ([corner, u, v], places)
}

#[test]
fn a_rectangle_is_seen_under_lamberts_vector_and_its_solid_angle() {
    let ([corner, u, v], places) = before_rectangle();
    let light = lights()[3];
    let Light::Rectangle { corner: c, edge_u, edge_v, .. } = light else { panic!("a rectangle") };
    for place in places {
        let (mut vector, mut solid, mut most) = (DVec3::ZERO, 0.0, 0f64);
        let side = 500;
        for k in 0..side * side {
            let xi = [k % side, k / side].map(|i| (i as f32 + 0.5) / side as f32);
            let (weight, point) = sample_rectangle(c, edge_u, edge_v, place.as_vec3(), xi);
            let (weight, offset) = (f64::from(weight), point.as_dvec3() - corner);
            let normal = u.cross(v);
            let at = |edge: DVec3, other: DVec3| {
                let across = other.cross(normal);
                offset.dot(across) / edge.dot(across)
            };
            let inside = |share: f64| (-1e-4..1.0001).contains(&share);
            assert!(inside(at(u, v)) && inside(at(v, u)), "{place} {xi:?}: {point}");
            assert!(offset.dot(normal.normalize()).abs() < 1e-6, "{place} {xi:?}: {point}");
            vector += weight * (point.as_dvec3() - place).normalize() / f64::from(side * side);
            solid += weight / f64::from(side * side);
            most = most.max(weight);
        }
        // The place is rounded to f32, 1e-7 of the scene; it is 1e-3 from the rectangle at least. The numbers' grid may be cut anywhere between the halves: 1/500.
        let expected = lambert(&[corner, corner + u, corner + u + v, corner + v], place);
        let error = (vector - expected).length() / solid;
        assert!(error < 1e-3, "{place}: {vector} {expected} {solid}");
        assert!(most < 1.3 * solid, "{place}: {most} of {solid}");
        // By quadrature over the rectangle, where it is no needle.
        let nearest = (place - corner).dot(u.cross(v).normalize());
        if nearest > 0.02 {
            let steps = 400;
            let sum = (0..steps * steps).map(|k| {
                let [a, b] = [k % steps, k / steps].map(|i| (f64::from(i) + 0.5) / f64::from(steps));
                nearest / (corner + a * u + b * v - place).length().powi(3)
            });
            let exact = sum.sum::<f64>() * u.cross(v).length() / f64::from(steps * steps);
            assert!((solid / exact - 1.0).abs() < 1e-3, "{place}: {solid} {exact}");
        }
    }
    let behind = (corner + 0.5 * (u + v) - 0.1 * u.cross(v)).as_vec3();
    assert_eq!(light.flux_density(behind, [0.3, 0.6]).0, Vec3::ZERO);
}

#[test]
fn a_sphere_is_seen_under_its_cone() {
    let (center, radius) = (Vec3::new(0.3, 1.0, -0.2), 0.2);
    let light = Light::Sphere { center, radius, radiance: RADIANCE };
    for distance in [1.001, 1.1, 2.0, 20.0, 2000.0] {
        let place = center + radius * distance * Vec3::new(0.6, 0.0, -0.8);
        let sin2 = (f64::from(radius) / f64::from(place.distance(center))).powi(2);
        let exact = std::f64::consts::TAU * sin2 / (1.0 + (1.0 - sin2).sqrt());
        let mut vector = DVec3::ZERO;
        for k in 0..64 * 64 {
            let xi = [k % 64, k / 64].map(|i| (i as f32 + 0.5) / 64.0);
            let (density, from) = light.flux_density(place, xi);
            assert!((f64::from(density.x) / 3.0 / exact - 1.0).abs() < 1e-5, "{distance}: {density} {exact}");
            assert!((from.distance(center) / radius - 1.0).abs() < 1e-4, "{distance}: {from}");
            // On the side that the place sees.
            assert!((from - center).dot(place - from) > -1e-4 * radius, "{distance}: {from}");
            vector += (from - place).as_dvec3().normalize() / 4096.0;
        }
        // Mean over the cone of the directions: (1 + cos)/2 along its axis.
        let along = (center - place).as_dvec3().normalize();
        let mean = 0.5 * (1.0 + (1.0 - sin2).max(0.0).sqrt());
        assert!((vector - mean * along).length() < 1e-3, "{distance}: {vector} {mean}");
    }
    assert_eq!(light.flux_density(center + 0.1 * Vec3::X, [0.5, 0.5]).0, Vec3::ZERO);
}

#[test]
fn a_sun_has_its_irradiance_across_its_direction() {
    for angle in [0.0, 0.5, 30.0, 90.0] {
        let light = sun(angle);
        let count = 40_000;
        let mut random = Random::new([1, 5, 9, 13]);
        let direction = AXIS.normalize();
        let normal = -(direction + 0.3 * direction.any_orthonormal_vector()).normalize();
        let sum: Vec3 = (0..count).map(|_| light.irradiance(Vec3::splat(0.3), normal, &mut random).0).sum();
        // No part of the sun, 45° wide at most, is behind a surface tilted by 17°: the mean over its disk is that of the cosine.
        let expected = RADIANCE * -normal.dot(direction);
        // A direction's cosine varies by 20 % at most: 1e-3 of the mean.
        assert!(
            (sum / count as f32 / expected - 1.0).abs().max_element() < 4e-3,
            "{angle}: {sum} {expected}"
        );
    }
}

/// Distances from 0.5 to 4 along a ray at which there is light of a light.
fn lit(light: &Light, origin: Vec3, direction: Vec3) -> impl Iterator<Item = (f32, bool)> {
    (0..50).map(move |step| {
        let distance = 0.5 + 3.5 * (step as f32 + 0.5) / 50.0;
        let place = origin + distance * direction;
        // Of a sun with an angle, several of its directions.
        let numbers = [[0.0; 2], [0.9, 0.1], [0.9, 0.4], [0.9, 0.7]];
        (distance, numbers.iter().any(|&xi| light.flux_density(place, xi).0.x > 0.0))
    })
}

#[test]
fn the_lit_stretch_holds_all_places_with_light_and_no_others() {
    let lights = lights();
    let mut random = Random::new([5, 6, 7, 8]);
    let mut seen = [0; 2];
    for _ in 0..2000 {
        let mut place = || Vec3::new(random.uniform(), random.uniform(), random.uniform()) * 4.0 - 2.0;
        let (origin, direction) = (place(), place().normalize());
        for light in lights {
            // Rays of a sun's own size, which is that of its scene.
            let scale = if let Light::Sun(_) = light { 4.0 } else { 1.0 };
            let origin = scale * origin;
            let found = light.lit_stretch(origin, direction, 0.5, 4.0);
            seen[usize::from(found.is_some())] += 1;
            let (from, to) = found.unwrap_or((f32::MAX, f32::MIN));
            // What a sphere hides of a ray may lie in the middle of it, and a sun's directions need not all reach as far as the widest.
            let is_exact = !matches!(light, Light::Sphere { .. }) && light != lights[6];
            for (distance, is_lit) in lit(&light, origin, direction) {
                // An angle from its f32 cosine is good to 1e-4 at the cone's edge, where the fall-off is below 1e-6.
                let clear = (distance - from).abs().min((distance - to).abs()) > 1e-3;
                let is_inside = (from..to).contains(&distance);
                let agrees = is_lit == is_inside || (!is_exact && is_inside);
                assert!(!clear || agrees, "{light:?} {distance}: {found:?}");
            }
        }
    }
    assert!(seen[0] > 500 && seen[1] > 500, "{seen:?}");
}

#[test]
fn the_lit_stretch_of_a_ray_without_end_has_none_either_where_it_stays_in_the_light() {
    let down = AXIS.normalize();
    let lights = lights();
    for light in lights {
        let (_, to) = light.lit_stretch(Vec3::new(0.0, 3.0, 0.0), down, 0.0, f32::INFINITY).unwrap();
        // Where a cylinder ends whose axis is rounded.
        assert!(to > 1e6, "{light:?}: {to}");
    }
    assert!(lights[1].lit_stretch(Vec3::new(0.0, 3.0, 0.0), -down, 0.0, f32::INFINITY).is_none());
}
