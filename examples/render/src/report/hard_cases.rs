//! The hard cases of the light field's arithmetic, run anew.

use covbeam_hard_cases::stability::{
    Case, Family, cases, errors, extinguished_beam, families, many_deposits, spread,
};
use rayon::prelude::*;
use serde::Serialize;

/// Deposits into one voxel: six times as many as single precision can count.
const DEPOSITS: u64 = 100_000_000;

/// Longest path that a quick report runs: one of a thousand events takes seconds in 1600 bits.
const QUICK_EVENTS: usize = 250;

/// One path or beam.
#[derive(Clone, Debug, Serialize)]
pub struct HardCase {
    /// What it is.
    pub name: String,
    /// Relative error of the textbook form in single precision; None where it does not apply.
    pub textbook: Option<f64>,
    /// Of the textbook form stored in single precision, each operator computed in double precision.
    pub textbook_wide: Option<f64>,
    /// Of covbeam.
    pub covbeam: f64,
    /// What is accepted; None where the table of tolerances has no entry.
    pub tolerance: Option<f64>,
}

/// Runs all, without those that take more than two seconds if `quick`. None: cancelled.
pub(super) fn hard_cases(quick: bool, cancelled: &(dyn Fn() -> bool + Sync)) -> Option<Vec<HardCase>> {
    let is_short = |case: &Case| !quick || case.events.len() <= QUICK_EVENTS;
    let cases: Vec<Case> = cases().into_iter().filter(is_short).collect();
    let one = |case: &Case| {
        let found = (!cancelled()).then(|| errors(case))?;
        Some(HardCase {
            name: case.name.to_owned(),
            textbook: Some(found.textbook),
            textbook_wide: Some(found.textbook_wide),
            covbeam: found.square_root,
            tolerance: Some(case.tolerance),
        })
    };
    let mut rows: Vec<HardCase> = cases.par_iter().map(one).collect::<Option<_>>()?;
    let beam = extinguished_beam();
    rows.push(HardCase {
        name: format!("a beam through optical depth 200, worst of the {} of 100 voxels with data", beam.1),
        textbook: None,
        textbook_wide: None,
        covbeam: beam.0,
        tolerance: None,
    });
    if quick {
        return Some(rows);
    }
    let random = |family: &Family| {
        let found = (!cancelled()).then(|| spread(family))?;
        let row = |(quantile, name): (usize, &str)| HardCase {
            name: format!("{}: {name}", family.name),
            textbook: Some(found.textbook[quantile]),
            textbook_wide: None,
            covbeam: found.square_root[quantile],
            tolerance: None,
        };
        Some(["median", "99 %"].into_iter().enumerate().map(row).collect::<Vec<_>>())
    };
    let found: Vec<Vec<HardCase>> = families().par_iter().map(random).collect::<Option<_>>()?;
    rows.extend(found.into_iter().flatten());
    let (single, grid) = many_deposits(DEPOSITS);
    rows.push(HardCase {
        name: "10⁸ deposits into one voxel (textbook: running sums in single precision)".to_owned(),
        textbook: Some(single),
        textbook_wide: None,
        covbeam: grid,
        tolerance: None,
    });
    Some(rows)
}
