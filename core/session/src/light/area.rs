//! Flat lights whose light may be narrowed by a honeycomb before them.

use super::rays::{CURVATURE, EmittedPhoton, LEAST_EXPECTED};
use super::seen::patch::{FRAC_1_SQRT_PI, diffuse_field, front, lifted};
use super::seen::{disk, patch};
use super::stretch::{before, in_cone};
use crate::random::PathSampler;
use covbeam::LightField;
use covbeam_geometry::shape::intersect_rectangle;
use glam::{DVec3, Vec3};
use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI, TAU};

/// Edges that are so nearly as long as each other and at right angles have a disk between them.
const ROUND: f32 = 1e-5;

/// A parallelogram, or an ellipse in it, that shines on the side of edge_u x edge_v.
///
/// The slats of a honeycomb of half-angle a let the share (tan a - tan x)/(tan a - a) of the radiance through at an angle x to the normal: the
/// flux is the same for all a.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// Middle.
    pub center: Vec3,
    /// First edge, whole.
    pub edge_u: Vec3,
    /// Second edge, not parallel to the first.
    pub edge_v: Vec3,
    /// Whether it is the ellipse that touches the edges in their middles.
    pub round: bool,
    /// Half-angle of the honeycomb \[rad\], in (0, π/2]; π/2: none.
    pub spread: f32,
    /// W/(m² sr) per channel, what a honeycomb lets through on average.
    pub radiance: Vec3,
}

impl Area {
    pub(crate) fn normal(&self) -> Vec3 {
        front(self.edge_u, self.edge_v)
    }

    pub(super) fn corner(&self) -> Vec3 {
        self.center - 0.5 * (self.edge_u + self.edge_v)
    }

    fn area(&self) -> f32 {
        let whole = self.edge_u.as_dvec3().cross(self.edge_v.as_dvec3()).length() as f32;
        if self.round { 0.25 * PI * whole } else { whole }
    }

    /// Radius of a disk as large.
    fn equal_radius(&self) -> f32 {
        FRAC_1_SQRT_PI * self.area().sqrt()
    }

    fn has_honeycomb(&self) -> bool {
        self.spread < FRAC_PI_2
    }

    /// Factor on the radiance by the tangent of the angle from the normal.
    fn factor(&self, tangent: f32) -> f32 {
        if !self.has_honeycomb() {
            return 1.0;
        }
        let widest = libm::tan(f64::from(self.spread));
        ((widest - f64::from(tangent)).max(0.0) / (widest - f64::from(self.spread))) as f32
    }

    fn factor_towards(&self, direction: DVec3) -> f32 {
        let normal = self.normal().as_dvec3();
        let cosine = direction.dot(normal);
        if cosine > 0.0 { self.factor((direction.cross(normal).length() / cosine) as f32) } else { 0.0 }
    }

    pub(super) fn flux(&self) -> Vec3 {
        PI * self.area() * self.radiance
    }

    /// Along the normal, from far away \[W/sr\].
    pub(super) fn intensity(&self) -> Vec3 {
        self.factor(0.0) * self.area() * self.radiance
    }

    pub(super) fn position(&self) -> Vec3 {
        self.center + 1e-4 * self.equal_radius() * self.normal()
    }

    pub(super) fn bounds(&self) -> (Vec3, Vec3) {
        let half = 0.5 * (self.edge_u.abs() + self.edge_v.abs());
        (self.center - half, self.center + half)
    }

    /// As [`super::Light::may_have_sent`].
    pub(super) fn may_have_sent(&self, origin: Vec3) -> bool {
        origin.distance(self.center) <= 0.501 * (self.edge_u.length() + self.edge_v.length())
    }

    /// Place of two numbers in [-1, 1]², in half edges from the middle.
    pub(crate) fn place(&self, [u, v]: [f32; 2]) -> DVec3 {
        let half = 0.5 * (f64::from(u) * self.edge_u.as_dvec3() + f64::from(v) * self.edge_v.as_dvec3());
        self.center.as_dvec3() + half
    }

    /// A place of the light by uniform numbers, evenly, moved off surfaces that it may lie on.
    pub(crate) fn start(&self, [c, d]: [f32; 2]) -> Vec3 {
        let place = if self.round {
            let (sin_psi, cos_psi) = libm::sincosf(TAU * d);
            [cos_psi, sin_psi].map(|side| c.sqrt() * side)
        } else {
            [c, d].map(|number| 2.0 * number - 1.0)
        };
        self.off(self.place(place))
    }

    fn off(&self, place: DVec3) -> Vec3 {
        lifted(place, f64::from(self.area().sqrt()), self.normal().as_dvec3())
    }

    /// As [`super::Light::emit_at`]: in proportion to the cosine, as far out as the light reaches.
    pub(super) fn emit_at(&self, [a, b]: [f32; 2], sampler: &mut PathSampler) -> EmittedPhoton {
        let widest = if self.has_honeycomb() { libm::sinf(self.spread) } else { 1.0 };
        let limit = widest * widest;
        let sine2 = (a * limit).min(1.0 - f32::EPSILON);
        let normal = self.normal();
        let direction = super::cosine_direction(normal, [sine2, b]);
        let factor = limit * self.factor((sine2 / (1.0 - sine2)).sqrt());
        EmittedPhoton::new(self.start(sampler.uniform_pair()), direction, factor * self.flux(), normal)
    }

    /// As [`super::Light::light_field`].
    pub(super) fn light_field(&self, direction: Vec3) -> LightField {
        let normal = self.normal();
        let mut field = diffuse_field(direction, normal, self.equal_radius());
        if self.has_honeycomb() {
            let tangent = libm::tanf(self.spread);
            field.narrow(normal, CURVATURE / (tangent * tangent));
        }
        field
    }

    /// The radius if it is a disk.
    fn radius(&self) -> Option<f32> {
        let [u, v] = [self.edge_u.length(), self.edge_v.length()];
        let is_even = (u - v).abs() <= ROUND * u && self.edge_u.dot(self.edge_v).abs() <= ROUND * u * v;
        (self.round && is_even).then_some(0.25 * (u + v))
    }

    /// As [`super::Light::flux_density`].
    pub(super) fn flux_density(&self, point: Vec3, xi: [f32; 2]) -> (Vec3, Vec3) {
        if let (Some(radius), false) = (self.radius(), self.has_honeycomb()) {
            let (solid_angle, from) = disk::sample(self.center, self.normal(), radius, point, xi);
            return (self.radiance * solid_angle, self.off(from.as_dvec3()));
        }
        let Some(part) = self.lit_part(point) else { return (Vec3::ZERO, self.position()) };
        let [corner, edge_u, edge_v] = self.patch(part);
        let (solid_angle, from) = patch::sample(corner, edge_u, edge_v, point, xi);
        let is_there =
            !self.round || self.halves(from.as_dvec3()).iter().map(|half| half * half).sum::<f64>() < 1.0;
        let factor = if is_there { self.factor_towards(point.as_dvec3() - from.as_dvec3()) } else { 0.0 };
        (self.radiance * (solid_angle * factor), self.off(from.as_dvec3()))
    }

    /// Corner and edges of a part of the parallelogram.
    fn patch(&self, [low, high]: [[f32; 2]; 2]) -> [Vec3; 3] {
        let edge = |edge: Vec3, axis: usize| 0.5 * (high[axis] - low[axis]) * edge;
        [self.place(low).as_vec3(), edge(self.edge_u, 0), edge(self.edge_v, 1)]
    }

    /// As [`super::Light::expected`]: the patch's solid angle, and how much four of its places send.
    pub(super) fn expected(&self, point: Vec3) -> (Vec3, Vec3) {
        let Some(part) = self.lit_part(point) else { return (Vec3::ZERO, self.position()) };
        let [corner, edge_u, edge_v] = self.patch(part);
        let solid_angle = patch::solid_angle(corner, edge_u, edge_v, point);
        let sends = |quarter: usize| {
            let at = |axis: usize| {
                let share = if quarter >> axis & 1 == 0 { 0.25 } else { 0.75 };
                part[0][axis] + share * (part[1][axis] - part[0][axis])
            };
            let place = [at(0), at(1)];
            let is_there = !self.round || place[0] * place[0] + place[1] * place[1] < 1.0;
            if is_there { self.factor_towards(point.as_dvec3() - self.place(place)) } else { 0.0 }
        };
        let mean = 0.25 * (0..4).map(sends).sum::<f32>();
        let factor = mean + LEAST_EXPECTED * self.factor(0.0);
        (self.radiance * (solid_angle * factor), corner + 0.5 * (edge_u + edge_v))
    }

    /// Where a point is across the light, in half edges from the middle.
    fn halves(&self, point: DVec3) -> [f64; 2] {
        let (u, v) = (self.edge_u.as_dvec3(), self.edge_v.as_dvec3());
        let (normal, offset) = (u.cross(v), point - self.center.as_dvec3());
        let scale = 2.0 / normal.length_squared();
        [scale * offset.cross(v).dot(normal), scale * u.cross(offset).dot(normal)]
    }

    /// Lower and upper corner, in half edges from the middle, of the part of the parallelogram whose light may reach a point through the
    /// honeycomb.
    fn lit_part(&self, point: Vec3) -> Option<[[f32; 2]; 2]> {
        if !self.has_honeycomb() {
            return Some([[-1.0; 2], [1.0; 2]]);
        }
        let (u, v) = (self.edge_u.as_dvec3(), self.edge_v.as_dvec3());
        let normal = u.cross(v);
        let area = normal.length();
        let height = (point.as_dvec3() - self.center.as_dvec3()).dot(normal) / area;
        let radius = height * libm::tan(f64::from(self.spread));
        // The disk around the point's foot that it gets light from, along each edge across the other one.
        let foot = self.halves(point.as_dvec3());
        let reach = [2.0 * radius * v.length() / area, 2.0 * radius * u.length() / area];
        let low = [0, 1].map(|axis| (foot[axis] - reach[axis]).max(-1.0) as f32);
        let high = [0, 1].map(|axis| (foot[axis] + reach[axis]).min(1.0) as f32);
        (height > 0.0 && low[0] < high[0] && low[1] < high[1]).then_some([low, high])
    }

    /// As [`super::Light::lit_stretch`].
    pub(super) fn lit_stretch(&self, origin: DVec3, direction: DVec3, ends: [f32; 2]) -> Option<(f32, f32)> {
        let normal = self.normal().as_dvec3();
        let m = origin - self.center.as_dvec3();
        let (from, to) = before(m, direction, normal, ends)?;
        if !self.has_honeycomb() {
            return Some((from, to));
        }
        // A cone with all that a disk around the light shines on.
        let (u, v) = (self.edge_u.as_dvec3(), self.edge_v.as_dvec3());
        let around = 0.5 * (u + v).length().max((u - v).length());
        let (sine, cosine) = libm::sincos(f64::from(self.spread));
        let tip = m + around * cosine / sine * normal;
        let (mut from, mut to) = in_cone(tip, direction, normal, cosine, [from, to])?;
        // And where `lit_part` is something: before four planes through the edges, tilted outwards by the spread.
        let across = u.cross(v);
        let area = across.length();
        for (edge, other, turn) in [(u, v, 1.0), (v, u, -1.0)] {
            let inwards = other.cross(across) * (turn / (area * other.length()));
            for side in [1.0, -1.0] {
                let plane = sine * normal + side * cosine * inwards;
                (from, to) = before(m + side * 0.5 * edge, direction, plane, [from, to])?;
            }
        }
        Some((from, to))
    }

    /// As [`super::Light::met`].
    pub(super) fn met(&self, origin: DVec3, direction: DVec3) -> Option<(f64, Vec3)> {
        let edges = (self.edge_u.as_dvec3(), self.edge_v.as_dvec3());
        let distance = intersect_rectangle(self.corner().as_dvec3(), edges, origin, direction)?;
        let [u, v] = self.halves(origin + distance * direction);
        let is_met = !self.round || u * u + v * v < 1.0;
        is_met.then(|| (distance, self.radiance * self.factor_towards(-direction)))
    }

    /// Its radiance along the normal.
    pub(super) fn brightest(&self) -> Vec3 {
        self.factor(0.0) * self.radiance
    }

    /// As the second of [`super::Light::middle`].
    pub(super) fn softening(&self) -> f32 {
        FRAC_1_SQRT_2 * self.equal_radius()
    }
}
