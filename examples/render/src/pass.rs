//! Renders one pass: light paths, covariance grid, beams, eye rays.

use crate::eye::EyeTracer;
use crate::grids::Grids;
use crate::kind::{Kind, Split};
use crate::march::{Guide, Marcher, Placement};
use crate::media;
use crate::photon::{Energy, PathBeam, PhotonRecord, PhotonTracer, Record};
use crate::pilot::{self, Spread};
use crate::plan::{FirstSurfaces, Plan};
use crate::radius::{BeamVoxels, Radii, RadiusRule};
use crate::random::Random;
use crate::samples::PassImage;
use crate::scene::Scene;
use crate::settings::{Gather, Settings};
use crate::shown::SmallLamps;
use crate::starts::EyeStarts;
use crate::straight::{Straight, is_left_to_beams};
use crate::surface::{CROWD, Disks, SurfaceMap};
use crate::view::{BeamView, View, pixel_offset};
use covbeam::{Beam, BeamMap, FluenceCell, FluenceGrid, GridError, GridLayout, Kernel, Medium, error_bound};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::AddAssign;
use std::sync::Arc;
use std::time::Instant;

/// Every one of the first passes traces light fields, and after them one pass in so many: the grid's own noise falls with the number of
/// light fields, and later ones change it little. Where surfaces scatter much light they cost as much as all the rest of a pass.
const FIRST_FIELD_PASSES: u32 = 8;
const FIELD_PASS_EVERY: u32 = 8;

/// From some pass on, each time that the passes double so many of them trace light fields: what a late pass needs of all earlier ones must not
/// grow with its number, or a thousand machines would wait for it.
const FIELD_PASSES_A_DOUBLING: u32 = 4;

/// Light paths that one task traces.
const CHUNK: u32 = 64;

/// Of methods without spectra.
const NO_GRID: GridLayout = GridLayout { min: Vec3::ZERO, max: Vec3::ONE, cells: [1; 3] };

const NEVER: &str = "never cancelled";
const FITS: &str = "as many cells as the grid has";

/// Sequences of light paths: without a light field, with one, for connections.
const PLAIN_SEQUENCE: u32 = 0;
const FIELD_SEQUENCE: u32 = 1;
const CONNECTION_SEQUENCE: u32 = 2;

/// Purpose of the random numbers that say where light tracing looks for lamps.
const SHOWN_KEY: u32 = 0x5403;

/// How much wider than a pass' own radius spectra may make its kernels, at least. To look a radius up costs as much as two pairs do; where
/// pairs are most of a pass, kernels that are hardly wider do not earn that: plain ones have up to a third of the error at equal time.
const WORTH_LOOKING_UP: f32 = 3.0;

/// Kernel radii of surface photons in beam radii: of caustics, and of light that arrives after scattering, which is smooth.
const CAUSTIC_RADIUS_FACTOR: f32 = 2.0;
const DIFFUSE_RADIUS_FACTOR: f32 = 10.0;

/// Smallest kernel radius of focused light in that of other light, where filters smooth the noise: guided photons are dense in a caustic, and its
/// borders sharp. Without filters it is noise that decides: up to 1.7 times the error where much light came through glass.
const FOCUSED_SHARE: f32 = 0.25;

/// Photons that a disk of a caustic holds at least: its own says nothing of how far others are.
const FEWEST: usize = 2;

/// Core-seconds by part, and what they bought.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassTimes {
    /// Photon paths.
    pub trace: f64,
    /// Light fields and edge probes.
    pub light_fields: f64,
    /// Grid deposits and resolve.
    pub grid: f64,
    /// Hierarchies over beams and surface photons.
    pub build: f64,
    /// The spectrum of the picture; and in the first pass, what light is worth in it.
    pub plan: f64,
    /// Eye rays, gather and shading.
    pub gather: f64,
    /// Accepted beam-ray pairs.
    pub pairs: u64,
    /// Shadow rays of the method `march`, and the rays from the lights that guide them.
    pub shadow_rays: u64,
}

impl PassTimes {
    /// Core-seconds of all parts.
    pub fn total(&self) -> f64 {
        self.trace + self.light_fields + self.grid + self.build + self.plan + self.gather
    }
}

impl AddAssign for PassTimes {
    fn add_assign(&mut self, other: Self) {
        self.trace += other.trace;
        self.light_fields += other.light_fields;
        self.grid += other.grid;
        self.build += other.build;
        self.plan += other.plan;
        self.gather += other.gather;
        self.pairs += other.pairs;
        self.shadow_rays += other.shadow_rays;
    }
}

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
    fogs: Vec<Medium<'a>>,
    starts: EyeStarts<'a>,
    small: SmallLamps,
    /// What is first behind each pixel; None: no eye rays are planned.
    surfaces: Option<Arc<FirstSurfaces>>,
    /// None: [`RadiusRule::Bias`].
    radii: Option<Radii>,
    grids: Grids,
    energy: Energy,
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
    pub fn of_instants(
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
            fogs: media::all(scene),
            starts: EyeStarts::new(scene),
            small: SmallLamps::new(scene),
            surfaces,
            radii: (rule != RadiusRule::Bias).then(|| Radii::new(rule, scene.grid)),
            grids: Grids::new(NO_GRID, Split::TOGETHER),
            energy: Energy::default(),
            split: settings.layers.split(scene),
            spread: None,
            pilot: 0.0,
            is_everywhere: false,
        }
    }

    /// Learns where light paths are needed at all instants.
    fn guide(instants: &mut [Self], cancelled: &(dyn Fn() -> bool + Sync)) {
        let scenes: Vec<_> =
            instants.iter().map(|at| pilot::Instant { scene: at.scene, fogs: &at.fogs }).collect();
        let found = pilot::guidance(&scenes, cancelled);
        let mut spread = None;
        for (made, guidance) in instants.iter_mut().zip(found) {
            let Some(guidance) = guidance else { continue };
            made.tracer.guide(guidance);
            // What it says of one holds for the others: only their noise depends on it.
            made.spread = *spread.get_or_insert_with(|| Spread::of(&made.tracer, &made.fogs, cancelled));
            match made.spread {
                Some(_) => made.decide_branches(),
                None => made.tracer.guide_no_more(),
            }
        }
    }

    fn new_grids(&self) -> Grids {
        let layout = if self.settings.has_grid() { self.scene.grid } else { NO_GRID };
        Grids::new(layout, self.split.unwrap_or(Split::TOGETHER))
    }

    fn decide_branches(&mut self) {
        if let Some(spread) = &self.spread {
            let share = spread.share_of_branches(self.settings.photons, &self.scene.camera);
            self.tracer.scale_branches(share);
        }
    }

    /// Starts anew with so many light paths a pass: from now on it is as one that was made with them, and has nothing to look at again.
    pub fn restart(&mut self, photons: u32) {
        self.settings.photons = photons;
        self.grids.clear();
        self.energy = Energy::default();
        self.decide_branches();
    }

    /// Goes on from the light fields of another renderer, which has none then: one of the same scene at another instant, with the same grid. In
    /// spectra that are the mean over the instants all of them may have a part, and the pictures of all be filtered as one.
    pub fn go_on_from(&mut self, other: &mut Self) {
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

    /// How many of a pass' paths carry a light field.
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
                    self.tracer.trace(
                        sequence,
                        first.wrapping_add(i),
                        self.settings.photons,
                        record,
                        &mut out,
                    );
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
            let sequences = [(PLAIN_SEQUENCE, self.settings.photons - fields), (FIELD_SEQUENCE, fields)];
            let mut record = PhotonRecord::default();
            for (sequence, count) in sequences {
                record.append(self.trace(sequence, earlier, count, Record::Beams, cancelled)?.0);
            }
            beams.add(&record.beams, &self.fogs);
        }
        beams.add(&record.beams, &self.fogs);
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

    fn beams(&mut self, index: u32, cancelled: &(dyn Fn() -> bool + Sync)) -> Option<(PassImage, PassTimes)> {
        let mut times = PassTimes::default();
        let numbers = self.scene.settings;
        let adaptive = self.settings.gather == Gather::Adaptive;
        let counts_only = self.radii.as_ref().is_some_and(|radii| radii.rule == RadiusRule::BeamDensity);
        // Planning needs spectra whatever the radii come from.
        let has_spectra = adaptive && (!counts_only || self.surfaces.is_some()) && !self.is_all_behind();

        let field_photons = self.field_photons();
        let has_fields = has_spectra && latest_field_pass(index) == index;
        let field_record = if has_fields { Record::BeamsAndField } else { Record::Beams };
        let (fields, seconds) = self.trace(FIELD_SEQUENCE, index, field_photons, field_record, cancelled)?;
        times.light_fields = fields.field_time.as_secs_f64();
        times.trace = seconds - times.light_fields;
        let plain_photons = self.settings.photons - field_photons;
        let (mut record, seconds) =
            self.trace(PLAIN_SEQUENCE, index, plain_photons, Record::Beams, cancelled)?;
        times.trace += seconds;

        let start = Instant::now();
        if has_spectra {
            self.update_grid(index, &fields, cancelled)?;
        }
        record.append(fields);
        if adaptive {
            self.update_radii(index, &record, cancelled)?;
        }
        times.grid = start.elapsed().as_secs_f64();
        self.energy = record.energy;
        let kernel = numbers.schedule.kernel(index, None);
        let start = Instant::now();
        let plans = match has_spectra {
            true => self.plans(index, kernel.error, self.settings.photons, cancelled)?,
            false => Vec::new(),
        };
        times.plan = start.elapsed().as_secs_f64() + std::mem::take(&mut self.pilot);

        let kernel = |layer| if adaptive { self.kernel(kernel, layer) } else { kernel };
        let start = Instant::now();
        let split = self.split.unwrap_or(Split::TOGETHER);
        let by_kind = adaptive && self.split.is_some();
        let narrows = by_kind && !plans.is_empty();
        // In each layer: what has the layer's kernel, and focused light.
        let mut beams = vec![[(); 2].map(|()| vec![Vec::new(); self.scene.region_count()]); split.count()];
        let mut next_to_lamps = vec![Vec::new(); self.scene.region_count()];
        for PathBeam { medium, kind, near, beam } in record.beams.drain(..) {
            let is_marched = self.settings.shadow_rays && kind == Kind::Straight;
            if is_marched && !is_left_to_beams(self.scene, medium) {
                next_to_lamps[medium as usize].extend(first_part(beam, near));
            } else {
                let is_narrow = narrows && kind == Kind::Focused;
                beams[split.of(kind)][usize::from(is_narrow)][medium as usize].push(beam);
            }
        }
        let build = |(layer, [others, narrow]): (usize, [Vec<Vec<Beam>>; 2])| {
            let plain = kernel(layer);
            [(others, plain), (narrow, focused(plain))].map(|(beams, kernel)| {
                let maps = self.maps(beams, plain.max_radius);
                let behind = Kernel { max_radius: plain.min_radius, grid: None, ..plain };
                BeamView { layer, maps, kernel, behind, kind: split.last_kind(layer) }
            })
        };
        // A photon's disk shrinks in area as a beam's kernel shrinks in width: r² ~ 1D schedule.
        let area = kernel(0).min_radius / numbers.schedule.radius;
        let radius_on_surfaces = numbers.schedule.radius * area.sqrt();
        let disks = Disks {
            diffuse: DIFFUSE_RADIUS_FACTOR * radius_on_surfaces,
            caustic: CAUSTIC_RADIUS_FACTOR * radius_on_surfaces,
            crowd: by_kind.then(|| crowd(index)),
            within: true,
        };
        let photons = std::mem::take(&mut record.surface);
        times.build = start.elapsed().as_secs_f64();
        let ((mut beams, of_beams), (surfaces, of_photons)) = rayon::join(
            || timed(|| beams.into_iter().enumerate().flat_map(build).collect::<Vec<BeamView>>()),
            || timed(|| SurfaceMap::build(photons, disks)),
        );
        times.build += of_beams + of_photons;
        let start = Instant::now();
        beams.extend(self.next_to_lamps(next_to_lamps, index));
        times.build += start.elapsed().as_secs_f64();

        let starts = self.starts;
        let tracer = EyeTracer {
            scene: self.scene,
            fogs: &self.fogs,
            starts,
            lamps: self.tracer.lamps(),
            surfaces: &surfaces,
            beyond: self.settings.beyond,
            shown: Some(&self.small),
            is_apart: false,
        };
        let view = View {
            scene: self.scene,
            fogs: &self.fogs,
            tracer,
            beams: &beams,
            seed: self.settings.seed,
            pass: index,
            plans,
            straight: self.settings.shadow_rays.then(|| Straight {
                scene: self.scene,
                fogs: &self.fogs,
                lamps: self.tracer.lamps(),
                seed: self.settings.seed,
                pass: index,
                near: Some(self.tracer.near()),
            }),
            wants_rest: self.wants_rest(),
            spectra: (has_spectra && self.settings.first_apart).then(|| self.grids.look_up(0)),
        };
        let (image, cost) = view.image(cancelled)?;
        (times.gather, times.pairs) = (cost.seconds, cost.pairs);
        Some((image, times))
    }

    /// Hierarchies over the beams of each medium, for kernels up to a radius.
    fn maps(&self, beams: Vec<Vec<Beam>>, radius: f32) -> Vec<BeamMap> {
        beams.into_iter().zip(&self.fogs).map(|(beams, fog)| BeamMap::build(beams, radius, fog)).collect()
    }

    /// Straight light next to the lamps; None: no lamp is a point.
    fn next_to_lamps(&self, beams: Vec<Vec<Beam>>, index: u32) -> Option<BeamView<'_>> {
        if beams.iter().all(Vec::is_empty) {
            return None;
        }
        let kernel = self.tracer.near().kernel(self.scene.settings.schedule, index);
        let maps = self.maps(beams, kernel.max_radius);
        let split = self.split.unwrap_or(Split::TOGETHER);
        let (layer, kind) = (split.of(Kind::Straight), Kind::Straight);
        Some(BeamView { layer, maps, kernel, behind: kernel, kind })
    }

    /// Whether eye rays may see fog before the first surface, as far as that is known.
    fn sees_fog_first(&self) -> bool {
        self.settings.first_apart || self.surfaces.as_ref().is_none_or(|surfaces| surfaces.has_fog())
    }

    /// Whether all fog lies behind glass, where no filter thins rays out: wide kernels cost more than they are worth there, and spectra are of no
    /// other use. Radii by a rule are as the rule says.
    fn is_all_behind(&self) -> bool {
        self.radii.is_none() && !self.sees_fog_first()
    }

    /// The kernel of a layer's beams in a pass whose own is `plain`.
    fn kernel<'k>(&'k self, plain: Kernel<'k>, layer: usize) -> Kernel<'k> {
        let wide_enough = plain.max_radius > WORTH_LOOKING_UP * plain.min_radius;
        let is_wide = wide_enough || self.surfaces.is_none() || self.radii.is_some();
        if !is_wide || self.is_all_behind() {
            return Kernel { max_radius: plain.min_radius, ..plain };
        }
        let rule = self.radii.as_ref();
        let by_rule = |radii: &'k Radii| FluenceGrid::new(self.scene.grid, &radii.cells).expect(FITS);
        Kernel { grid: Some(rule.map_or_else(|| self.grids.look_up(layer), by_rule)), ..plain }
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
            let spectra = grids.image(layer, surfaces, &self.fogs);
            let kind = split.filter(|split| split.count() > 1).map(|split| split.last_kind(layer));
            let made = Plan::new(Arc::clone(surfaces), kind, index, error, beams, spectra, cancelled)?;
            Some(if self.is_everywhere { made.everywhere() } else { made })
        };
        (0..split.unwrap_or(Split::TOGETHER).count()).map(plan).collect()
    }

    fn march(&mut self, index: u32, cancelled: &(dyn Fn() -> bool + Sync)) -> Option<(PassImage, PassTimes)> {
        let mut times = PassTimes::default();
        let adaptive = self.settings.marching.placement == Placement::Adaptive;
        if adaptive {
            let count = self.field_photons();
            let mut fields = PhotonRecord::default();
            if latest_field_pass(index) == index {
                (fields, times.light_fields) =
                    self.trace(FIELD_SEQUENCE, index, count, Record::Direct, cancelled)?;
            }
            let start = Instant::now();
            self.update_grid(index, &fields, cancelled)?;
            times.grid = start.elapsed().as_secs_f64();
        }
        let scene = self.scene;
        let key = [self.settings.seed, index];
        let start = Instant::now();
        let error = error_bound(scene.settings.schedule.error, index);
        let plan = if adaptive { self.plans(index, error, 0, cancelled)?.pop() } else { None };
        let guide =
            || Guide::new(scene, self.grids.look_up(0), self.settings.marching.samples, key, cancelled);
        let guide = if adaptive { Some(guide()?) } else { None };
        times.plan = start.elapsed().as_secs_f64();
        let marcher = Marcher {
            scene,
            fogs: &self.fogs,
            starts: self.starts,
            small: &self.small,
            marching: self.settings.marching,
            plan,
            guide: guide.as_ref(),
            key,
            offset: if self.settings.marching.centred {
                [0.5; 2]
            } else {
                pixel_offset(self.settings.seed, index)
            },
            beyond: self.settings.beyond,
            wants_rest: self.wants_rest(),
        };
        let (image, seconds, shadow_rays) = marcher.image(cancelled)?;
        times.shadow_rays = shadow_rays;
        times.gather = seconds;
        Some((image, times))
    }

    fn light_trace(
        &mut self,
        index: u32,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<(PassImage, PassTimes)> {
        let (record, mut seconds) =
            self.trace(CONNECTION_SEQUENCE, index, self.settings.photons, Record::Connections, cancelled)?;
        self.energy = record.energy;
        let (width, height) = (self.scene.camera.width, self.scene.camera.height);
        let mut radiance = vec![Vec3::ZERO; (width * height) as usize];
        for splat in record.splats {
            radiance[splat.pixel as usize] += splat.radiance;
        }
        if self.scene.camera.is_pinhole() && self.scene.shows_surfaces() && !self.scene.shown.is_empty() {
            // Connections start where light has met something.
            let row = |(y, row): (usize, &mut [Vec3])| {
                let add =
                    || row.iter_mut().zip(0..).for_each(|(sum, x)| *sum += self.shown(index, [x, y as u32]));
                (!cancelled()).then(|| timed(add).1)
            };
            seconds += radiance.par_chunks_mut(width as usize).enumerate().map(row).sum::<Option<f64>>()?;
        }
        let times = PassTimes { trace: seconds, ..PassTimes::default() };
        Some((PassImage { pass: index, width, height, radiance, ..PassImage::default() }, times))
    }

    /// Lamps that an eye ray somewhere through a pixel sees straight.
    fn shown(&self, index: u32, corner: [u32; 2]) -> Vec3 {
        let pixel = corner[1] * self.scene.camera.width + corner[0];
        let mut random = Random::new([self.settings.seed, index, pixel, SHOWN_KEY]);
        let start = self.starts.at(corner.map(|corner| corner as f32 + random.uniform()), [0.0; 2]);
        let seen = self.scene.shown.seen(self.scene, &self.small, &self.starts, &start);
        seen.iter().map(|seen| seen.dimmed(self.scene, &self.fogs)).sum()
    }
}

/// The kernel of a layer's focused light.
fn focused(kernel: Kernel<'_>) -> Kernel<'_> {
    let is_plain = kernel.max_radius <= kernel.min_radius;
    let min_radius = FOCUSED_SHARE * kernel.min_radius;
    Kernel { min_radius, max_radius: if is_plain { min_radius } else { kernel.max_radius }, ..kernel }
}

/// The part of a beam up to a distance > 0.
fn first_part(beam: Beam, until: f32) -> Option<Beam> {
    let is_whole = beam.length <= until;
    let part = if is_whole { beam } else { Beam { length: until, end_normal: Vec3::ZERO, ..beam } };
    (until > 0.0).then_some(part)
}

/// How many of passes 1 to `passes` trace light fields.
pub fn field_passes(passes: u32) -> u32 {
    let mut count = 0;
    let mut pass = next_field_pass(0);
    while pass <= passes {
        count += 1;
        pass = next_field_pass(pass);
    }
    count
}

/// The last pass up to `index` whose paths carry light fields; 0 = none.
pub(crate) fn latest_field_pass(index: u32) -> u32 {
    index - index % field_pass_step(index)
}

/// The first pass after `pass` whose paths carry light fields.
fn next_field_pass(pass: u32) -> u32 {
    (pass - pass % field_pass_step(pass)).saturating_add(field_pass_step(pass))
}

/// One pass in so many around this one traces light fields: a power of two.
fn field_pass_step(pass: u32) -> u32 {
    match pass {
        ..FIRST_FIELD_PASSES => 1,
        _ => ((1 << pass.ilog2()) / FIELD_PASSES_A_DOUBLING).max(FIELD_PASS_EVERY),
    }
}

/// Photons that a disk of a caustic holds in pass `index`: their number falls as index^(-1/3), since the squared bias of disks that hold k goes
/// as k² and the variance of the mean over so many passes as 1/(k index).
fn crowd(index: u32) -> usize {
    ((CROWD as f32 / (index as f32).cbrt()).round() as usize).max(FEWEST)
}

/// What `run` returns, and the seconds that it took.
fn timed<T>(run: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = run();
    (result, start.elapsed().as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_with_light_fields_follow_one_another() {
        let mut found = vec![];
        while found.last() < Some(&512) {
            found.push(next_field_pass(*found.last().unwrap_or(&0)));
        }
        let expected = [
            1, 2, 3, 4, 5, 6, 7, 8, 16, 24, 32, 40, 48, 56, 64, 80, 96, 112, 128, 160, 192, 224, 256, 320,
            384, 448, 512,
        ];
        assert_eq!(found, expected);
        assert_eq!(latest_field_pass(u32::MAX), 7 << 29);
        for passes in 0..=512 {
            let seen: Vec<u32> = found.iter().copied().filter(|pass| *pass <= passes).collect();
            assert_eq!(latest_field_pass(passes), seen.last().copied().unwrap_or(0));
            assert_eq!(field_passes(passes), seen.len() as u32);
        }
    }
}
