//! Reconstruction filters and the density of eye rays that goes with them.

use crate::math::Sym2;
use core::f32::consts::PI;
use libm::sqrtf;

/// Variance of a pixel, a unit square, along each axis \[pixels²\].
pub(crate) const PIXEL_VARIANCE: f32 = 1.0 / 12.0;

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
        let (xx, yy) = (self.xx + PIXEL_VARIANCE, self.yy + PIXEL_VARIANCE);
        let area = 4.0 * PI * sqrtf((xx * yy - self.xy * self.xy).max(0.0));
        if area > RAYS_A_FILTER && area < f32::INFINITY { RAYS_A_FILTER / area } else { 1.0 }
    }

    pub(super) fn matrix(&self) -> Sym2 {
        Sym2 { xx: self.xx, xy: self.xy, yy: self.yy }
    }
}

impl From<Sym2> for ImageFilter {
    fn from(Sym2 { xx, xy, yy }: Sym2) -> Self {
        Self { xx, xy, yy }
    }
}
