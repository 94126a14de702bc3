//! What is really there: the fluence of every voxel from many light paths, in independent batches that tell its noise.

use super::walk::{voxel_size, walk};
use covbeam::{Beam, Column, GridLayout, Knot, Medium};
use covbeam_session::paths::{PathBeam, PhotonRecord, PhotonTracer, Record};
use covbeam_session::random::Emission;
use covbeam_session::scene::Scene;
use covbeam_session::scene::media;
use glam::Vec3;
use rayon::prelude::*;

/// Batches of light paths. Each has a scrambled sequence of its own, so that their spread is the noise of a mean, low
/// discrepancy included; 16 tell a standard error to 1/sqrt(2 x 15) = 18 %.
pub const BATCHES: u32 = 16;

/// Sequences of the batches, apart from those that pictures are rendered with.
const FIRST_SEQUENCE: u32 = 0x5bec_0000;

/// Light paths between two reports of progress.
const REPORT_EVERY: u32 = 4096;

/// What happened to light before it came to a voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Straight from a light.
    Direct,
    /// By mirrors and through glass.
    Specular,
    /// Scattered by a medium or a matt surface, at least once.
    Scattered,
}

impl Origin {
    /// All of them, in the order of [`Fluence::shares`].
    pub const ALL: [Self; 3] = [Self::Direct, Self::Specular, Self::Scattered];

    /// For tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::Specular => "specular",
            Self::Scattered => "scattered",
        }
    }
}

/// The measured fluence \[W/m²\] of the voxels of a grid: mean over the colour channels, and over the whole voxel.
#[derive(Clone, Debug)]
pub struct Fluence {
    /// One estimate a batch; in each, one value a voxel.
    pub batches: Vec<Vec<f32>>,
    /// Shares of the [`Origin`]s in each voxel, which add up to 1 (or are 0 where it is dark).
    pub shares: Vec<[f32; 3]>,
}

impl Fluence {
    /// Traces `paths` light paths, a multiple of [`BATCHES`], and adds up power x ∫ transmittance ds over the piece of
    /// each beam in each voxel. `report` is told of light paths as they are finished and answers false to give up (then
    /// None is returned).
    ///
    /// Guarantee: the same bits for any number of threads.
    pub fn measure(
        scene: &Scene,
        layout: &GridLayout,
        paths: u32,
        seed: u32,
        report: &(dyn Fn(u32) -> bool + Sync),
    ) -> Option<Self> {
        let tracer = PhotonTracer::new(scene, seed, Emission::LowDiscrepancy);
        let paths = paths / BATCHES;
        let batches: Option<Vec<_>> = (0..BATCHES)
            .into_par_iter()
            .map(|batch| measure_batch(scene, &tracer, layout, FIRST_SEQUENCE + batch, paths, report))
            .collect();
        let mut all = Self { batches: Vec::new(), shares: vec![[0.0; 3]; layout.cell_count()] };
        for batch in batches? {
            let total = |by_origin: &[f32; 3]| by_origin.iter().sum();
            all.batches.push(batch.iter().map(total).collect());
            for (shares, by_origin) in all.shares.iter_mut().zip(&batch) {
                *shares = std::array::from_fn(|i| shares[i] + by_origin[i]);
            }
        }
        for shares in &mut all.shares {
            let total: f32 = shares.iter().sum();
            if total > 0.0 {
                *shares = shares.map(|share| share / total);
            }
        }
        Some(all)
    }

    /// Mean over the batches.
    pub fn mean(&self, voxel: usize) -> f64 {
        self.batches.iter().map(|batch| f64::from(batch[voxel])).sum::<f64>() / self.batches.len() as f64
    }
}

/// Mean and standard error of the mean.
pub(super) fn mean_and_error(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    let squares: f64 = values.map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (count * (count - 1.0))).sqrt())
}

fn measure_batch(
    scene: &Scene,
    tracer: &PhotonTracer,
    layout: &GridLayout,
    sequence: u32,
    paths: u32,
    report: &(dyn Fn(u32) -> bool + Sync),
) -> Option<Vec<[f32; 3]>> {
    let mut sums = vec![[0.0_f64; 3]; layout.cell_count()];
    let fogs = media::all(scene);
    let (mut record, mut knots) = (PhotonRecord::default(), Vec::new());
    for first in (0..paths).step_by(REPORT_EVERY as usize) {
        let count = REPORT_EVERY.min(paths - first);
        for index in first..first + count {
            record.beams.clear();
            record.surface.clear();
            tracer.trace(sequence, index, paths, Record::Beams, &mut record);
            let mut origin = Origin::Direct;
            for PathBeam { medium, beam, .. } in &record.beams {
                origin = origin_of(scene, beam, origin);
                add_beam(layout, beam, &fogs[*medium as usize], &mut knots, |voxel, weight| {
                    sums[voxel][origin as usize] += weight;
                });
            }
        }
        if !report(count) {
            return None;
        }
    }
    let volume = voxel_size(layout).element_product();
    Some(sums.iter().map(|sums| sums.map(|sum| (sum / volume) as f32)).collect())
}

/// Calls `add` with each voxel on the beam's way and the beam's power x ∫ transmittance ds in it; inside a voxel, the
/// transmittance of a medium whose density varies is taken as an exponential between its two ends.
fn add_beam(
    layout: &GridLayout,
    beam: &Beam,
    fog: &Medium,
    knots: &mut Vec<Knot>,
    mut add: impl FnMut(usize, f64),
) {
    let column = media::column(fog, beam.origin, beam.direction, beam.length, knots);
    let column_at = |distance: f64| match column {
        Column::Uniform => distance,
        column => f64::from(column.at(distance as f32)),
    };
    let extinction = fog.extinction();
    let grey = extinction.x == extinction.y && extinction.y == extinction.z;
    let channels: &[(f64, f64)] = if grey {
        &[(f64::from(beam.power.element_sum()) / 3.0, f64::from(extinction.x))]
    } else {
        &std::array::from_fn::<_, 3, _>(|c| (f64::from(beam.power[c]) / 3.0, f64::from(extinction[c])))
    };
    for &(power, extinction) in channels {
        // The box may begin behind the beam's start.
        let (mut left, mut reached) = (power, 0.0);
        walk(layout, beam.origin, beam.direction, beam.length, |voxel, from, to| {
            if reached == 0.0 && from > 0.0 {
                reached = column_at(from);
                left *= (-extinction * reached).exp();
            }
            let end = column_at(to);
            let depth = extinction * (end - reached);
            reached = end;
            let lost = -(-depth).exp_m1();
            add(voxel, left * (to - from) * if depth > 0.0 { lost / depth } else { 1.0 });
            left -= left * lost;
        });
    }
}

/// Where the light of a path's next beam comes from, after that of the beam before (Direct for the first).
fn origin_of(scene: &Scene, beam: &Beam, before: Origin) -> Origin {
    if before == Origin::Scattered {
        return Origin::Scattered;
    }
    if before == Origin::Direct
        && scene.lights.iter().any(|light| light.may_have_sent(beam.origin, beam.direction))
    {
        return Origin::Direct;
    }
    // The surface is just behind the start, which was moved off it.
    let behind = scene.intersect(beam.origin, -beam.start_normal, f32::INFINITY);
    match behind.map(|hit| *scene.material(&hit)) {
        _ if beam.start_normal == Vec3::ZERO => Origin::Scattered,
        Some(material) if material.bends_light() || material.index().is_some() => Origin::Specular,
        _ => Origin::Scattered,
    }
}
