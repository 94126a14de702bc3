//! What a render would use: the covariance grid after some passes.

use crate::operators::Operator;
use crate::pass::FIELD_SEQUENCE;
use crate::photon::{PhotonRecord, PhotonTracer, Record};
use crate::random::Emission;
use crate::scene::Scene;
use covbeam::{CovarianceGrid, FluenceCell, GridCell, GridLayout};
use rayon::prelude::*;

/// Light paths that one task traces.
const CHUNK: u32 = 64;

/// How the predicted spectra are made, as in a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Passes, > 0.
    pub passes: u32,
    /// Light paths a pass that carry a light field, > 0.
    pub field_paths: u32,
    /// Of the random numbers.
    pub seed: u32,
}

/// The resolved covariance grid: the same spectra as in a render's last pass. `report` as in
/// [`super::Fluence::measure`].
///
/// Guarantee: the same bits for any number of threads.
///
/// # Panics
/// If `layout` is not sound.
pub fn predict(
    scene: &Scene,
    layout: &GridLayout,
    prediction: &Prediction,
    report: &(dyn Fn(u32) -> bool + Sync),
) -> Option<Vec<FluenceCell>> {
    predict_without(scene, layout, prediction, None, report)
}

/// Like [`predict`], with an operator left out of all light fields, to see what it buys.
///
/// # Panics
/// If `layout` is not sound.
pub fn predict_without(
    scene: &Scene,
    layout: &GridLayout,
    prediction: &Prediction,
    left_out: Option<Operator>,
    report: &(dyn Fn(u32) -> bool + Sync),
) -> Option<Vec<FluenceCell>> {
    let Prediction { passes, field_paths, seed } = *prediction;
    let mut tracer = PhotonTracer::new(scene, seed, Emission::LowDiscrepancy);
    if let Some(operator) = left_out {
        tracer.leave_out(operator);
    }
    let mut cells = vec![GridCell::default(); layout.cell_count()];
    let mut grid = CovarianceGrid::new(*layout, &mut cells).expect("the grid was validated");
    for pass in 0..passes {
        let first = pass.wrapping_mul(field_paths);
        let chunks: Vec<PhotonRecord> = (0..field_paths.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let mut out = PhotonRecord::default();
                for i in chunk * CHUNK..((chunk + 1) * CHUNK).min(field_paths) {
                    tracer.trace(FIELD_SEQUENCE, first.wrapping_add(i), field_paths, Record::Field, &mut out);
                }
                out
            })
            .collect();
        for chunk in &chunks {
            tracer.deposit_into(&mut grid, &chunk.deposits);
        }
        if !report(field_paths) {
            return None;
        }
    }
    let mut resolved = vec![FluenceCell::default(); layout.cell_count()];
    grid.resolve(&mut resolved).expect("as many cells as the grid has");
    Some(resolved)
}
