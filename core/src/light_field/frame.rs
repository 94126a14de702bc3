//! Orthonormal frames in double precision.
//!
//! Cosines decide how a light field is stretched, and a cosine of 1e-6 has one correct digit left when it is
//! computed in single precision. Products of two `f32` are exact in `f64`, so the frame's few scalars are not
//! what limits an operator.

use glam::{DVec3, Vec3};

/// Square of 1e-14, some roundings of a vector: what is left of it across another may all be rounding, in any
/// direction.
const ROUNDING: f64 = 1e-28;

/// Right-handed orthonormal frame: z = direction of propagation, x and y across it.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub(super) x: DVec3,
    pub(super) y: DVec3,
    pub(super) z: DVec3,
}

impl Frame {
    /// The frame with the given z whose x axis is the part of `x` across `z`; any axis across `z` when there
    /// is none.
    pub(super) fn new(x: DVec3, z: DVec3) -> Self {
        let across = x - x.dot(z) * z;
        let rest = across.dot(across);
        let x = if rest > 0.5 * x.dot(x) {
            frame_axis(across, z)
        } else if rest > ROUNDING * x.dot(x) {
            // A large cancellation leaves a part along z: once more.
            let x = frame_axis(across, z);
            frame_axis(x - x.dot(z) * z, z)
        } else {
            any_across(z)
        };
        Self { x, y: z.cross(x), z }
    }
}

/// `across` as a unit vector, or any axis across `z` if it has no direction.
fn frame_axis(across: DVec3, z: DVec3) -> DVec3 {
    across.try_normalize().unwrap_or_else(|| any_across(z))
}

/// `v` scaled to length 1; `None` for a zero vector or one that is not finite.
pub(super) fn unit(v: Vec3) -> Option<DVec3> {
    v.as_dvec3().try_normalize()
}

/// A unit vector across the unit vector `z`.
pub(super) fn any_across(z: DVec3) -> DVec3 {
    // The coordinate axis furthest from z.
    let axis = if z.x.abs() < 0.6 { DVec3::X } else { DVec3::Y };
    z.cross(axis).cross(z).normalize_or(axis)
}

/// The unit vector across both `z` and `other`; `fallback`, which is across z, when these are parallel: the
/// plane of incidence is then arbitrary.
pub(super) fn sagittal_or(z: DVec3, other: DVec3, fallback: DVec3) -> DVec3 {
    let s = z.cross(other);
    // Closer than 1e-8 the plane changes no cosine by an ulp, but rounding would tilt s out of it.
    if s.dot(s) < 1e-16 { fallback } else { s.normalize_or(fallback) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_orthonormal_and_right_handed_even_when_its_x_axis_is_almost_along_z() {
        let z = DVec3::new(0.3, -0.5, 0.8).normalize();
        for x in [DVec3::X, z, z + 1e-12 * DVec3::Y, DVec3::ZERO, DVec3::NAN] {
            let frame = Frame::new(x, z);
            // A few roundings of f64.
            assert!(frame.x.dot(z).abs() < 1e-15 && frame.y.dot(z).abs() < 1e-15);
            assert!((frame.x.dot(frame.x) - 1.0).abs() < 1e-15);
            assert!((frame.x.cross(frame.y).dot(z) - 1.0).abs() < 1e-15);
        }
        // Less is left of these across z than they are rounded by.
        for x in
            [[-0.225355, 3.22771e28, -0.721998], [0.25, -3e29, -1e-30], [1e-30, 1.0, 1e-17]].map(DVec3::from)
        {
            let z = DVec3::new(-0.805019, 6.62924e29, -9.41048e-31).normalize();
            let frame = Frame::new(x, z);
            assert!(frame.x.dot(z).abs() < 1e-15 && (frame.x.dot(frame.x) - 1.0).abs() < 1e-15);
        }
    }
}
