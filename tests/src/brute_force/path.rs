//! One path from the camera.
//!
//! All three channels share it: one of them, drawn evenly at its start, decides all that happens, as an analog of nature would, and the
//! light is divided by the mean density of the three (the balance heuristic with one sample). What a path weighs is then at most three.

use super::lamps::{Spark, around};
use super::world::{End, Material, Way, World};
use crate::random::Stream;
use glam::DVec3;
use std::f64::consts::PI;

/// Events after which paths end by chance: of n of them the share n/(n + 1) goes on, so that fog without end and without absorption ends.
const EVENTS: u32 = 64;

/// How often a sun is looked for where faces that it shines on squarely mirror it.
const MIRRORED: f64 = 0.1;

pub(super) struct Path<'a> {
    world: &'a World,
    stream: &'a mut Stream,
    origin: DVec3,
    direction: DVec3,
    /// The channel that decides.
    channel: usize,
    /// Density of the path if each channel decided, over the mean of them.
    weight: DVec3,
    /// What else light is multiplied by: the squared index, and roulette.
    factor: f64,
    /// Whether nothing but glass and mirrors was met so far, and since the last event that spreads light.
    seen: bool,
    is_sharp: bool,
    light: DVec3,
}

/// Radiance along a ray.
pub(super) fn radiance(world: &World, (origin, direction): (DVec3, DVec3), stream: &mut Stream) -> DVec3 {
    let channel = (3.0 * stream.uniform()) as usize;
    let (weight, light) = (DVec3::ONE, DVec3::ZERO);
    let (seen, is_sharp, factor) = (true, true, 1.0);
    let mut path = Path { world, stream, origin, direction, channel, weight, factor, seen, is_sharp, light };
    let mut events = 0;
    while path.step() {
        events += 1;
        if events >= EVENTS {
            let goes_on = f64::from(events) / f64::from(events + 1);
            if path.stream.uniform() >= goes_on {
                break;
            }
            path.factor /= goes_on;
        }
    }
    path.light
}

impl Path<'_> {
    /// Goes on by one event; false: the path has ended.
    fn step(&mut self) -> bool {
        let way = self.world.way(self.origin, self.direction, f64::INFINITY);
        self.meet_lamps(&way);
        self.gather_fog(&way);
        if let Some((distance, medium)) = self.collision(&way) {
            return self.scatter(&way, distance, medium);
        }
        let length = way.length();
        let transmittance = way.transmittance(self.world, length);
        if !self.multiply(transmittance) {
            return false;
        }
        match way.end {
            End::Nowhere => false,
            End::Surface { object, normal } => self.meet_surface(length, object, normal),
            End::Interface { before, beyond, normal } => {
                self.origin += length * self.direction;
                self.meet_interface(before / beyond, normal);
                true
            }
        }
    }

    /// Multiplies the densities of all channels; false: the one that decides has none left.
    fn multiply(&mut self, densities: DVec3) -> bool {
        self.weight *= densities;
        let mean = self.weight.element_sum() / 3.0;
        self.weight /= mean;
        mean > 0.0 && self.weight[self.channel] > 0.0
    }

    /// The same by shares that are absorbed otherwise, which chance decides.
    fn survive(&mut self, shares: DVec3) -> bool {
        self.stream.uniform() < shares[self.channel] && self.multiply(shares)
    }

    fn add(&mut self, light: DVec3) {
        self.light += self.factor * self.weight * light;
    }

    /// Light of lamps that the way meets, where none was asked for that is aimed at.
    fn meet_lamps(&mut self, way: &Way) {
        if !self.is_sharp {
            return;
        }
        for lamp in &self.world.lamps {
            if self.seen && !lamp.is_visible {
                continue;
            }
            let Some((distance, radiance)) = lamp.met(self.origin, self.direction) else { continue };
            // A lamp on a wall shines.
            if distance <= way.length() + self.world.tolerance() {
                self.add(radiance * way.transmittance(self.world, distance));
            }
        }
    }

    /// Light that the fog on the way scatters here straight from a lamp: one place, chosen by the angle that the lamp sees the way under.
    fn gather_fog(&mut self, way: &Way) {
        let world = self.world;
        let scatters = |medium: Option<usize>| {
            medium.is_some_and(|medium| world.media[medium].scattering != DVec3::ZERO)
        };
        let (mut ends, mut from) = ([f64::INFINITY, 0.0], 0.0);
        for &(to, medium) in &way.stretches {
            if scatters(medium) {
                ends = [ends[0].min(from), to];
            }
            from = to;
        }
        if ends[0] >= ends[1] {
            return;
        }
        let (origin, direction) = (self.origin, self.direction);
        let Some((number, spark, share)) = self.choose(|lamp, spark| {
            if world.lamps[lamp].is_sun() {
                ends[1] - ends[0]
            } else {
                seen_from(spark.place, origin, direction, ends)[2]
            }
        }) else {
            return;
        };
        let lamp = &world.lamps[number];
        let xi = self.stream.uniform();
        let (distance, density) = if lamp.is_sun() {
            (ends[0] + xi * (ends[1] - ends[0]), 1.0 / (ends[1] - ends[0]))
        } else {
            equiangular(spark.place, origin, direction, ends, xi)
        };
        let place = way.stretches.iter().find(|stretch| distance < stretch.0).and_then(|stretch| stretch.1);
        let Some(medium) = place.map(|medium| &world.media[medium]) else { return };
        let point = origin + distance * direction;
        let (light, towards) = self.light_of(number, &spark, point);
        let phase = henyey_greenstein(medium.asymmetry, towards.dot(direction));
        let passed = way.transmittance(world, distance);
        self.add(passed * medium.scattering * light * (phase / (density * share)));
    }

    /// One of all lamps, each with a point of its own, in proportion to its strength times a factor; with its share.
    fn choose(&mut self, factor: impl Fn(usize, &Spark) -> f64) -> Option<(usize, Spark, f64)> {
        let lamps = &self.world.lamps;
        let sparks: Vec<Spark> = lamps.iter().map(|lamp| lamp.spark(self.stream)).collect();
        let each = |number: usize| lamps[number].strength() * factor(number, &sparks[number]);
        let strengths: Vec<f64> = (0..lamps.len()).map(each).collect();
        let sum: f64 = strengths.iter().sum();
        let mut left = self.stream.uniform() * sum;
        for (number, strength) in strengths.iter().enumerate() {
            left -= strength;
            if left < 0.0 {
                return Some((number, sparks[number], strength / sum));
            }
        }
        None
    }

    /// Light of a spark that arrives at a point through nothing but fog, and the direction towards it.
    fn light_of(&mut self, lamp: usize, spark: &Spark, point: DVec3) -> (DVec3, DVec3) {
        let lamp = &self.world.lamps[lamp];
        if lamp.is_along_an_axis() {
            let towards = if self.stream.uniform() < MIRRORED { -spark.place } else { spark.place };
            let share = if towards == spark.place { 1.0 - MIRRORED } else { MIRRORED };
            let passed = self.square_on(point, towards, spark.place);
            return (lamp.arriving(spark, point) * passed / share, towards);
        }
        let (towards, distance) = if lamp.is_sun() {
            (spark.place, f64::INFINITY)
        } else {
            let offset = spark.place - point;
            (offset.normalize(), offset.length())
        };
        let light = lamp.arriving(spark, point);
        if light == DVec3::ZERO {
            return (light, towards);
        }
        // What lies on a face shines to both sides of it.
        let way = self.world.way(point, towards, distance - self.world.tolerance());
        let is_free = matches!(way.end, End::Nowhere);
        let passed = if is_free { way.transmittance(self.world, distance) } else { DVec3::ZERO };
        (light * passed, towards)
    }

    /// What fog leaves of a sun's light that comes to a point from `from` by way of nothing but faces that are square on it, each of which reflects
    /// or lets through by chance.
    fn square_on(&mut self, point: DVec3, mut from: DVec3, sun: DVec3) -> DVec3 {
        let (mut place, mut passed) = (point, DVec3::ONE);
        loop {
            let way = self.world.way(place, from, f64::INFINITY);
            passed *= way.transmittance(self.world, f64::INFINITY);
            match way.end {
                End::Nowhere => return if from == sun { passed } else { DVec3::ZERO },
                End::Surface { .. } => return DVec3::ZERO,
                End::Interface { before, beyond, .. } => {
                    place += way.length() * from;
                    if self.stream.uniform() < ((before - beyond) / (before + beyond)).powi(2) {
                        from = -from;
                    }
                }
            }
        }
    }

    /// Where the channel that decides collides with the fog, if it does.
    fn collision(&mut self, way: &Way) -> Option<(f64, usize)> {
        let mut depth = -(1.0 - self.stream.uniform()).ln();
        let mut from = 0.0;
        for &(to, medium) in &way.stretches {
            let extinction = self.world.extinction(medium)[self.channel];
            if extinction > 0.0 {
                let passed = (to - from) * extinction;
                if depth < passed {
                    return medium.map(|medium| (from + depth / extinction, medium));
                }
                depth -= passed;
            }
            from = to;
        }
        None
    }

    fn scatter(&mut self, way: &Way, distance: f64, medium: usize) -> bool {
        let medium = &self.world.media[medium];
        let albedo = medium.scattering[self.channel] / medium.extinction()[self.channel];
        let densities = way.transmittance(self.world, distance) * medium.scattering;
        if self.stream.uniform() >= albedo || !self.multiply(densities) {
            return false;
        }
        self.origin += distance * self.direction;
        let cosine = sample_henyey_greenstein(medium.asymmetry, self.stream.uniform());
        self.direction = around(self.direction, cosine, self.stream.uniform());
        (self.seen, self.is_sharp) = (false, false);
        true
    }

    fn meet_surface(&mut self, length: f64, object: usize, normal: DVec3) -> bool {
        self.origin += length * self.direction;
        let normal = if normal.dot(self.direction) > 0.0 { -normal } else { normal };
        match self.world.objects[object].material {
            Material::Black | Material::Dielectric(_) => false,
            Material::Mirror(reflectance) => {
                self.direction -= 2.0 * self.direction.dot(normal) * normal;
                self.is_sharp = true;
                self.survive(reflectance)
            }
            Material::Lambert(albedo) => {
                self.gather_surface(normal, albedo);
                let sine2 = self.stream.uniform();
                self.direction = around(normal, (1.0 - sine2).sqrt(), self.stream.uniform());
                (self.seen, self.is_sharp) = (false, false);
                self.survive(albedo)
            }
        }
    }

    fn gather_surface(&mut self, normal: DVec3, albedo: DVec3) {
        let (world, point) = (self.world, self.origin);
        let near = |lamp: usize, spark: &Spark| {
            if world.lamps[lamp].is_sun() { 1.0 } else { spark.place.distance_squared(point).recip() }
        };
        let Some((number, spark, share)) = self.choose(near) else { return };
        let (light, towards) = self.light_of(number, &spark, point);
        let cosine = towards.dot(normal);
        if cosine > 0.0 {
            self.add(light * albedo * (cosine / (PI * share)));
        }
    }

    /// Reflects or refracts by chance; `eta`: the index before over that beyond.
    fn meet_interface(&mut self, eta: f64, normal: DVec3) {
        let normal = if normal.dot(self.direction) > 0.0 { -normal } else { normal };
        let cosine = -self.direction.dot(normal);
        let sine2 = eta * eta * (1.0 - cosine * cosine);
        let beyond = (1.0 - sine2).max(0.0).sqrt();
        let across = (eta * cosine - beyond) / (eta * cosine + beyond);
        let along = (cosine - eta * beyond) / (cosine + eta * beyond);
        let reflectance = if sine2 >= 1.0 { 1.0 } else { 0.5 * (across * across + along * along) };
        self.is_sharp = true;
        if self.stream.uniform() < reflectance {
            self.direction += 2.0 * cosine * normal;
        } else {
            self.direction = (eta * self.direction + (eta * cosine - beyond) * normal).normalize();
            // Radiance over the squared index is what refraction keeps.
            self.factor *= eta * eta;
        }
    }
}

/// Angles under which a point sees the ends of a part of a ray, from where the ray is nearest, and the difference over that distance: the
/// integral of the inverse square.
fn seen_from(place: DVec3, origin: DVec3, direction: DVec3, ends: [f64; 2]) -> [f64; 3] {
    let nearest = (place - origin).dot(direction);
    let gap = (place - origin - nearest * direction).length();
    let [low, high] = ends.map(|end| ((end - nearest) / gap).atan());
    [low, high, (high - low) / gap]
}

/// A place on a part of a ray in proportion to the inverse square of its distance from a point, with the density.
fn equiangular(place: DVec3, origin: DVec3, direction: DVec3, ends: [f64; 2], xi: f64) -> (f64, f64) {
    let [low, high, integral] = seen_from(place, origin, direction, ends);
    let nearest = (place - origin).dot(direction);
    let gap = (place - origin - nearest * direction).length();
    let angle = low + xi * (high - low);
    (nearest + gap * angle.tan(), angle.cos().powi(2) / (gap * gap * integral))
}

pub(super) fn henyey_greenstein(g: f64, cosine: f64) -> f64 {
    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5))
}

pub(super) fn sample_henyey_greenstein(g: f64, xi: f64) -> f64 {
    if g == 0.0 {
        return 2.0 * xi - 1.0;
    }
    let part = (1.0 - g * g) / (1.0 - g + 2.0 * g * xi);
    ((1.0 + g * g - part * part) / (2.0 * g)).clamp(-1.0, 1.0)
}
