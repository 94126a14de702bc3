//! Light paths: from a light through media and surfaces until they are absorbed or escape.

mod connect;
mod division;
mod emission;
mod events;
mod fields;
pub mod guidance;
mod guided;
mod lit;
pub mod operators;
mod photon;
mod plain;
mod reception;
pub mod record;
mod roulette;
mod scattering;
mod segment;
mod transport;
mod weight;

use crate::lamps::LampTree;
use crate::lamps::near::Near;
use crate::paths::emission::Lights;
use crate::paths::guidance::Guidance;
use crate::paths::operators::Operator;
pub use crate::paths::record::{Energy, FieldSegment, PathBeam, PhotonRecord, Record, Splat};
use crate::paths::transport::Transport;
use crate::random::{Emission, PathSampler};
use crate::scene::Scene;
use covbeam::{CovarianceGrid, Medium};
pub(crate) use weight::{GOING_ON, LONG_PATH};

/// Beams of a guided path, on average, at most: where each of very many scatterings matters, paths branch less than the picture would like,
/// or a pass would not end.
const MOST_BEAMS: f32 = 6.0;

/// Times that this is tried, at most.
const TRIALS: u32 = 8;

/// Paths that find out.
const TRIAL_PATHS: u32 = 64;
const TRIAL_SEQUENCE: u32 = 0x7e57;

/// Traces light paths of a scene.
pub struct PhotonTracer<'a> {
    transport: Transport<'a>,
    lights: Lights,
    lamps: LampTree,
    seed: u32,
    emission: Emission,
    /// None: paths are drawn as their power goes.
    guidance: Option<Guidance>,
}

impl<'a> PhotonTracer<'a> {
    /// Prepares `scene`.
    pub fn new(scene: &'a Scene, seed: u32, emission: Emission) -> Self {
        Self {
            transport: Transport::new(scene),
            lights: Lights::new(scene),
            lamps: LampTree::new(scene),
            seed,
            emission,
            guidance: None,
        }
    }

    /// Leaves an operator out of all light fields, to see what it buys.
    pub fn leave_out(&mut self, operator: Operator) {
        self.transport.left_out = Some(operator);
    }

    /// From now on sends light paths where the picture needs them; not those for connections with the camera.
    pub(crate) fn guide(&mut self, guidance: Guidance) {
        self.guidance = Some(guidance);
        for _ in 0..TRIALS {
            let mut record = PhotonRecord::default();
            (0..TRIAL_PATHS).for_each(|index| {
                self.trace(TRIAL_SEQUENCE, index, TRIAL_PATHS, Record::Beams, &mut record);
            });
            let excess = record.beams.len() as f32 / (TRIAL_PATHS as f32 * MOST_BEAMS);
            if let Some(guidance) = &mut self.guidance {
                guidance.coarsen(excess.max(1.0));
            }
            // Large trees are cut short, and hide how much too large they are.
            if excess < 2.0 {
                return;
            }
        }
    }

    /// Sends light paths as their power goes, as before [`PhotonTracer::guide`].
    pub(crate) fn guide_no_more(&mut self) {
        self.guidance = None;
    }

    /// Where light paths are sent, if anything says so.
    pub(crate) fn guidance(&self) -> Option<&Guidance> {
        self.guidance.as_ref()
    }

    /// Guided light paths have this many times their branches, about.
    ///
    /// - `share`: > 0.
    pub(crate) fn scale_branches(&mut self, share: f32) {
        if let Some(guidance) = &mut self.guidance {
            guidance.leave(share);
        }
    }

    /// The scene.
    pub(crate) fn scene(&self) -> &'a Scene {
        self.transport.scene
    }

    /// The scene's media, by region.
    pub(crate) fn fogs(&self) -> &[Medium<'a>] {
        &self.transport.fogs
    }

    /// The lamps that shadow rays look for.
    pub(crate) fn lamps(&self) -> &LampTree {
        &self.lamps
    }

    /// Where straight light is left to beams.
    pub(crate) fn near(&self) -> &Near {
        &self.lights.near
    }

    /// Adds deposits that this tracer made to a covariance grid, in their order.
    pub fn deposit_into<'d>(
        &self,
        grid: &mut CovarianceGrid,
        deposits: impl IntoIterator<Item = &'d (u32, FieldSegment)>,
    ) {
        self.transport.deposit_into(grid, deposits);
    }

    /// Traces light path `index` of `sequence`; its power is divided by `paths`.
    pub fn trace(&self, sequence: u32, index: u32, paths: u32, record: Record, out: &mut PhotonRecord) {
        let Self { transport, lights, guidance, .. } = self;
        let sampler = PathSampler::new(self.emission, self.seed, sequence, index);
        match guidance {
            // Connections with the camera know nothing of where the picture needs light.
            Some(guidance) if matches!(record, Record::Beams | Record::BeamsAndField | Record::Field) => {
                guided::trace(transport, lights, guidance, sampler, paths, record, out);
            }
            _ => plain::trace(transport, lights, sampler, paths, record, out),
        }
    }
}
