//! Lamps: points on them, the light that arrives from there, and what a ray sees that meets them.

use crate::random::Stream;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// A lamp; `power` is W/sr, W/(m² sr) or W/m², as its kind has it.
#[derive(Clone, Debug)]
pub(super) struct Lamp {
    pub(super) kind: Kind,
    pub(super) power: DVec3,
    /// Whether the camera sees it, straight or by way of glass and mirrors alone.
    pub(super) is_visible: bool,
}

#[derive(Clone, Debug)]
pub(super) enum Kind {
    Point {
        position: DVec3,
    },
    /// Half-angles \[rad\].
    Spot {
        position: DVec3,
        axis: DVec3,
        inner: f64,
        outer: f64,
    },
    Disk {
        center: DVec3,
        normal: DVec3,
        radius: f64,
    },
    Rectangle {
        corner: DVec3,
        u: DVec3,
        v: DVec3,
    },
    Sphere {
        center: DVec3,
        radius: f64,
    },
    /// Half the angle that it is seen under \[rad\], and the direction of its light.
    Sun {
        direction: DVec3,
        angle: f64,
    },
}

/// A point of a lamp.
#[derive(Clone, Copy)]
pub(super) struct Spark {
    /// Of a sun: towards it.
    pub(super) place: DVec3,
    normal: DVec3,
}

impl Lamp {
    /// Whether rays find it that are not aimed at it.
    pub(super) fn has_size(&self) -> bool {
        match self.kind {
            Kind::Point { .. } | Kind::Spot { .. } => false,
            Kind::Sun { angle, .. } => angle > 0.0,
            Kind::Disk { .. } | Kind::Rectangle { .. } | Kind::Sphere { .. } => true,
        }
    }

    /// Whether it is a sun without a size whose light goes along an axis.
    pub(super) fn is_along_an_axis(&self) -> bool {
        matches!(self.kind, Kind::Sun { direction, angle: 0.0 } if direction.abs().max_element() == 1.0)
    }

    pub(super) fn is_sun(&self) -> bool {
        matches!(self.kind, Kind::Sun { .. })
    }

    /// A point of it, evenly over its area, or a direction, evenly over the disk of a sun.
    pub(super) fn spark(&self, stream: &mut Stream) -> Spark {
        let mut pair = || (stream.uniform(), stream.uniform());
        let (place, normal) = match self.kind {
            Kind::Point { position } | Kind::Spot { position, .. } => (position, DVec3::ZERO),
            Kind::Disk { center, normal, radius } => {
                let (a, b) = pair();
                let (e, f) = normal.any_orthonormal_pair();
                (center + radius * a.sqrt() * ((TAU * b).cos() * e + (TAU * b).sin() * f), normal)
            }
            Kind::Rectangle { corner, u, v } => {
                let (a, b) = pair();
                (corner + a * u + b * v, u.cross(v).normalize())
            }
            Kind::Sphere { center, radius } => {
                let (a, b) = pair();
                let normal = around(DVec3::Z, 2.0 * a - 1.0, b);
                (center + radius * normal, normal)
            }
            Kind::Sun { direction, angle } => {
                let (a, b) = pair();
                (around(-direction, 1.0 - a * cap(angle), b), DVec3::ZERO)
            }
        };
        Spark { place, normal }
    }

    /// Light that arrives at a point from a spark \[W/m² across the way\], over the density of the sparks; nothing between counts.
    pub(super) fn arriving(&self, spark: &Spark, point: DVec3) -> DVec3 {
        let offset = point - spark.place;
        let square = offset.length_squared();
        let factor = match self.kind {
            Kind::Point { .. } => 1.0 / square,
            Kind::Spot { axis, inner, outer, .. } => {
                let q = ((outer - axis.angle_between(offset)) / (outer - inner)).clamp(0.0, 1.0);
                q * q * (3.0 - 2.0 * q) / square
            }
            Kind::Sun { angle, .. } => 2.0 / (1.0 + angle.cos()),
            Kind::Disk { .. } | Kind::Rectangle { .. } | Kind::Sphere { .. } => {
                let cosine = offset.dot(spark.normal) / square.sqrt();
                cosine.max(0.0) * self.area() / square
            }
        };
        if factor > 0.0 { factor * self.power } else { DVec3::ZERO }
    }

    fn area(&self) -> f64 {
        match self.kind {
            Kind::Disk { radius, .. } => PI * radius * radius,
            Kind::Rectangle { u, v, .. } => u.cross(v).length(),
            Kind::Sphere { radius, .. } => 4.0 * PI * radius * radius,
            Kind::Point { .. } | Kind::Spot { .. } | Kind::Sun { .. } => 0.0,
        }
    }

    /// Intensity towards where most light goes, or irradiance of a sun: what lamps are chosen by.
    pub(super) fn strength(&self) -> f64 {
        self.power.element_sum() * if self.has_size() && !self.is_sun() { self.area() } else { 1.0 }
    }

    /// How far along a ray its shining side is met, and the radiance there; of a sun infinitely far.
    pub(super) fn met(&self, origin: DVec3, direction: DVec3) -> Option<(f64, DVec3)> {
        let (distance, radiance) = match self.kind {
            Kind::Point { .. } | Kind::Spot { .. } => return None,
            Kind::Sun { direction: light, angle } => {
                let is_met = angle > 0.0 && (-light).angle_between(direction) < angle;
                (if is_met { f64::INFINITY } else { 0.0 }, self.power / (PI * angle.sin().powi(2)))
            }
            Kind::Disk { center, normal, radius } => {
                let distance = (center - origin).dot(normal) / direction.dot(normal);
                let place = origin + distance * direction;
                let is_met = direction.dot(normal) < 0.0 && place.distance(center) < radius;
                (if is_met { distance } else { 0.0 }, self.power)
            }
            Kind::Rectangle { corner, u, v } => {
                let shape = super::shapes::Shape::Rectangle { corner, u, v };
                let met = shape.crossings(origin, direction);
                let is_front = u.cross(v).dot(direction) < 0.0;
                (met.first().map_or(0.0, |found| if is_front { found.0 } else { 0.0 }), self.power)
            }
            Kind::Sphere { center, radius } => {
                let shape = super::shapes::Shape::Sphere { center, radius };
                (shape.crossings(origin, direction).first().map_or(0.0, |near| near.0), self.power)
            }
        };
        (distance > 0.0).then_some((distance, radiance))
    }
}

/// Height of the cap of a half-angle on the unit sphere: 1 - cos without its cancellation.
fn cap(angle: f64) -> f64 {
    2.0 * (0.5 * angle).sin().powi(2)
}

/// A unit direction at this cosine from a unit axis, `turn` of the way around it.
pub(super) fn around(axis: DVec3, cosine: f64, turn: f64) -> DVec3 {
    let (e, f) = axis.any_orthonormal_pair();
    let sine = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
    (cosine * axis + sine * ((TAU * turn).cos() * e + (TAU * turn).sin() * f)).normalize()
}
