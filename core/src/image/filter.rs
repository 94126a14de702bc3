//! Reconstruction filters and the density of eye rays that goes with them.

use super::ImageSpectrum;
use crate::math::Sym2;
use core::f32::consts::PI;
use libm::sqrtf;

/// Variance of a pixel, a unit square, along each axis \[pixels²\].
pub(crate) const PIXEL_VARIANCE: f32 = 1.0 / 12.0;

/// Largest variance of a filter \[pixels²\]: flat over any picture, and its square within what `f32` holds.
pub(super) const WIDEST: f32 = 1e12;

/// Eye rays under a filter, a pass: with fewer, whether a ray lies near the middle of the filter is left to
/// chance.
const RAYS_A_FILTER: f32 = 2.0;

/// Covariance of a Gaussian reconstruction filter \[pixels²\]: x to the right, y down.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImageFilter {
    /// Variance across.
    pub xx: f32,
    /// Covariance of across and down.
    pub xy: f32,
    /// Variance down.
    pub yy: f32,
}

impl ImageFilter {
    /// No filter: a pixel keeps to its own rays.
    pub const NONE: Self = Self { xx: 0.0, xy: 0.0, yy: 0.0 };

    /// Eye rays a pixel and pass, in (0, 1\]: two under each filter.
    ///
    /// A Gaussian filter averages over 4π sqrt(det H) pixels. With the pixel's own variance of 1/12, no
    /// filter gives 1.
    ///
    /// Source: thesis 5.3.2, density in proportion to sqrt(det C).
    ///
    /// ```
    /// use covbeam::ImageFilter;
    /// assert_eq!(ImageFilter::NONE.density(), 1.0);
    /// let wide = ImageFilter { xx: 16.0, xy: 0.0, yy: 16.0 };
    /// assert!((wide.density() - 2.0 / (4.0 * 3.14159 * (16.0 + 1.0 / 12.0))).abs() < 1e-6);
    /// ```
    pub fn density(&self) -> f32 {
        let area = 4.0 * PI * sqrtf(self.with_pixel().determinant().max(0.0));
        if area > RAYS_A_FILTER && area < f32::INFINITY { RAYS_A_FILTER / area } else { 1.0 }
    }

    /// With a pixel's own extent, which keeps filters thinner than a pixel from falling between pixels.
    fn with_pixel(&self) -> Sym2 {
        Sym2 { xx: self.xx + PIXEL_VARIANCE, xy: self.xy, yy: self.yy + PIXEL_VARIANCE }
    }

    pub(super) fn matrix(&self) -> Sym2 {
        Sym2 { xx: self.xx, xy: self.xy, yy: self.yy }
    }
}

impl ImageSpectrum {
    /// The reconstruction filter that blurs the picture by a relative bias of `error`, to second order: a
    /// Gaussian of covariance ε/(4π²) C⁻¹, wide where the spectrum is narrow.
    ///
    /// - `error` ε > 0: 2π² tr(H C) = ε for the filter's covariance H, half of it along each principal axis.
    /// - `widest` \[pixels\] > 0: largest standard deviation.
    ///
    /// Without data (weight 0) the filter is [`ImageFilter::NONE`].
    ///
    /// Source: thesis 5.3.2. It gives the filter exp(-½ xᵀ 4π²C x), which has ε = 1 and would blur a Gaussian
    /// to 1/√2 of its height; scaled here to a bias that the caller accepts.
    ///
    /// ```
    /// use covbeam::{ImageSpectrum, ImageFilter};
    /// let spectrum = ImageSpectrum { xx: 1e-2, xy: 0.0, yy: 1e-4, weight: 1.0 };
    /// let filter = spectrum.filter(0.04, 100.0);
    /// // ε/(4π²) / variance.
    /// assert!((filter.xx - 0.101_321).abs() < 1e-5 && (filter.yy - 10.132_1).abs() < 1e-3);
    /// ```
    pub fn filter(&self, error: f32, widest: f32) -> ImageFilter {
        let Self { xx, xy, yy, weight } = *self;
        if !(weight > 0.0 && error > 0.0 && widest > 0.0 && (xx + yy + xy).is_finite()) {
            return ImageFilter::NONE;
        }
        let scale = error / (4.0 * PI * PI);
        let filter = Sym2 { xx, xy, yy }.through_eigenvalues(|variance| {
            let most = widest * widest;
            // NaN-free where the variance is 0 or, by rounding, below.
            if variance * most > scale { scale / variance } else { most }
        });
        filter.map_or(ImageFilter::NONE, ImageFilter::from)
    }
}

impl From<Sym2> for ImageFilter {
    fn from(Sym2 { xx, xy, yy }: Sym2) -> Self {
        Self { xx, xy, yy }
    }
}

/// A filter's principal axes: along its own axes nothing cancels, and a long thin one does not visit the box
/// around it.
pub(super) struct Ellipse {
    /// Direction of the largest variance, unit.
    pub(super) axis: [f32; 2],
    /// Variances along it and across it \[pixels²\].
    pub(super) largest: f32,
    pub(super) smallest: f32,
}

impl Ellipse {
    pub(super) fn of(filter: &ImageFilter) -> Self {
        let matrix = filter.with_pixel();
        let largest = matrix.eigenvalues()[0];
        let smallest = (matrix.determinant() / largest).max(PIXEL_VARIANCE);
        Self { axis: matrix.axis(), largest, smallest }
    }
}

/// [`ImageFilter::NONE`] for what is none; otherwise a filter that is positive semi-definite and no wider
/// than [`WIDEST`].
pub(super) fn bounded(filter: &ImageFilter) -> ImageFilter {
    let ImageFilter { xx, xy, yy } = *filter;
    if !(xx >= 0.0 && yy >= 0.0 && xx.is_finite() && xy.is_finite() && yy.is_finite()) {
        return ImageFilter::NONE;
    }
    let (xx, yy) = (xx.min(WIDEST), yy.min(WIDEST));
    let most = sqrtf(xx * yy);
    ImageFilter { xx, xy: xy.clamp(-most, most), yy }
}
