mod flat;
mod lamps;
mod skies;

use super::directions::cap_direction;
use super::*;
use crate::random::Emission;
use crate::scene::Material;
use crate::scene::made::{BOUND, Made, camera, cuboid, rectangle};
use glam::{DVec3, Mat3};
use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

const AXIS: Vec3 = Vec3::new(0.2, -1.0, 0.4);
const RADIANCE: Vec3 = Vec3::new(3.0, 2.0, 1.0);

fn sun(angle: f32) -> Light {
    let camera = camera([0.0, 0.0, -9.0], [0.0; 3], 40.0, [8, 8]);
    let floor = rectangle([-4.0, -2.0, -4.0], [0.0, 0.0, 8.0], [8.0, 0.0, 0.0]);
    let made = Made::new(camera)
        .fog(0.1, 0.0)
        .filled(cuboid([-1.0, -1.5, -1.0], [1.0, 1.0, 1.0]), BOUND, 0)
        .object(floor, Material::Black)
        .sun(AXIS.to_array(), angle, RADIANCE);
    made.scene().lights[0].clone()
}

/// Places of lights in [`lights`].
const SPHERE: usize = 4;
const WIDE_SUN: usize = 6;
const FIRST_ALL_AROUND: usize = 13;

/// Those before [`FIRST_ALL_AROUND`] are seen in one direction, about.
fn lights() -> Vec<Light> {
    let position = Vec3::new(0.3, 1.0, -0.2);
    let direction = AXIS.normalize();
    let (edge_u, edge_v) = (Vec3::new(0.5, 0.1, 0.0), Vec3::new(0.1, 0.05, 0.3));
    let corner = position - 0.5 * (edge_u + edge_v);
    let cone = Some(Cone { axis: direction, cosine: 0.8, blend: 0.1 });
    let lamp = |radius, soft, cone: Option<Cone>, pattern| {
        let (intensity, pattern) = (RADIANCE, pattern_if(pattern, cone.as_ref()));
        Light::Lamp(Lamp { position, intensity, radius, soft, cone, pattern, glow: 0.5 })
    };
    let area = |round, spread| {
        Light::Area(Area { center: position, edge_u, edge_v, round, spread, radiance: RADIANCE })
    };
    vec![
        Light::Point { position, intensity: RADIANCE },
        Light::Spot { position, direction, intensity: RADIANCE, inner_angle: 0.3, outer_angle: 0.6 },
        Light::Disk { center: position, normal: direction, radius: 0.2, radiance: RADIANCE },
        Light::Rectangle { corner, edge_u, edge_v, radiance: RADIANCE },
        Light::Sphere { center: position, radius: 0.2, radiance: RADIANCE },
        sun(0.0),
        sun(30.0),
        lamp(0.0, false, None, true),
        lamp(0.2, true, cone, false),
        lamp(0.2, false, cone, false),
        lamp(0.2, false, None, false),
        area(false, 0.9),
        area(true, FRAC_PI_2),
        // So large that the ball below lies partly inside.
        lamp(1.5, false, None, false),
        lamp(0.2, true, cone, true),
        lamp(1.5, false, None, true),
        lamp(1.5, false, cone, false),
        lamp(1.5, true, None, false),
        lamp(1.5, true, cone, true),
        mesh(),
        sky(),
    ]
}

/// Light and dark cells, none of them grey.
fn cells(rows: usize, columns: usize) -> Vec<Vec3> {
    let mut random = Random::new([rows as u32, columns as u32, 5, 6]);
    let mut cell = |index: usize| {
        let color = Vec3::new(random.uniform(), random.uniform(), random.uniform());
        if index % 7 == 3 { Vec3::ZERO } else { color * color }
    };
    (0..rows * columns).map(&mut cell).collect()
}

/// A rotation by an even share of everything.
fn turned() -> Mat3 {
    Mat3::from_axis_angle(Vec3::new(0.6, -0.3, 0.8).normalize(), 1.1)
}

fn pattern_if(has_pattern: bool, cone: Option<&Cone>) -> Option<Arc<Pattern>> {
    let axis = cone.map_or(Vec3::new(0.1, -1.0, 0.3).normalize(), |cone| cone.axis);
    let (x, y) = axis.any_orthonormal_pair();
    let reach = cone.map_or(PI, |cone| cone.cosine.acos());
    has_pattern
        .then(|| Arc::new(Pattern::new(cells(6, 10), 10, [x, y, axis], reach, cone).expect("light in it")))
}

/// A crooked pyramid without a floor.
fn mesh() -> Light {
    let [a, b, c, top] =
        [[0.0, 0.6, 0.0], [0.7, 0.7, 0.1], [0.2, 0.5, -0.9], [0.3, 1.3, -0.2]].map(Vec3::from_array);
    let triangles = [[a, b, top], [b, c, top], [top, c, a], [a, a, b]];
    Light::Mesh(ShiningMesh::new(&triangles, RADIANCE).expect("triangles with areas"))
}

fn sky() -> Light {
    let ball = |center, radius| Ball { center, radius };
    let (media, scene) = (ball(Vec3::new(0.4, -0.5, 0.1), 0.4), ball(Vec3::ZERO, 2.0));
    Light::Sky(Sky::around(cells(5, 8), 8, turned(), media, scene).expect("light in it"))
}

/// Spots as narrow as a laser, in double precision: the flux of their photons and where these go, and the light at places on a cone's slope.
#[test]
fn narrow_spots_shine_as_wide_ones_do() {
    let axis = AXIS.normalize();
    let steps = 1000;
    for outer_angle in [2e-4f32, 2e-3, 0.02, 0.2] {
        let (inner, outer) = (0.5 * f64::from(outer_angle), f64::from(outer_angle));
        let falloff = |theta: f64| {
            let q = ((outer - theta) / (outer - inner)).clamp(0.0, 1.0);
            q * q * (3.0 - 2.0 * q)
        };
        let rings = (0..steps).map(|k| outer * (f64::from(k) + 0.5) / f64::from(steps));
        let ring =
            |theta: f64| std::f64::consts::TAU * falloff(theta) * theta.sin() * outer / f64::from(steps);
        let flux: f64 = rings.clone().map(ring).sum();
        let mean_angle = rings.map(|theta| theta * ring(theta)).sum::<f64>() / flux;
        let light = Light::Spot {
            position: Vec3::ZERO,
            direction: axis,
            intensity: Vec3::ONE,
            inner_angle: 0.5 * outer_angle,
            outer_angle,
        };
        let angle = |direction: Vec3| {
            let (a, d) = (axis.as_dvec3(), direction.as_dvec3());
            a.cross(d).length().atan2(a.dot(d))
        };
        let count = 20_000;
        let (mut sent, mut angles) = (0.0, 0.0);
        for index in 0..count {
            let photon = light.emit(&mut PathSampler::new(Emission::LowDiscrepancy, 7, 0, index));
            sent += f64::from(photon.power.x) / f64::from(count);
            angles += f64::from(photon.power.x) / f64::from(count) * angle(photon.direction);
        }
        // A direction is good to 1e-7 of a radian, evenly spread photons to 1e-3 of these sums.
        assert!((sent / flux - 1.0).abs() < 2e-3, "{outer_angle}: {sent} of {flux}");
        assert!((angles / (flux * mean_angle) - 1.0).abs() < 4e-3, "{outer_angle}: {angles}");
        for share in [0.1f32, 0.6, 0.75, 0.9] {
            let place = 3.0 * (axis + (share * outer_angle).tan() * axis.any_orthonormal_vector());
            let exact = falloff(angle(place)) / place.as_dvec3().length_squared();
            let (density, _) = light.flux_density(place, [0.0; 2]);
            assert!((f64::from(density.x) / exact - 1.0).abs() < 1e-2, "{outer_angle}, {share}: {density}");
        }
    }
}

/// What photons carry through a ball is what shadow rays from inside of it find: power x chord over the ball's volume, and the mean of the
/// flux density over its places.
#[test]
fn photons_bring_the_light_that_shadow_rays_find() {
    let (center, radius) = (Vec3::new(0.4, -0.5, 0.1), 0.3f32);
    for (number, light) in lights().into_iter().enumerate() {
        let mut random = Random::new([1, 2, 3, number as u32]);
        // Patterned light has more noise.
        let count = if number <= WIDE_SUN { 400_000 } else { 1_000_000 };
        let (mut carried, mut squares) = (0.0, 0.0);
        for index in 0..count {
            let mut sampler = PathSampler::new(Emission::Independent, 7, 0, index);
            let photon = light.emit(&mut sampler);
            let offset = center - photon.origin;
            let along = offset.dot(photon.direction);
            let aside2 = (offset - along * photon.direction).length_squared();
            let half = (radius * radius - aside2).max(0.0).sqrt();
            let chord = (along + half).min(photon.until) - (along - half).max(photon.dark);
            if aside2 < radius * radius && chord > 0.0 {
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

/// Radiance of a light along a ray up to a distance.
fn seen_along(light: &Light, origin: Vec3, direction: Vec3, reach: f32) -> Vec3 {
    let mut met = Meetings::new();
    light.met(origin, direction, [0.0, f64::from(reach)], &mut met);
    met.iter().map(|(_, radiance)| *radiance).sum()
}

/// All light that arrives at a place from a light that is seen, by directions all around.
#[test]
fn what_is_seen_of_a_light_is_what_it_sends() {
    let place = Vec3::new(0.4, -0.3, 0.1);
    for light in lights().iter().filter(|light| light.has_size()) {
        if let Light::Sun(Sun { angle: 0.0, .. }) = light {
            continue;
        }
        let mut random = Random::new([3, 1, 4, 1]);
        let mut xi = || [random.uniform(), random.uniform()];
        // In the cone that holds what is seen of small ones, or all around.
        let middle = light.middle().0 - place;
        let height = match light {
            Light::Sky(_) | Light::Sun(_) => 2.0,
            _ if middle.length() < 1.6 && light.bounds().1.x > 1.0 => 2.0,
            _ => 0.4,
        };
        let axis = middle.as_dvec3().normalize();
        let count = 400_000;
        let seen: f64 = (0..count)
            .map(|_| {
                let direction = cap_direction(axis, height, xi()).as_vec3().normalize();
                f64::from(seen_along(light, place, direction, f32::INFINITY).x)
            })
            .sum();
        let seen = seen * std::f64::consts::TAU * height / f64::from(count);
        let sent: f64 = (0..count).map(|_| f64::from(light.flux_density(place, xi()).0.x)).sum();
        let sent = sent / f64::from(count);
        // Of 400,000 directions in the cone 1 % and more meet the light: 1.6 %.
        assert!((seen / sent - 1.0).abs() < 0.05, "{light:?}: {seen} {sent}");
    }
}

#[test]
fn a_ball_catches_what_a_surface_that_faces_the_light_does() {
    let point = Vec3::new(0.7, -0.8, 0.3);
    for light in lights().into_iter().take(FIRST_ALL_AROUND) {
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
    let light = &lights()[3];
    let Light::Rectangle { corner: c, edge_u, edge_v, .. } = *light else { panic!("a rectangle") };
    for place in places {
        let (mut vector, mut solid, mut most) = (DVec3::ZERO, 0.0, 0f64);
        let side = 500;
        for k in 0..side * side {
            let xi = [k % side, k / side].map(|i| (i as f32 + 0.5) / side as f32);
            let (weight, point) = seen::patch::sample(c, edge_u, edge_v, place.as_vec3(), xi);
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
        for (number, light) in lights.iter().enumerate() {
            // Rays of a sun's own size, which is that of its scene.
            let scale = if matches!(light, Light::Sun(_) | Light::Sky(_)) { 4.0 } else { 1.0 };
            let origin = scale * origin;
            let found = light.lit_stretch(origin, direction, 0.5, 4.0);
            seen[usize::from(found.is_some())] += 1;
            let (from, to) = found.unwrap_or((f32::MAX, f32::MIN));
            // What a sphere hides of a ray may lie in the middle of it, and a sun's directions need not all reach as far as the widest. Lamps,
            // areas and skies have whatever holds all of their light.
            let is_exact = number < SPHERE || (number > SPHERE && number < WIDE_SUN);
            for (distance, is_lit) in lit(light, origin, direction) {
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
    for light in &lights {
        let (_, to) = light.lit_stretch(Vec3::new(0.0, 3.0, 0.0), down, 0.0, f32::INFINITY).unwrap();
        // Where a cylinder ends whose axis is rounded.
        assert!(to > 1e6, "{light:?}: {to}");
    }
    assert!(lights[1].lit_stretch(Vec3::new(0.0, 3.0, 0.0), -down, 0.0, f32::INFINITY).is_none());
}

/// Photons of a net of so many points.
fn emitted(light: &Light, count: u32) -> Vec<EmittedPhoton> {
    (0..count).map(|index| light.emit(&mut PathSampler::new(Emission::LowDiscrepancy, 3, 0, index))).collect()
}

/// Mean of a function of photons.
fn mean_of(photons: &[EmittedPhoton], value: impl Fn(&EmittedPhoton) -> f64) -> f64 {
    photons.iter().map(value).sum::<f64>() / photons.len() as f64
}

/// Mean over a grid of numbers of the light that arrives at a place \[W/m²\].
fn arriving(light: &Light, place: Vec3, [across, down]: [u32; 2]) -> f64 {
    let at = |index: u32, count: u32| (index as f32 + 0.5) / count as f32;
    let density = |k: u32| light.flux_density(place, [at(k % across, across), at(k / across, down)]).0;
    (0..across * down).map(|k| f64::from(density(k).x)).sum::<f64>() / f64::from(across * down)
}
