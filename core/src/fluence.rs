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
    pub fn to_array(self) -> [f32; 6] {
        [self.xx, self.yy, self.zz, self.xy, self.xz, self.yz]
    }

    /// The inverse of [`FluenceSpectrum::to_array`].
    pub fn from_array([xx, yy, zz, xy, xz, yz]: [f32; 6]) -> Self {
        Self { xx, yy, zz, xy, xz, yz }
    }

    /// The spectrum's variance σ² = nᵀ Σ n along a unit `axis` \[cycles²/m²\], never negative.
    pub fn variance_along(&self, axis: Vec3) -> f32 {
        let n = axis;
        let sum = n.x * n.x * self.xx
            + n.y * n.y * self.yy
            + n.z * n.z * self.zz
            + 2.0 * (n.x * n.y * self.xy + n.x * n.z * self.xz + n.y * n.z * self.yz);
        sum.max(0.0)
    }
}
