//! Orthonormal frames in double precision.
//!
//! Cosines decide how a light field is stretched, and a cosine of 1e-6 has one correct digit left when it is
//! computed in single precision. Products of two `f32` are exact in `f64`, so the frame's few scalars are not
//! what limits an operator.

use glam::Vec3;

/// A vector of three `f64` in world axes.
pub(crate) type Vector = [f64; 3];

/// Square of 1e-14, some roundings of a vector: what is left of it across another may all be rounding, in any direction.
const ROUNDING: f64 = 1e-28;

/// Right-handed orthonormal frame: z = direction of propagation, x and y across it.
#[derive(Clone, Copy)]
pub(crate) struct Frame {
    pub(crate) x: Vector,
    pub(crate) y: Vector,
    pub(crate) z: Vector,
}

impl Frame {
    /// The frame with the given z whose x axis is the part of `x` across `z`; any axis across `z` when there is
    /// none.
    pub(crate) fn new(x: Vector, z: Vector) -> Self {
        let across = combine(1.0, x, -dot(x, z), z);
        let rest = dot(across, across);
        let x = if rest > 0.5 * dot(x, x) {
            frame_axis(across, z)
        } else if rest > ROUNDING * dot(x, x) {
            // A large cancellation leaves a part along z: once more.
            let x = frame_axis(across, z);
            frame_axis(combine(1.0, x, -dot(x, z), z), z)
        } else {
            any_across(z)
        };
        Self { x, y: cross(z, x), z }
    }
}

/// `across` as a unit vector, or any axis across `z` if it has no direction.
fn frame_axis(across: Vector, z: Vector) -> Vector {
    unit(across).unwrap_or_else(|| any_across(z))
}

/// `v` as a unit vector; `None` for a zero vector or one that is not finite.
pub(crate) fn unit_from(v: Vec3) -> Option<Vector> {
    unit([f64::from(v.x), f64::from(v.y), f64::from(v.z)])
}

/// `v` scaled to length 1; `None` for a zero vector or one that is not finite.
pub(crate) fn unit(v: Vector) -> Option<Vector> {
    let length = libm::sqrt(dot(v, v));
    (length > 0.0 && length < f64::INFINITY).then(|| scale(1.0 / length, v))
}

/// A unit vector across the unit vector `z`.
pub(crate) fn any_across(z: Vector) -> Vector {
    // The coordinate axis furthest from z.
    let axis = if z[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    unit(cross(cross(z, axis), z)).unwrap_or(axis)
}

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn scale(a: f64, v: Vector) -> Vector {
    [a * v[0], a * v[1], a * v[2]]
}

/// a v + b w.
pub(crate) fn combine(a: f64, v: Vector, b: f64, w: Vector) -> Vector {
    [a * v[0] + b * w[0], a * v[1] + b * w[1], a * v[2] + b * w[2]]
}

/// Rounded to single precision.
pub(crate) fn rounded(v: Vector) -> Vec3 {
    Vec3::new(v[0] as f32, v[1] as f32, v[2] as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_orthonormal_and_right_handed_even_when_its_x_axis_is_almost_along_z() {
        let z = unit([0.3, -0.5, 0.8]).unwrap();
        for x in [[1.0, 0.0, 0.0], z, combine(1.0, z, 1e-12, [0.0, 1.0, 0.0]), [0.0; 3], [f64::NAN; 3]] {
            let frame = Frame::new(x, z);
            // A few roundings of f64.
            assert!(dot(frame.x, z).abs() < 1e-15 && dot(frame.y, z).abs() < 1e-15);
            assert!((dot(frame.x, frame.x) - 1.0).abs() < 1e-15);
            assert!((dot(cross(frame.x, frame.y), z) - 1.0).abs() < 1e-15);
        }
        // Less is left of these across z than they are rounded by.
        for x in [[-0.225355, 3.22771e28, -0.721998], [0.25, -3e29, -1e-30], [1e-30, 1.0, 1e-17]] {
            let z = unit([-0.805019, 6.62924e29, -9.41048e-31]).unwrap();
            let frame = Frame::new(x, z);
            assert!(dot(frame.x, z).abs() < 1e-15 && (dot(frame.x, frame.x) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn a_vector_without_a_direction_has_no_unit_vector() {
        assert!(unit_from(Vec3::ZERO).is_none());
        assert!(unit_from(Vec3::new(f32::NAN, 0.0, 1.0)).is_none());
        assert!(unit_from(Vec3::new(f32::INFINITY, 0.0, 1.0)).is_none());
        // The shortest f32 still has one: its square does not vanish in f64.
        assert_eq!(unit_from(Vec3::new(1e-45, 0.0, 0.0)), Some([1.0, 0.0, 0.0]));
    }
}
