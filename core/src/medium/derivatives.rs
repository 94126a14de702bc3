//! Gradient and Hessian of a scalar field.

use glam::Vec3;

/// First and second derivatives of a density, or of an optical depth, in world axes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Derivatives {
    /// \[1/m\] of a relative density.
    pub gradient: Vec3,
    /// \[xx, yy, zz, xy, xz, yz\] \[1/m²\] of a relative density.
    pub hessian: [f32; 6],
}
