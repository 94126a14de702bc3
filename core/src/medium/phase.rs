//! Phase functions: their values, how they are sampled, and the bandwidth of their lobes.

use crate::math::sqrt;
use core::f32::consts::{PI, TAU};
use glam::Vec3;
use libm::{cbrtf, sincosf, sqrtf};

/// The |g| that stands for all larger ones: the largest f32 below 1.
const LARGEST_ASYMMETRY: f32 = 1.0 - f32::EPSILON / 2.0;

/// Which phase function.
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PhaseKind {
    /// The same in all directions: 1/(4π).
    #[default]
    Isotropic = 0,
    /// Henyey-Greenstein: (1 - g²) / (4π (1 + g² - 2 g cos θ)^(3/2)).
    HenyeyGreenstein = 1,
    /// Rayleigh: 3/(16π) (1 + cos²θ).
    Rayleigh = 2,
}

/// A phase function by value: how scattered light is spread over directions, 1 in all.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PhaseFunction {
    /// Its kind.
    pub kind: PhaseKind,
    /// Mean cosine g of Henyey-Greenstein, in (-1, 1), forward positive; ignored by the others. Values
    /// outside are taken as the nearest f32 inside.
    pub asymmetry: f32,
}

impl PhaseFunction {
    /// The isotropic phase function.
    pub const ISOTROPIC: Self = Self { kind: PhaseKind::Isotropic, asymmetry: 0.0 };

    /// The phase function's value \[1/sr\].
    ///
    /// - `cos_theta`: dot(incoming propagation, outgoing propagation), forward +1; rounding past ±1 is
    ///   harmless.
    ///
    /// Guarantee: no cancellation, whatever g. A narrow lobe (1 - |g| below 1e-3) varies by more than the
    /// last digit of an f32 cosine; there the value is that of the cosine as given.
    ///
    /// ```
    /// use covbeam::{PhaseFunction, PhaseKind};
    /// let fog = PhaseFunction { kind: PhaseKind::HenyeyGreenstein, asymmetry: 0.5 };
    /// // At the peak: (1 + g) / (4π (1 - g)²).
    /// assert!((fog.evaluate(1.0) - 0.477_464_8).abs() < 1e-6);
    /// ```
    // Eight-wide twin: beam_map/eight.rs.
    #[inline]
    pub fn evaluate(&self, cos_theta: f32) -> f32 {
        let cos_theta = cos_theta.clamp(-1.0, 1.0);
        match self.kind {
            PhaseKind::Isotropic => 1.0 / (4.0 * PI),
            PhaseKind::HenyeyGreenstein => {
                let g = self.clamped_asymmetry();
                let strength = g.abs();
                let width = 1.0 - strength;
                // 1 + g² - 2 g cos θ as a sum of positive terms.
                let versine = if g < 0.0 { 1.0 + cos_theta } else { 1.0 - cos_theta };
                let square = width * width + 2.0 * strength * versine;
                width * (1.0 + strength) / (4.0 * PI * square * sqrt(square))
            }
            PhaseKind::Rayleigh => 3.0 / (16.0 * PI) * (1.0 + cos_theta * cos_theta),
        }
    }

    /// Samples cos θ exactly in proportion to the phase function: the inverse of its cumulative distribution.
    ///
    /// - `xi`: uniform in [0, 1); 0 gives -1, and the cosine grows with `xi`.
    ///
    /// Guarantee: in [-1, 1] for every `xi` in [0, 1), also at g = 0 and as g → ±1 (test
    /// `extremes_stay_in_range_and_grow_with_xi`).
    ///
    /// ```
    /// use covbeam::PhaseFunction;
    /// assert_eq!(PhaseFunction::ISOTROPIC.sample_cosine(0.75), 0.5);
    /// ```
    pub fn sample_cosine(&self, xi: f32) -> f32 {
        match self.kind {
            PhaseKind::Isotropic => 2.0 * xi - 1.0,
            PhaseKind::HenyeyGreenstein if self.asymmetry < 0.0 => self.versine_to_peak(xi) - 1.0,
            PhaseKind::HenyeyGreenstein => 1.0 - self.versine_to_peak(xi),
            PhaseKind::Rayleigh => rayleigh_cosine(xi),
        }
    }

    /// Samples a direction of propagation after scattering; its weight is 1 (value / density).
    ///
    /// - `direction`: propagation before the event, unit.
    /// - `xi`: two independent uniform numbers in [0, 1).
    ///
    /// Guarantee: unit to rounding. The angle of a narrow lobe is exact: it does not pass through its cosine
    /// (test `the_angle_of_a_lobe_narrower_than_an_f32_cosine_is_exact`).
    pub fn sample(&self, direction: Vec3, xi: [f32; 2]) -> Vec3 {
        let (cos_theta, sin_theta) = match self.kind {
            PhaseKind::HenyeyGreenstein => {
                let versine = self.versine_to_peak(xi[0]);
                let towards_peak = 1.0 - versine;
                let cos_theta = if self.asymmetry < 0.0 { -towards_peak } else { towards_peak };
                (cos_theta, sqrtf(versine * (2.0 - versine)))
            }
            PhaseKind::Isotropic | PhaseKind::Rayleigh => {
                let cos_theta = self.sample_cosine(xi[0]);
                (cos_theta, sqrtf((1.0 - cos_theta) * (1.0 + cos_theta)))
            }
        };
        let (sin_phi, cos_phi) = sincosf(TAU * xi[1]);
        let (across, aside) = direction.any_orthonormal_pair();
        (direction * cos_theta + (across * cos_phi + aside * sin_phi) * sin_theta).normalize()
    }

    /// Variance, per axis, of the angular spectrum that the lobe imposes when light is convolved with it
    /// \[cycles²/rad²\].
    ///
    /// It is the relative curvature of the lobe at its peak, over 4π²: `3|g| / (4π² (1 - |g|)²)` for
    /// Henyey-Greenstein, `1/(4π²)` for Rayleigh, 0 for isotropic (convolved light is flat).
    ///
    /// Source: derived from Hess f = -4π² f Σ at the peak.
    pub fn angular_variance(&self) -> f32 {
        match self.kind {
            PhaseKind::Isotropic => 0.0,
            PhaseKind::HenyeyGreenstein => {
                let strength = self.clamped_asymmetry().abs();
                let width = 1.0 - strength;
                3.0 * strength / (4.0 * PI * PI * width * width)
            }
            PhaseKind::Rayleigh => 1.0 / (4.0 * PI * PI),
        }
    }

    fn clamped_asymmetry(&self) -> f32 {
        self.asymmetry.clamp(-LARGEST_ASYMMETRY, LARGEST_ASYMMETRY)
    }

    /// 1 - cos of the angle to Henyey-Greenstein's peak, in [0, 2].
    ///
    /// The textbook inverse divides by g and subtracts nearly equal squares. With the subtraction carried out
    /// on paper only positive factors are left: 2 (1-a)² (1-x) (1+ax) / (1-a+2ax)², a = |g|.
    fn versine_to_peak(&self, xi: f32) -> f32 {
        let g = self.clamped_asymmetry();
        let a = g.abs();
        let (x, rest) = if g < 0.0 { (1.0 - xi, xi) } else { (xi, 1.0 - xi) };
        let width = 1.0 - a;
        let ratio = width / (width + 2.0 * a * x);
        (2.0 * ratio * ratio * rest * (1.0 + a * x)).clamp(0.0, 2.0)
    }
}

/// Solves cos³θ + 3 cos θ = 8ξ - 4, Rayleigh's cumulative distribution, by Cardano's formula.
fn rayleigh_cosine(xi: f32) -> f32 {
    let half = 4.0 * xi - 2.0;
    // The cube root of the sum, on the side where nothing cancels.
    let magnitude = half.abs();
    let root = cbrtf(magnitude + sqrtf(magnitude * magnitude + 1.0));
    (root - 1.0 / root).clamp(0.0, 1.0).copysign(half)
}
