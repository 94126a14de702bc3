//! Blur kernels, the radius that keeps their bias below a bound, and how radii and bounds shrink over passes.

use core::f32::consts::PI;

use glam::Vec3;
use libm::{pow, sqrtf};

use crate::FluenceGrid;

/// Shape of the one-dimensional blur kernel K_r(d), normalised: its integral over [-r, r] is 1. With q = d/r:
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kernel {
    /// 1/(2r).
    Box = 0,
    /// 3/(4r) (1-q²).
    #[default]
    Epanechnikov = 1,
    /// 15/(16r) (1-q²)².
    Biweight = 2,
}

impl Kernel {
    /// K_r(d) \[1/m\].
    ///
    /// - `distance` d \[m\], of either sign.
    /// - `radius` r \[m\] > 0.
    ///
    /// Guarantee: 0 where |d| >= r, for r <= 0, and where either is NaN.
    #[inline]
    pub fn evaluate(self, distance: f32, radius: f32) -> f32 {
        let distance = distance.abs();
        if distance < radius {
            let q = distance / radius;
            let bump = 1.0 - q * q;
            let shape = match self {
                Kernel::Box => 0.5,
                Kernel::Epanechnikov => 0.75 * bump,
                Kernel::Biweight => 0.9375 * bump * bump,
            };
            shape / radius
        } else {
            0.0
        }
    }

    /// Second moment μ₂ of the kernel of radius 1 (that of radius r is μ₂ r²).
    #[inline]
    pub fn second_moment(self) -> f32 {
        match self {
            Kernel::Box => 1.0 / 3.0,
            Kernel::Epanechnikov => 1.0 / 5.0,
            Kernel::Biweight => 1.0 / 7.0,
        }
    }

    /// The radius r_σ \[m\] at which blurring a signal of this spectrum costs a relative bias of `error`, to second
    /// order: sqrt(ε / (2π² μ₂ σ²)).
    ///
    /// - `error` ε > 0.
    /// - `variance` σ² of the spectrum along the kernel's axis \[cycles²/m²\], >= 0; 0 gives infinity.
    ///
    /// Guarantee: falls as `variance` grows, without overflow between.
    ///
    /// Source: thesis 5.3.4 (Eq 5.11 in 1D), derived from Hess f = -4π² f Σ.
    ///
    /// ```
    /// use covbeam::Kernel;
    /// let r = Kernel::Box.radius_from_error(0.01, 4.0);
    /// let bias = 2.0 * std::f32::consts::PI.powi(2) / 3.0 * 4.0 * r * r;
    /// assert!((bias - 0.01).abs() < 1e-8);
    /// ```
    #[inline]
    pub fn radius_from_error(self, error: f32, variance: f32) -> f32 {
        sqrtf(error / (2.0 * PI * PI * self.second_moment()) / variance)
    }
}

/// The radius r_i of plain progressive photon beams: r_1 = `initial`, r_{i+1} = r_i (i+α)/(i+1).
///
/// - `initial` r_1 \[m\] > 0.
/// - `alpha` α in (0, 1); r_i falls as i^(α-1). 1 keeps the radius.
/// - `pass` i, counted from 1 (0 is taken as 1). The cost grows with it, a few ns a pass.
///
/// Guarantee: depends on `pass` alone, so passes may run in any order. The product is taken in f64: its error stays
/// below the last digit of an f32 up to 10⁸ passes.
///
/// Source: Jarosz et al., Progressive Photon Beams (2011), with a kernel in one dimension.
///
/// ```
/// // (1 + 1/2)/2, then (2 + 1/2)/3.
/// assert_eq!(covbeam::progressive_radius(1.0, 0.5, 3), 0.625);
/// ```
pub fn progressive_radius(initial: f32, alpha: f32, pass: u32) -> f32 {
    let alpha = f64::from(alpha);
    let mut radius = f64::from(initial);
    for i in 1..pass {
        let i = f64::from(i);
        radius *= (i + alpha) / (i + 1.0);
    }
    radius as f32
}

/// The bound on the relative bias in pass i: ε_i = ε_1 i^(-2/5), so that r_σ falls as i^(-1/5).
///
/// - `initial` ε_1 > 0.
/// - `pass` i, counted from 1 (0 is taken as 1).
///
/// Guarantee: the bias of the mean over passes goes to 0, which a fixed bound does not achieve.
///
/// Source: derived; with r_σ ~ √ε it lets squared bias and variance fall alike, as N^(-4/5).
///
/// ```
/// assert_eq!(covbeam::error_bound(0.02, 32), 0.005);
/// ```
pub fn error_bound(initial: f32, pass: u32) -> f32 {
    (f64::from(initial) * pow(f64::from(pass.max(1)), -0.4)) as f32
}

/// How wide each pair of beam and eye ray is gathered in this pass: d < max(r_i, min(ceiling, r_σ)).
#[derive(Clone, Copy, Debug)]
pub struct KernelRadius<'a> {
    /// Shape.
    pub kernel: Kernel,
    /// r_i \[m\] > 0: the radius where the grid has no opinion, and the smallest one.
    pub progressive: f32,
    /// Largest radius \[m\]; what the hierarchy over the beams must allow for.
    pub ceiling: f32,
    /// Accepted relative bias ε > 0 of one pair.
    pub error: f32,
    /// Where σ² comes from; None = plain progressive photon beams.
    pub grid: Option<FluenceGrid<'a>>,
}

impl KernelRadius<'_> {
    /// The radius \[m\] of a pair, and σ \[cycles/m\] along its kernel's axis (0 where the grid has no data).
    ///
    /// - `position`: where the spectrum is looked up; the closest point on the *eye ray* (looked up on the beam, the
    ///   steps of the grid print into the image).
    /// - `axis`: the kernel's axis, unit: perpendicular to beam and eye ray.
    ///
    /// Guarantee: never below `progressive`; never above `ceiling`, unless `progressive` is.
    ///
    /// Source: thesis 5.3.4, d < max(r_i, r_σ). Differs from it in the ceiling.
    #[inline]
    pub fn at(&self, position: Vec3, axis: Vec3) -> (f32, f32) {
        let Some(spectrum) = self.grid.and_then(|grid| grid.look_up(position)) else {
            return (self.progressive, 0.0);
        };
        let variance = spectrum.variance_along(axis);
        let wanted = self.kernel.radius_from_error(self.error, variance);
        (wanted.min(self.ceiling).max(self.progressive), sqrtf(variance))
    }
}
