//! The covariance of the fluence's spectrum: a light field's slice (Eq 5.14), which a voxel stores and a
//! kernel radius is read from.

use super::LightField;
use crate::math::SIX;
use core::f64::consts::PI;
use glam::Vec3;

/// Symmetric 3x3 covariance of the spectrum of the fluence around a point, in world axes \[cycles²/m²\].
///
/// Source: thesis 5.3.1, Eq 5.12 and 5.14. Always positive semi-definite up to rounding.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FluenceSpectrum {
    /// Variance along world x.
    pub xx: f32,
    /// Variance along world y.
    pub yy: f32,
    /// Variance along world z.
    pub zz: f32,
    /// Covariance of x and y.
    pub xy: f32,
    /// Covariance of x and z.
    pub xz: f32,
    /// Covariance of y and z.
    pub yz: f32,
}

impl FluenceSpectrum {
    /// The six numbers in the order xx, yy, zz, xy, xz, yz.
    ///
    /// ```
    /// use covbeam::FluenceSpectrum;
    /// let spectrum = FluenceSpectrum { xx: 1.0, yy: 2.0, zz: 3.0, xy: 0.1, xz: 0.2, yz: 0.3 };
    /// assert_eq!(spectrum.to_array(), [1.0, 2.0, 3.0, 0.1, 0.2, 0.3]);
    /// assert_eq!(FluenceSpectrum::from_array(spectrum.to_array()), spectrum);
    /// ```
    pub fn to_array(self) -> [f32; 6] {
        [self.xx, self.yy, self.zz, self.xy, self.xz, self.yz]
    }

    /// The inverse of [`FluenceSpectrum::to_array`].
    pub fn from_array([xx, yy, zz, xy, xz, yz]: [f32; 6]) -> Self {
        Self { xx, yy, zz, xy, xz, yz }
    }

    /// Adds a variance along one axis: Σ + `variance` n nᵀ.
    ///
    /// - `axis` n: unit.
    /// - `variance` \[cycles²/m²\] >= 0.
    ///
    /// ```
    /// use covbeam::{FluenceSpectrum, Vec3};
    /// let mut spectrum = FluenceSpectrum::default();
    /// spectrum.add_along(Vec3::new(0.6, 0.8, 0.0), 100.0);
    /// assert!((spectrum.variance_along(Vec3::Y) - 64.0).abs() < 1e-4);
    /// ```
    pub fn add_along(&mut self, axis: Vec3, variance: f32) {
        let (sum, along) = (self.to_array(), axis * variance);
        let added = SIX.map(|(i, j)| axis[i] * along[j]);
        *self = Self::from_array(core::array::from_fn(|k| sum[k] + added[k]));
    }

    /// The spectrum's variance σ² = nᵀ Σ n along a unit `axis` \[cycles²/m²\], never negative.
    ///
    /// Scales with the square of the axis' length; an axis with a NaN gives 0. Error: a few roundings of the
    /// trace, so that it says little about axes with less than 1e-6 of the largest variance.
    ///
    /// Source: thesis 5.3.4.
    ///
    /// ```
    /// use covbeam::{FluenceSpectrum, Vec3};
    /// let spectrum = FluenceSpectrum::from_array([1.0, 4.0, 0.0, 0.5, 0.0, 0.0]);
    /// assert_eq!(spectrum.variance_along(Vec3::Y), 4.0);
    /// let diagonal = Vec3::new(0.6, 0.8, 0.0);
    /// assert!((spectrum.variance_along(diagonal) - (0.36 + 4.0 * 0.64 + 0.48)).abs() < 1e-6);
    /// ```
    pub fn variance_along(&self, axis: Vec3) -> f32 {
        let n = axis;
        let sum = n.x * n.x * self.xx
            + n.y * n.y * self.yy
            + n.z * n.z * self.zz
            + 2.0 * (n.x * n.y * self.xy + n.x * n.z * self.xz + n.y * n.z * self.yz);
        sum.max(0.0)
    }
}

impl LightField {
    /// The spectrum of the fluence across the ray: the 2x2 covariance `[xx, xy, yy]` along the frame's x and
    /// y \[cycles²/m²\].
    ///
    /// Spectrum: the slice of Σ at zero angular frequency, its Schur complement Σ_xx - Σ_xu Σ_uu⁺ Σ_ux. Read
    /// from L without arithmetic on the angular part; with a singular Σ_uu it is the pseudo-inverse's limit.
    ///
    /// Source: thesis Eq 5.14.
    ///
    /// ```
    /// use covbeam::{LightField, Vec3};
    /// let light = LightField::gaussian(Vec3::Z, Vec3::X, [4.0, 9.0], [1.0, 1.0]);
    /// assert_eq!(light.slice(), [4.0, 0.0, 9.0]);
    /// ```
    #[doc(alias = "Schur complement")]
    #[doc(alias = "Eq 5.14")]
    pub fn slice(&self) -> [f32; 3] {
        let [_, _, _, _, _, xx, _, _, yx, yy] = self.root.map(f64::from);
        within_range([xx * xx, xx * yx, yx * yx + yy * yy])
    }

    /// The spectrum of the fluence around the ray, in world axes \[cycles²/m²\].
    ///
    /// Spectrum: R \[slice 0; 0 0\] Rᵀ, with R the frame's axes: zero along the ray.
    ///
    /// Source: thesis Eq 5.14.
    ///
    /// ```
    /// use covbeam::{LightField, Vec3};
    /// let light = LightField::gaussian(Vec3::Z, Vec3::X, [4.0, 9.0], [1.0, 1.0]);
    /// assert_eq!(light.fluence().to_array(), [4.0, 9.0, 0.0, 0.0, 0.0, 0.0]);
    /// ```
    pub fn fluence(&self) -> FluenceSpectrum {
        self.fluence_within(f32::INFINITY)
    }

    /// The spectrum of the fluence around the ray, bounded by what a voxel can resolve, in world axes
    /// \[cycles²/m²\].
    ///
    /// Spectrum: that of [`LightField::fluence`] with each of the root's two spatial columns cut to `limit`.
    ///
    /// - `limit` \[cycles/m\] > 0: the largest deviation kept. Light beside an edge has a variance of
    ///   1/(4π²ρ²), whose mean over all distances ρ does not exist: a few photons next to an edge would speak
    ///   for all. Voxels of side h cannot tell their Nyquist frequency, 1/(2h), from more.
    ///
    /// Guarantee: positive semi-definite up to rounding, no deviation above √2 `limit`.
    ///
    /// Source: thesis Eq 5.14; the bound is derived.
    ///
    /// ```
    /// use covbeam::{LightField, Vec3};
    /// let light = LightField::gaussian(Vec3::Z, Vec3::X, [4.0, 900.0], [1.0, 1.0]);
    /// assert_eq!(light.fluence_within(5.0).to_array(), [4.0, 25.0, 0.0, 0.0, 0.0, 0.0]);
    /// ```
    pub fn fluence_within(&self, limit: f32) -> FluenceSpectrum {
        let (frame, limit) = (self.frame(), f64::from(limit));
        let [_, _, _, _, _, xx, _, _, yx, yy] = self.root.map(f64::from);
        // The two spatial columns of L as vectors of the world.
        let bounded = |x: f64, y: f64| {
            let length = libm::sqrt(x * x + y * y);
            let scale = if length > limit { limit / length } else { 1.0 };
            scale * x * frame.x + scale * y * frame.y
        };
        let (a, b) = (bounded(xx, yx), bounded(0.0, yy));
        FluenceSpectrum::from_array(within_range(SIX.map(|(i, j)| a[i] * a[j] + b[i] * b[j])))
    }

    /// Variance of the fluence's spectrum along the ray \[cycles²/m²\], from how the rays spread or converge
    /// and from extinction.
    ///
    /// Spectrum: for the Gaussian field of covariance Σ the fluence goes as f ∝ √det(slice) exp(-κ s), so
    /// that with M = Σ_xu Σ_uu⁻¹ (minus the wavefront's curvature) (ln f)' = tr M - κ and (ln f)'' = tr M² -
    /// tr(slice Σ_uu⁻¹). The variance is the larger of |f''/f| and (f'/f)², over 4π².
    ///
    /// - `extinction` κ \[1/m\] >= 0 around the ray.
    ///
    /// Holds for light that comes from its source without scattering on the way: scattered light starts all
    /// along its path, and what one vertex spreads the next ones replace.
    ///
    /// Guarantee: >= 0 and finite. Test: `along_the_ray_the_fluence_has_the_spectrum_of_its_closed_form`.
    ///
    /// Source: derived. The thesis (5.3.1.2) takes the fluence as constant along the ray.
    ///
    /// ```
    /// use covbeam::{LightField, Vec3};
    /// // A point light: 1/d², a relative curvature of 2/d² across the ray and of 6/d² along it.
    /// let mut light = LightField::point(Vec3::Z, 2.0 / (4.0 * std::f32::consts::PI.powi(2)));
    /// light.travel(2.0);
    /// assert!((light.variance_along_ray(0.0) / light.slice()[0] - 3.0).abs() < 1e-5);
    /// ```
    pub fn variance_along_ray(&self, extinction: f32) -> f32 {
        let [uu, vu, vv, xu, xv, xx, yu, yv, yx, yy] = self.root.map(f64::from);
        // With L = [[A, 0], [B, C]]: M = B A⁻¹, and tr(slice Σ_uu⁻¹) is the sum of the squares in A⁻¹ C. A
        // row of A without a pivot has no column in B.
        let over = |a: f64, b: f64| if b == 0.0 { 0.0 } else { a / b };
        let (m_xv, m_yv) = (over(xv, vv), over(yv, vv));
        let (m_xu, m_yu) = (over(xu - m_xv * vu, uu), over(yu - m_yv * vu, uu));
        let first = over(xx, uu);
        let rest = [first, over(yx - vu * first, vv), over(yy, vv)];
        let slope = m_xu + m_yv - f64::from(extinction);
        let bend = m_xu * m_xu + 2.0 * m_xv * m_yu + m_yv * m_yv - rest.iter().map(|r| r * r).sum::<f64>();
        let curvature = (bend + slope * slope).abs().max(slope * slope);
        let [variance] = within_range([curvature / (4.0 * PI * PI)]);
        variance
    }
}

/// The matrix with these entries in `f32`, scaled down as a whole (so that it stays positive semi-definite)
/// if its largest entry exceeds 2¹²⁵, which leaves room for the sum of a quadratic form.
fn within_range<const N: usize>(entries: [f64; N]) -> [f32; N] {
    const END: f64 = (1u128 << 125) as f64;
    let largest = entries.iter().fold(0.0, |largest: f64, e| largest.max(e.abs()));
    let factor = if largest > END { END / largest } else { 1.0 };
    entries.map(|entry| (entry * factor) as f32)
}
