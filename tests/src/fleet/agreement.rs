//! The default method held against others on one scene, block by block and ring by ring: see [`super::blocks`].

use super::blocks::{SUSPECT, Verdict, compare};
use super::rings::rings;
use super::runs::{Estimator, light_tracing_sees_all, mean, pictures};
use crate::statistics::sidak;
use covbeam_session::film::{FilmError, Picture};
use covbeam_session::scene::Scene;

/// Independent runs of each method, for each of the two steps.
pub const RUNS: u32 = 8;

/// Chance that a fleet of sound pictures has a failing block.
const FAMILY_WISE: f64 = 0.01;

/// Passes of each run.
#[derive(Clone, Copy, Debug)]
pub struct Passes {
    /// Of the default, and of plain beams at its radius.
    pub default: u32,
    /// Of narrow plain beams.
    pub reference: u32,
    /// Of light tracing.
    pub light: u32,
}

/// A block or ring that the first runs made suspect.
#[derive(Clone, Copy, Debug)]
pub struct Suspect {
    /// Blocks row by row, and then the rings.
    pub region: usize,
    /// [`Estimator::Reference`] or [`Estimator::Light`].
    pub against: Estimator,
    /// Of the default's fresh runs.
    pub judged: Verdict,
    /// Of the same against runs of plain beams with the default's passes and radius: what both do alike is the radius' blur, and falls with
    /// the passes.
    pub plain: Verdict,
}

impl Suspect {
    /// Whether the default is wrong there, and not only as blurred as plain beams are: it differs from both, at the same level. Hundreds
    /// of blurred blocks are judged in a fleet; with a level of 5 % for plain beams, one in twenty of these would fail by chance.
    ///
    /// - `level`: see [`level`].
    pub fn fails(&self, level: f64) -> bool {
        self.judged.p < level && self.plain.p < level
    }
}

/// What was found.
pub struct Agreement {
    /// Blocks and rings to judge, once those of all scenes are known.
    pub suspects: Vec<Suspect>,
    /// Whether light tracing could be asked.
    pub light_traced: bool,
    /// The default's first runs.
    pub tested: Vec<Picture>,
    /// The reference's first runs.
    pub reference: Vec<Picture>,
}

/// Holds the default against narrow plain beams, and against light tracing where that sees all.
///
/// # Errors
/// A pass that is not finite.
pub fn examine(scene: &Scene, passes: Passes) -> Result<Agreement, FilmError> {
    // Step 0 suspects, step 1 judges; seeds of a method and step never meet those of another.
    let runs = |estimator: Estimator, step: u32| {
        let (seed, passes) = match estimator {
            Estimator::Default => (1_000, passes.default),
            Estimator::Plain => (2_000, passes.default),
            Estimator::Reference => (3_000, passes.reference),
            Estimator::Light => (4_000, passes.light),
            Estimator::EveryPixel => (5_000, passes.default),
        };
        let first = seed + step * RUNS;
        pictures(scene, estimator, first..first + RUNS, passes)
    };
    let (tested, reference) = (runs(Estimator::Default, 0)?, runs(Estimator::Reference, 0)?);
    let light_traced = light_tracing_sees_all(scene);
    let rings = rings(&mean(&reference));
    let mut suspects = Vec::new();
    let mut fresh = None;
    for against in [Estimator::Reference, Estimator::Light] {
        let first = match against {
            Estimator::Reference => compare(&tested, &reference, &rings),
            _ if light_traced => compare(&tested, &runs(against, 0)?, &rings),
            _ => continue,
        };
        let suspected = |verdict: &Verdict| verdict.p < SUSPECT;
        if !first.iter().any(suspected) {
            continue;
        }
        if fresh.is_none() {
            fresh = Some((runs(Estimator::Default, 1)?, runs(Estimator::Plain, 1)?));
        }
        let (tested, plain) = fresh.as_ref().expect("made above");
        let others = runs(against, 1)?;
        let judged = compare(tested, &others, &rings).into_iter().zip(compare(tested, plain, &rings));
        for (region, (first, (judged, plain))) in first.iter().zip(judged).enumerate() {
            if suspected(first) {
                suspects.push(Suspect { region, against, judged, plain });
            }
        }
    }
    Ok(Agreement { suspects, light_traced, tested, reference })
}

/// The level at which the suspects of all scenes are judged.
pub fn level(suspects: usize) -> f64 {
    sidak(FAMILY_WISE, suspects.max(1))
}
