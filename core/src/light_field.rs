//! stub
use crate::FluenceSpectrum;
use glam::Vec3;

/// Curvature tensor of a surface at a hit, in the tangent frame (`tangent`, `normal x tangent`) \[1/m\];
/// positive = convex towards the side that the normal points to (a sphere of radius R with outward normal: 1/R).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Curvature {
    /// First axis of the tensor: unit, perpendicular to the normal. Ignored when the surface is flat.
    pub tangent: Vec3,
    /// Normal curvature along `tangent`.
    pub along: f32,
    /// Normal curvature along `normal x tangent`.
    pub across: f32,
    /// The off-diagonal entry.
    pub twist: f32,
}

/// Square root of the covariance of a local light field's spectrum, with the frame it is expressed in.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightField {
    /// Lower-triangular L with Σ = L Lᵀ, rows (u, v, x, y), packed row by row:
    /// `[uu, vu, vv, xu, xv, xx, yu, yv, yx, yy]`.
    pub root: [f32; 10],
    /// The frame's x axis, unit, perpendicular to `direction`; y = direction x x_axis.
    pub x_axis: Vec3,
    /// The central ray's direction of propagation, unit.
    pub direction: Vec3,
}

impl LightField {
    /// Point source.
    pub fn point(direction: Vec3, angular_variance: f32) -> Self {
        let _ = (direction, angular_variance);
        todo!()
    }
    /// Disk source.
    pub fn disk(direction: Vec3, normal: Vec3, radius: f32, angular_variance: f32) -> Self {
        let _ = (direction, normal, radius, angular_variance);
        todo!()
    }
    /// Travel.
    pub fn travel(&mut self, distance: f32) {
        let _ = distance;
        todo!()
    }
    /// Mirror.
    pub fn reflect(&mut self, normal: Vec3, curvature: &Curvature) {
        let _ = (normal, curvature);
        todo!()
    }
    /// Refraction; false (and unchanged) on total internal reflection. `eta` = n_incident / n_transmitted.
    pub fn refract(&mut self, normal: Vec3, curvature: &Curvature, eta: f32) -> bool {
        let _ = (normal, curvature, eta);
        todo!()
    }
    /// Occlusion by an edge at `distance` from the ray; `towards_edge` is a world-space direction.
    pub fn occlude(&mut self, towards_edge: Vec3, distance: f32) {
        let _ = (towards_edge, distance);
        todo!()
    }
    /// Angular spectrum multiplied in: adds angular variance along a world-space direction (a spot's rim).
    pub fn narrow(&mut self, across: Vec3, angular_variance: f32) {
        let _ = (across, angular_variance);
        todo!()
    }
    /// Scattering into `direction` by a lobe of `angular_variance` (0 = isotropic).
    pub fn scatter(&mut self, direction: Vec3, angular_variance: f32) {
        let _ = (direction, angular_variance);
        todo!()
    }
    /// Diffuse (Lambert) reflection at a surface with `normal` into `direction`.
    pub fn diffuse(&mut self, normal: Vec3, direction: Vec3) {
        let _ = (normal, direction);
        todo!()
    }
    /// The 2x2 slice at zero angular frequency `[xx, xy, yy]` in the local frame.
    pub fn slice(&self) -> [f32; 3] {
        todo!()
    }
    /// The fluence's 3x3 spectrum in world axes.
    pub fn fluence(&self) -> FluenceSpectrum {
        todo!()
    }
}
