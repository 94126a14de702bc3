//! Media: extinction, transmittance, phase functions, and densities that vary in space.

mod column;
mod density;
mod derivatives;
mod mixture;
mod phase;
mod voxel_density;

use column::OPAQUE_DEPTH;
pub use column::{Column, Knot};
#[cfg(feature = "bvh")]
pub(crate) use density::LARGEST_LOGARITHM;
pub use density::{Density, ExponentialDensity};
pub use derivatives::Derivatives;
pub use mixture::PhaseShare;
pub use phase::{PhaseFunction, PhaseKind};
pub use voxel_density::DensityGrid;

use crate::math::exp;
use glam::Vec3;

/// Error of the optical depth in a table of columns: half a thousandth of the transmittance.
// A table of the exact integral, looked up by each pair: ratio tracking is unbiased, but noise in every pair.
const DEPTH_ERROR: f32 = 5e-4;

/// A medium: its coefficients, one a colour channel, how it scatters, and how its density varies in space.
///
/// ```
/// use covbeam::{Density, ExponentialDensity, Medium, Vec3};
/// let air = ExponentialDensity { origin: Vec3::ZERO, up: Vec3::Y, scale_height: 2.0 };
/// let haze = Medium { density: Density::Exponential(air), ..Medium::homogeneous(0.5, 0.25) };
/// assert_eq!(haze.mean_extinction(), 0.75);
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Medium<'a> {
    /// Scattering coefficient σ_s per channel \[1/m\], >= 0, where the density is 1.
    pub scattering: Vec3,
    /// Absorption coefficient σ_a per channel \[1/m\], >= 0, where the density is 1.
    pub absorption: Vec3,
    /// How scattered light is spread.
    pub phase: PhaseFunction,
    /// Phase functions of what is scattered otherwise: of media that overlap.
    pub more: &'a [PhaseShare],
    /// Relative density, which scales both coefficients.
    pub density: Density<'a>,
}

impl Medium<'_> {
    /// Grey fog of density 1 that scatters evenly.
    ///
    /// - `scattering`, `absorption` \[1/m\] >= 0: of all channels.
    pub const fn homogeneous(scattering: f32, absorption: f32) -> Self {
        Self {
            scattering: Vec3::splat(scattering),
            absorption: Vec3::splat(absorption),
            phase: PhaseFunction::ISOTROPIC,
            more: &[],
            density: Density::Uniform,
        }
    }

    /// The extinction coefficient σ_t = σ_s + σ_a per channel \[1/m\], where the density is 1.
    #[inline]
    pub fn extinction(&self) -> Vec3 {
        self.scattering + self.absorption
    }

    /// Mean extinction of the channels \[1/m\], where the density is 1: what light fields are attenuated
    /// with.
    #[inline]
    pub fn mean_extinction(&self) -> f32 {
        self.extinction().element_sum() / 3.0
    }

    /// The column \[m\] of density 1 after which light of every channel is down to e^-17 = 4e-8; infinite
    /// where a channel has no extinction.
    ///
    /// ```
    /// use covbeam::{Medium, Vec3};
    /// let medium = Medium { scattering: Vec3::new(1.0, 2.0, 4.0), ..Medium::default() };
    /// assert_eq!(medium.opaque_column(), 17.0);
    /// ```
    pub fn opaque_column(&self) -> f32 {
        OPAQUE_DEPTH / self.extinction().min_element()
    }

    /// The share of light left behind a column of the medium: exp(-σ_t column) per channel, in [0, 1].
    ///
    /// - `column` \[m\] >= 0: ∫ density ds, which is the distance where the density is 1. Infinity leaves 0,
    ///   or 1 in a channel without extinction.
    ///
    /// Costs one exponential where the three channels are equal, three otherwise.
    ///
    /// ```
    /// use covbeam::{Medium, Vec3};
    /// let medium = Medium { scattering: Vec3::new(1.0, 2.0, 0.0), ..Medium::default() };
    /// assert_eq!(medium.transmittance(f32::INFINITY), Vec3::new(0.0, 0.0, 1.0));
    /// ```
    // Eight-wide twin: beam_map/eight.rs.
    #[doc(alias = "Beer-Lambert")]
    #[inline(always)]
    pub fn transmittance(&self, column: f32) -> Vec3 {
        let extinction = self.extinction();
        let red = attenuation(extinction.x, column);
        if extinction.y == extinction.x && extinction.z == extinction.x {
            return Vec3::splat(red);
        }
        Vec3::new(red, attenuation(extinction.y, column), attenuation(extinction.z, column))
    }

    /// The mean of the channels of [`Medium::transmittance`]: behind fog of strong colours far more than what the mean extinction leaves.
    ///
    /// ```
    /// use covbeam::{Medium, Vec3};
    /// let medium = Medium { scattering: Vec3::new(0.0, 0.0, 300.0), ..Medium::default() };
    /// assert_eq!(medium.mean_transmittance(1.0), 2.0 / 3.0);
    /// ```
    #[inline]
    pub fn mean_transmittance(&self, column: f32) -> f32 {
        self.transmittance(column).element_sum() / 3.0
    }

    /// What is left behind a column of light that the medium scatters at its end, of all channels together: each counts by its scattering.
    #[inline]
    pub(crate) fn seen_through(&self, column: f32) -> f32 {
        let scattering = self.scattering.element_sum();
        if scattering > 0.0 {
            self.transmittance(column).dot(self.scattering) / scattering
        } else {
            self.mean_transmittance(column)
        }
    }

    /// The table of columns along a ray ([`Density::knots`]) as a gather wants it: within 5e-4 of the optical
    /// depth of the channel that is attenuated most, up to where every channel is opaque
    /// ([`Medium::opaque_column`]).
    ///
    /// ```
    /// use covbeam::{Density, DensityGrid, GridLayout, Knot, Medium, Vec3};
    /// let layout = GridLayout { min: Vec3::ZERO, max: Vec3::ONE, cells: [1, 1, 1] };
    /// let smoke = Density::Grid(DensityGrid::new(layout, &[3.0])?);
    /// let medium = Medium { density: smoke, ..Medium::homogeneous(1.0, 0.0) };
    /// let mut last = Knot::default();
    /// medium.tabulate(Vec3::splat(0.5), Vec3::Z, f32::INFINITY, &mut |knot| last = knot);
    /// assert_eq!(last, Knot { distance: 0.5, column: 1.5 });
    /// # Ok::<(), covbeam::GridError>(())
    /// ```
    pub fn tabulate(&self, origin: Vec3, direction: Vec3, length: f32, knot: &mut dyn FnMut(Knot)) {
        let error = DEPTH_ERROR / self.extinction().max_element();
        self.density.knots(origin, direction, length, error, self.opaque_column(), knot);
    }
}

#[inline(always)]
fn attenuation(extinction: f32, column: f32) -> f32 {
    // 0 · ∞ would be NaN.
    if extinction == 0.0 { 1.0 } else { exp(-extinction * column) }
}
