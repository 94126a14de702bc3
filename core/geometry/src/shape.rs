//! Shapes: what they are, where lines meet them, and what is there.
//!
//! Spheres, rectangles and boxes are intersected in f64 and rounded once at the end, so nothing here depends on
//! the scene's size or on its distance from the origin beyond what f32 positions can say.

use crate::hit::Hit;
use crate::mesh::Mesh;
use crate::triangles::TriangleHit;
use covbeam::Curvature;
use glam::{DVec3, Vec3};

/// Geometry of an object.
#[derive(Clone, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "a scene holds few shapes, and a mesh's triangles are on the heap"
)]
pub enum Shape {
    /// Normal points outwards.
    Sphere {
        /// Centre.
        center: Vec3,
        /// > 0.
        radius: f32,
    },
    /// The parallelogram `corner + a edge_u + b edge_v`, a, b in [0, 1]; normal along edge_u x edge_v.
    Rectangle {
        /// One corner.
        corner: Vec3,
        /// First edge.
        edge_u: Vec3,
        /// Second edge.
        edge_v: Vec3,
    },
    /// Axis-aligned box; normal points outwards. Hit from inside and from outside.
    Box {
        /// Lower corner.
        min: Vec3,
        /// Upper corner.
        max: Vec3,
    },
    /// Triangles.
    Mesh(Mesh),
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
    pub fn is_near(&self, point: Vec3, reach: f64) -> bool {
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
pub fn line_through(shape: &Shape, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
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
pub fn ahead(shape: &Shape, origin: DVec3, direction: DVec3) -> Option<f64> {
    let (near, far) = line_through(shape, origin, direction)?;
    let distance = if near > 0.0 { near } else { far };
    (distance > 0.0).then_some(distance)
}

/// The box around two boxes.
pub fn unite((a, b): (Vec3, Vec3), (c, d): (Vec3, Vec3)) -> (Vec3, Vec3) {
    (a.min(c), b.max(d))
}

/// Distances at which a line enters and leaves a sphere.
pub fn intersect_sphere(center: DVec3, radius: f64, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
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
pub fn intersect_rectangle(
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
pub fn intersect_box(min: DVec3, max: DVec3, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
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
pub fn describe(
    shape: &Shape,
    index: u32,
    point: DVec3,
    distance: f64,
    mesh_hit: Option<TriangleHit>,
) -> Hit {
    let flat = |normal: Vec3| Curvature { tangent: normal.any_orthonormal_vector(), ..Curvature::default() };
    let (min, max) = shape.bounds();
    let mesh_error = if let Shape::Mesh(mesh) = shape { mesh.position_error() } else { 0.0 };
    // The rounding of a point to f32, the mesh's own f32 arithmetic, and far below them the f64 arithmetic of
    // large shapes near the origin, where the point itself is exact.
    let error =
        f32::EPSILON * point.abs().max_element() as f32 + mesh_error + 1e-12 * (max - min).max_element();
    let offset = 4.0 * error;
    let (position, geometric_normal, normal, curvature) = match shape {
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
    Hit {
        distance,
        position,
        geometric_normal,
        normal,
        curvature,
        object: index,
        material: 0,
        mark: [0; 3],
        is_alone: false,
        offset,
    }
}
