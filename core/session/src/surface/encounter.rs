//! Light at a surface of several lobes: how much each takes, where it sends it, and how much goes into a given direction.

use crate::light::cosine_direction;
use crate::material::{FOCUSING, Lobes, microfacet};
use crate::scene::Scene;
use crate::scene::optics::{Interior, curvature_towards, facing_normal, reflect, refract};
use covbeam::{Curvature, LightField};
use covbeam_geometry::hit::Hit;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, FRAC_1_SQRT_2, TAU};

/// A lobe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lobe {
    Transparent,
    Diffuse,
    Translucent,
    Metal,
    Coat,
    GlassReflection,
    GlassTransmission,
}

impl Lobe {
    const ALL: [Self; 7] = [
        Self::Transparent,
        Self::Diffuse,
        Self::Translucent,
        Self::Metal,
        Self::Coat,
        Self::GlassReflection,
        Self::GlassTransmission,
    ];

    /// Those that keep directions apart, or nearly.
    const SHARP: [Self; 5] =
        [Self::Transparent, Self::Metal, Self::Coat, Self::GlassReflection, Self::GlassTransmission];

    /// Whether light leaves it diffusely.
    pub(crate) fn is_diffuse(self) -> bool {
        matches!(self, Self::Diffuse | Self::Translucent)
    }

    /// Whether it sends light through the surface.
    pub(crate) fn crosses(self) -> bool {
        matches!(self, Self::Transparent | Self::Translucent | Self::GlassTransmission)
    }
}

/// A way on from a surface.
pub(crate) struct Way {
    pub(crate) lobe: Lobe,
    /// Unit.
    pub(crate) direction: Vec3,
    /// Of the light that arrives, the part that goes on like this, over the probability that it does.
    pub(crate) factor: Vec3,
    /// What it is inside of then.
    pub(crate) interior: Interior,
}

/// Light, or an eye path, that meets a surface of lobes along a direction.
pub(crate) struct Encounter<'a> {
    lobes: &'a Lobes,
    direction: Vec3,
    /// Shading normal, turned against the direction.
    pub(crate) normal: Vec3,
    /// The triangle's.
    geometric: Vec3,
    /// Of the facet that is met; on a smooth surface the shading normal.
    facet: Vec3,
    /// Index on this side over that on the other.
    eta: f32,
    refracted: Option<Vec3>,
    /// Square root of what becomes of radiance that goes through without being refracted: of shapes whose inside has another index all.
    straight_eta: f32,
    /// What the ray is inside of; what it is straight through the surface, and refracted.
    interiors: [Interior; 3],
    /// Of all lobes, in their order.
    factors: [Vec3; 7],
}

impl<'a> Encounter<'a> {
    /// - `direction`: unit, towards the surface.
    /// - `xi`: uniform, for the facet that is met.
    pub(crate) fn new(
        scene: &Scene,
        hit: &Hit,
        direction: Vec3,
        interior: &Interior,
        lobes: &'a Lobes,
        xi: [f32; 2],
    ) -> Self {
        let normal = facing_normal(hit, direction);
        let against = if hit.geometric_normal.dot(direction) > 0.0 { -1.0 } else { 1.0 };
        let facet = match lobes.is_rough() {
            true => microfacet::visible_facet(-direction, normal, lobes.alpha, xi),
            false => normal,
        };
        let through = interior.through(scene, hit, direction);
        let beyond = if lobes.is_glass() { interior.beyond(scene, hit, direction) } else { through };
        let eta = interior.eta(scene, hit, direction, &beyond);
        let straight_eta = if scene.placed_hit(hit).is_some() { 1.0 } else { eta };
        let (reflectance, refracted) = refract(direction, facet, eta);
        let factors = [
            lobes.transparent,
            lobes.diffuse
                * (Vec3::ONE - coat(lobes, direction, if lobes.multiscatter { facet } else { normal })),
            lobes.translucent,
            metal(lobes, direction, facet),
            coat(lobes, direction, facet),
            lobes.glass_reflection * reflectance,
            lobes.glass_transmission * (1.0 - reflectance),
        ];
        Self {
            lobes,
            direction,
            normal,
            geometric: against * hit.geometric_normal,
            facet,
            eta,
            refracted,
            straight_eta,
            interiors: [*interior, through, beyond],
            factors,
        }
    }

    /// Whether light of lamps that arrives on this side leaves it in other directions than sharp ones.
    pub(crate) fn is_rough(&self) -> bool {
        self.lobes.is_rough()
    }

    /// What light that comes through the surface diffusely is inside of before.
    pub(crate) fn beyond(&self) -> Interior {
        self.interiors[1]
    }

    /// What radiance is divided by on its way from beyond a surface: refraction keeps that over the squared index.
    pub(crate) fn narrowing(&self, lobe: Lobe) -> f32 {
        let eta = match lobe {
            Lobe::GlassTransmission => self.eta,
            Lobe::Transparent | Lobe::Translucent => self.straight_eta,
            _ => 1.0,
        };
        eta * eta
    }

    /// Of light that arrives diffusely from this side and from behind, what goes back against the direction.
    pub(crate) fn diffuse(&self) -> [Vec3; 2] {
        [Lobe::Diffuse, Lobe::Translucent].map(|lobe| self.factors[lobe as usize])
    }

    /// The ways that an eye path follows, each with all of its light.
    pub(crate) fn sharp_ways(&self) -> impl Iterator<Item = Way> {
        Lobe::SHARP.into_iter().filter_map(|lobe| self.way(lobe, 1.0, [0.5; 2]))
    }

    /// Draws a way in proportion to what it takes of some light, and keeps it with the probability of the largest weight that it has then; None:
    /// absorbed.
    ///
    /// - `weights`: of the light in each channel, by which 1 is what it is to weigh. With any, those after it sum to no more than those before, or
    ///   their largest is no more than 1.
    /// - `choice`, `xi`: uniform.
    pub(crate) fn draw(&self, weights: Vec3, choice: f32, xi: [f32; 2]) -> Option<Way> {
        self.draw_of(&Lobe::ALL, weights, choice, xi)
    }

    /// Draws one of the [`Encounter::sharp_ways`] for light that is to be as bright then in its largest channel.
    pub(crate) fn draw_sharp(&self, power: Vec3, choice: f32) -> Option<Way> {
        self.draw_of(&Lobe::SHARP, power / power.max_element(), choice, [0.5; 2])
    }

    fn draw_of(&self, lobes: &[Lobe], weights: Vec3, choice: f32, xi: [f32; 2]) -> Option<Way> {
        let of = |lobe: Lobe| self.factors[lobe as usize] * weights;
        let all: f32 = lobes.iter().map(|&lobe| of(lobe).element_sum()).sum();
        let mut left = choice;
        for &lobe in lobes {
            let after = of(lobe);
            let share = after.element_sum() / all;
            let probability = share.min(after.max_element());
            if left < probability {
                return self.way(lobe, probability, xi);
            }
            left -= probability;
        }
        None
    }

    /// None: a lobe without light, or a facet that sends it to the wrong side.
    fn way(&self, lobe: Lobe, probability: f32, xi: [f32; 2]) -> Option<Way> {
        let factor = self.factors[lobe as usize];
        if factor == Vec3::ZERO {
            return None;
        }
        let [here, through, beyond] = self.interiors;
        let direction = match lobe {
            Lobe::Transparent => self.direction,
            Lobe::Diffuse => cosine_direction(self.normal, xi),
            Lobe::Translucent => cosine_direction(-self.normal, xi),
            Lobe::Metal | Lobe::Coat | Lobe::GlassReflection => reflect(self.direction, self.facet),
            Lobe::GlassTransmission => self.refracted?,
        };
        let side = if lobe.crosses() { -1.0 } else { 1.0 };
        let is_facet = !(lobe == Lobe::Transparent || lobe.is_diffuse());
        let seen = if is_facet { self.seen(side * direction.dot(self.normal)) } else { 1.0 };
        // What a shading normal sends to the wrong side of the true surface is mirrored back.
        let is_wrong = side * direction.dot(self.geometric) < 0.0;
        let direction = if is_wrong { reflect(direction, self.geometric) } else { direction };
        let interior = match lobe {
            Lobe::GlassTransmission => beyond,
            lobe if lobe.crosses() => through,
            _ => here,
        };
        (seen > 0.0).then(|| Way { lobe, direction, factor: factor * (seen / probability), interior })
    }

    /// Share of the facet's light that no other facet is in the way of, by the cosine at which it leaves.
    fn seen(&self, cosine: f32) -> f32 {
        if !self.lobes.is_rough() || self.lobes.multiscatter {
            return 1.0;
        }
        let cos_in = (-self.direction.dot(self.normal)).clamp(1e-6, 1.0);
        if cosine > 0.0 { microfacet::seen_too(cos_in, cosine.min(1.0), self.lobes.alpha) } else { 0.0 }
    }

    /// The scattering function \[1/sr\] of diffuse lobes and of what rough ones reflect, from the direction to another one or back: of
    /// flux that arrives along one of them, what leaves along the other, a steradian and cosine. What rough glass lets through is not in it.
    ///
    /// - `out`: unit, away from the surface on either side.
    pub(crate) fn towards(&self, out: Vec3) -> Vec3 {
        let cos_out = out.dot(self.normal);
        if cos_out * out.dot(self.geometric) <= 0.0 {
            return Vec3::ZERO;
        }
        let [back, through] = self.diffuse();
        if cos_out < 0.0 {
            return through * FRAC_1_PI;
        }
        back * FRAC_1_PI + self.glossy_towards(out)
    }

    /// Of it, what rough lobes reflect.
    pub(crate) fn glossy_towards(&self, out: Vec3) -> Vec3 {
        let (lobes, cos_out, cos_in) = (self.lobes, out.dot(self.normal), -self.direction.dot(self.normal));
        if !(lobes.is_rough() && cos_in > 0.0 && cos_out > 0.0) {
            return Vec3::ZERO;
        }
        let seen = |cos_out: f32| microfacet::seen_by_both(cos_in.min(1.0), cos_out.min(1.0), lobes.alpha);
        let of_facets = |out: Vec3, seen: f32| {
            let facet = (out - self.direction).try_normalize();
            let Some(facet) = facet.filter(|facet| facet.dot(self.normal) > 0.0) else { return Vec3::ZERO };
            let glass = lobes.glass_reflection * refract(self.direction, facet, self.eta).0;
            let reflected = metal(lobes, self.direction, facet) + coat(lobes, self.direction, facet) + glass;
            let density = microfacet::density(facet.dot(self.normal).min(1.0), lobes.alpha);
            reflected * (density * seen / (4.0 * cos_in * cos_out))
        };
        if !lobes.multiscatter {
            return of_facets(out, seen(cos_out));
        }
        // And of the facets that send light to the wrong side, where it is mirrored back.
        of_facets(out, seen(1.0)) + of_facets(reflect(out, self.geometric), seen(1.0))
    }

    /// Whether light keeps its directions well enough on a way to make caustics.
    pub(crate) fn keeps_focus(&self, lobe: Lobe) -> bool {
        lobe == Lobe::Transparent || !(lobe.is_diffuse() || self.lobes.alpha > FOCUSING)
    }

    /// What a way makes of a light field.
    ///
    /// - `curves`: whether the surface's curvature counts.
    pub(crate) fn turn(&self, field: &mut LightField, hit: &Hit, way: &Way, curves: bool) {
        let curvature = if curves { curvature_towards(hit, self.facet) } else { Curvature::default() };
        // How far light turns with a facet.
        let turns = match way.lobe {
            Lobe::Transparent => return,
            Lobe::Diffuse | Lobe::Translucent => return field.diffuse(self.normal, way.direction),
            Lobe::GlassTransmission => {
                field.refract(self.facet, &curvature, self.eta);
                (1.0 - self.eta).abs()
            }
            Lobe::Metal | Lobe::Coat | Lobe::GlassReflection => {
                field.reflect(self.facet, &curvature);
                2.0
            }
        };
        if self.lobes.is_rough() {
            // A facet turns by α/√2 along each axis.
            let deviation = (turns * self.lobes.alpha * FRAC_1_SQRT_2).max(1e-3);
            field.scatter(way.direction, (TAU * deviation).powi(-2));
        }
    }
}

/// Share that a metal reflects, by Schlick's curve.
fn metal(lobes: &Lobes, direction: Vec3, facet: Vec3) -> Vec3 {
    let cosine = (-direction.dot(facet)).clamp(0.0, 1.0);
    lobes.metal + (lobes.edge - lobes.metal) * (1.0 - cosine).powi(5)
}

/// Share that a coat reflects: it is thin, and met from outside on either side.
fn coat(lobes: &Lobes, direction: Vec3, facet: Vec3) -> Vec3 {
    lobes.coat * refract(direction, facet, 1.0 / lobes.index).0
}

#[cfg(test)]
mod tests {
    use super::*;
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
            let met = Encounter::new(scene, &hit, direction, &interior, lobes, facet);
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

    /// What is drawn is what shadow rays are told, and all of it goes on; of metal alone, F D G1/(4 cos), mirrored up from below.
    #[test]
    fn light_that_facets_hide_from_each_other_goes_on_where_it_is_kept() {
        let mut scene = scene(Material::Black);
        let (metal, alpha) = (Vec3::splat(0.6), 0.64);
        let lobes = Lobes { metal, edge: Vec3::ONE, alpha, multiscatter: true, ..Lobes::NONE };
        let facets = Facets { alpha: alpha.into() };
        for angle in [0.1, 0.8, 1.3] {
            scene.objects[0].material = Material::Lobes(lobes);
            let direction = incoming(angle, 1.0);
            let towards = -direction.as_dvec3();
            let of_facets = |out: DVec3| {
                let half = (out + towards).normalize();
                let fresnel = 0.6 + 0.4 * (1.0 - half.dot(towards)).powi(5);
                let is_there = half.z > 0.0;
                let value =
                    fresnel * facets.density(half.z) * facets.seen([towards.z, 1.0]) / (4.0 * towards.z);
                if is_there { value } else { 0.0 }
            };
            let function = |out: DVec3| match out.z > 0.0 {
                true => of_facets(out) + of_facets(out * DVec3::new(1.0, 1.0, -1.0)),
                false => 0.0,
            };
            check("metal that keeps its light", &scene, direction, function);
            let (lobes, hit, interior) = met(&scene, direction);
            let found = Encounter::new(&scene, &hit, direction, &interior, lobes, [0.3, 0.4]);
            for out in [Vec3::new(0.6, 0.2, 0.7), Vec3::new(-0.3, 0.9, 0.1), Vec3::new(0.2, 0.0, -0.5)] {
                let out = out.normalize();
                let expected = (function(out.as_dvec3()) / f64::from(out.z)) as f32;
                let found = found.towards(out).x;
                assert!((found - expected).abs() <= 1e-4 * expected, "{found} for {expected}");
            }
        }
        let white = [
            Lobes { metal: Vec3::ONE, edge: Vec3::ONE, alpha, multiscatter: true, ..Lobes::NONE },
            Lobes { diffuse: Vec3::ONE, coat: Vec3::ONE, alpha, multiscatter: true, ..Lobes::NONE },
        ];
        for lobes in white {
            scene.objects[0].material = Material::Lobes(lobes);
            let (_, hit, interior) = met(&scene, incoming(1.3, 1.0));
            let mut random = Random::new([1, 1, 2, 3]);
            let mut next = || [random.uniform(), random.uniform()];
            for _ in 0..1000 {
                let direction = incoming(1.3, 1.0);
                let met = Encounter::new(&scene, &hit, direction, &interior, &lobes, next());
                let way = met.draw(Vec3::ONE, next()[0], next()).expect("nothing is absorbed");
                assert!((way.factor - 1.0).abs().max_element() < 1e-5 && way.direction.z > 0.0);
            }
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
                    fresnel * facets.density(half.z) * facets.seen([towards.z, out.z])
                        / (4.0 * towards.z * out.z)
                };
                check("metal", &scene, direction, |out| function(out) * out.z);
                // And the function that shadow rays use is the same one.
                let (lobes, hit, interior) = met(&scene, direction);
                let met = Encounter::new(&scene, &hit, direction, &interior, lobes, [0.3, 0.4]);
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
        for (angle, downwards) in [(0.1, 1.0), (0.8, 1.0), (1.3, 1.0), (0.2, -1.0), (0.6, -1.0), (1.0, -1.0)]
        {
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
        let met = Encounter::new(&scene, &hit, direction, &interior, lobes, [0.5; 2]);
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
}
