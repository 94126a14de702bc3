//! Light at a surface of several lobes: how much each takes, where it sends it, and how much goes into a given direction.

mod lobe;
mod own;

pub(crate) use lobe::Lobe;

use crate::host::Host;
use crate::light::cosine_direction;
use crate::material::{Asks, FOCUSING, Lobes, SHARP, microfacet};
use crate::scene::Scene;
use crate::scene::optics::{Interior, curvature_towards, facing_normal, reflect, refract, to_side};
use covbeam::{Curvature, LightField};
use covbeam_geometry::hit::Hit;
use glam::Vec3;
use lobe::{coat, coated, gain, metal};
use own::OwnWays;
use std::f32::consts::{FRAC_1_PI, FRAC_1_SQRT_2, TAU};

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

/// What meets a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Met {
    ByLight,
    ByEyePath,
}

/// Light, or an eye path, that meets a surface of lobes along a direction.
pub(crate) struct Encounter<'a> {
    lobes: &'a Lobes,
    met: Met,
    direction: Vec3,
    /// Shading normal, turned against the direction.
    pub(crate) normal: Vec3,
    /// The triangle's.
    pub(crate) geometric: Vec3,
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
    /// Of a host's own scattering function: where it sends reflected and refracted light.
    own: Option<OwnWays>,
}

impl<'a> Encounter<'a> {
    /// - `met`: what comes along `direction`, unit, towards the surface.
    /// - `xi`: uniform, for the facet that is met.
    pub(crate) fn new(
        scene: &Scene,
        hit: &Hit,
        (met, direction): (Met, Vec3),
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
        let of_lobes = || {
            [
                lobes.transparent,
                lobes.diffuse * (Vec3::ONE - coated(lobes, direction, normal, facet)),
                lobes.translucent,
                metal(lobes, direction, facet),
                coat(lobes, direction, facet),
                lobes.glass_reflection * reflectance,
                lobes.glass_transmission * (1.0 - reflectance),
            ]
        };
        let (factors, own) = match own_host(scene, hit, lobes) {
            Some((host, hit)) => {
                let ways = host.ways(&hit, direction, xi, Vec3::ONE - lobes.transparent);
                let (factors, own) = OwnWays::sorted(lobes.transparent, &ways);
                (factors, Some(own))
            }
            None => (of_lobes(), None),
        };
        Self {
            lobes,
            met,
            direction,
            normal,
            geometric: against * hit.geometric_normal,
            facet,
            eta,
            refracted,
            straight_eta,
            interiors: [*interior, through, beyond],
            factors,
            own,
        }
    }

    /// Whether light of lamps that arrives on this side leaves it in other directions than sharp ones, as is known of all.
    pub(crate) fn is_rough(&self) -> bool {
        self.own.is_none() && self.lobes.is_rough()
    }

    /// Whether a way is one of many that only a host knows.
    pub(crate) fn is_drawn(&self, lobe: Lobe) -> bool {
        self.own.is_some_and(|own| !lobe.is_diffuse() && own.is_rough(lobe))
    }

    /// The albedo of a surface that only reflects, diffusely, as a host says; what is described like that is none of lobes.
    pub(crate) fn lambert(&self) -> Option<Vec3> {
        let others = [Lobe::Translucent].iter().chain(&Lobe::SHARP);
        let is_alone = self.own.is_some()
            && others.map(|&lobe| self.factors[lobe as usize]).all(|other| other == Vec3::ZERO);
        is_alone.then_some(self.factors[Lobe::Diffuse as usize])
    }

    /// Whether any light leaves it diffusely.
    pub(crate) fn is_diffuse(&self) -> bool {
        match self.own {
            Some(_) => self.diffuse() != [Vec3::ZERO; 2],
            None => self.lobes.diffuse.max(self.lobes.translucent) != Vec3::ZERO,
        }
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

    /// Like [`Encounter::draw`], of what does not leave diffusely.
    pub(crate) fn draw_undiffused(&self, weights: Vec3, choice: f32) -> Option<Way> {
        self.draw_of(&Lobe::SHARP, weights, choice, [0.5; 2])
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
            lobe => match &self.own {
                Some(own) => own.direction(lobe),
                None if lobe == Lobe::GlassTransmission => self.refracted?,
                None => reflect(self.direction, self.facet),
            },
        };
        let side = if lobe.crosses() { -1.0 } else { 1.0 };
        let is_facet = !(lobe == Lobe::Transparent || lobe.is_diffuse());
        let seen = if is_facet { self.seen(lobe, side * direction.dot(self.normal)) } else { Vec3::ONE };
        let direction = to_side(direction, side * self.geometric);
        let interior = match lobe {
            Lobe::GlassTransmission => beyond,
            lobe if lobe.crosses() => through,
            _ => here,
        };
        (seen != Vec3::ZERO).then(|| Way { lobe, direction, factor: factor * seen / probability, interior })
    }

    /// Share of the facet's light that no other facet is in the way of, by the cosine at which it leaves, with what goes on by way of others.
    fn seen(&self, lobe: Lobe, cosine: f32) -> Vec3 {
        if !self.is_rough() || self.lobes.multiscatter && lobe.is_glass() {
            return Vec3::ONE;
        }
        let cos_in = (-self.direction.dot(self.normal)).clamp(1e-6, 1.0);
        if cosine <= 0.0 {
            return Vec3::ZERO;
        }
        let cosine = cosine.min(1.0);
        microfacet::seen_too(cos_in, cosine, self.lobes.alpha) * self.gain(lobe, cosine)
    }

    /// What leaves a lobe in all over what has met a single facet, by the cosine at which it leaves.
    fn gain(&self, lobe: Lobe, cosine: f32) -> Vec3 {
        let seen_at = match self.met {
            Met::ByLight => cosine,
            Met::ByEyePath => -self.direction.dot(self.normal),
        };
        if self.lobes.multiscatter { gain(self.lobes, lobe, seen_at) } else { Vec3::ONE }
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
        if !(self.is_rough() && cos_in > 0.0 && cos_out > 0.0) {
            return Vec3::ZERO;
        }
        let seen = |cos_out: f32| microfacet::seen_by_both(cos_in.min(1.0), cos_out.min(1.0), lobes.alpha);
        let of_facets = |out: Vec3, seen: f32, reflected: &dyn Fn(Vec3) -> Vec3| {
            let facet = (out - self.direction).try_normalize();
            let Some(facet) = facet.filter(|facet| facet.dot(self.normal) > 0.0) else { return Vec3::ZERO };
            let density = microfacet::density(facet.dot(self.normal).min(1.0), lobes.alpha);
            reflected(facet) * (density * seen / (4.0 * cos_in * cos_out))
        };
        let [of_metal, of_coat] = [Lobe::Metal, Lobe::Coat].map(|lobe| self.gain(lobe, cos_out));
        let opaque = |facet| {
            of_metal * metal(lobes, self.direction, facet) + of_coat * coat(lobes, self.direction, facet)
        };
        let glass = |facet| lobes.glass_reflection * refract(self.direction, facet, self.eta).0;
        if !lobes.multiscatter || lobes.glass_reflection == Vec3::ZERO {
            return of_facets(out, seen(cos_out), &|facet| opaque(facet) + glass(facet));
        }
        // And of glass those facets that send light to the wrong side, where it is mirrored back.
        of_facets(out, seen(cos_out), &opaque)
            + of_facets(out, seen(1.0), &glass)
            + of_facets(reflect(out, self.geometric), seen(1.0), &glass)
    }

    /// Whether a way is that of a mirror, or of clear glass, or nearly.
    pub(crate) fn is_sharp(&self, lobe: Lobe) -> bool {
        self.keeps_focus(lobe) && (self.own.is_some() || self.lobes.alpha < SHARP)
    }

    /// Whether light keeps its directions well enough on a way to make caustics.
    pub(crate) fn keeps_focus(&self, lobe: Lobe) -> bool {
        match (lobe, &self.own) {
            (Lobe::Transparent, _) => true,
            (Lobe::Diffuse | Lobe::Translucent, _) => false,
            (_, Some(own)) => own.keeps_focus(lobe),
            (_, None) => self.lobes.alpha <= FOCUSING,
        }
    }

    /// What a way makes of a light field.
    ///
    /// - `curves`: whether the surface's curvature counts.
    pub(crate) fn turn(&self, field: &mut LightField, hit: &Hit, way: &Way, curves: bool) {
        let curvature = |facet| if curves { curvature_towards(hit, facet) } else { Curvature::default() };
        if let Some(own) = self.own.filter(|_| !(way.lobe == Lobe::Transparent || way.lobe.is_diffuse())) {
            return own.turn(field, way.lobe, (self.direction, self.normal), curvature, self.eta);
        }
        let curvature = curvature(self.facet);
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
        if self.is_rough() {
            // A facet turns by α/√2 along each axis.
            let deviation = TAU * (turns * self.lobes.alpha * FRAC_1_SQRT_2).max(1e-3);
            field.scatter(way.direction, 1.0 / (deviation * deviation));
        }
    }
}

/// The host whose scattering function a surface has, and the hit as it knows it.
fn own_host<'s>(scene: &'s Scene, hit: &Hit, lobes: &Lobes) -> Option<(&'s Host, Hit)> {
    if lobes.asks != Asks::Ways {
        return None;
    }
    let (placed, object) = scene.placed_hit(hit)?;
    Some((placed.host()?, Hit { object, ..*hit }))
}

#[cfg(test)]
mod tests;
