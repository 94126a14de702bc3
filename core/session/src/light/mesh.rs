//! Triangles that shine on both sides.

mod tree;

use super::directions::cosine_direction;
use super::rays::EmittedPhoton;
use super::rays::Meetings;
use super::seen::patch::triangle::SeenTriangle;
use super::seen::patch::{FRAC_1_SQRT_PI, diffuse_field, lifted};
use crate::random::PathSampler;
use covbeam::LightField;
use covbeam_geometry::MAX_COORDINATE;
use covbeam_geometry::shape::unite;
use covbeam_geometry::triangles::{Frame, Triangles, area_vector};
use glam::{DVec3, Vec3};
use std::f32::consts::{FRAC_1_SQRT_2, PI};
use std::sync::Arc;
use tree::Tree;

/// How far past a triangle that a ray has met it looks for others, in shares of the way and of the largest coordinate: ten times what rounding
/// makes of both.
const PAST: f64 = 1e-6;

/// A mesh that shines on both sides of its triangles, evenly.
#[derive(Clone, Debug, PartialEq)]
pub struct ShiningMesh {
    /// W/(m² sr) per channel.
    radiance: Vec3,
    parts: Arc<Parts>,
}

struct Parts {
    corners: Vec<[Vec3; 3]>,
    /// Areas up to each triangle's end \[m²\].
    areas: Vec<f64>,
    bounds: (Vec3, Vec3),
    /// To draw those that are near a place.
    tree: Tree,
    /// To meet them by rays.
    met: Triangles,
}

impl std::fmt::Debug for Parts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (count, (min, max)) = (self.corners.len(), self.bounds);
        write!(f, "Parts {{ {count} triangles, {min}..{max} }}")
    }
}

impl PartialEq for Parts {
    fn eq(&self, other: &Self) -> bool {
        self.corners == other.corners
    }
}

impl ShiningMesh {
    /// None: no triangle has an area, or coordinates are not finite or beyond ±1e9. Triangles without area are left out.
    ///
    /// - `radiance`: >= 0, on both sides [W/(m² sr)].
    pub fn new(triangles: &[[Vec3; 3]], radiance: Vec3) -> Option<Self> {
        let is_valid = |corner: &Vec3| corner.is_finite() && corner.abs().max_element() <= MAX_COORDINATE;
        if !triangles.iter().flatten().all(is_valid) {
            return None;
        }
        let has_area = |corners: &&[Vec3; 3]| area_vector(**corners) != DVec3::ZERO;
        let mut corners: Vec<[Vec3; 3]> = triangles.iter().filter(has_area).copied().collect();
        let bounds = corners.iter().flatten().map(|&corner| (corner, corner)).reduce(unite)?;
        let tree = Tree::new(&mut corners);
        let mut sum = 0.0;
        let areas = corners.iter().map(|&corners| {
            sum += 0.5 * area_vector(corners).length();
            sum
        });
        let areas = areas.collect();
        let frame = Frame::around(bounds.0.as_dvec3(), bounds.1.as_dvec3());
        let local: Vec<_> =
            corners.iter().map(|corners| corners.map(|c| frame.local(c.as_dvec3()))).collect();
        let met = Triangles::new(frame, &local, &[]);
        Some(Self { radiance, parts: Arc::new(Parts { corners, areas, bounds, tree, met }) })
    }

    fn area(&self) -> f64 {
        self.parts.areas[self.parts.areas.len() - 1]
    }

    /// Radius of a disk as large.
    fn equal_radius(&self) -> f32 {
        FRAC_1_SQRT_PI * self.area().sqrt() as f32
    }

    pub(super) fn flux(&self) -> Vec3 {
        2.0 * PI * self.area() as f32 * self.radiance
    }

    pub(super) fn position(&self) -> Vec3 {
        let corners = self.parts.corners[0];
        let middle = corners.iter().map(|corner| corner.as_dvec3()).sum::<DVec3>() / 3.0;
        let across = area_vector(corners);
        (middle + 1e-4 * across / across.length().sqrt()).as_vec3()
    }

    pub(super) fn bounds(&self) -> (Vec3, Vec3) {
        self.parts.bounds
    }

    /// As [`super::Light::may_have_sent`].
    pub(super) fn may_have_sent(&self, origin: Vec3) -> bool {
        let (min, max) = self.parts.bounds;
        let margin = 1e-4 * (max - min).length();
        origin.cmpge(min - margin).all() && origin.cmple(max + margin).all()
    }

    /// A place evenly on the mesh, and the unit normal of its triangle.
    pub(crate) fn place(&self, [c, d]: [f32; 2]) -> (DVec3, DVec3) {
        let areas = &self.parts.areas;
        let at = f64::from(c) * self.area();
        let index = areas.partition_point(|&end| end <= at).min(areas.len() - 1);
        let before = if index == 0 { 0.0 } else { areas[index - 1] };
        // What the choice leaves of the number.
        let rest = ((at - before) / (areas[index] - before)).clamp(0.0, 1.0);
        let corners = self.parts.corners[index];
        let [a, b, c] = corners.map(|corner| corner.as_dvec3());
        let (root, v) = (rest.sqrt(), f64::from(d));
        let place = a + root * (1.0 - v) * (b - a) + root * v * (c - a);
        (place, area_vector(corners).normalize())
    }

    /// A place moved off the mesh, to the side that a unit normal points to.
    pub(crate) fn off(&self, place: DVec3, normal: DVec3) -> Vec3 {
        lifted(place, self.area().sqrt(), normal)
    }

    /// As [`super::Light::emit_at`]: the first number runs from one side's normal to that of the other.
    pub(super) fn emit_at(&self, [a, b]: [f32; 2], sampler: &mut PathSampler) -> EmittedPhoton {
        let (place, front) = self.place(sampler.uniform_pair());
        let is_front = a < 0.5;
        let sine2 = if is_front { 2.0 * a } else { 2.0 * (1.0 - a) };
        let outwards = front.as_vec3().normalize();
        let mut direction = cosine_direction(outwards, [sine2.min(1.0 - f32::EPSILON), b]);
        let (mut normal, mut side) = (outwards, front);
        if !is_front {
            (normal, side) = (-outwards, -front);
            direction -= 2.0 * direction.dot(outwards) * outwards;
        }
        EmittedPhoton::new(self.off(place, side), direction.normalize(), self.flux(), normal)
    }

    /// As [`super::Light::light_field`].
    pub(super) fn light_field(&self, direction: Vec3, normal: Vec3) -> LightField {
        diffuse_field(direction, normal, self.equal_radius())
    }

    /// As [`super::Light::flux_density`]: a triangle by how much the place sees of it, about, and a point of it by solid angle.
    pub(super) fn flux_density(&self, point: Vec3, [u, v]: [f32; 2]) -> (Vec3, Vec3) {
        let (index, rest, share) = self.parts.tree.pick(point.as_dvec3(), f64::from(u));
        let [a, b, c] = self.parts.corners[index];
        let normal = area_vector([a, b, c]).normalize();
        let is_front = (point.as_dvec3() - a.as_dvec3()).dot(normal) > 0.0;
        let (corners, side) = if is_front { ([a, b, c], normal) } else { ([a, c, b], -normal) };
        let seen = SeenTriangle::new(corners, point);
        if !(seen.solid_angle > 0.0) {
            return (Vec3::ZERO, self.off(a.as_dvec3(), side));
        }
        let (stands_for, offset) = seen.sample([rest, f64::from(v)]);
        let density = self.radiance * (stands_for / share) as f32;
        (density, self.off(point.as_dvec3() + offset, side))
    }

    /// As [`super::Light::expected`]: as of a ball of the same area, in the middle; places in the plane of a triangle see others.
    pub(super) fn expected(&self, point: Vec3) -> (Vec3, Vec3) {
        let (middle, _) = self.middle();
        let area = self.area() as f32;
        // Half of it is turned towards the place, with half of the cosine; and no light fills more than all directions.
        let solid_angle = area / (2.0 * point.distance_squared(middle) + area / (4.0 * PI));
        (self.radiance * solid_angle, middle)
    }

    /// As [`super::Light::met`]: each look starts past what the last one found, and sheets that are closer than that are one.
    pub(super) fn met(&self, origin: DVec3, direction: DVec3, ends: [f64; 2], found: &mut Meetings) {
        let step = PAST * origin.abs().max_element().max(self.reach(origin));
        // From the same start whatever part of the ray is asked for: the same distances.
        let (mut passed, mut last) = (0.0, None);
        while let Some(hit) = self.parts.met.intersect(origin + passed * direction, direction, f64::INFINITY)
        {
            let distance = passed + hit.distance;
            if distance > ends[1] {
                break;
            }
            // A ray along a triangle may seem to meet it again.
            let triangle = Some(self.parts.met.index(&hit));
            let is_new = last != triangle && distance > ends[0];
            found.extend(is_new.then_some((distance, self.radiance)));
            (passed, last) = (distance + step, triangle);
        }
    }

    /// How far from a place it reaches.
    fn reach(&self, place: DVec3) -> f64 {
        let (min, max) = self.parts.bounds;
        (place - min.as_dvec3()).abs().max((max.as_dvec3() - place).abs()).length()
    }

    pub(super) fn radiance(&self) -> Vec3 {
        self.radiance
    }

    /// As [`super::Light::middle`].
    pub(super) fn middle(&self) -> (Vec3, f32) {
        let (min, max) = self.parts.bounds;
        (0.5 * (min + max), FRAC_1_SQRT_2 * self.equal_radius())
    }
}
