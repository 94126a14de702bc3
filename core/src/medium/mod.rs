//! Media: extinction, transmittance, phase functions, and densities that vary in space.

mod column;
mod density;
mod derivatives;
mod phase;
mod voxel_density;

pub use column::{Column, Knot};
pub use density::{Density, ExponentialDensity};
pub use derivatives::Derivatives;
pub use phase::{PhaseFunction, PhaseKind};
pub use voxel_density::DensityGrid;

use crate::math::exp;
use glam::Vec3;

/// An optical depth that lets nothing through that single precision could see beside the rest: e^-17 = 4e-8.
pub(crate) const OPAQUE_DEPTH: f32 = 17.0;

/// A homogeneous medium with one coefficient per colour channel.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Medium {
    /// Scattering coefficient σ_s per channel \[1/m\], >= 0.
    pub scattering: Vec3,
    /// Absorption coefficient σ_a per channel \[1/m\], >= 0.
    pub absorption: Vec3,
    /// How scattered light is spread.
    pub phase: PhaseFunction,
}

impl Medium {
    /// The extinction coefficient σ_t = σ_s + σ_a per channel \[1/m\].
    #[inline]
    pub fn extinction(&self) -> Vec3 {
        self.scattering + self.absorption
    }

    /// The column \[m\] of density 1 after which light of every channel is down to e^-17 = 4e-8; infinite where a channel has no
    /// extinction.
    ///
    /// ```
    /// use covbeam::{Medium, Vec3};
    /// let medium = Medium { scattering: Vec3::new(1.0, 2.0, 4.0), ..Medium::default() };
    /// assert_eq!(medium.opaque_column(), 17.0);
    /// ```
    pub fn opaque_column(&self) -> f32 {
        OPAQUE_DEPTH / self.extinction().min_element()
    }

    /// The share of light left after `distance`: exp(-σ_t distance) per channel, in [0, 1].
    ///
    /// Does not change the spectrum: a homogeneous medium has no structure of its own.
    ///
    /// - `distance` \[m\] >= 0. Infinity leaves 0, or 1 in a channel without extinction.
    ///
    /// Costs one exponential where the three channels are equal, three otherwise.
    ///
    /// ```
    /// use covbeam::{Medium, Vec3};
    /// let medium = Medium { scattering: Vec3::new(1.0, 2.0, 0.0), ..Medium::default() };
    /// assert_eq!(medium.transmittance(f32::INFINITY), Vec3::new(0.0, 0.0, 1.0));
    /// ```
    #[inline]
    pub fn transmittance(&self, distance: f32) -> Vec3 {
        let extinction = self.extinction();
        let red = attenuation(extinction.x, distance);
        if extinction.y == extinction.x && extinction.z == extinction.x {
            return Vec3::splat(red);
        }
        Vec3::new(red, attenuation(extinction.y, distance), attenuation(extinction.z, distance))
    }
}

#[inline(always)]
fn attenuation(extinction: f32, distance: f32) -> f32 {
    // 0 · ∞ would be NaN.
    if extinction == 0.0 { 1.0 } else { exp(-extinction * distance) }
}
