//! Where a ray meets the scene.
//!
//! Spheres, rectangles and boxes are intersected in f64 and rounded once at the end, so nothing here depends on
//! the scene's size or on its distance from the origin beyond what f32 positions can say.

use covbeam::{Curvature, Edges, ProbeHit, find_edges};
use covbeam_geometry::hit::Hit;
use covbeam_geometry::instances::{InstanceHit, Instances};
use covbeam_geometry::triangles::TriangleHit;
use glam::{DVec3, Vec3};

use crate::coincident::reach;
use crate::placed::hair;
use crate::scene::{Light, Material, Object, Placed, Scene, Shape};

/// Bounds of fog that a straight way crosses at most.
pub(crate) const MOST_BOUNDS: u32 = 64;

impl Scene {
    /// Nearest hit with distance in (0, max_distance). Self-intersection is avoided by the caller starting at
    /// [`Hit::leave`]. `direction` is unit.
    pub fn intersect(&self, origin: Vec3, direction: Vec3, max_distance: f32) -> Option<Hit> {
        self.nearest(origin, direction, max_distance, Instances::describe)
    }

    /// The same, of placed geometry as if it were shaded flat: cheaper.
    pub(crate) fn intersect_flat(&self, origin: Vec3, direction: Vec3, max_distance: f32) -> Option<Hit> {
        self.nearest(origin, direction, max_distance, Instances::describe_flat)
    }

    /// The nearest hit; of several at its place the one that decides what happens there.
    fn nearest(
        &self,
        origin: Vec3,
        direction: Vec3,
        max_distance: f32,
        describe_placed: impl Fn(&Instances, &InstanceHit) -> Hit,
    ) -> Option<Hit> {
        let (hit, is_alone) = self.first(origin, direction, max_distance, &describe_placed)?;
        Some(if is_alone { hit } else { self.deciding(hit, direction, &describe_placed) })
    }

    /// The nearest hit, and whether it is certain that no other object is at its place.
    fn first(
        &self,
        origin: Vec3,
        direction: Vec3,
        max_distance: f32,
        describe_placed: &impl Fn(&Instances, &InstanceHit) -> Hit,
    ) -> Option<(Hit, bool)> {
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
            && let Some(hit) = placed.instances().intersect(from, along, nearest)
        {
            let hit = describe_placed(placed.instances(), &hit);
            return Some((Hit { object: self.objects.len() as u32 + hit.object, ..hit }, false));
        }
        let (object, index, mesh_hit) = found?;
        let hit = describe(object, index, from + along * nearest, nearest, mesh_hit);
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
        Some((hit, is_alone))
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
            || self.placed.as_ref().is_some_and(|placed| placed.instances().occluded(start, along, distance))
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
        let is_transparent = |object: &Object| object.material.transparent() != Vec3::ZERO;
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

impl Shape {
    /// Lower and upper corner of the bounding box.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        match self {
            Self::Sphere { center, radius } => (*center - *radius, *center + *radius),
            Self::Rectangle { corner, edge_u, edge_v } => {
                let opposite = *corner + *edge_u + *edge_v;
                let (a, b) = (*corner + *edge_u, *corner + *edge_v);
                (corner.min(opposite).min(a).min(b), corner.max(opposite).max(a).max(b))
            }
            Self::Box { min, max } => (*min, *max),
            Self::Mesh(mesh) => mesh.bounds(),
        }
    }

    /// True if the shape separates an inside from an outside.
    pub fn is_closed(&self) -> bool {
        match self {
            Self::Sphere { .. } | Self::Box { .. } => true,
            Self::Rectangle { .. } => false,
            Self::Mesh(mesh) => mesh.is_closed(),
        }
    }

    /// True if a closed shape holds `point`; false for an open one.
    pub fn contains(&self, point: Vec3) -> bool {
        let point = point.as_dvec3();
        match self {
            Self::Sphere { center, radius } => {
                (point - center.as_dvec3()).length_squared() < f64::from(*radius) * f64::from(*radius)
            }
            Self::Rectangle { .. } => false,
            Self::Box { min, max } => point.cmpgt(min.as_dvec3()).all() && point.cmplt(max.as_dvec3()).all(),
            Self::Mesh(mesh) => mesh.is_closed() && mesh.contains(point),
        }
    }
}

impl Shape {
    /// False if no part of the surface is within `reach` of `point`.
    pub(crate) fn is_near(&self, point: Vec3, reach: f64) -> bool {
        let point = point.as_dvec3();
        let (min, max) = self.bounds();
        let (min, max) = (min.as_dvec3(), max.as_dvec3());
        let is_within = |margin: f64| point.cmpge(min - margin).all() && point.cmple(max + margin).all();
        match self {
            Self::Sphere { center, radius } => {
                ((point - center.as_dvec3()).length() - f64::from(*radius)).abs() <= reach
            }
            Self::Box { .. } => is_within(reach) && !is_within(-reach),
            Self::Rectangle { .. } | Self::Mesh(_) => is_within(reach),
        }
    }
}

/// Distances, of any sign, at which a line enters and leaves a shape that is not a mesh.
pub(crate) fn line_through(shape: &Shape, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
    match shape {
        Shape::Sphere { center, radius } => {
            intersect_sphere(center.as_dvec3(), f64::from(*radius), origin, direction)
        }
        Shape::Rectangle { corner, edge_u, edge_v } => {
            let edges = (edge_u.as_dvec3(), edge_v.as_dvec3());
            let distance = intersect_rectangle(corner.as_dvec3(), edges, origin, direction)?;
            Some((distance, distance))
        }
        Shape::Box { min, max } => intersect_box(min.as_dvec3(), max.as_dvec3(), origin, direction),
        Shape::Mesh(_) => None,
    }
}

/// Distance > 0 to a shape that is not a mesh.
fn ahead(shape: &Shape, origin: DVec3, direction: DVec3) -> Option<f64> {
    let (near, far) = line_through(shape, origin, direction)?;
    let distance = if near > 0.0 { near } else { far };
    (distance > 0.0).then_some(distance)
}

/// The box around two boxes.
pub(crate) fn unite((a, b): (Vec3, Vec3), (c, d): (Vec3, Vec3)) -> (Vec3, Vec3) {
    (a.min(c), b.max(d))
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
        let side = (volume / left).powf(1.0 / (3 - place) as f64);
        let count = (size[axis] / side).round().max(1.0);
        cells[axis] = count as u32;
        left /= count;
    }
    cells
}

/// Distances at which a line enters and leaves a sphere.
pub(crate) fn intersect_sphere(
    center: DVec3,
    radius: f64,
    origin: DVec3,
    direction: DVec3,
) -> Option<(f64, f64)> {
    let offset = origin - center;
    // f32 directions are unit only to 1e-7.
    let a = direction.length_squared();
    let half_b = offset.dot(direction);
    // The distance of the line from the centre: no difference of large squares.
    let aside = offset - half_b / a * direction;
    let discriminant = radius * radius - aside.length_squared();
    if discriminant < 0.0 {
        return None;
    }
    let away = offset.length();
    let c = (away - radius) * (away + radius);
    // The root of larger magnitude first, the other from their product.
    let q = -(half_b + half_b.signum() * (a * discriminant).sqrt());
    if q == 0.0 {
        return None;
    }
    let (one, other) = (q / a, c / q);
    Some((one.min(other), one.max(other)))
}

/// Distance, of any sign, at which a line meets a parallelogram.
pub(crate) fn intersect_rectangle(
    corner: DVec3,
    (edge_u, edge_v): (DVec3, DVec3),
    origin: DVec3,
    direction: DVec3,
) -> Option<f64> {
    let normal = edge_u.cross(edge_v);
    let distance = (corner - origin).dot(normal) / direction.dot(normal);
    // Not finite where the ray is parallel to the plane.
    if !distance.is_finite() {
        return None;
    }
    let from_corner = origin + distance * direction - corner;
    let area = normal.length_squared();
    let u = from_corner.cross(edge_v).dot(normal) / area;
    let v = edge_u.cross(from_corner).dot(normal) / area;
    ((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v)).then_some(distance)
}

/// Distances at which a line enters and leaves a box.
pub(crate) fn intersect_box(min: DVec3, max: DVec3, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
    let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let (o, d) = (origin[axis], direction[axis]);
        if d == 0.0 {
            // Division would give NaN for an origin on the plane.
            if o < min[axis] || o > max[axis] {
                return None;
            }
            continue;
        }
        let (a, b) = ((min[axis] - o) / d, (max[axis] - o) / d);
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    (near <= far).then_some((near, far))
}

/// The outward normal of the box face that `point` is nearest to, and the point moved onto it but at least
/// `margin` away from the other faces: a ray that leaves an edge must not start beyond the face next to it.
fn box_face(min: DVec3, max: DVec3, point: DVec3, margin: f64) -> (DVec3, Vec3) {
    let size = max - min;
    let margin = margin.min(0.25 * size.min_element());
    let gaps = [(point - min) / size, (max - point) / size];
    let (mut best, mut nearest) = ((0, 0), f64::INFINITY);
    for (side, gap) in gaps.iter().enumerate() {
        for axis in 0..3 {
            if gap[axis] < nearest {
                (best, nearest) = ((side, axis), gap[axis]);
            }
        }
    }
    let (side, axis) = best;
    let (mut moved, mut normal) = (point.clamp(min + margin, max - margin), Vec3::ZERO);
    moved[axis] = [min, max][side][axis];
    normal[axis] = [-1.0, 1.0][side];
    (moved, normal)
}

/// Everything about a hit at `point` = origin + distance * direction.
pub(crate) fn describe(
    object: &Object,
    index: u32,
    point: DVec3,
    distance: f64,
    mesh_hit: Option<TriangleHit>,
) -> Hit {
    let flat = |normal: Vec3| Curvature { tangent: normal.any_orthonormal_vector(), ..Curvature::default() };
    let (min, max) = object.shape.bounds();
    let mesh_error = if let Shape::Mesh(mesh) = &object.shape { mesh.position_error() } else { 0.0 };
    // The rounding of a point to f32, the mesh's own f32 arithmetic, and far below them the f64 arithmetic of
    // large shapes near the origin, where the point itself is exact.
    let error =
        f32::EPSILON * point.abs().max_element() as f32 + mesh_error + 1e-12 * (max - min).max_element();
    let offset = 4.0 * error;
    let (position, geometric_normal, normal, curvature) = match &object.shape {
        Shape::Sphere { center, radius } => {
            let outward = (point - center.as_dvec3()).normalize();
            let position = center.as_dvec3() + f64::from(*radius) * outward;
            let normal = outward.as_vec3().normalize();
            let tangent = normal.any_orthonormal_vector();
            (
                position,
                normal,
                normal,
                Curvature { tangent, along: 1.0 / radius, across: 1.0 / radius, twist: 0.0 },
            )
        }
        Shape::Rectangle { corner, edge_u, edge_v } => {
            let outward = edge_u.as_dvec3().cross(edge_v.as_dvec3()).normalize();
            let position = point - outward * (point - corner.as_dvec3()).dot(outward);
            let normal = outward.as_vec3().normalize();
            (position, normal, normal, flat(normal))
        }
        Shape::Box { min, max } => {
            let (position, normal) = box_face(min.as_dvec3(), max.as_dvec3(), point, f64::from(offset));
            (position, normal, normal, flat(normal))
        }
        Shape::Mesh(mesh) => match mesh_hit {
            Some(hit) => {
                let surface = mesh.surface(&hit);
                (surface.position, surface.geometric_normal, surface.normal, surface.curvature)
            }
            None => unreachable!("a mesh is only hit with a TriangleHit"),
        },
    };
    let (distance, position) = (distance as f32, position.as_vec3());
    Hit { distance, position, geometric_normal, normal, curvature, object: index, material: 0, offset }
}
