//! Where a ray meets the scene.

use covbeam::{Edges, ProbeHit, find_edges};
use covbeam_geometry::hit::Hit;
use glam::{DVec3, Vec3};

use crate::object::geometry::Shading;
use crate::object::placed::hair;
use crate::scene::coincident::reach;
use crate::scene::{Light, Material, Object, Placed, Scene};
use covbeam_geometry::shape::{Shape, ahead, describe, unite};

/// Bounds of fog that a straight way crosses at most.
pub(crate) const MOST_BOUNDS: u32 = 64;

impl Scene {
    /// Nearest hit with distance in (0, max_distance). Self-intersection is avoided by the caller starting at
    /// [`Hit::leave`]. `direction` is unit.
    pub fn intersect(&self, origin: Vec3, direction: Vec3, max_distance: f32) -> Option<Hit> {
        self.nearest(origin, direction, max_distance, Shading::Smooth)
    }

    /// The same, of placed geometry as if it were shaded flat: cheaper.
    pub(crate) fn intersect_flat(&self, origin: Vec3, direction: Vec3, max_distance: f32) -> Option<Hit> {
        self.nearest(origin, direction, max_distance, Shading::Flat)
    }

    /// The nearest hit; of several at its place the one that decides what happens there.
    fn nearest(&self, origin: Vec3, direction: Vec3, max_distance: f32, shading: Shading) -> Option<Hit> {
        let hit = self.first(origin, direction, max_distance, shading)?;
        Some(if hit.is_alone { hit } else { self.deciding(hit, direction, shading) })
    }

    /// The nearest hit; whether it is alone may be left open.
    fn first(&self, origin: Vec3, direction: Vec3, max_distance: f32, shading: Shading) -> Option<Hit> {
        let (from, along) = (origin.as_dvec3(), direction.as_dvec3());
        let mut nearest = f64::from(max_distance);
        // Where the line meets the first of the other shapes.
        let mut next = f64::INFINITY;
        let mut found = None;
        for (object, index) in self.objects.iter().zip(0u32..) {
            let (distance, mesh_hit) = match &object.shape {
                Shape::Mesh(mesh) => match mesh.intersect(from, direction, nearest) {
                    Some(hit) => (hit.distance, Some(hit)),
                    None => continue,
                },
                shape => match ahead(shape, from, along) {
                    Some(distance) => (distance, None),
                    None => continue,
                },
            };
            if distance < nearest {
                if found.is_some() {
                    next = nearest;
                }
                nearest = distance;
                found = Some((object, index, mesh_hit));
            } else {
                next = next.min(distance);
            }
        }
        if let Some(placed) = &self.placed
            && let Some(hit) = placed.surfaces().nearest((from, along), nearest, shading)
        {
            return Some(Hit { object: self.objects.len() as u32 + hit.object, ..hit });
        }
        let (object, index, mesh_hit) = found?;
        let hit = describe(&object.shape, index, from + along * nearest, nearest, mesh_hit);
        let reach = reach(&hit);
        let may_touch = |(other, number): (&Object, u32)| {
            number != index
                && matches!(other.shape, Shape::Mesh(_))
                && other.shape.is_near(hit.position, reach)
        };
        let is_alone = nearest > reach
            && next - nearest > reach
            && self.placed.is_none()
            && !self.objects.iter().zip(0u32..).any(may_touch);
        Some(Hit { is_alone, ..hit })
    }

    /// True if anything lies strictly between the two points (shadow ray). A start on a surface should be moved off it with
    /// [`Hit::leave`]; at the end surfaces within the rounding of its coordinates do not count: a lamp may hang in a ceiling.
    pub fn occluded(&self, from: Vec3, to: Vec3) -> bool {
        let (start, end) = (from.as_dvec3(), to.as_dvec3());
        let distance = (end - start).length();
        let before = distance - hair(to);
        before > 0.0 && self.meets(start, (end - start) / distance, before)
    }

    /// True if anything is met at a distance in (0, `distance`).
    pub(crate) fn meets(&self, start: DVec3, along: DVec3, distance: f64) -> bool {
        let direction = along.as_vec3();
        let is_met = |object: &Object| match &object.shape {
            Shape::Mesh(mesh) => mesh.occluded(start, direction, distance),
            shape => ahead(shape, start, along).is_some_and(|met| met < distance),
        };
        self.objects.iter().any(is_met)
            || self
                .placed
                .as_ref()
                .is_some_and(|placed| placed.surfaces().is_blocked((start, along), distance))
    }

    /// Whether something may let light go straight on: it is transparent in part, or a dielectric that has the index of what is around all, or
    /// of another one.
    pub(crate) fn may_be_seen_through(&self) -> bool {
        if self.placed.as_ref().is_some_and(Placed::shows_through) {
            return true;
        }
        let mut indices = self.objects.iter().filter_map(|object| match object.material {
            Material::Dielectric { index } => Some(index),
            _ => None,
        });
        let mut is_matched = || indices.next().is_some_and(|first| first == 1.0 || indices.next().is_some());
        let is_transparent =
            |object: &Object| object.material.transparent().max(object.material.shadow()) != Vec3::ZERO;
        self.objects.iter().any(is_transparent) || is_matched()
    }

    /// The nearest hit of what does not let all light go straight on, of placed geometry as if it were shaded flat. A ray that has passed
    /// [`MOST_BOUNDS`] bounds is taken to meet nothing.
    pub(crate) fn intersect_solid(&self, origin: Vec3, direction: Vec3, max_distance: f32) -> Option<Hit> {
        let (mut start, mut passed) = (origin, 0.0);
        for _ in 0..MOST_BOUNDS {
            let hit = self.intersect_flat(start, direction, max_distance - passed)?;
            let distance = if passed > 0.0 { (hit.position - origin).dot(direction) } else { hit.distance };
            if !self.material(&hit).is_clear() {
                return Some(Hit { distance, ..hit });
            }
            (start, passed) = (hit.leave(direction), distance);
        }
        None
    }

    /// Edges beside the ray from `origin` along `direction` (unit) that ends at `hit`. What lets all light go straight on has none, and hides
    /// none.
    pub fn edges_beside(&self, origin: Vec3, direction: Vec3, hit: Option<&Hit>) -> Edges {
        let nearest =
            |towards: Vec3| self.intersect_solid(origin, towards, f32::INFINITY).as_ref().map(ProbeHit::from);
        let end = match hit {
            Some(hit) if self.material(hit).is_clear() => nearest(direction),
            hit => hit.map(ProbeHit::from),
        };
        find_edges(direction, end, nearest)
    }

    /// The closed dielectric objects that contain `point`.
    pub fn containing(&self, point: Vec3) -> impl Iterator<Item = u32> {
        let holds = move |object: &Object| object.material.index().is_some() && object.shape.contains(point);
        self.objects.iter().zip(0u32..).filter(move |(object, _)| holds(object)).map(|(_, index)| index)
    }
}

/// The box around all objects and lamps of a scene.
pub(crate) fn bounds_of_scene(scene: &Scene) -> (Vec3, Vec3) {
    let placed = scene.placed.as_ref().and_then(Placed::bounds);
    let objects = scene.objects.iter().map(|object| object.shape.bounds()).chain(placed);
    let lamps = scene.lights.iter().map(Light::bounds);
    objects.chain(lamps).reduce(unite).expect("a scene has a light")
}

/// Numbers of about cubic cells in a box of this size, at most about `budget` together: the spectra of light know no axes.
pub(crate) fn divide(size: Vec3, budget: u32) -> [u32; 3] {
    let size = size.as_dvec3();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| size[a].total_cmp(&size[b]));
    let mut cells = [1; 3];
    let mut left = f64::from(budget);
    for (place, &axis) in order.iter().enumerate() {
        // A side shorter than a cell has one, and leaves its share to the others.
        let volume: f64 = order[place..].iter().map(|&axis| size[axis]).product();
        let side = libm::pow(volume / left, 1.0 / (3 - place) as f64);
        let count = (size[axis] / side).round().max(1.0);
        cells[axis] = count as u32;
        left /= count;
    }
    cells
}
