//! What is measured of one scene.

use crate::Outcome;
use crate::budget::spend;
use covbeam_render::film::Picture;
use covbeam_render::scene::Scene;
use covbeam_tests::fleet::Member;
use covbeam_tests::fleet::agreement::{Agreement, Passes, RUNS, Suspect, examine};
use covbeam_tests::fleet::blocks;
use covbeam_tests::fleet::errors::{Errors, true_over_stated};
use covbeam_tests::fleet::rings::{ENDS, Ratio, ratios, rings};
use covbeam_tests::fleet::runs::{Estimator, mean, narrow};
use cpu_time::ProcessTime;

/// CPU-seconds of all runs of a method for the test of blocks, about, in the last budget; a power of two of passes is chosen, so that it
/// seldom depends on the machine. Either half of the reference costs what a method does at equal time: what they leave is in the standard
/// errors.
const EFFORT: [(Estimator, f64); 3] =
    [(Estimator::Default, 0.4), (Estimator::Reference, 2.0), (Estimator::Light, 0.2)];

/// First seed of the runs at equal time: those of the test of blocks are below.
const SEED: u32 = 10_000;

/// The methods at equal time, the default first.
pub(super) const COMPARED: [Estimator; 3] = [Estimator::Default, Estimator::Plain, Estimator::EveryPixel];

/// When a budget was spent.
pub(super) struct Point {
    /// Of [`COMPARED`].
    pub(super) passes: [u32; 3],
    pub(super) seconds: [f64; 3],
    pub(super) rel_mse: [Ratio; 3],
    /// Default over plain, and over every pixel.
    pub(super) ratios: [Ratio; 2],
}

pub(super) struct Row {
    pub(super) number: u32,
    /// Of the runs for the test of blocks.
    pub(super) passes: Passes,
    /// Blocks and rings.
    pub(super) blocks: usize,
    pub(super) light_traced: bool,
    pub(super) suspects: Vec<Suspect>,
    /// Those of the suspects that fail, known when all scenes are.
    pub(super) failures: Vec<Suspect>,
    pub(super) rings: [Option<Ratio>; 6],
    /// Total light, default over reference.
    pub(super) total: f64,
    pub(super) points: Vec<Point>,
    /// True error over the stated one of the default at the last budget.
    pub(super) calibration: Option<f64>,
    /// relMSE of half of the reference.
    pub(super) noise: f64,
    pub(super) cpu_seconds: f64,
    /// At the last budget, of [`COMPARED`]; then the reference.
    pub(super) pictures: Vec<Picture>,
}

/// Passes of one of the runs, from the time of one pass.
fn passes(scene: &Scene, estimator: Estimator, effort: f64) -> u32 {
    let narrowed = narrow(scene);
    let scene = if estimator == Estimator::Reference { &narrowed } else { scene };
    let mut renderer = estimator.renderer(scene, 1);
    let start = ProcessTime::now();
    // The first pass is not typical: the grid is empty.
    for pass in 1..=2 {
        renderer.pass(pass, &|| false).expect("never cancelled");
    }
    let a_pass = (start.elapsed().as_secs_f64() / 2.0).max(0.005);
    let exponent = (effort / (f64::from(RUNS) * a_pass)).log2().round();
    2_f64.powf(exponent.clamp(1.0, 6.0)) as u32
}

pub(super) fn measure(
    number: u32,
    member: &Member,
    budgets: &[f64],
    report: &dyn Fn(&str, f64),
) -> Outcome<Row> {
    let start = ProcessTime::now();
    let scene = &member.scene;
    report("blocks", 0.05);
    let [default, reference, light] =
        EFFORT.map(|(estimator, share)| passes(scene, estimator, share * budgets[budgets.len() - 1]));
    let passes = Passes { default, reference, light };
    let Agreement { suspects, light_traced, tested, reference } = examine(scene, passes)?;
    let halves = reference.split_at(RUNS as usize / 2);
    let (a, b, whole) = (mean(halves.0), mean(halves.1), mean(&reference));
    let mut curves = Vec::new();
    for (index, estimator) in (0_u32..).zip(COMPARED) {
        report("equal time", 0.5 + 0.16 * f64::from(index));
        let seed = SEED + index;
        curves.push(spend(scene, || estimator.renderer(scene, seed), budgets)?);
    }
    let points = (0..budgets.len()).map(|budget| {
        let spent = |index: usize| &curves[index][budget];
        let errors: [Errors; 3] = std::array::from_fn(|index| Errors::new(&spent(index).picture, [&a, &b]));
        Point {
            passes: std::array::from_fn(|index| spent(index).passes),
            seconds: std::array::from_fn(|index| spent(index).seconds),
            rel_mse: errors.each_ref().map(Errors::rel_mse),
            ratios: [errors[0].over(&errors[1]), errors[0].over(&errors[2])],
        }
    });
    let light = |picture: &Picture| blocks::means(picture).iter().sum::<f64>();
    Ok(Row {
        number,
        passes,
        blocks: blocks::means(&whole).len() + ENDS.len(),
        light_traced,
        suspects,
        failures: Vec::new(),
        rings: ratios(&rings(&whole), &tested, &reference),
        total: light(&mean(&tested)) / light(&whole),
        calibration: curves[0].last().and_then(|spent| true_over_stated(&spent.picture, [&a, &b])),
        points: points.collect(),
        noise: covbeam_render::compare::compare(&a, &b, |_, _| true)?.rel_mse / 2.0,
        cpu_seconds: start.elapsed().as_secs_f64(),
        pictures: curves
            .into_iter()
            .filter_map(|curve| curve.into_iter().next_back())
            .map(|spent| spent.picture)
            .chain([whole])
            .collect(),
    })
}
