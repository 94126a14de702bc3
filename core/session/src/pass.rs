//! Renders one pass: light paths, covariance grid, beams, eye rays.

mod beams;
mod connections;
mod fields;
mod instants;
mod marched;
pub mod memory;
mod times;

pub use fields::field_passes;
pub use fields::latest_field_pass;
pub use instants::Instants;
pub use times::PassTimes;

use crate::eye::shown::SmallLamps;
use crate::eye::starts::EyeStarts;
use crate::eye::straight::looks::StraightLooks;
use crate::film::samples::PassImage;
use crate::kind::Split;
use crate::paths::{Energy, PhotonRecord, PhotonTracer, Record};
use crate::pilot::defaults::NO_GRID;
use crate::pilot::{self, Spread};
use crate::plan::grids::Grids;
use crate::plan::radius::{BeamVoxels, Radii, RadiusRule};
use crate::plan::{FirstSurfaces, Plan};
use crate::scene::Scene;
use crate::settings::{Gather, Settings};
use crate::surface::SurfaceMap;
use covbeam::{FluenceCell, GridError};
use fields::next_field_pass;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// Light paths that one task traces.
const CHUNK: u32 = 64;

const NEVER: &str = "never cancelled";
const FITS: &str = "as many cells as the grid has";

/// Sequences of light paths: without a light field, with one, for connections.
const PLAIN_SEQUENCE: u32 = 0;
const FIELD_SEQUENCE: u32 = 1;
const CONNECTION_SEQUENCE: u32 = 2;

/// The light fields in the voxels after a pass.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldState {
    /// The pass, counted from 1: its own and those of all before.
    pub after: u32,
    /// A grid for each layer of light, as the core saves them.
    pub grids: Vec<u8>,
}

/// Renders passes of one scene with one method.
///
/// A pass is a pure function of (scene, method, photons, seed, emission, index): the same bits for any number of
/// threads and any order of passes. Work runs on rayon's current pool.
pub struct Renderer<'a> {
    scene: &'a Scene,
    settings: Settings,
    tracer: PhotonTracer<'a>,
    starts: EyeStarts<'a>,
    small: SmallLamps,
    /// For straight light; None: it has no shadow rays, or no eye rays are planned.
    looks: Option<StraightLooks>,
    /// What is first behind each pixel; None: no eye rays are planned.
    surfaces: Option<Arc<FirstSurfaces>>,
    /// None: [`RadiusRule::Bias`].
    radii: Option<Radii>,
    grids: Grids,
    energy: Energy,
    /// Light paths a pass: those that the settings ask for, or more of guided ones that leave few beams.
    paths: u32,
    /// Some: kinds of light are told apart, in these layers.
    split: Option<Split>,
    /// What the branches of guided paths are decided by.
    spread: Option<Spread>,
    /// Core-seconds of the pilot, not yet said.
    pilot: f64,
    /// Whether each pass looks through all pixels: of few passes a pixel would see some instants only, others than the pixels around.
    is_everywhere: bool,
}

impl<'a> Renderer<'a> {
    /// Gets ready, with a pilot if light paths are guided.
    pub fn new(scene: &'a Scene, settings: Settings) -> Self {
        let surfaces = settings.planned.then(|| FirstSurfaces::new(scene, &|| false).expect(NEVER));
        let made = Self::of_instants([scene], settings, surfaces.map(Arc::new), &|| false);
        made.and_then(|mut made| made.pop()).expect(NEVER)
    }

    /// Renderers of one scene at several instants while a shutter is open, all with the same grid: with one pilot for all of them. The first has
    /// their light fields; see [`Renderer::go_on_from`].
    ///
    /// - `surfaces`: what is first behind each pixel at all instants, where eye rays are planned.
    /// - `cancelled` is polled all the time, and says yes for good once it did; None = it has.
    fn of_instants(
        scenes: impl IntoIterator<Item = &'a Scene>,
        settings: Settings,
        surfaces: Option<Arc<FirstSurfaces>>,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<Vec<Self>> {
        let make = |scene| Self::without_light(scene, settings, surfaces.clone());
        let mut instants: Vec<Self> = scenes.into_iter().map(make).collect();
        if settings.gather == Gather::Adaptive && settings.guided {
            let start = Instant::now();
            Self::guide(&mut instants, cancelled);
            if let Some(first) = instants.first_mut() {
                first.pilot = start.elapsed().as_secs_f64();
            }
        }
        let (count, no_photons) = (instants.len(), SurfaceMap::empty());
        for made in instants.iter_mut().filter(|made| made.settings.shadow_rays && made.surfaces.is_some()) {
            let start = Instant::now();
            let eye = made.eye(&no_photons);
            made.looks = Some(StraightLooks::new(&made.straight(1), &eye, count, cancelled)?);
            made.pilot += start.elapsed().as_secs_f64();
        }
        if cancelled() {
            return None;
        }
        let is_everywhere = instants.len() > 1;
        instants.iter_mut().for_each(|made| made.is_everywhere = is_everywhere);
        // Grids may take most of the memory, and one is enough.
        if let Some(first) = instants.first_mut() {
            first.grids = first.new_grids();
        }
        Some(instants)
    }

    /// One that has neither guides nor a grid yet.
    fn without_light(scene: &'a Scene, settings: Settings, surfaces: Option<Arc<FirstSurfaces>>) -> Self {
        let mut tracer = PhotonTracer::new(scene, settings.seed, settings.emission);
        if let Some(operator) = settings.left_out {
            tracer.leave_out(operator);
        }
        let rule = settings.radius_rule;
        Self {
            scene,
            settings,
            tracer,
            starts: EyeStarts::new(scene),
            small: SmallLamps::new(scene),
            looks: None,
            surfaces,
            radii: (rule != RadiusRule::Bias).then(|| Radii::new(rule, scene.grid)),
            grids: Grids::new(NO_GRID, Split::TOGETHER),
            energy: Energy::default(),
            paths: settings.photons,
            split: settings.layers.split(scene),
            spread: None,
            pilot: 0.0,
            is_everywhere: false,
        }
    }

    /// Learns where light paths are needed at all instants.
    fn guide(instants: &mut [Self], cancelled: &(dyn Fn() -> bool + Sync)) {
        let scenes: Vec<_> =
            instants.iter().map(|at| pilot::Instant { scene: at.scene, fogs: at.tracer.fogs() }).collect();
        let found = pilot::guidance(&scenes, cancelled);
        let mut spread = None;
        for (made, guidance) in instants.iter_mut().zip(found) {
            let Some(guidance) = guidance else { continue };
            made.tracer.guide(guidance);
            // What it says of one holds for the others: only their noise depends on it.
            made.spread =
                *spread.get_or_insert_with(|| Spread::of(&made.tracer, made.tracer.fogs(), cancelled));
            match made.spread {
                Some(_) => made.decide_paths(),
                None => made.tracer.guide_no_more(),
            }
        }
    }

    fn new_grids(&self) -> Grids {
        // Methods without spectra have none.
        let layout = if self.settings.has_grid() { self.scene.grid } else { NO_GRID };
        Grids::new(layout, self.split.unwrap_or(Split::TOGETHER))
    }

    /// How many light paths a pass has, and how many branches they have.
    fn decide_paths(&mut self) {
        self.paths = self.settings.photons;
        if let Some(spread) = &self.spread {
            self.paths = spread.paths(self.settings.photons, &self.scene.camera);
            let share = spread.share_of_branches(self.paths, &self.scene.camera);
            self.tracer.scale_branches(share);
        }
    }

    /// Starts anew with so many light paths a pass: from now on it is as one that was made with them, and has nothing to look at again.
    pub fn restart(&mut self, photons: u32) {
        self.settings.photons = photons;
        self.grids.clear();
        self.energy = Energy::default();
        self.decide_paths();
    }

    /// Goes on from the light fields of another renderer, which has none then: one of the same scene at another instant, with the same grid. In
    /// spectra that are the mean over the instants all of them may have a part, and the pictures of all be filtered as one.
    fn go_on_from(&mut self, other: &mut Self) {
        std::mem::swap(&mut self.grids, &mut other.grids);
        other.grids = Grids::new(NO_GRID, Split::TOGETHER);
    }

    /// Whether eye rays are asked for more than the light that the fog before the first surface scatters.
    fn wants_rest(&self) -> bool {
        self.settings.beyond || self.scene.glows()
    }

    /// Where the power of the latest pass' light paths went.
    pub fn energy(&self) -> Energy {
        self.energy
    }

    /// Pass `index`, counted from 1. `cancelled` is polled a few hundred times a pass; None = it said yes.
    ///
    /// The adaptive method's pass i uses the light fields of passes 1 to i, those that have any: the first eight, every eighth up to 64, and then four each time that the passes double.
    /// Asked for out of order, it traces those of the earlier passes that it has not seen.
    pub fn pass(
        &mut self,
        index: u32,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<(PassImage, PassTimes)> {
        match self.settings.gather {
            Gather::LightTrace => self.light_trace(index, cancelled),
            Gather::March => self.march(index, cancelled),
            Gather::Plain | Gather::Adaptive => self.beams(index, cancelled),
        }
    }

    /// How many of a pass' paths carry a light field: a share of those asked for.
    fn field_photons(&self) -> u32 {
        let photons = self.settings.photons;
        ((photons as f32 * self.scene.settings.light_field_share).round() as u32).clamp(1, photons)
    }

    /// Traces paths `0..count` of a pass of one sequence, in order. Also returns the core-seconds spent.
    fn trace(
        &self,
        sequence: u32,
        index: u32,
        count: u32,
        record: Record,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<(PhotonRecord, f64)> {
        let first = (index - 1).wrapping_mul(count);
        let chunks: Option<Vec<(PhotonRecord, f64)>> = (0..count.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let start = Instant::now();
                let mut out = PhotonRecord::default();
                for i in chunk * CHUNK..((chunk + 1) * CHUNK).min(count) {
                    // A path between mirrors may take as long as a thousand others.
                    if cancelled() {
                        return None;
                    }
                    self.tracer.trace(sequence, first.wrapping_add(i), self.paths, record, &mut out);
                }
                Some((out, start.elapsed().as_secs_f64()))
            })
            .collect();
        let mut all = PhotonRecord::default();
        let mut seconds = 0.0;
        for (chunk, time) in chunks? {
            all.append(chunk);
            seconds += time;
        }
        Some((all, seconds))
    }

    /// Brings the grid to the state after pass `index`, whose own light fields, if it has any, are in `record`.
    fn update_grid(
        &mut self,
        index: u32,
        record: &PhotonRecord,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<()> {
        let latest = latest_field_pass(index);
        if self.grids.deposited() > latest {
            self.grids.clear();
        }
        while self.grids.deposited() < latest {
            let next = next_field_pass(self.grids.deposited());
            if next == index {
                self.grids.deposit(index, &self.tracer, &record.deposits);
            } else {
                self.add_light_fields(cancelled)?;
            }
        }
        self.grids.resolve();
        Some(())
    }

    /// The next pass before pass `index` whose light fields its grids lack; grids that are beyond it are cleared.
    fn missing_fields(&mut self, index: u32) -> Option<u32> {
        let latest = latest_field_pass(index);
        if self.grids.deposited() > latest {
            self.grids.clear();
        }
        self.next_fields(latest).filter(|next| *next < index && !self.is_all_behind())
    }

    /// Brings the radii of rules that count beams to the state after pass `index`, whose own paths left `record`.
    fn update_radii(
        &mut self,
        index: u32,
        record: &PhotonRecord,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<()> {
        let Some(mut radii) = self.radii.take() else { return Some(()) };
        let counted = self.count_beams(index, record, &mut radii.beams, cancelled);
        let settings = &self.scene.settings;
        radii.resolve(self.grids.cells(0), settings.schedule.shape, settings.schedule.error);
        self.radii = Some(radii);
        counted
    }

    fn count_beams(
        &self,
        index: u32,
        record: &PhotonRecord,
        beams: &mut BeamVoxels,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<()> {
        if beams.passes() >= index {
            beams.clear();
        }
        while beams.passes() + 1 < index {
            let (earlier, fields) = (beams.passes() + 1, self.field_photons());
            let sequences = [(PLAIN_SEQUENCE, self.paths - fields), (FIELD_SEQUENCE, fields)];
            let mut record = PhotonRecord::default();
            for (sequence, count) in sequences {
                record.append(self.trace(sequence, earlier, count, Record::Beams, cancelled)?.0);
            }
            beams.add(&record.beams, self.tracer.fogs());
        }
        beams.add(&record.beams, self.tracer.fogs());
        Some(())
    }

    /// Traces and deposits the light fields of the next pass that has any.
    fn add_light_fields(&mut self, cancelled: &(dyn Fn() -> bool + Sync)) -> Option<()> {
        let (next, count) = (next_field_pass(self.grids.deposited()), self.field_photons());
        let record = if self.settings.gather == Gather::March { Record::Direct } else { Record::Field };
        let (record, _) = self.trace(FIELD_SEQUENCE, next, count, record, cancelled)?;
        self.grids.deposit(next, &self.tracer, &record.deposits);
        Some(())
    }

    /// The next pass up to `passes` whose light fields are not in the grids yet; None: they are all there, or the method has none.
    pub fn next_fields(&self, passes: u32) -> Option<u32> {
        (self.settings.has_grid() && self.grids.deposited() < latest_field_pass(passes))
            .then(|| next_field_pass(self.grids.deposited()))
    }

    /// Traces the light fields of that pass; None = cancelled.
    pub fn trace_fields(&mut self, cancelled: &(dyn Fn() -> bool + Sync)) -> Option<FieldState> {
        self.add_light_fields(cancelled)?;
        Some(FieldState { after: self.grids.deposited(), grids: self.grids.save() })
    }

    /// Goes on from these light fields, as if this renderer had traced them.
    ///
    /// # Errors
    /// They are of other grids; the renderer is of no use then.
    pub fn load_fields(&mut self, state: &FieldState) -> Result<(), GridError> {
        self.grids.load(state.after, &state.grids)
    }

    /// The spectra that the adaptive method looks up in pass `passes`, without rendering. `report` is called with the number
    /// of light paths of each pass with light fields done; it answers false to give up, and then None is returned.
    pub fn spectra(mut self, passes: u32, report: &dyn Fn(u32) -> bool) -> Option<Vec<FluenceCell>> {
        while self.grids.deposited() < latest_field_pass(passes) {
            self.add_light_fields(&|| false)?;
            if !report(self.field_photons()) {
                return None;
            }
        }
        self.grids.resolve();
        Some(self.grids.into_cells(0))
    }

    /// Whether eye rays may see fog before the first surface, as far as that is known.
    fn sees_fog_first(&self) -> bool {
        self.settings.first_apart || self.surfaces.as_ref().is_none_or(|surfaces| surfaces.has_fog())
    }

    /// Where the pass needs eye rays for each layer; none: everywhere.
    fn plans(
        &mut self,
        index: u32,
        error: f32,
        beams: u32,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<Vec<Plan>> {
        let Some(surfaces) = self.surfaces.as_ref().filter(|_| self.sees_fog_first()) else {
            return Some(Vec::new());
        };
        let (grids, split) = (&mut self.grids, self.split);
        let plan = |layer| {
            let spectra = grids.image(layer, surfaces, self.tracer.fogs());
            let kind = split.filter(|split| split.count() > 1).map(|split| split.last_kind(layer));
            let made = Plan::new(Arc::clone(surfaces), kind, index, error, beams, spectra, cancelled)?;
            Some(if self.is_everywhere { made.everywhere() } else { made })
        };
        (0..split.unwrap_or(Split::TOGETHER).count()).map(plan).collect()
    }
}
