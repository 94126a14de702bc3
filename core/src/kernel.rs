//! Blur kernels, the radius that keeps their bias below a bound, and how radii and bounds shrink over passes.

use core::f32::consts::PI;

use glam::Vec3;
use libm::pow;

use crate::grid::FluenceGrid;
use crate::light_field::FluenceSpectrum;
use crate::math::sqrt;

/// Shape of the one-dimensional blur kernel K_r(d), normalised: its integral over [-r, r] is 1. With q = d/r:
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KernelShape {
    /// 1/(2r).
    Box = 0,
    /// 3/(4r) (1-q²).
    #[default]
    Epanechnikov = 1,
    /// 15/(16r) (1-q²)².
    Biweight = 2,
}

impl KernelShape {
    /// K_r(d) \[1/m\].
    ///
    /// - `distance` d \[m\], of either sign.
    /// - `radius` r \[m\] > 0.
    ///
    /// Guarantee: 0 where |d| >= r, for r <= 0, and where either is NaN.
    // Eight-wide twin: beam_map/eight.rs.
    #[inline]
    pub fn evaluate(self, distance: f32, radius: f32) -> f32 {
        let distance = distance.abs();
        if distance < radius {
            let q = distance / radius;
            let bump = 1.0 - q * q;
            let shape = match self {
                KernelShape::Box => 0.5,
                KernelShape::Epanechnikov => 0.75 * bump,
                KernelShape::Biweight => 0.9375 * bump * bump,
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
            KernelShape::Box => 1.0 / 3.0,
            KernelShape::Epanechnikov => 1.0 / 5.0,
            KernelShape::Biweight => 1.0 / 7.0,
        }
    }

    /// The radius r_σ \[m\] at which blurring a signal of this spectrum costs a relative bias of `error`, to
    /// second order: sqrt(ε / (2π² μ₂ σ²)).
    ///
    /// - `error` ε > 0.
    /// - `variance` σ² of the spectrum along the kernel's axis \[cycles²/m²\], >= 0; 0 gives infinity.
    ///
    /// Guarantee: falls as `variance` grows, without overflow between.
    ///
    /// Source: thesis 5.3.4 (Eq 5.11 in 1D), derived from Hess f = -4π² f Σ.
    ///
    /// ```
    /// use covbeam::KernelShape;
    /// let r = KernelShape::Box.radius_from_error(0.01, 4.0);
    /// let bias = 2.0 * std::f32::consts::PI.powi(2) / 3.0 * 4.0 * r * r;
    /// assert!((bias - 0.01).abs() < 1e-8);
    /// ```
    #[inline]
    pub fn radius_from_error(self, error: f32, variance: f32) -> f32 {
        sqrt(self.error_over_moment(error) / variance)
    }

    /// ε / (2π² μ₂), which over σ² is the square of r_σ.
    #[inline(always)]
    pub(crate) fn error_over_moment(self, error: f32) -> f32 {
        error / (2.0 * PI * PI * self.second_moment())
    }
}

/// Passes up to which the smallest radius is the product itself.
const EXACT_PASSES: u32 = 4096;

/// The radius r_i of plain progressive photon beams: r_1 = `initial`, r_{i+1} = r_i (i+α)/(i+1).
///
/// - `initial` r_1 \[m\] > 0.
/// - `alpha` α in (0, 1); r_i falls as i^(α-1). 1 keeps the radius. With 4/5 squared bias and variance fall
///   alike, as with [`error_bound`]; below, it is noise that is left.
/// - `pass` i, counted from 1 (0 is taken as 1).
///
/// NaN gives NaN from pass 2 on.
///
/// Guarantee: depends on `pass` alone, so passes may run in any order. Computed in f64: the error stays below
/// the last digit of an f32 for every pass. Cost: a few ns a pass up to pass 4096, and no more from there on.
///
/// Source: Jarosz et al., Progressive Photon Beams (2011), with a kernel in one dimension. Beyond pass 4096
/// the product, a quotient of Gamma functions, goes on by their asymptotic quotient (Tricomi and Erdélyi
/// 1951).
///
/// ```
/// // (1 + 1/2)/2, then (2 + 1/2)/3.
/// assert_eq!(covbeam::progressive_radius(1.0, 0.5, 3), 0.625);
/// ```
pub fn progressive_radius(initial: f32, alpha: f32, pass: u32) -> f32 {
    let alpha = f64::from(alpha);
    let mut radius = f64::from(initial);
    for i in 1..pass.min(EXACT_PASSES) {
        let i = f64::from(i);
        radius *= (i + alpha) / (i + 1.0);
    }
    if pass > EXACT_PASSES {
        // Γ(i+α)/Γ(i+1) = w^(α-1) (1 - c/w² + ...) with w = i + α/2 and c < 0.0161: 1e-9 at the switch.
        let middle = |i: u32| f64::from(i) + 0.5 * alpha;
        radius *= pow(middle(pass) / middle(EXACT_PASSES), alpha - 1.0);
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

/// How wide each pair of beam and eye ray is gathered in one pass: d < max(r_i, min(`max_radius`, r_σ)).
#[derive(Clone, Copy, Debug)]
pub struct Kernel<'a> {
    /// Shape.
    pub shape: KernelShape,
    /// r_i \[m\] > 0: the radius where the grid has no data, and the smallest one.
    pub min_radius: f32,
    /// Largest radius \[m\]; what the hierarchy over the beams must allow for.
    pub max_radius: f32,
    /// Accepted relative bias ε > 0 of one pair.
    pub error: f32,
    /// Where σ² comes from; `None`: plain progressive photon beams.
    pub grid: Option<FluenceGrid<'a>>,
}

impl Kernel<'_> {
    /// The radius \[m\] of a pair, and σ \[cycles/m\] along its kernel's axis (0 where the grid has no data).
    ///
    /// - `position`: where the spectrum is looked up; the closest point on the *eye ray* (looked up on the
    ///   beam, the steps of the grid print into the image).
    /// - `axis`: the kernel's axis, unit: perpendicular to beam and eye ray.
    ///
    /// The bias is bounded relative to the dimmest light around: σ² is the looked-up variance times the
    /// fluence there over the harmonic mean of the voxels' around. Beside a bright shaft, in the dark, a
    /// kernel that is right for the shaft would leak it.
    ///
    /// Guarantee: never below `min_radius`; never above `max_radius`, unless `min_radius` is.
    ///
    /// Source: thesis 5.3.4, d < max(r_i, r_σ). Differs from it in the largest radius, and beside shadows.
    ///
    /// Eight-wide twin: `beam_map/eight.rs`.
    #[inline(always)] // A call here costs the gather a quarter of its time.
    pub fn radius_at(&self, position: Vec3, axis: Vec3) -> (f32, f32) {
        self.radius_for(position, |spectrum| spectrum.variance_along(axis))
    }

    /// As [`Kernel::radius_at`], of a kernel on two axes: the biases add up, so do the variances. An axis on
    /// which the kernel is narrower is shorter than 1.
    pub(crate) fn radius_across(&self, position: Vec3, [first, second]: [Vec3; 2]) -> (f32, f32) {
        let variance =
            |spectrum: &FluenceSpectrum| spectrum.variance_along(first) + spectrum.variance_along(second);
        self.radius_for(position, variance)
    }

    #[inline(always)]
    fn radius_for(&self, position: Vec3, variance: impl Fn(&FluenceSpectrum) -> f32) -> (f32, f32) {
        let Some(found) = self.grid.and_then(|grid| grid.around(position)) else {
            return (self.min_radius, 0.0);
        };
        let variance = variance(&found.spectrum) * (found.flux / found.dimmest);
        let wanted = self.shape.radius_from_error(self.error, variance);
        (wanted.min(self.max_radius).max(self.min_radius), sqrt(variance))
    }
}

/// How the kernel shrinks over the passes of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    /// Shape.
    pub shape: KernelShape,
    /// Smallest radius in pass 1 \[m\] > 0; it falls as [`progressive_radius`].
    pub radius: f32,
    /// α in (0, 1]: the smallest radius falls as pass^(α - 1); 1 keeps it.
    pub alpha: f32,
    /// Largest radius that a spectrum may ask for \[m\] > 0.
    pub max_radius: f32,
    /// Accepted relative bias of a pair in pass 1, > 0; it falls as [`error_bound`].
    pub error: f32,
}

impl Schedule {
    /// The kernel of a pass.
    ///
    /// - `pass`: counted from 1. Passes may run in any order.
    /// - `grid`: spectra to look radii up in; `None`: plain progressive photon beams, all of them
    ///   `min_radius` wide.
    ///
    /// ```
    /// use covbeam::{KernelShape, Schedule};
    /// let shape = KernelShape::Epanechnikov;
    /// let schedule = Schedule { shape, radius: 0.5, alpha: 0.5, max_radius: 0.375, error: 0.02 };
    /// let kernels = [1, 3].map(|pass| schedule.kernel(pass, None));
    /// assert_eq!(kernels.map(|kernel| kernel.min_radius), [0.5, 0.3125]);
    /// assert_eq!(kernels.map(|kernel| kernel.max_radius), [0.5, 0.375]);
    /// ```
    pub fn kernel<'a>(&self, pass: u32, grid: Option<FluenceGrid<'a>>) -> Kernel<'a> {
        let Self { shape, radius, alpha, max_radius, error } = *self;
        let min_radius = progressive_radius(radius, alpha, pass);
        Kernel {
            shape,
            min_radius,
            max_radius: max_radius.max(min_radius),
            error: error_bound(error, pass),
            grid,
        }
    }
}
