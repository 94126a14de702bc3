//! The truth test: the spectra that the covariance grid predicts, voxel by voxel, against the light that is there.
//!
//! Along each world axis, in every voxel of a scene's grid:
//! - *Predicted*: the standard deviation of the fluence's spectrum in the covariance grid as a render would use it, seen
//!   through the same three voxels as the measurement: the flux-weighted mean with weights 1, 2, 1, as the render's look-ups
//!   between voxels are flux-weighted means. The voxel alone is judged too, in a row of its own.
//! - *Measured*: what differences of a fluence tell that many other light paths measured: with the fluences f₋, f₀, f₊
//!   of a voxel and its two neighbours and h its size, c = (f₋ - 2f₀ + f₊)/h², g = (f₊ - f₋)/(2h),
//!   m = (f₋ + 2f₀ + f₊)/4, σ² = max(|c|/m, (g/m)²)/(4π²). See [`measured`].
//! - Both are kept within what a voxel can say, see [`Bounds`], and then compared, see [`Verdict`].
//!
//! Source: the definition of the spectrum's covariance by curvature, thesis Eq 5.12; the test itself is ours.

mod gaussians;
mod judge;
mod lines;
mod measure;
mod places;
mod predict;
mod slices;
mod surroundings;
mod table;
mod walk;

pub use gaussians::{Point, draw_gaussians};
pub use judge::{Bounds, FACTOR, Measured, Verdict, judge, measured};
pub use lines::{Line, draw_lines};
pub use measure::{BATCHES, Fluence, Origin};
pub use places::{default_lines, default_points, focus};
pub use predict::{Prediction, predict, predict_without};
pub use slices::draw_slice;
pub use table::{Shares, summary, write_table};

use covbeam::{FluenceCell, FluenceGrid, FluenceSpectrum, GridLayout};
use covbeam_session::pass::field_passes;
use covbeam_session::scene::Scene;
use glam::{DVec3, Vec3};
use judge::LARGEST_CUT;
use surroundings::Surroundings;
use walk::{center_of, index_of, voxel_of, voxel_size};

/// The test looks at the brightest voxels that together hold this share of the energy.
pub const ENERGY: f64 = 0.99;

/// World axes.
const AXES: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::Z];

/// How the test is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Voxels along x, y, z in the box of the scene's grid.
    pub cells: [u32; 3],
    /// What is predicted from.
    pub prediction: Prediction,
    /// Light paths of the measurement, a multiple of [`BATCHES`].
    pub paths: u32,
}

/// Predicted and measured along one axis of a voxel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Standard deviation \[cycles / scene unit\] over the three voxels of the measurement's differences, with the weights 1, 2, 1
    /// times their fluence, as the measurement's mean m is; of the voxel alone where nothing is measured. None = no light
    /// field came by.
    pub predicted: Option<f64>,
    /// None at the border of the grid, at surfaces and in the dark.
    pub measured: Option<Measured>,
    /// With both bounds.
    pub verdict: Verdict,
    /// With the upper bound only: the measurement must stand out of its own noise.
    pub strict: Verdict,
    /// With both bounds, and the prediction of the voxel alone.
    pub at_center: Verdict,
    /// Whether neither predicted nor measured is above the lower bound, so that they agree however wrong they may be.
    pub flat: bool,
}

/// All that is known about a voxel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Voxel {
    /// Its place in the grid.
    pub cell: [u32; 3],
    /// Its centre.
    pub center: DVec3,
    /// Whether it is among the brightest that hold 99 % of the energy.
    pub bright: bool,
    /// Fluence of the part that is medium \[W/m²\], mean over the channels.
    pub fluence: f64,
    /// Standard error of the fluence over the fluence.
    pub noise: f64,
    /// Share of the energy of the grid.
    pub energy: f64,
    /// Share of the voxel that is medium.
    pub medium: f32,
    /// Shares of the [`Origin`]s of its light.
    pub origins: [f32; 3],
    /// Predicted spectrum; None = no light field came by.
    pub spectrum: Option<FluenceSpectrum>,
    /// Along x, y, z.
    pub axes: [Axis; 3],
}

impl Voxel {
    /// Where most of its light comes from.
    pub fn origin(&self) -> Origin {
        let brightest = (0..3).max_by(|a, b| self.origins[*a].total_cmp(&self.origins[*b]));
        Origin::ALL[brightest.expect("three origins")]
    }
}

/// The result of the test.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// The grid.
    pub layout: GridLayout,
    /// How it was made.
    pub options: Options,
    /// One entry a voxel, x fastest.
    pub voxels: Vec<Voxel>,
}

/// Runs the test. `report` is called now and then with the share of the work done, 0..=1; it answers false to give up,
/// and then None is returned.
///
/// Guarantee: the same bits for any number of threads; work runs on rayon's current pool.
///
/// # Panics
/// Unless `options.cells` makes a sound grid of the scene's box and there are passes and light paths.
pub fn analyse(scene: &Scene, options: &Options, report: &(dyn Fn(f64) -> bool + Sync)) -> Option<Analysis> {
    /// A light path with a light field and its probes takes about as long as this many without.
    const FIELD_COST: f64 = 12.0;
    let layout = GridLayout { cells: options.cells, ..scene.grid };
    let prediction = &options.prediction;
    let field_work =
        FIELD_COST * f64::from(field_passes(prediction.passes)) * f64::from(prediction.field_paths);
    let all_work = field_work + f64::from(options.paths);
    let done = std::sync::Mutex::new(0.0);
    let work = |amount: f64| {
        let mut done = done.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        *done += amount;
        report(f64::min(*done / all_work, 1.0))
    };
    let resolved = predict(scene, &layout, prediction, &|paths| work(FIELD_COST * f64::from(paths)))?;
    let fluence =
        Fluence::measure(scene, &layout, options.paths, prediction.seed, &|paths| work(f64::from(paths)))?;
    Some(Analysis { layout, options: *options, voxels: compare(scene, &layout, &resolved, &fluence) })
}

/// Compares predicted spectra with a measured fluence, voxel by voxel.
///
/// - `layout`: of the grid that both lie in.
/// - `resolved`: from [`predict`]; as many cells as the grid has.
/// - `fluence`: of all voxels, from [`Fluence::measure`] or a closed form.
///
/// # Panics
/// If there are more or fewer cells than the grid has.
pub fn compare(
    scene: &Scene,
    layout: &GridLayout,
    resolved: &[FluenceCell],
    fluence: &Fluence,
) -> Vec<Voxel> {
    let grid = FluenceGrid::new(*layout, resolved).expect("as many cells as the grid has");
    let means: Vec<f64> = (0..layout.cell_count()).map(|voxel| fluence.mean(voxel)).collect();
    let total: f64 = means.iter().sum();
    let bright = brightest(&means, ENERGY * total);
    let surroundings = Surroundings::of(scene, layout);
    let spectrum_at = |index: usize| {
        let center = center_of(layout, voxel_of(layout, index));
        grid.look_up(center.as_vec3()).filter(|_| resolved[index].weight > 0.0)
    };
    let spectra: Vec<Option<FluenceSpectrum>> = (0..layout.cell_count()).map(spectrum_at).collect();
    let known = Known { layout, spectra: &spectra, means: &means, fluence, surroundings: &surroundings };
    (0..layout.cell_count())
        .map(|index| {
            let medium = surroundings.medium[index];
            let batches = fluence.batches.iter().map(|batch| f64::from(batch[index]));
            let (mean, error) = measure::mean_and_error(batches);
            let cell = voxel_of(layout, index);
            Voxel {
                cell,
                center: center_of(layout, cell),
                bright: bright[index],
                fluence: if medium > 0.0 { mean / f64::from(medium) } else { 0.0 },
                noise: if mean > 0.0 { error / mean } else { 0.0 },
                energy: mean / total.max(f64::MIN_POSITIVE),
                medium,
                origins: fluence.shares[index],
                spectrum: spectra[index],
                axes: std::array::from_fn(|axis| known.compare_axis(index, axis)),
            }
        })
        .collect()
}

/// Marks the largest values, as few as add up to `sum`.
fn brightest(values: &[f64], sum: f64) -> Vec<bool> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
    let mut bright = vec![false; values.len()];
    let mut reached = 0.0;
    for index in order {
        if reached >= sum {
            break;
        }
        reached += values[index];
        bright[index] = true;
    }
    bright
}

/// What the comparison of one axis needs.
struct Known<'a> {
    layout: &'a GridLayout,
    spectra: &'a [Option<FluenceSpectrum>],
    means: &'a [f64],
    fluence: &'a Fluence,
    surroundings: &'a Surroundings,
}

impl Known<'_> {
    fn compare_axis(&self, index: usize, axis: usize) -> Axis {
        let Self { layout, spectra, means, fluence, surroundings } = *self;
        let variance = |voxel: usize| {
            spectra[voxel].map(|spectrum| f64::from(spectrum.variance_along(AXES[axis]).max(0.0)))
        };
        let at_center = variance(index).map(f64::sqrt);
        let left_out = |verdict| Axis {
            predicted: at_center,
            measured: None,
            verdict,
            strict: verdict,
            at_center: verdict,
            flat: false,
        };
        let cell = voxel_of(layout, index);
        if cell[axis] == 0 || cell[axis] + 1 == layout.cells[axis] {
            return left_out(Verdict::Border);
        }
        let mut unit = [0; 3];
        unit[axis] = 1;
        let stride = index_of(layout, unit);
        let stencil = [index - stride, index, index + stride];
        let filled = |voxel: usize| f64::from(surroundings.medium[voxel]) >= 1.0 - LARGEST_CUT;
        if !stencil.iter().all(|voxel| filled(*voxel)) || surroundings.cut(&stencil, axis) > LARGEST_CUT {
            return left_out(Verdict::Surface);
        }
        let in_medium = |batch: &Vec<f32>, voxel: usize| f64::from(batch[voxel] / surroundings.medium[voxel]);
        let stencils = fluence.batches.iter().map(|batch| stencil.map(|voxel| in_medium(batch, voxel)));
        let h = voxel_size(layout)[axis];
        let Some(measured) = judge::measured(stencils, h) else { return left_out(Verdict::Undecided) };

        let (mut sum, mut total) = (0.0, 0.0);
        for (voxel, times) in stencil.into_iter().zip([1.0, 2.0, 1.0]) {
            if let Some(variance) = variance(voxel) {
                sum += times * means[voxel] * variance;
                total += times * means[voxel];
            }
        }
        let predicted = (total > 0.0).then(|| (sum / total).sqrt());
        let bounds = Bounds::of_voxel(h);
        let strict_bounds = Bounds { low: 0.0, ..bounds };
        Axis {
            predicted,
            measured: Some(measured),
            verdict: judge(predicted, &measured, &bounds),
            strict: judge(predicted, &measured, &strict_bounds),
            at_center: judge(at_center, &measured, &bounds),
            flat: predicted.is_some_and(|sigma| sigma <= bounds.low) && measured.sigma <= bounds.low,
        }
    }
}
