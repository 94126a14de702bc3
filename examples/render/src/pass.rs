//! Renders one pass: light paths, covariance grid, beams, eye rays.

use crate::eye::EyeTracer;
use crate::grids::Grids;
use crate::guidance::{self, Guidance, Spread};
use crate::kind::{Kind, Split};
use crate::march::{Guide, Marcher, Marching, Placement};
use crate::media;
use crate::operators::Operator;
use crate::photon::{Energy, PathBeam, PhotonRecord, PhotonTracer, Record};
use crate::plan::{FirstSurfaces, Plan};
use crate::radius::{BeamVoxels, Radii, RadiusRule};
use crate::random::{Emission, Random};
use crate::samples::PassImage;
use crate::scene::Scene;
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

/// How the picture is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Plain progressive photon beams.
    Ppb,
    /// The thesis: the kernel is as wide as the covariance allows.
    Adaptive,
    /// Unbiased connections of every path segment and diffuse vertex with the camera; blind to what is seen through glass. For pinholes
    /// ([`crate::camera::Camera::is_pinhole`]): pictures of other cameras are black.
    LightTrace,
    /// Light scattered once, by shadow rays from places along the eye rays.
    March,
}

/// The parts of [`Renderer::light_by_kind`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts {
    /// Straight light from shadow rays.
    pub straight: bool,
    /// Light paths that go where the picture needs them.
    pub guided: bool,
    /// Spectra, eye rays and filters of its own for straight light.
    pub apart: bool,
}

impl Parts {
    /// What a render gets. A layer of its own for straight light costs a tenth of a pass, and has .7 to 1.3 times the error.
    pub const DEFAULT: Self = Self { straight: true, guided: true, apart: false };
}

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
    method: Method,
    photons: u32,
    seed: u32,
    tracer: PhotonTracer<'a>,
    fogs: Vec<Medium<'a>>,
    starts: EyeStarts<'a>,
    small: SmallLamps,
    marching: Marching,
    surfaces: Option<Arc<FirstSurfaces>>,
    /// None: [`RadiusRule::Bias`].
    radii: Option<Radii>,
    grids: Grids,
    energy: Energy,
    /// Whether straight light comes from shadow rays.
    has_shadow_rays: bool,
    /// Some: kinds of light are told apart, in these layers.
    split: Option<Split>,
    /// What the branches of guided paths are decided by.
    spread: Option<Spread>,
    /// Core-seconds of the pilot, not yet said.
    pilot: f64,
    /// Whether anything is wanted from the first surface on.
    beyond: bool,
    /// Whether the fog before the first surface is kept apart where no eye rays need planning.
    is_first_apart: bool,
    /// Whether each pass looks through all pixels.
    is_everywhere: bool,
}

impl<'a> Renderer<'a> {
    /// `photons` = light paths a pass.
    pub fn new(scene: &'a Scene, method: Method, photons: u32, seed: u32) -> Self {
        Self::with_emission(scene, method, photons, seed, Emission::LowDiscrepancy)
    }

    /// Like [`Renderer::new`] with a choice of how light paths are drawn.
    pub fn with_emission(
        scene: &'a Scene,
        method: Method,
        photons: u32,
        seed: u32,
        emission: Emission,
    ) -> Self {
        let has_grid = matches!(method, Method::Adaptive | Method::March);
        let layout = if has_grid { scene.grid } else { NO_GRID };
        Self {
            scene,
            method,
            photons,
            seed,
            tracer: PhotonTracer::new(scene, seed, emission),
            fogs: media::all(scene),
            starts: EyeStarts::new(scene),
            small: SmallLamps::new(scene),
            marching: Marching::default(),
            surfaces: None,
            radii: None,
            grids: Grids::new(layout, Split::TOGETHER),
            energy: Energy::default(),
            has_shadow_rays: false,
            split: None,
            spread: None,
            pilot: 0.0,
            beyond: true,
            is_first_apart: false,
            is_everywhere: false,
        }
    }

    /// Leaves an operator out of all light fields, to see what it buys. For the first pass to see it, call it before.
    pub fn leave_out(&mut self, operator: Operator) {
        self.tracer.leave_out(operator);
    }

    /// From now on traces few eye rays where the covariance grid says that the picture is smooth, with filters between them (thesis
    /// 5.3.2), and looks kernel radii up only in passes where spectra may make them three times as wide as the pass' own; layer σ is 0 in the
    /// others. Call it before the first pass. Methods without a grid, and scenes without fog before the first surface that is more than a bound of
    /// fog, go on with an eye ray through every pixel.
    pub fn plan_eye_rays(&mut self) {
        self.plan_by(FirstSurfaces::new(self.scene, &|| false).expect("never cancelled"));
    }

    /// The same, with what is first behind each pixel of this scene as it was found before.
    pub fn plan_by(&mut self, surfaces: impl Into<Arc<FirstSurfaces>>) {
        self.surfaces = Some(surfaces.into());
    }

    /// From now on passes with planned eye rays keep the fog before the first surface apart always: where no pixel's middle sees any, with an eye
    /// ray through each pixel; and tell its layer σ where kernels look nothing up, too. Call it before the first pass.
    pub fn keep_first_apart(&mut self) {
        self.is_first_apart = true;
    }

    /// From now on leaves out all light from the first surface on that is more than a bound of fog; what the fog before it sends out stays. Call it before the first pass.
    pub fn leave_out_beyond(&mut self) {
        self.beyond = false;
    }

    /// From now on each kind of light comes from what is best for it: light straight from the lamps from shadow rays, but for media of voxels;
    /// all other light from light paths that go where the picture needs them, after a pilot
    /// that depends on scene and seed alone. Call it before the first pass. For the method adaptive.
    pub fn light_by_kind(&mut self) {
        self.light_by_parts(Parts::DEFAULT);
    }

    /// The same with some parts only, to see what each buys.
    pub fn light_by_parts(&mut self, parts: Parts) {
        Self::light_instants_by_parts(std::slice::from_mut(self), parts, &|| false).expect("never cancelled");
    }

    /// The same of renderers of one scene at several instants while a shutter is open, all with the same grid: with one pilot for all of them.
    /// The first has their light fields; see [`Renderer::go_on_from`].
    ///
    /// `cancelled` is polled all the time, and says yes for good once it did; None = it has, and the renderers are of no use.
    pub fn light_instants_by_parts(
        instants: &mut [Self],
        parts: Parts,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<()> {
        let start = Instant::now();
        if parts.guided {
            let scenes: Vec<_> =
                instants.iter().map(|at| guidance::Instant { scene: at.scene, fogs: &at.fogs }).collect();
            let found = Guidance::of(&scenes, cancelled);
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
        if cancelled() {
            return None;
        }
        let split = if parts.apart { Split::STRAIGHT_APART } else { Split::TOGETHER };
        for made in &mut *instants {
            made.has_shadow_rays = parts.straight;
            made.split = Some(split);
            made.give_up_fields();
        }
        if let Some(first) = instants.first_mut() {
            first.split_into(split);
            first.pilot = start.elapsed().as_secs_f64();
        }
        Some(())
    }

    fn decide_branches(&mut self) {
        if let Some(spread) = &self.spread {
            self.tracer.scale_branches(spread.share_of_branches(self.photons, &self.scene.camera));
        }
    }

    /// Starts anew with so many light paths a pass: from now on it is as one that was made with them, and has nothing to look at again.
    pub fn restart(&mut self, photons: u32) {
        self.photons = photons;
        self.grids.clear();
        self.energy = Energy::default();
        self.decide_branches();
    }

    /// From now on passes with planned eye rays look through all pixels for the fog, for pictures of a scene that moves: of few passes a pixel
    /// would see some instants only, others than the pixels around. Call it before the first pass.
    pub fn look_everywhere(&mut self) {
        self.is_everywhere = true;
    }

    /// Goes on from the light fields of another renderer, which has none then: one of the same scene at another instant, with the same grid. In
    /// spectra that are the mean over the instants all of them may have a part, and the pictures of all be filtered as one.
    pub fn go_on_from(&mut self, other: &mut Self) {
        std::mem::swap(&mut self.grids, &mut other.grids);
        other.give_up_fields();
    }

    /// Gives the memory of the light fields up, for those of another renderer: [`Renderer::go_on_from`].
    pub fn give_up_fields(&mut self) {
        self.grids = Grids::new(NO_GRID, Split::TOGETHER);
    }

    /// From now on each kind of light that the scene can have has spectra, eye rays and filters of its own, for a film that keeps them apart.
    /// Call it before the first pass, after [`Renderer::light_by_kind`].
    pub fn keep_kinds(&mut self) -> Split {
        let split = Split::of_each_kind(self.scene);
        self.split_into(split);
        split
    }

    /// Whether eye rays are asked for more than the light that the fog before the first surface scatters.
    fn wants_rest(&self) -> bool {
        self.beyond || self.scene.glows()
    }

    fn split_into(&mut self, split: Split) {
        self.grids = Grids::new(self.scene.grid, split);
        self.split = Some(split);
    }

    /// What the adaptive method's kernel radii come from; other methods go on as they are. Call it before the first pass.
    ///
    /// With a rule other than [`RadiusRule::Bias`] the layer σ of the picture is the one that gives the same radii by that rule. Asked for
    /// out of order, a pass traces all light paths of the earlier ones that it has not seen.
    pub fn widen_by(&mut self, rule: RadiusRule) {
        self.radii = (rule != RadiusRule::Bias).then(|| Radii::new(rule, self.scene.grid));
    }

    /// How the method `march` chooses places. Call it before the first pass.
    pub fn march_as(&mut self, marching: Marching) {
        self.marching = marching;
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
        match self.method {
            Method::LightTrace => self.light_trace(index, cancelled),
            Method::March => self.march(index, cancelled),
            Method::Ppb | Method::Adaptive => self.beams(index, cancelled),
        }
    }

    /// How many of a pass' paths carry a light field.
    fn field_photons(&self) -> u32 {
        ((self.photons as f32 * self.scene.settings.light_field_share).round() as u32).clamp(1, self.photons)
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
                    self.tracer.trace(sequence, first.wrapping_add(i), self.photons, record, &mut out);
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
            let sequences = [(PLAIN_SEQUENCE, self.photons - fields), (FIELD_SEQUENCE, fields)];
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
        let record = if self.method == Method::March { Record::Direct } else { Record::Field };
        let (record, _) = self.trace(FIELD_SEQUENCE, next, count, record, cancelled)?;
        self.grids.deposit(next, &self.tracer, &record.deposits);
        Some(())
    }

    /// The next pass up to `passes` whose light fields are not in the grids yet; None: they are all there, or the method has none.
    pub fn next_fields(&self, passes: u32) -> Option<u32> {
        let has_fields = matches!(self.method, Method::Adaptive | Method::March);
        (has_fields && self.grids.deposited() < latest_field_pass(passes))
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
        let settings = self.scene.settings;
        let adaptive = self.method == Method::Adaptive;
        let counts_only = self.radii.as_ref().is_some_and(|radii| radii.rule == RadiusRule::BeamDensity);
        // Planning needs spectra whatever the radii come from.
        let has_spectra = adaptive && (!counts_only || self.surfaces.is_some()) && !self.is_all_behind();

        let field_photons = self.field_photons();
        let has_fields = has_spectra && latest_field_pass(index) == index;
        let field_record = if has_fields { Record::BeamsAndField } else { Record::Beams };
        let (fields, seconds) = self.trace(FIELD_SEQUENCE, index, field_photons, field_record, cancelled)?;
        times.light_fields = fields.field_time.as_secs_f64();
        times.trace = seconds - times.light_fields;
        let plain_photons = self.photons - field_photons;
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
        let kernel = settings.schedule.kernel(index, None);
        let start = Instant::now();
        let plans = match has_spectra {
            true => self.plans(index, kernel.error, self.photons, cancelled)?,
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
            let is_marched = self.has_shadow_rays && kind == Kind::Straight;
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
        let area = kernel(0).min_radius / settings.schedule.radius;
        let radius_on_surfaces = settings.schedule.radius * area.sqrt();
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
            beyond: self.beyond,
            shown: Some(&self.small),
            is_apart: false,
        };
        let view = View {
            scene: self.scene,
            fogs: &self.fogs,
            tracer,
            beams: &beams,
            seed: self.seed,
            pass: index,
            plans,
            straight: self.has_shadow_rays.then(|| Straight {
                scene: self.scene,
                fogs: &self.fogs,
                lamps: self.tracer.lamps(),
                seed: self.seed,
                pass: index,
                near: Some(self.tracer.near()),
            }),
            wants_rest: self.wants_rest(),
            spectra: (has_spectra && self.is_first_apart).then(|| self.grids.look_up(0)),
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
        self.is_first_apart || self.surfaces.as_ref().is_none_or(|surfaces| surfaces.has_fog())
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
        let adaptive = self.marching.placement == Placement::Adaptive;
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
        let key = [self.seed, index];
        let start = Instant::now();
        let error = error_bound(scene.settings.schedule.error, index);
        let plan = if adaptive { self.plans(index, error, 0, cancelled)?.pop() } else { None };
        let guide = || Guide::new(scene, self.grids.look_up(0), self.marching.samples, key, cancelled);
        let guide = if adaptive { Some(guide()?) } else { None };
        times.plan = start.elapsed().as_secs_f64();
        let marcher = Marcher {
            scene,
            fogs: &self.fogs,
            starts: self.starts,
            small: &self.small,
            marching: self.marching,
            plan,
            guide: guide.as_ref(),
            key,
            offset: if self.marching.centred { [0.5; 2] } else { pixel_offset(self.seed, index) },
            beyond: self.beyond,
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
            self.trace(CONNECTION_SEQUENCE, index, self.photons, Record::Connections, cancelled)?;
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
        let mut random = Random::new([self.seed, index, pixel, SHOWN_KEY]);
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
