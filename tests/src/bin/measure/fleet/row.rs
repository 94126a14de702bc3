//! What is measured of one scene.

use super::Fleet;
use crate::Outcome;
use crate::budget::{Spent, spend};
use covbeam_session::film::Picture;
use covbeam_session::scene::Scene;
use covbeam_tests::fleet::Member;
use covbeam_tests::fleet::agreement::{Agreement, Passes, RUNS, Suspect, examine};
use covbeam_tests::fleet::blocks;
use covbeam_tests::fleet::errors::{Errors, true_over_stated};
use covbeam_tests::fleet::rings::{ENDS, Ratio, ratios, rings};
use covbeam_tests::fleet::runs::{Estimator, mean, narrow};
use cpu_time::ProcessTime;

/// CPU-seconds of all runs of a method for the test of blocks, about, in the last budget; a power of two of passes is chosen, so that it
/// seldom depends on the machine.
const EFFORT: [(Estimator, f64); 3] =
    [(Estimator::Default, 0.4), (Estimator::Reference, 2.0), (Estimator::Light, 0.2)];

/// First seed of the runs at equal time: those of the test of blocks are below.
const SEED: u32 = 10_000;

/// Seeds of the halves of what errors at equal time are held against.
const HALVES: [u32; 2] = [20_000, 20_001];

/// The methods at equal time, the default first.
pub(super) const COMPARED: [Estimator; 3] = [Estimator::Default, Estimator::Plain, Estimator::EveryPixel];

/// When a budget was spent.
pub(super) struct Point {
    /// Of [`COMPARED`], in the first run.
    pub(super) passes: [u32; 3],
    pub(super) seconds: [f64; 3],
    /// Mean of the runs, as it would be at exactly the budget: times the CPU time over it.
    pub(super) rel_mse: [Ratio; 3],
    /// Default over plain, and over every pixel.
    pub(super) ratios: [Ratio; 2],
    /// The same where no pixel counts for more than an error of 100 %.
    pub(super) bounded: [Ratio; 2],
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
    /// At the last budget, of [`COMPARED`] in the first run; then the reference.
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
    fleet: &Fleet,
    report: &dyn Fn(&str, f64),
) -> Outcome<Row> {
    let start = ProcessTime::now();
    let (scene, budgets) = (&member.scene, &fleet.seconds);
    report("blocks", 0.05);
    let [default, reference, light] =
        EFFORT.map(|(estimator, share)| passes(scene, estimator, share * budgets[budgets.len() - 1]));
    let passes = Passes { default, reference, light };
    let Agreement { suspects, light_traced, tested, reference } = examine(scene, passes)?;
    let beside = mean(&reference);
    report("reference", 0.3);
    let narrowed = narrow(scene);
    let mut halves = Vec::new();
    for seed in HALVES {
        let renderer = || Estimator::Reference.renderer(&narrowed, seed);
        halves.extend(spend(&narrowed, renderer, &[fleet.reference])?.into_iter().map(|spent| spent.picture));
    }
    let (a, b, whole) = (&halves[0], &halves[1], mean(&halves));
    // [method][run][budget]
    let mut curves = Vec::new();
    for (index, estimator) in (0_u32..).zip(COMPARED) {
        report("equal time", 0.7 + 0.1 * f64::from(index));
        let run = |run| {
            let seed = SEED + fleet.runs * index + run;
            spend(scene, || estimator.renderer(scene, seed), budgets)
        };
        curves.push((0..fleet.runs).map(run).collect::<Outcome<Vec<_>>>()?);
    }
    let points = budgets.iter().enumerate().map(|(budget, seconds)| {
        let errors: [Errors; 3] = std::array::from_fn(|method| {
            let of_run =
                |run: &Vec<Spent>| (Errors::new(&run[budget].picture, [a, b]), run[budget].seconds / seconds);
            Errors::mean(&curves[method].iter().map(of_run).collect::<Vec<_>>())
        });
        let first = |method: usize| &curves[method][0][budget];
        Point {
            passes: std::array::from_fn(|method| first(method).passes),
            seconds: std::array::from_fn(|method| first(method).seconds),
            rel_mse: errors.each_ref().map(Errors::rel_mse),
            ratios: [1, 2].map(|other| errors[0].over(&errors[other])),
            bounded: [1, 2].map(|other| errors[0].bounded_over(&errors[other])),
        }
    });
    let light = |picture: &Picture| blocks::means(picture).iter().sum::<f64>();
    Ok(Row {
        number,
        passes,
        blocks: blocks::means(&beside).len() + ENDS.len(),
        light_traced,
        suspects,
        failures: Vec::new(),
        rings: ratios(&rings(&beside), &tested, &reference),
        total: light(&mean(&tested)) / light(&beside),
        calibration: curves[0][0].last().and_then(|spent| true_over_stated(&spent.picture, [a, b])),
        points: points.collect(),
        noise: covbeam_render::study::compare::compare(a, b, |_, _| true)?.rel_mse / 2.0,
        cpu_seconds: start.elapsed().as_secs_f64(),
        pictures: curves
            .into_iter()
            .filter_map(|runs| runs.into_iter().next()?.into_iter().next_back())
            .map(|spent| spent.picture)
            .chain([whole])
            .collect(),
    })
}
