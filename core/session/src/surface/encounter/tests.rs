//! Encounters with lobes: what is drawn, and what shadow rays are told, against scattering functions from the papers.

use super::*;
use crate::material::kept;
use crate::random::{Random, spread};
use crate::scene::Material;
use crate::scene::made::{Made, camera, cuboid, point};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

fn scene(material: Material) -> Scene {
    Made::new(camera([0.0, 0.0, 9.0], [0.0; 3], 40.0, [8, 8]))
        .object(cuboid([-8.0, -8.0, -8.0], [8.0, 8.0, 0.0]), material)
        .light(point([0.0, 0.0, 4.0], 1.0))
        .scene()
}

/// The lobes of the only object, and where a ray from outside or inside meets it in the middle.
fn met(scene: &Scene, direction: Vec3) -> (&Lobes, Hit, Interior) {
    let origin = -3.0 * direction;
    let hit = scene.intersect(origin, direction, f32::INFINITY).expect("the box is there");
    let Material::Lobes(lobes) = &scene.objects[0].material else { panic!("lobes") };
    (lobes, hit, Interior::at(scene, origin))
}

/// GGX with Smith's masking and shadowing, from the papers.
struct Facets {
    alpha: f64,
}

impl Facets {
    fn density(&self, cosine: f64) -> f64 {
        let (c2, a2) = (cosine * cosine, self.alpha * self.alpha);
        a2 / (PI * c2 * c2 * (a2 + (1.0 - c2) / c2).powi(2))
    }

    fn seen(&self, cosines: [f64; 2]) -> f64 {
        let hidden = |c: f64| ((1.0 + self.alpha.powi(2) * (1.0 - c * c) / (c * c)).sqrt() - 1.0) / 2.0;
        1.0 / (1.0 + hidden(cosines[0]) + hidden(cosines[1]))
    }
}

fn dielectric(cos_i: f64, eta: f64) -> f64 {
    let sin2_t = eta * eta * (1.0 - cos_i * cos_i);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let (s, p) =
        ((eta * cos_i - cos_t) / (eta * cos_i + cos_t), (cos_i - eta * cos_t) / (cos_i + eta * cos_t));
    (s * s + p * p) / 2.0
}

/// Directions of both hemispheres with their solid angles.
fn sphere() -> impl Iterator<Item = (DVec3, f64)> {
    let (rings, parts) = (1600, 1200);
    (0..rings).flat_map(move |ring| {
        let theta = PI * (f64::from(ring) + 0.5) / f64::from(rings);
        (0..parts).map(move |part| {
            let phi = TAU * (f64::from(part) + 0.5) / f64::from(parts);
            let direction = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            (direction, theta.sin() * PI / f64::from(rings) * TAU / f64::from(parts))
        })
    })
}

fn moments(d: DVec3) -> [f64; 4] {
    [1.0, d.x, d.y * d.y, d.z]
}

/// Draws ways of a lamp's watt and compares their moments, on either side, with a quadrature of `function`, the flux a steradian.
fn check(name: &str, scene: &Scene, direction: Vec3, function: impl Fn(DVec3) -> f64) {
    let mut expected = [[0.0; 4]; 2];
    for (out, solid) in sphere() {
        let value = function(out) * solid;
        let side = &mut expected[usize::from(out.z < 0.0)];
        side.iter_mut().zip(moments(out)).for_each(|(sum, moment)| *sum += value * moment);
    }
    let (lobes, hit, interior) = met(scene, direction);
    let (count, mut found) = (200_000, [[0.0; 4]; 2]);
    let mut random = Random::new([5, 6, 7, 8]);
    let mut next = || [random.uniform(), random.uniform()];
    let shifts = [next(), next()];
    for index in 0..count {
        let facet = spread(shifts[0], index);
        let met = Encounter::new(scene, &hit, (Met::ByLight, direction), &interior, lobes, facet);
        let Some(way) = met.draw(Vec3::ONE, next()[0], next()) else { continue };
        let side = &mut found[usize::from(way.direction.z < 0.0)];
        let value = f64::from(way.factor.x) / count as f64;
        side.iter_mut()
            .zip(moments(way.direction.as_dvec3()))
            .for_each(|(sum, moment)| *sum += value * moment);
    }
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        // Four standard errors of numbers between -1 and 1 are 9e-3 at most; of most moments a third of that.
        assert!((found - expected).abs() < 5e-3, "{name} {direction}: {found:?} for {expected:?}");
    }
}

fn incoming(angle: f32, downwards: f32) -> Vec3 {
    Vec3::new(angle.sin(), 0.0, -downwards * angle.cos())
}

/// What is drawn is what shadow rays are told: of metal F D G₂/(4 cos cos) times what others send on by the angle of the camera, which is where
/// light goes, or where an eye path comes from. Of that white metal loses nothing.
#[test]
fn light_that_facets_hide_from_each_other_goes_on_where_it_is_kept() {
    let mut scene = scene(Material::Black);
    let alpha = 0.64;
    let facets = Facets { alpha: alpha.into() };
    let of = |metal: f32| {
        let metal = Vec3::splat(metal);
        Lobes { metal, edge: Vec3::ONE, alpha, multiscatter: true, ..Lobes::NONE }
    };
    for angle in [0.1, 0.8, 1.3] {
        scene.objects[0].material = Material::Lobes(of(0.6));
        let direction = incoming(angle, 1.0);
        let towards = -direction.as_dvec3();
        let function = |out: DVec3, view: f64| {
            if out.z <= 0.0 {
                return 0.0;
            }
            let half = (out + towards).normalize();
            let fresnel = 0.6 + 0.4 * (1.0 - half.dot(towards)).powi(5);
            let single =
                fresnel * facets.density(half.z) * facets.seen([towards.z, out.z]) / (4.0 * towards.z);
            single * f64::from(kept::gain(view as f32, alpha, Vec3::splat(0.6 + 0.4 / 21.0)).x)
        };
        check("metal that keeps its light", &scene, direction, |out| function(out, out.z));
        let (lobes, hit, interior) = met(&scene, direction);
        for out in [Vec3::new(0.6, 0.2, 0.7), Vec3::new(-0.3, 0.9, 0.1), Vec3::new(0.2, 0.0, -0.5)] {
            let out = out.normalize();
            for (by, view) in [(Met::ByLight, f64::from(out.z)), (Met::ByEyePath, towards.z)] {
                let found = Encounter::new(&scene, &hit, (by, direction), &interior, lobes, [0.3, 0.4]);
                let expected = (function(out.as_dvec3(), view) / f64::from(out.z)) as f32;
                let found = found.towards(out).x;
                assert!((found - expected).abs() <= 1e-4 * expected, "{found} for {expected}");
            }
        }
    }
    let coated = Lobes { diffuse: Vec3::ONE, coat: Vec3::ONE, alpha, multiscatter: true, ..Lobes::NONE };
    for (lobes, angle) in [(of(1.0), 0.3), (of(1.0), 1.2), (coated, 0.3), (coated, 1.2)] {
        scene.objects[0].material = Material::Lobes(lobes);
        let (_, hit, interior) = met(&scene, incoming(angle, 1.0));
        let mut random = Random::new([1, 1, 2, 3]);
        let mut next = || [random.uniform(), random.uniform()];
        let count = 100_000;
        let sum: f32 = (0..count)
            .filter_map(|_| {
                let direction = (Met::ByEyePath, incoming(angle, 1.0));
                let met = Encounter::new(&scene, &hit, direction, &interior, &lobes, next());
                met.draw(Vec3::ONE, next()[0], next())
            })
            .map(|way| way.factor.x / count as f32)
            .sum();
        // The table's error, and that of the sum: a way's factor is below 2.
        assert!((sum - 1.0).abs() < 0.02, "{angle}: {sum}");
    }
}

#[test]
fn metal_is_drawn_as_its_scattering_function_says() {
    for (roughness, alpha) in [(0.5_f32, 0.25), (0.8, 0.64)] {
        let metal = Vec3::splat(0.6);
        let lobes = Lobes { metal, edge: Vec3::ONE, alpha: roughness * roughness, ..Lobes::NONE };
        let scene = scene(Material::Lobes(lobes));
        let facets = Facets { alpha };
        for angle in [0.1, 0.8, 1.3] {
            let direction = incoming(angle, 1.0);
            let towards = -direction.as_dvec3();
            let function = |out: DVec3| {
                if out.z <= 0.0 {
                    return 0.0;
                }
                let half = (out + towards).normalize();
                let fresnel = 0.6 + 0.4 * (1.0 - half.dot(towards)).powi(5);
                fresnel * facets.density(half.z) * facets.seen([towards.z, out.z]) / (4.0 * towards.z * out.z)
            };
            check("metal", &scene, direction, |out| function(out) * out.z);
            // And the function that shadow rays use is the same one.
            let (lobes, hit, interior) = met(&scene, direction);
            let met = Encounter::new(&scene, &hit, (Met::ByLight, direction), &interior, lobes, [0.3, 0.4]);
            for out in [Vec3::new(0.6, 0.2, 0.7), Vec3::new(-0.3, 0.9, 0.1), Vec3::new(0.2, 0.0, -0.5)] {
                let out = out.normalize();
                let (found, expected) = (met.towards(out).x, function(out.as_dvec3()) as f32);
                assert!((found - expected).abs() <= 1e-4 * expected, "{found} for {expected}");
            }
        }
    }
}

/// Walter et al.'s equations 20 and 21, from both sides.
#[test]
fn rough_glass_is_drawn_as_its_scattering_function_says() {
    let (glass_reflection, glass_transmission) = (Vec3::ONE, Vec3::ONE);
    let (index, alpha) = (1.5, 0.6 * 0.6);
    let glass = Lobes { glass_reflection, glass_transmission, index, alpha, ..Lobes::NONE };
    let scene = scene(Material::Lobes(glass));
    let facets = Facets { alpha: 0.36 };
    for (angle, downwards) in [(0.1, 1.0), (0.8, 1.0), (1.3, 1.0), (0.2, -1.0), (0.6, -1.0), (1.0, -1.0)] {
        let direction = incoming(angle, downwards);
        let flip = f64::from(downwards);
        let eta = if downwards > 0.0 { 1.0 / 1.5 } else { 1.5 };
        let towards = -direction.as_dvec3() * DVec3::new(1.0, 1.0, flip);
        check("glass", &scene, direction, |out| {
            let out = out * DVec3::new(1.0, 1.0, flip);
            let seen = |out: DVec3| facets.seen([towards.z, out.z.abs()]);
            if out.z > 0.0 {
                let half = (out + towards).normalize();
                let fresnel = dielectric(half.dot(towards), eta);
                return fresnel * facets.density(half.z) * seen(out) / (4.0 * towards.z);
            }
            let half = -(eta * towards + out).normalize();
            let half = if half.z < 0.0 { -half } else { half };
            let (i, o) = (towards.dot(half), out.dot(half));
            if i <= 0.0 || o >= 0.0 {
                return 0.0;
            }
            let through = 1.0 - dielectric(i, eta);
            let jacobian = -o / (eta * i + o).powi(2);
            through * facets.density(half.z) * seen(out) * jacobian * i / towards.z
        });
    }
}

#[test]
fn diffuse_lobes_share_what_the_coat_leaves() {
    let [diffuse, translucent, coat, transparent] = [0.5, 0.3, 0.5, 0.2].map(Vec3::splat);
    let lobes = Lobes { diffuse, translucent, coat, transparent, ..Lobes::NONE };
    let scene = scene(Material::Lobes(lobes));
    let direction = incoming(0.8, 1.0);
    let coat = 0.5 * dielectric(0.8f64.cos(), 1.0 / 1.5);
    let (lobes, hit, interior) = met(&scene, direction);
    let met = Encounter::new(&scene, &hit, (Met::ByLight, direction), &interior, lobes, [0.5; 2]);
    let expected = [0.2, 0.5 * (1.0 - coat), 0.3, 0.0, coat];
    for (found, expected) in met.factors.iter().zip(expected) {
        assert!((f64::from(found.x) - expected).abs() < 1e-6, "{found} for {expected}");
    }
    let ways: Vec<Way> = met.sharp_ways().collect();
    assert_eq!(ways.iter().map(|way| way.lobe).collect::<Vec<_>>(), [Lobe::Transparent, Lobe::Coat]);
    assert_eq!(ways[0].direction, direction);
    let up = met.towards(Vec3::Z).x - (0.5 * (1.0 - coat) / PI) as f32;
    assert!(up.abs() < 1e-6 && (met.towards(-Vec3::Z).x - (0.3 / PI) as f32).abs() < 1e-6);
}
