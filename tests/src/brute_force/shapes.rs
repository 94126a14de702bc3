//! Balls, boxes and parallelograms: where a line crosses them, which points they hold, and which of them holds another.

use glam::DVec3;

/// Geometry of an object.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    Sphere { center: DVec3, radius: f64 },
    Box { min: DVec3, max: DVec3 },
    Rectangle { corner: DVec3, u: DVec3, v: DVec3 },
}

impl Shape {
    /// Distances along a ray, of any sign, at which it crosses the surface, with a unit normal each.
    pub(super) fn crossings(&self, origin: DVec3, direction: DVec3) -> Vec<(f64, DVec3)> {
        match *self {
            Self::Sphere { center, radius } => {
                let offset = origin - center;
                let half = offset.dot(direction);
                // From the point next to the centre: no cancellation.
                let across = (offset - half * direction).length_squared();
                let square = radius * radius - across;
                if square <= 0.0 {
                    return Vec::new();
                }
                let normal = |t: f64| (t, (offset + t * direction) / radius);
                vec![normal(-half - square.sqrt()), normal(-half + square.sqrt())]
            }
            Self::Box { min, max } => {
                let (mut enters, mut leaves) =
                    ((f64::NEG_INFINITY, DVec3::ZERO), (f64::INFINITY, DVec3::ZERO));
                for axis in 0..3 {
                    let at = |plane: DVec3| (plane[axis] - origin[axis]) / direction[axis];
                    if direction[axis] == 0.0 {
                        if origin[axis] < min[axis] || origin[axis] > max[axis] {
                            return Vec::new();
                        }
                        continue;
                    }
                    let (near, far) = (at(min).min(at(max)), at(min).max(at(max)));
                    let normal = DVec3::AXES[axis];
                    enters = if near > enters.0 { (near, normal) } else { enters };
                    leaves = if far < leaves.0 { (far, normal) } else { leaves };
                }
                if enters.0 < leaves.0 { vec![enters, leaves] } else { Vec::new() }
            }
            Self::Rectangle { corner, u, v } => {
                let normal = u.cross(v);
                let slope = normal.dot(direction);
                if slope == 0.0 {
                    return Vec::new();
                }
                let distance = normal.dot(corner - origin) / slope;
                let offset = origin + distance * direction - corner;
                let square = normal.length_squared();
                let [a, b] = [offset.cross(v), u.cross(offset)].map(|part| part.dot(normal) / square);
                let within = (0.0..=1.0).contains(&a) && (0.0..=1.0).contains(&b);
                if within { vec![(distance, normal / square.sqrt())] } else { Vec::new() }
            }
        }
    }

    /// Whether a point is inside; nothing is inside of a parallelogram.
    pub(super) fn holds(&self, point: DVec3) -> bool {
        match *self {
            Self::Sphere { center, radius } => point.distance(center) < radius,
            Self::Box { min, max } => point.cmpgt(min).all() && point.cmplt(max).all(),
            Self::Rectangle { .. } => false,
        }
    }

    /// Whether another shape is inside, but for a hundredth of its size.
    pub(super) fn holds_all(&self, other: &Self, tolerance: f64) -> bool {
        let corners = other.corners();
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let corners: Vec<DVec3> = corners.iter().map(|corner| middle + 0.99 * (corner - middle)).collect();
        match (self, other) {
            (Self::Sphere { center, radius }, Self::Sphere { center: c, radius: r }) => {
                center.distance(*c) + 0.99 * r <= radius + tolerance
            }
            (Self::Sphere { center, radius }, _) => {
                corners.iter().all(|corner| corner.distance(*center) <= radius + tolerance)
            }
            (Self::Box { min, max }, _) => {
                let inside = |corner: &DVec3| {
                    corner.cmpge(*min - tolerance).all() && corner.cmple(*max + tolerance).all()
                };
                corners.iter().all(inside)
            }
            (Self::Rectangle { .. }, _) => false,
        }
    }

    /// Corners, of a ball those of the box around it.
    pub(super) fn corners(&self) -> Vec<DVec3> {
        let of_box = |min: DVec3, max: DVec3| {
            let corner = |bits: u32| {
                let side = |axis: usize| if bits >> axis & 1 == 0 { min[axis] } else { max[axis] };
                DVec3::new(side(0), side(1), side(2))
            };
            (0..8).map(corner).collect()
        };
        match *self {
            Self::Sphere { center, radius } => of_box(center - radius, center + radius),
            Self::Box { min, max } => of_box(min, max),
            Self::Rectangle { corner, u, v } => vec![corner, corner + u, corner + v, corner + u + v],
        }
    }
}
