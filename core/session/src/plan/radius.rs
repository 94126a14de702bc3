//! What kernel radii are taken from: the thesis' bound on the bias, and its rivals, which count beams. The
//! rivals are no better in most scenes, and worse in a caustic.
//!
//! **Least error.** A radius r costs a relative bias of a r² σ², a = 2π² μ₂ (as [`KernelShape::radius_from_error`] has it), and a relative
//! variance. Beams of density ν (length per volume) at an angle θ cross a strip of length l along an eye ray and width w in ν l w sin θ places;
//! each adds K_r(d)/sin θ. So over one pass the variance is R/(m r), with R = ∫K_1² and m = ν l/⟨1/sin θ⟩ = (2/π) ν l beams a
//! metre where light comes from everywhere. The least sum of squared bias and variance is at r⁵ = R/(4 a² σ⁴ m).
//! - l is how much of the eye ray sees the light whose curvature σ is: for a Gaussian profile (∫g)²/∫g² = 2√π/(2πσ).
//! - Unequal powers w count as ν = (Σw)²/Σw² beams.
//! - Radii that fall as i^(-1/5) cost the mean over passes 5/3 of the last one's bias and 5/6 of its variance: r⁵ by 3/10.
//! - Low-discrepancy emission lowers the variance of light scattered once: r⁵ by 1/8.
//!
//! **Beam density.** A ball of radius r is crossed by π r² ν beams: r is such that there are always as many, but for i^(-1/5).

use crate::paths::record::PathBeam;
use crate::scene::media;
use covbeam::{FluenceCell, FluenceSpectrum, GridLayout, KernelShape, Medium};
use glam::Vec3;
use std::f64::consts::PI;

/// What the adaptive method takes the radii of its kernels from. All stay between the scene's radius, which falls with the passes, and its
/// largest one; all narrow them beside the dark ([`covbeam::Kernel::radius_at`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RadiusRule {
    /// A bound on the relative bias, from spectra (thesis 5.3.4). Plain kernels where no light field has been.
    #[default]
    Bias,
    /// The least sum of squared bias and variance, from spectra and beams, with nothing to choose;
    /// [`RadiusRule::BeamDensity`] where no light field has been.
    LeastError,
    /// As many beams in each ball, from the beams alone. Traces no light fields, unless to plan eye rays.
    BeamDensity,
}

/// Beams of a pass that cross the ball of [`RadiusRule::BeamDensity`]: chosen by error, 8 before 4 on three scenes; 16 is no better on one.
pub const CROWD: f64 = 8.0;

/// What radii that fall as i^(-1/5) save, in r⁵: (5/6)/(5/3)².
const SCHEDULE: f64 = 0.3;

/// Variance of light scattered once, drawn from the low-discrepancy sequence, over that of independent paths (`measure emission`).
const EMISSION: f64 = 1.0 / 8.0;

/// Least weight of a voxel that a beam crosses.
const DIMMEST: f64 = 1e-30;

/// The radius \[m\] with the least sum of squared relative bias and relative variance: (R/(4 a² σ⁴ m))^(1/5).
///
/// - `variance` σ² of the spectrum along the kernel's axis \[cycles²/m²\] > 0.
/// - `beams` m: independent ones, of equal power, a metre along that axis > 0.
///
/// Source: derived, see the module; the classical optimum of a density estimate (E. Parzen 1962) with a curvature of 4π²σ².
pub fn least_error_radius(kernel: KernelShape, variance: f64, beams: f64) -> f64 {
    let bias = bias_factor(kernel);
    libm::pow(roughness(kernel) / (4.0 * bias * bias * variance * variance * beams), 0.2)
}

/// Independent beams a metre, of light from everywhere, that a kernel sees along a stretch of an eye ray: (2/π) ν l.
///
/// - `density` ν: length of beams per volume \[1/m²\]; `length` l \[m\].
pub fn beams_a_metre(density: f64, length: f64) -> f64 {
    2.0 / PI * density * length
}

/// The radius \[m\] of a ball that [`CROWD`] beams cross, of a density \[1/m²\].
pub fn crowd_radius(density: f64) -> f64 {
    (CROWD / (PI * density)).sqrt()
}

/// a: a r² σ² is a kernel's relative bias.
fn bias_factor(kernel: KernelShape) -> f64 {
    2.0 * PI * PI * f64::from(kernel.second_moment())
}

/// R = ∫K_1².
fn roughness(kernel: KernelShape) -> f64 {
    match kernel {
        KernelShape::Box => 1.0 / 2.0,
        KernelShape::Epanechnikov => 3.0 / 5.0,
        KernelShape::Biweight => 5.0 / 7.0,
    }
}

/// The beams in one voxel.
#[derive(Clone, Copy, Debug, Default)]
struct Voxel {
    /// Σ power x length.
    weight: f64,
    /// Σ power² x length.
    square: f64,
}

/// How many beams of the passes so far there are where.
#[derive(Debug)]
pub struct BeamVoxels {
    layout: GridLayout,
    passes: u32,
    voxels: Vec<Voxel>,
}

impl BeamVoxels {
    /// Without beams.
    pub fn new(layout: GridLayout) -> Self {
        Self { layout, passes: 0, voxels: vec![Voxel::default(); layout.cell_count()] }
    }

    /// Number of passes added.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// Forgets all passes.
    pub fn clear(&mut self) {
        self.passes = 0;
        self.voxels.fill(Voxel::default());
    }

    /// Adds the beams of one pass. Same bits for the same beams in the same order.
    ///
    /// A beam is cut into pieces no longer than a voxel's shortest side, each of which counts where its middle is. Cost: 0.2 µs a beam.
    pub fn add(&mut self, beams: &[PathBeam], fogs: &[Medium]) {
        let (size, cells) =
            (self.layout.max - self.layout.min, Vec3::from(self.layout.cells.map(|n| n as f32)));
        let (scale, stride) = (cells / size, (size / cells).min_element());
        let row = self.layout.cells[0] as usize;
        let plane = row * self.layout.cells[1] as usize;
        let mut knots = Vec::new();
        for PathBeam { medium, beam, .. } in beams {
            let planes =
                [self.layout.min, self.layout.max].map(|corner| (corner - beam.origin) / beam.direction);
            let from = planes[0].min(planes[1]).max_element().max(0.0);
            let to = planes[0].max(planes[1]).min_element().min(beam.length);
            if !(from < to) {
                continue;
            }
            let fog = &fogs[*medium as usize];
            let column = media::column(fog, beam.origin, beam.direction, beam.length, &mut knots);
            let pieces = ((to - from) / stride).ceil();
            let step = (to - from) / pieces;
            for piece in 0..pieces as u32 {
                let at = from + (piece as f32 + 0.5) * step;
                let place = (beam.origin + at * beam.direction - self.layout.min) * scale;
                let [x, y, z] = place.clamp(Vec3::ZERO, cells - 1.0).to_array().map(|place| place as usize);
                let weight = f64::from(beam.power.dot(fog.transmittance(column.at(at))) / 3.0);
                let voxel = &mut self.voxels[z * plane + y * row + x];
                voxel.weight += weight * f64::from(step);
                voxel.square += weight * weight * f64::from(step);
            }
        }
        self.passes += 1;
    }

    /// Of each voxel, in the layout's order: the sums of power x length and of power² x length of its beams.
    pub(crate) fn sums(&self) -> Vec<[f64; 2]> {
        self.voxels.iter().map(|voxel| [voxel.weight, voxel.square]).collect()
    }

    /// Density of a pass' beams in each voxel \[1/m²\], in the layout's order: of as many equally bright ones as would be as noisy.
    pub fn densities(&self) -> impl Iterator<Item = f64> {
        let size = (self.layout.max - self.layout.min).as_dvec3();
        let volume = size.element_product() / self.voxels.len() as f64 * f64::from(self.passes);
        let equal = |voxel: &Voxel| voxel.weight * voxel.weight / voxel.square;
        self.voxels.iter().map(move |voxel| if voxel.square > 0.0 { equal(voxel) / volume } else { 0.0 })
    }
}

/// The radii of a rule other than [`RadiusRule::Bias`].
///
/// A kernel's radius is looked up as a spectrum; so these are the spectra for which the bound on the bias gives the rule's radius.
#[derive(Debug)]
pub(crate) struct Radii {
    pub(crate) rule: RadiusRule,
    pub(crate) beams: BeamVoxels,
    pub(crate) cells: Vec<FluenceCell>,
}

impl Radii {
    pub(crate) fn new(rule: RadiusRule, layout: GridLayout) -> Self {
        Self {
            rule,
            beams: BeamVoxels::new(layout),
            cells: vec![FluenceCell::default(); layout.cell_count()],
        }
    }

    /// Finds `cells`. `error`: the bound of pass 1; that of later ones falls so that these radii fall as i^(-1/5).
    pub(crate) fn resolve(&mut self, spectra: &[FluenceCell], kernel: KernelShape, error: f32) {
        // The variance for which the bound gives a radius.
        let bound = f64::from(error) / bias_factor(kernel);
        let variance = |radius: f64| bound / (radius * radius);
        let brightest = self.beams.voxels.iter().fold(0.0, |most: f64, voxel| most.max(voxel.weight));
        let voxels = self.beams.voxels.iter().zip(self.beams.densities());
        for ((cell, found), (voxel, density)) in self.cells.iter_mut().zip(spectra).zip(voxels) {
            if !(density > 0.0) {
                *cell = FluenceCell::default();
                continue;
            }
            let has_spectrum = found.weight > 0.0;
            let spectrum = match self.rule {
                RadiusRule::LeastError if has_spectrum => {
                    // At σ = 1; l falls as 1/σ, so r² does as σ^(-6/5).
                    let beams = beams_a_metre(density, 1.0 / PI.sqrt()) / (SCHEDULE * EMISSION);
                    power(&found.spectrum, 0.6, variance(least_error_radius(kernel, 1.0, beams)))
                }
                _ => {
                    let variance = variance(crowd_radius(density)) as f32;
                    FluenceSpectrum::from_array([variance, variance, variance, 0.0, 0.0, 0.0])
                }
            };
            *cell = FluenceCell { spectrum, weight: (voxel.weight / brightest).max(DIMMEST) as f32 };
        }
    }
}

/// `factor` Σ^`exponent`, by Jacobi's rotations.
fn power(spectrum: &FluenceSpectrum, exponent: f64, factor: f64) -> FluenceSpectrum {
    let [xx, yy, zz, xy, xz, yz] = spectrum.to_array().map(f64::from);
    let mut a = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // The off-diagonal falls quadratically: four rounds leave nothing of it in f32.
    for (i, j) in [(0, 1), (0, 2), (1, 2)].into_iter().cycle().take(12) {
        if a[i][j] == 0.0 {
            continue;
        }
        let half_cotangent: f64 = (a[j][j] - a[i][i]) / (2.0 * a[i][j]);
        let tangent =
            1.0_f64.copysign(half_cotangent) / (half_cotangent.abs() + libm::hypot(half_cotangent, 1.0));
        let cosine = 1.0 / libm::hypot(tangent, 1.0);
        let turn = |[p, q]: [f64; 2]| [cosine * (p - tangent * q), cosine * (q + tangent * p)];
        for rows in [&mut a, &mut axes] {
            rows.iter_mut().for_each(|row| [row[i], row[j]] = turn([row[i], row[j]]));
        }
        for (column, (p, q)) in a[i].into_iter().zip(a[j]).enumerate() {
            [a[i][column], a[j][column]] = turn([p, q]);
        }
    }
    let scaled = [0, 1, 2].map(|k: usize| factor * libm::pow(a[k][k].max(0.0), exponent));
    let at = |i: usize, j: usize| (0..3).map(|k| axes[i][k] * axes[j][k] * scaled[k]).sum::<f64>() as f32;
    FluenceSpectrum::from_array([at(0, 0), at(1, 1), at(2, 2), at(0, 1), at(0, 2), at(1, 2)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_of_a_spectrum_keeps_its_axes() {
        // Eigenvalues 64, 8 and 0 along unequal axes.
        let axes =
            [Vec3::new(2.0, 3.0, 6.0), Vec3::new(3.0, -6.0, 2.0), Vec3::new(6.0, 2.0, -3.0)].map(|a| a / 7.0);
        let mut spectrum = FluenceSpectrum::default();
        spectrum.add_along(axes[0], 64.0);
        spectrum.add_along(axes[1], 8.0);
        let root = power(&spectrum, 2.0 / 3.0, 0.5);
        for (axis, expected) in axes.into_iter().zip([8.0, 2.0, 0.0]) {
            // f32 entries of up to 64, whose roundings a power below 1 enlarges where the value is 0: (4e-6)^(2/3).
            assert!(
                (root.variance_along(axis) - expected).abs() < 3e-4,
                "{axis}: {}",
                root.variance_along(axis)
            );
        }
        assert_eq!(power(&FluenceSpectrum::default(), 0.6, 1.0), FluenceSpectrum::default());
    }

    #[test]
    fn three_tenths_is_what_a_schedule_of_falling_radii_wants() {
        // Bias b r² and variance v/r with an optimum at r = 1 after N passes of that radius: 4 b² = v/N.
        let passes = 20_000;
        let [mut bias, mut variance] = [0.0, 0.0];
        let fall = |i: u32| (f64::from(i) / f64::from(passes)).powf(-0.2);
        for i in 1..=passes {
            bias += fall(i) * fall(i) / f64::from(passes);
            variance += 1.0 / fall(i) / f64::from(passes);
        }
        let error = |last: f64| (bias * last * last).powi(2) + 4.0 * variance / last;
        let best = SCHEDULE.powf(0.2);
        // A parabola's worth around the least error, and the sums' difference from their integrals, N^(-3/5).
        assert!(error(best) < error(0.97 * best) && error(best) < error(1.03 * best));
    }
}
