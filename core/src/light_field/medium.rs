//! What a medium whose density varies does to a light field on its way.

use super::{LightField, UNBOUNDED, principal_axis};
use crate::math::symmetric;
use crate::medium::{Density, Derivatives, Medium};
use core::f64::consts::PI;
use glam::Vec3;

/// Most steps in which a light field is carried.
const MOST_STEPS: f32 = 256.0;

impl LightField {
    /// Attenuation by a stretch of medium whose optical depth τ varies across the ray.
    ///
    /// Spectrum: the signal is multiplied by exp(-τ), whose relative gradient is -∇τ and whose relative
    /// curvature is C = ∇τ ∇τᵀ - Hess τ, both across the ray. Over 4π², |C| (with the magnitudes of the
    /// eigenvalues: an envelope that knows no sign) or ∇τ ∇τᵀ is added as spatial variance, whichever has the
    /// larger trace: at an inflection the slope dominates.
    ///
    /// - `gradient` ∇τ \[1/m\] and `hessian` Hess τ \[1/m²\] of the stretch's optical depth, in world axes,
    ///   \[xx, yy, zz, xy, xz, yz\]: the extinction's derivatives integrated along the ray, with their signs.
    ///   Structure that cancels along the way attenuates evenly. All 0 (a homogeneous medium) changes
    ///   nothing.
    ///
    /// Source: thesis 5.3.1 (products in the primal domain); the positive form is derived from Hess f = -4π²
    /// f Σ.
    ///
    /// ```
    /// use covbeam::{LightField, Vec3};
    /// let mut light = LightField::gaussian(Vec3::Z, Vec3::X, [0.0, 0.0], [1.0, 1.0]);
    /// light.attenuate(Vec3::new(0.0, 3.0, 5.0), &[0.0, -7.0, 0.0, 0.0, 0.0, 0.0]);
    /// let [xx, xy, yy] = light.slice().map(|variance| variance * 4.0 * std::f32::consts::PI.powi(2));
    /// assert!(xx.abs() < 1e-5 && xy.abs() < 1e-5 && (yy - 16.0).abs() < 1e-4);
    /// ```
    #[doc(alias = "Beer-Lambert")]
    pub fn attenuate(&mut self, gradient: Vec3, hessian: &[f32; 6]) {
        if !(gradient.is_finite() && hessian.iter().all(|second| second.is_finite())) {
            return;
        }
        let frame = self.frame();
        let slope = gradient.as_dvec3();
        let (g_x, g_y) = (frame.x.dot(slope), frame.y.dot(slope));
        let hessian = symmetric(*hessian).as_dmat3();
        let p = g_x * g_x - frame.x.dot(hessian * frame.x);
        let q = g_x * g_y - frame.x.dot(hessian * frame.y);
        let r = g_y * g_y - frame.y.dot(hessian * frame.y);
        let (middle, half) = (0.5 * (p + r), 0.5 * (p - r));
        let spread = libm::sqrt(half * half + q * q);
        let (high, low) = ((middle + spread).abs(), (middle - spread).abs());
        let (cos, sin) = principal_axis(half, q);
        let root = |variance: f64| (libm::sqrt(variance) / (2.0 * PI)).min(UNBOUNDED);
        let added = if high + low >= g_x * g_x + g_y * g_y {
            let (a, b) = (root(high), root(low));
            [[a * cos, a * sin], [-b * sin, b * cos]]
        } else {
            [[g_x / (2.0 * PI), g_y / (2.0 * PI)], [0.0; 2]]
        };
        for [x, y] in added.into_iter().filter(|column| *column != [0.0; 2]) {
            self.multiply([0.0, 0.0, x, y]);
        }
    }

    /// Moves the light field through a medium: a travel, with the [`LightField::attenuate`] of the whole way
    /// at the centroid of what varies on it. Just a travel where the density is uniform.
    ///
    /// - `origin` \[m\]: where the field is; it moves along its direction.
    /// - `distance` \[m\] >= 0.
    ///
    /// The derivatives of the mean channel's optical depth are summed in steps of at most [`Density::step`]
    /// (256 of them at most) by the midpoint rule: about 1 % in an exponential medium.
    ///
    /// ```
    /// use covbeam::{Density, ExponentialDensity, LightField, Medium, Vec3};
    /// let air = Density::Exponential(ExponentialDensity { origin: Vec3::ZERO, up: Vec3::Y, scale_height: 1.0 });
    /// let haze = Medium { density: air, ..Medium::homogeneous(0.5, 0.0) };
    /// let mut light = LightField::collimated(Vec3::X, f32::INFINITY);
    /// light.travel_through(&haze, Vec3::ZERO, 2.0);
    /// // Level parallel light at height 0: τ = 1, with slope and curvature 1, which cancel: the slope dominates.
    /// assert!((light.fluence().yy - 1.0 / (4.0 * std::f32::consts::PI.powi(2))).abs() < 1e-6);
    /// ```
    pub fn travel_through(&mut self, medium: &Medium, origin: Vec3, distance: f32) {
        if matches!(medium.density, Density::Uniform) {
            self.travel(distance);
            return;
        }
        let mut shape = DepthShape::default();
        shape.add(medium, (origin, self.direction), [0.0, distance]);
        *self = shape.carried(self, distance);
    }
}

/// The derivatives of the optical depth of the way so far, and where on it they arose.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DepthShape {
    pub(crate) sum: Derivatives,
    /// Sum of the steps' weights, and of these times distance: structure counts as standing at its centroid.
    weight: f32,
    moment: f32,
}

impl DepthShape {
    /// Adds what lies between `from` and `to` on the way, in steps of at most [`Density::step`].
    pub(crate) fn add(&mut self, medium: &Medium, (origin, direction): (Vec3, Vec3), [from, to]: [f32; 2]) {
        let (density, extinction) = (&medium.density, medium.mean_extinction());
        let count = libm::ceilf((to - from) / density.step()).clamp(1.0, MOST_STEPS);
        let step = (to - from) / count;
        for i in 0..count as u32 {
            let middle = from + (i as f32 + 0.5) * step;
            let here = density.derivatives(origin + middle * direction);
            let depth = extinction * step;
            self.sum.gradient += depth * here.gradient;
            for (sum, second) in self.sum.hessian.iter_mut().zip(here.hessian) {
                *sum += depth * second;
            }
            let weight = depth * here.hessian.iter().fold(0.0, |sum: f32, second| sum + second.abs());
            self.weight += weight;
            self.moment += weight * middle;
        }
    }

    /// The field `start` after `distance` on the way that this is the shape of.
    pub(crate) fn carried(&self, start: &LightField, distance: f32) -> LightField {
        let mut field = *start;
        let centroid = if self.weight > 0.0 { (self.moment / self.weight).clamp(0.0, distance) } else { 0.0 };
        field.travel(centroid);
        field.attenuate(self.sum.gradient, &self.sum.hessian);
        field.travel(distance - centroid);
        field
    }
}
