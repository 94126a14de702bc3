//! What is measured of one scene.

use crate::Outcome;
use crate::budget::spend;
use crate::rendering::cpu_seconds;
use covbeam_render::film::Picture;
use covbeam_tests::fleet::Member;
use covbeam_tests::fleet::blocks::{self, SUSPECT, Verdict};
use covbeam_tests::fleet::errors::Errors;
use covbeam_tests::fleet::rings::{Ratio, ratios, rings};
use covbeam_tests::fleet::runs::{Estimator, light_tracing_sees_all, mean, narrow, pictures};

/// Independent runs of each method, for each of the two steps of the test of blocks.
const RUNS: u32 = 8;

/// Passes of a run. The reference is the noisier and cheaper a pass.
const PASSES: [(Estimator, u32); 3] =
    [(Estimator::Default, 8), (Estimator::Reference, 48), (Estimator::Light, 3)];

/// Seeds of a method and step never meet those of another.
const SEEDS: [(Estimator, u32); 5] = [
    (Estimator::Default, 1_000),
    (Estimator::Reference, 2_000),
    (Estimator::Light, 3_000),
    (Estimator::Plain, 4_000),
    (Estimator::EveryPixel, 5_000),
];

/// The methods at equal time, the default first.
pub(super) const COMPARED: [Estimator; 3] = [Estimator::Default, Estimator::Plain, Estimator::EveryPixel];

/// A block that the first runs made suspect.
#[derive(Clone, Copy)]
pub(super) struct Suspect {
    pub(super) block: usize,
    pub(super) against: Estimator,
    /// From fresh runs.
    pub(super) judged: Verdict,
}

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
    pub(super) blocks: usize,
    pub(super) light_traced: bool,
    pub(super) suspects: Vec<Suspect>,
    /// Those of the suspects that fail, known when all scenes are.
    pub(super) failures: Vec<Suspect>,
    pub(super) rings: [Option<Ratio>; 6],
    /// Total light, default over reference.
    pub(super) total: f64,
    pub(super) points: Vec<Point>,
    /// relMSE of half of the reference.
    pub(super) noise: f64,
    pub(super) cpu_seconds: f64,
    /// At the last budget, of [`COMPARED`]; then the reference.
    pub(super) pictures: Vec<Picture>,
}

fn of<T: Copy>(estimator: Estimator, table: &[(Estimator, T)]) -> T {
    table.iter().find(|(of, _)| *of == estimator).expect("every method that is run is in the table").1
}

pub(super) fn measure(
    number: u32,
    member: &Member,
    budgets: &[f64],
    report: &dyn Fn(&str, f64),
) -> Outcome<Row> {
    let start = cpu_seconds()?;
    let scene = &member.scene;
    // Step 0 suspects, step 1 judges.
    let runs = |estimator: Estimator, step: u32| {
        let first = of(estimator, &SEEDS) + step * RUNS;
        pictures(scene, estimator, first..first + RUNS, of(estimator, &PASSES))
    };
    report("reference", 0.0);
    let reference = runs(Estimator::Reference, 0)?;
    report("default", 0.3);
    let tested = runs(Estimator::Default, 0)?;
    let light_traced = light_tracing_sees_all(scene);
    let mut suspects = Vec::new();
    let mut fresh = None;
    for against in [Estimator::Reference, Estimator::Light] {
        if against == Estimator::Light && !light_traced {
            continue;
        }
        report("blocks", 0.4);
        let first = match against {
            Estimator::Reference => blocks::compare(&tested, &reference),
            _ => blocks::compare(&tested, &runs(against, 0)?),
        };
        let suspected = |verdict: &Verdict| verdict.p < SUSPECT;
        if first.iter().any(suspected) {
            let tested = match &fresh {
                Some(pictures) => pictures,
                None => fresh.insert(runs(Estimator::Default, 1)?),
            };
            let second = blocks::compare(tested, &runs(against, 1)?);
            let judged = first.iter().zip(second).enumerate().filter(|(_, (first, _))| suspected(first));
            suspects.extend(judged.map(|(block, (_, judged))| Suspect { block, against, judged }));
        }
    }
    let halves = reference.split_at(RUNS as usize / 2);
    let (a, b, whole) = (mean(halves.0), mean(halves.1), mean(&reference));
    let mut curves = Vec::new();
    for (index, estimator) in (0_u32..).zip(COMPARED) {
        report("equal time", 0.5 + 0.16 * f64::from(index));
        // The first seeds belong to the test of blocks.
        let seed = of(estimator, &SEEDS) + 2 * RUNS;
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
        blocks: blocks::means(&whole).len(),
        light_traced,
        suspects,
        failures: Vec::new(),
        rings: ratios(&rings(&whole), &tested, &reference),
        total: light(&mean(&tested)) / light(&whole),
        points: points.collect(),
        noise: covbeam_render::compare::compare(&a, &b, |_, _| true)?.rel_mse / 2.0,
        cpu_seconds: cpu_seconds()? - start,
        pictures: curves
            .into_iter()
            .filter_map(|curve| curve.into_iter().next_back())
            .map(|spent| spent.picture)
            .chain([whole])
            .collect(),
    })
}
