//! Predicted against measured: what the fluence's differences say, within which bounds, and the verdict.

use super::measure::mean_and_error;
use std::f64::consts::PI;

/// Relative bias that a kernel as wide as a voxel may cause in light that counts as flat.
const FLAT_BIAS: f64 = 0.01;

/// Second moment of the Epanechnikov kernel.
const KERNEL_MOMENT: f64 = 0.2;

/// A standard deviation is known if it is known to this share of itself (one standard error).
const KNOWN: f64 = 0.25;

/// Largest ratio of predicted and measured that counts as agreement.
pub const FACTOR: f64 = 2.0;

/// Largest share of a stencil that may be anything but medium.
pub(super) const LARGEST_CUT: f64 = 0.1;

/// The standard deviations of the spectrum \[cycles / scene unit\] that differences over voxels of size `h` can tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Light that a kernel as wide as a voxel blurs by less than 1 % is flat to the grid: sqrt(ε/(2π² μ₂))/h with
    /// ε = 0.01 and μ₂ = 1/5.
    pub low: f64,
    /// A lone bright voxel: 1/(πh), because |f₋ - 2f₀ + f₊| <= f₋ + 2f₀ + f₊.
    pub high: f64,
}

impl Bounds {
    /// For voxels of size `h` \[scene unit\].
    pub fn of_voxel(h: f64) -> Self {
        let low = (FLAT_BIAS / (2.0 * PI * PI * KERNEL_MOMENT)).sqrt() / h;
        Self { low, high: 1.0 / (PI * h) }
    }

    /// Along x, y, z for voxels of these edges.
    pub(super) fn of_voxel_edges(size: &glam::DVec3) -> [Self; 3] {
        size.to_array().map(Self::of_voxel)
    }

    /// The nearest value within the bounds.
    pub(super) fn clamp(&self, sigma: f64) -> f64 {
        sigma.clamp(self.low, self.high)
    }
}

/// A measured standard deviation along one axis \[cycles / scene unit\], not bounded from below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Best estimate.
    pub sigma: f64,
    /// One standard error of the differences below.
    pub low: f64,
    /// One standard error above.
    pub high: f64,
}

/// The standard deviation that differences of the fluence tell: with c = (f₋ - 2f₀ + f₊)/h², g = (f₊ - f₋)/(2h) and
/// m = (f₋ + 2f₀ + f₊)/4, σ² = max(|c|/m, (g/m)²)/(4π²).
///
/// The covariance of a spectrum is an envelope that knows no phase: at an inflection the curvature vanishes, but the
/// light is not smooth there. Therefore the gradient counts as well.
///
/// - `stencils`: (f₋, f₀, f₊) of independent batches, at least 2. Their spread gives the noise; its square is taken off (g/m)².
/// - `h`: size of the voxel along the axis \[scene unit\].
///
/// None where all is dark.
pub fn measured(stencils: impl Iterator<Item = [f64; 3]> + Clone, h: f64) -> Option<Measured> {
    let (mean, _) = mean_and_error(stencils.clone().map(|[a, b, c]| 0.25 * (a + 2.0 * b + c)));
    if !(mean > 0.0) {
        return None;
    }
    let (curvature, curvature_error) =
        mean_and_error(stencils.clone().map(|[a, b, c]| (a - 2.0 * b + c) / mean));
    let (gradient, gradient_error) = mean_and_error(stencils.map(|[a, _, c]| 0.5 * (c - a) / mean));
    let (curvature, gradient) = (curvature.abs(), gradient.abs());
    let sigma = |curvature: f64, gradient_squared: f64| {
        curvature.max(gradient_squared).max(0.0).sqrt() / (2.0 * PI * h)
    };
    Some(Measured {
        sigma: sigma(curvature, gradient * gradient - gradient_error * gradient_error),
        low: sigma(curvature - curvature_error, (gradient - gradient_error).max(0.0).powi(2)),
        high: sigma(curvature + curvature_error, (gradient + gradient_error).powi(2)),
    })
}

/// What one voxel and axis say about the prediction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Predicted within a factor of 2 of measured.
    Within,
    /// Less than half: a kernel of this width is too wide, which is bias.
    TooSmall,
    /// More than twice: a kernel of this width is too narrow, which is noise.
    TooLarge,
    /// No light field came by; a render then keeps its plain radius.
    NoData,
    /// The measurement's noise leaves more than 25 % of doubt.
    Undecided,
    /// A surface cuts the stencil, or more than 10 % of one of its voxels is no medium: the fluence jumps for a reason
    /// that is not the light's.
    Surface,
    /// A neighbour is missing, at the border of the grid.
    Border,
}

impl Verdict {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Within,
        Self::TooSmall,
        Self::TooLarge,
        Self::NoData,
        Self::Undecided,
        Self::Surface,
        Self::Border,
    ];

    /// For tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Within => "within",
            Self::TooSmall => "too small",
            Self::TooLarge => "too large",
            Self::NoData => "no data",
            Self::Undecided => "undecided",
            Self::Surface => "surface",
            Self::Border => "border",
        }
    }

    /// Whether the prediction was put to the test.
    pub fn is_judged(self) -> bool {
        matches!(self, Self::Within | Self::TooSmall | Self::TooLarge | Self::NoData)
    }
}

/// Compares a prediction with a measurement, both kept within `bounds`.
pub fn judge(predicted: Option<f64>, measured: &Measured, bounds: &Bounds) -> Verdict {
    let sigma = bounds.clamp(measured.sigma);
    if bounds.clamp(measured.high) - bounds.clamp(measured.low) > 2.0 * KNOWN * sigma {
        return Verdict::Undecided;
    }
    let Some(predicted) = predicted else { return Verdict::NoData };
    let ratio = bounds.clamp(predicted) / sigma;
    if ratio < 1.0 / FACTOR {
        Verdict::TooSmall
    } else if ratio > FACTOR {
        Verdict::TooLarge
    } else {
        Verdict::Within
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Batches without noise.
    fn exact(stencil: [f64; 3], h: f64) -> Measured {
        measured([stencil; 2].into_iter(), h).unwrap()
    }

    #[test]
    fn a_parabola_tells_its_relative_curvature() {
        // f = 1 + a x² sampled at -h, 0, h: c = 2a, m = 1 + a h²/2.
        let (a, h) = (0.3_f64, 0.5);
        let found = exact([1.0 + a * h * h, 1.0, 1.0 + a * h * h], h);
        let truth = (2.0 * a / (1.0 + 0.5 * a * h * h)).sqrt() / (2.0 * PI);
        assert!((found.sigma / truth - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_ramp_tells_its_relative_gradient_although_its_curvature_is_zero() {
        let found = exact([0.9, 1.0, 1.1], 0.25);
        assert!((found.sigma / (0.4 / (2.0 * PI)) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_rougher_than_the_upper_bound_and_a_lone_voxel_reaches_it() {
        let bounds = Bounds::of_voxel(0.2);
        for stencil in [[0.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]] {
            let sigma = exact(stencil, 0.2).sigma;
            assert!((sigma / bounds.high - 1.0).abs() < 1e-12, "{stencil:?}");
        }
        assert!(exact([0.3, 1.0, 0.1], 0.2).sigma < bounds.high);
    }

    #[test]
    fn at_the_lower_bound_a_kernel_as_wide_as_a_voxel_errs_by_one_percent() {
        // Relative bias of a kernel of radius r and second moment μ₂: 2π² μ₂ σ² r²; Epanechnikov: ∫ x² (3/4)(1 - x²) = 1/5.
        let h = 0.7;
        let bias = 2.0 * PI * PI * 0.2 * Bounds::of_voxel(h).low.powi(2) * h * h;
        assert!((bias - 0.01).abs() < 1e-12);
    }

    #[test]
    fn a_verdict_turns_at_the_factor_of_two() {
        let bounds = Bounds::of_voxel(0.1);
        let at = |sigma| Measured { sigma, low: sigma, high: sigma };
        assert_eq!(judge(Some(1.01), &at(2.0), &bounds), Verdict::Within);
        assert_eq!(judge(Some(0.99), &at(2.0), &bounds), Verdict::TooSmall);
        assert_eq!(judge(Some(1.99), &at(1.0), &bounds), Verdict::Within);
        assert_eq!(judge(Some(2.01), &at(1.0), &bounds), Verdict::TooLarge);
        assert_eq!(judge(None, &at(1.0), &bounds), Verdict::NoData);
        // Outside the bounds all is one: 1e-9 and 0.3 are both flat to these voxels.
        assert_eq!(judge(Some(1e-9), &at(0.3), &bounds), Verdict::Within);
        let noisy = Measured { sigma: 1.0, low: 0.7, high: 1.3 };
        assert_eq!(judge(Some(1.0), &noisy, &bounds), Verdict::Undecided);
        assert_eq!(judge(Some(1.0), &Measured { sigma: 0.1, low: 0.0, high: 0.5 }, &bounds), Verdict::Within);
    }

    #[test]
    fn the_noise_of_a_mean_is_the_spread_of_its_batches() {
        // c = -0.4, -0.8 of m = 0.9, 0.8 (mean 0.85): mean |c|/m = 0.6/0.85, its standard error 0.2/0.85; g = 0.
        let found = measured([[0.8, 1.0, 0.8], [0.6, 1.0, 0.6]].into_iter(), 1.0).unwrap();
        let sigma = |c: f64| (c / 0.85).sqrt() / (2.0 * PI);
        for (found, truth) in [(found.sigma, 0.6), (found.low, 0.4), (found.high, 0.8)] {
            assert!((found / sigma(truth) - 1.0).abs() < 1e-12);
        }
        assert_eq!(measured([[0.0; 3]; 2].into_iter(), 1.0), None);
    }
}
