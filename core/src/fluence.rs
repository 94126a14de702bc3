//! The covariance of the fluence's spectrum: what a voxel stores and a kernel radius is read from.

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
    /// ```
    pub fn to_array(self) -> [f32; 6] {
        [self.xx, self.yy, self.zz, self.xy, self.xz, self.yz]
    }

    /// The inverse of [`FluenceSpectrum::to_array`].
    ///
    /// ```
    /// use covbeam::FluenceSpectrum;
    /// let spectrum = FluenceSpectrum::from_array([1.0, 2.0, 3.0, 0.1, 0.2, 0.3]);
    /// assert_eq!((spectrum.zz, spectrum.xy), (3.0, 0.1));
    /// ```
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
        let (n, along) = (axis, axis * variance);
        self.xx += n.x * along.x;
        self.yy += n.y * along.y;
        self.zz += n.z * along.z;
        self.xy += n.x * along.y;
        self.xz += n.x * along.z;
        self.yz += n.y * along.z;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variance_along_an_axis_is_its_outer_product() {
        let before = [1.0, 2.0, 3.0, 0.1, 0.2, 0.3];
        let mut spectrum = FluenceSpectrum::from_array(before);
        // Unit, and unequal on every axis, so that swapped entries show.
        spectrum.add_along(Vec3::new(2.0, 3.0, 6.0) / 7.0, 49.0);
        let outer = [4.0, 9.0, 36.0, 6.0, 12.0, 18.0];
        for ((found, before), outer) in spectrum.to_array().into_iter().zip(before).zip(outer) {
            // Three roundings of f32 at 40.
            assert!((found - before - outer).abs() < 1e-5, "{found} {before} {outer}");
        }
    }

    #[test]
    fn rounding_never_makes_a_variance_negative() {
        // Rank one along (1, 1/3, 1/7): across it the true value is 0 and rounding may be below.
        let v = Vec3::new(1.0, 1.0 / 3.0, 1.0 / 7.0);
        let s =
            FluenceSpectrum::from_array([v.x * v.x, v.y * v.y, v.z * v.z, v.x * v.y, v.x * v.z, v.y * v.z]);
        for turn in 0..100 {
            let other = Vec3::new(turn as f32 * 0.37 - 10.0, 3.0, 1.0);
            let across = v.cross(other).normalize();
            let variance = s.variance_along(across);
            // Eight roundings of terms no larger than the trace, 1.13.
            assert!((0.0..1e-6).contains(&variance), "{variance}");
        }
        assert_eq!(s.variance_along(Vec3::NAN), 0.0);
    }
}
