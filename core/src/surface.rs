//! A curved surface as a light field meets it: the plane of incidence and the curvature tensor in it.

use crate::frame::{self, Frame, Vector, combine, cross, dot};
use glam::Vec3;

/// Cosines below this are taken for exactly grazing: in `f64` they have fewer than four digits left.
pub(crate) const GRAZING: f64 = 1e-12;

/// Curvature tensor of a surface at a hit, in the tangent frame (`tangent`, `normal x tangent`) \[1/m\];
/// positive = convex towards the side that the normal points to (a sphere of radius R with outward normal: 1/R).
///
/// ```
/// use covbeam::{Curvature, Vec3};
/// // A cylinder of radius 2 along z, seen from outside.
/// let cylinder = Curvature { tangent: Vec3::Z, along: 0.0, across: 0.5, twist: 0.0 };
/// assert_eq!(Curvature::default(), Curvature { tangent: Vec3::ZERO, along: 0.0, across: 0.0, twist: 0.0 });
/// # let _ = cylinder;
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Curvature {
    /// First axis of the tensor: perpendicular to the normal, any length but 0. Where it has no direction
    /// across the normal, some axis is used: right for a plane and for a sphere, where every axis serves.
    pub tangent: Vec3,
    /// Normal curvature along `tangent` \[1/m\].
    pub along: f32,
    /// Normal curvature along `normal x tangent` \[1/m\].
    pub across: f32,
    /// The off-diagonal entry \[1/m\].
    pub twist: f32,
}

/// A surface as the incoming ray meets it.
pub(crate) struct Hit {
    /// Unit, on the incoming side.
    pub(crate) normal: Vector,
    /// Unit, across the plane of incidence.
    pub(crate) sagittal: Vector,
    /// Of the angle of incidence, > 0.
    pub(crate) cosine: f64,
    /// Curvature tensor in (sagittal, in-plane tangent), positive = convex towards the incoming side.
    pub(crate) ss: f64,
    pub(crate) st: f64,
    pub(crate) tt: f64,
}

impl Hit {
    pub(crate) fn new(frame: &Frame, normal: Vec3, curvature: &Curvature) -> Option<Self> {
        let given = frame::unit_from(normal)?;
        let cosine = -dot(given, frame.z);
        let finite =
            curvature.along.is_finite() && curvature.across.is_finite() && curvature.twist.is_finite();
        if cosine.abs() < GRAZING || !finite {
            return None;
        }
        let side = cosine.signum();
        let normal = frame::scale(side, given);
        let s = sagittal_or(frame.z, given, frame.x);
        // In the surface, and towards y: y = z x s, and -z is on the normal's side.
        let t = cross(s, normal);
        let first = Frame::new(frame::unit_from(curvature.tangent).unwrap_or([0.0; 3]), given);
        let [along, across, twist] = [curvature.along, curvature.across, curvature.twist].map(f64::from);
        let bend = |a: Vector, b: Vector| {
            let (a1, a2, b1, b2) = (dot(a, first.x), dot(a, first.y), dot(b, first.x), dot(b, first.y));
            side * (along * a1 * b1 + across * a2 * b2 + twist * (a1 * b2 + a2 * b1))
        };
        Some(Self {
            normal,
            sagittal: s,
            cosine: cosine.abs(),
            ss: bend(s, s),
            st: bend(s, t),
            tt: bend(t, t),
        })
    }
}

/// The unit vector across both `z` and `other`; zero when they are parallel.
pub(crate) fn sagittal(z: Vector, other: Vector) -> Vector {
    sagittal_or(z, other, [0.0; 3])
}

/// The unit vector across both `z` and `other`; `fallback`, which is across z, when these are parallel: the plane
/// of incidence is then arbitrary.
pub(crate) fn sagittal_or(z: Vector, other: Vector, fallback: Vector) -> Vector {
    let s = cross(z, other);
    // Closer than 1e-8 the plane changes no cosine by an ulp, but rounding would tilt s out of it.
    if dot(s, s) < 1e-16 { fallback } else { frame::unit(s).unwrap_or(fallback) }
}

/// The unit vector along the part of `v` in the surface with unit normal `n`.
pub(crate) fn in_surface(v: Vector, n: Vector) -> Option<Vector> {
    frame::unit(combine(1.0, v, -dot(v, n), n))
}
