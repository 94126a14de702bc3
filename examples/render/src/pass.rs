//! Renders one pass: light paths, covariance grid, beams, eye rays.

use crate::eye::{EyeSegment, EyeTracer};
use crate::film::PassImage;
use crate::fog::Fog;
use crate::operators::Operator;
use crate::optics::Interior;
use crate::photon::{Energy, PhotonRecord, PhotonTracer, Record};
use crate::random::{Emission, Random};
use crate::scene::Scene;
use crate::surface::SurfaceMap;
use covbeam::{
    BeamMap, CovarianceGrid, FluenceCell, FluenceGrid, GatherScratch, Gathered, GridCell, KernelRadius,
    error_bound, progressive_radius,
};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::AddAssign;
use std::time::Instant;

/// Pixels along the side of a tile, whose eye rays are gathered together.
const TILE: u32 = 8;

/// Light paths that one task traces.
const CHUNK: u32 = 64;

/// Sequences of light paths: without a light field, with one, for connections.
const PLAIN_SEQUENCE: u32 = 0;
const FIELD_SEQUENCE: u32 = 1;
const CONNECTION_SEQUENCE: u32 = 2;

/// Kernel radii of surface photons in beam radii: of caustics, and of light that arrives after scattering, which is smooth.
const CAUSTIC_RADIUS_FACTOR: f32 = 2.0;
const DIFFUSE_RADIUS_FACTOR: f32 = 10.0;

/// How the picture is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Plain progressive photon beams.
    Ppb,
    /// The thesis: the kernel is as wide as the covariance allows.
    Adaptive,
    /// Unbiased connections of every path segment and diffuse vertex with the camera; blind to what is seen through glass.
    LightTrace,
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
    /// Eye rays, gather and shading.
    pub gather: f64,
    /// Accepted beam-ray pairs.
    pub pairs: u64,
}

impl PassTimes {
    /// Core-seconds of all parts.
    pub fn total(&self) -> f64 {
        self.trace + self.light_fields + self.grid + self.build + self.gather
    }
}

impl AddAssign for PassTimes {
    fn add_assign(&mut self, other: Self) {
        self.trace += other.trace;
        self.light_fields += other.light_fields;
        self.grid += other.grid;
        self.build += other.build;
        self.gather += other.gather;
        self.pairs += other.pairs;
    }
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
    fogs: Vec<Fog<'a>>,
    camera: Interior,
    grid: Vec<GridCell>,
    deposited: u32,
    resolved: Vec<FluenceCell>,
    energy: Energy,
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
        let cells = if method == Method::Adaptive { scene.grid.cell_count() } else { 0 };
        Self {
            scene,
            method,
            photons,
            seed,
            tracer: PhotonTracer::new(scene, seed, emission),
            fogs: Fog::all(scene),
            camera: Interior::at(scene, scene.camera.position),
            grid: vec![GridCell::default(); cells],
            deposited: 0,
            resolved: vec![FluenceCell::default(); cells],
            energy: Energy::default(),
        }
    }

    /// Leaves an operator out of all light fields, to see what it buys. For the first pass to see it, call it before.
    pub fn leave_out(&mut self, operator: Operator) {
        self.tracer.leave_out(operator);
    }

    /// Where the power of the latest pass' light paths went.
    pub fn energy(&self) -> Energy {
        self.energy
    }

    /// Pass `index`, counted from 1. `cancelled` is polled a few hundred times a pass; None = it said yes.
    ///
    /// The adaptive method's pass i uses the light fields of passes 1 to i. Asked for out of order, it traces those
    /// of the earlier passes that it has not seen.
    pub fn pass(
        &mut self,
        index: u32,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<(PassImage, PassTimes)> {
        match self.method {
            Method::LightTrace => self.light_trace(index, cancelled),
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
                if cancelled() {
                    return None;
                }
                let start = Instant::now();
                let mut out = PhotonRecord::default();
                for i in chunk * CHUNK..((chunk + 1) * CHUNK).min(count) {
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

    /// Adds a pass' light fields to the grid.
    fn deposit(&mut self, record: &PhotonRecord) {
        let mut grid =
            CovarianceGrid::new(self.scene.grid, &mut self.grid).expect("the scene's grid was validated");
        self.tracer.deposit_into(&mut grid, &record.deposits);
        self.deposited += 1;
    }

    /// Brings the grid to the state after pass `index`, whose own light fields are in `record`.
    fn update_grid(
        &mut self,
        index: u32,
        record: &PhotonRecord,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<()> {
        if self.deposited >= index {
            self.grid.fill(GridCell::default());
            self.deposited = 0;
        }
        while self.deposited + 1 < index {
            self.add_light_fields(cancelled)?;
        }
        self.deposit(record);
        self.resolve();
        Some(())
    }

    /// Traces and deposits the light fields of the next pass alone.
    fn add_light_fields(&mut self, cancelled: &(dyn Fn() -> bool + Sync)) -> Option<()> {
        let (next, count) = (self.deposited + 1, self.field_photons());
        let (record, _) = self.trace(FIELD_SEQUENCE, next, count, Record::Field, cancelled)?;
        self.deposit(&record);
        Some(())
    }

    fn resolve(&mut self) {
        let grid =
            CovarianceGrid::new(self.scene.grid, &mut self.grid).expect("the scene's grid was validated");
        grid.resolve(&mut self.resolved).expect("as many cells as the grid has");
    }

    /// The spectra that the adaptive method looks up in pass `passes`, without rendering. `report` is called with the number
    /// of light paths of each pass done; it answers false to give up, and then None is returned.
    pub fn spectra(mut self, passes: u32, report: &dyn Fn(u32) -> bool) -> Option<Vec<FluenceCell>> {
        while self.deposited < passes {
            self.add_light_fields(&|| false)?;
            if !report(self.field_photons()) {
                return None;
            }
        }
        self.resolve();
        Some(self.resolved)
    }

    fn beams(&mut self, index: u32, cancelled: &(dyn Fn() -> bool + Sync)) -> Option<(PassImage, PassTimes)> {
        let mut times = PassTimes::default();
        let settings = self.scene.settings;
        let adaptive = self.method == Method::Adaptive;

        let field_photons = self.field_photons();
        let field_record = if adaptive { Record::BeamsAndField } else { Record::Beams };
        let (fields, seconds) = self.trace(FIELD_SEQUENCE, index, field_photons, field_record, cancelled)?;
        times.light_fields = fields.field_time.as_secs_f64();
        times.trace = seconds - times.light_fields;
        let plain_photons = self.photons - field_photons;
        let (mut record, seconds) =
            self.trace(PLAIN_SEQUENCE, index, plain_photons, Record::Beams, cancelled)?;
        times.trace += seconds;

        if adaptive {
            let start = Instant::now();
            self.update_grid(index, &fields, cancelled)?;
            times.grid = start.elapsed().as_secs_f64();
        }

        let start = Instant::now();
        record.append(fields);
        self.energy = record.energy;
        let progressive = progressive_radius(settings.radius, settings.alpha, index);
        let radius = KernelRadius {
            kernel: settings.kernel,
            progressive,
            ceiling: if adaptive { settings.max_radius.max(progressive) } else { progressive },
            error: error_bound(settings.error, index),
            grid: adaptive.then(|| {
                FluenceGrid::new(self.scene.grid, &self.resolved).expect("as many cells as the grid has")
            }),
        };
        let mut by_medium = vec![Vec::new(); self.scene.media.len()];
        for (medium, beam) in record.beams.drain(..) {
            by_medium[medium as usize].push(beam);
        }
        let maps: Vec<BeamMap> = by_medium
            .into_iter()
            .zip(&self.fogs)
            .map(|(beams, fog)| BeamMap::build(beams, radius.ceiling, fog.medium, &fog.density))
            .collect();
        // A photon's disk shrinks in area as a beam's kernel shrinks in width: r² ~ 1D schedule.
        let shrink = (progressive / settings.radius).sqrt();
        let radius_on_surfaces = settings.radius * shrink;
        let surfaces = SurfaceMap::build(
            std::mem::take(&mut record.surface),
            DIFFUSE_RADIUS_FACTOR * radius_on_surfaces,
            CAUSTIC_RADIUS_FACTOR * radius_on_surfaces,
        );
        times.build = start.elapsed().as_secs_f64();

        let image = self.gather(index, &maps, &surfaces, &radius, cancelled, &mut times)?;
        Some((image, times))
    }

    fn gather(
        &self,
        index: u32,
        maps: &[BeamMap],
        surfaces: &SurfaceMap,
        radius: &KernelRadius,
        cancelled: &(dyn Fn() -> bool + Sync),
        times: &mut PassTimes,
    ) -> Option<PassImage> {
        let (width, height) = (self.scene.camera.width, self.scene.camera.height);
        let (across, down) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let tracer = EyeTracer { scene: self.scene, fogs: &self.fogs, interior: self.camera, surfaces };
        let tiles: Option<Vec<Tile>> = (0..across * down)
            .into_par_iter()
            .map_init(TileScratch::default, |scratch, tile| {
                if cancelled() {
                    return None;
                }
                let (x0, y0) = (tile % across * TILE, tile / across * TILE);
                let (x1, y1) = ((x0 + TILE).min(width), (y0 + TILE).min(height));
                Some(self.gather_tile(index, [x0, y0, x1, y1], &tracer, maps, radius, scratch))
            })
            .collect();
        let pixels = (width * height) as usize;
        let mut image =
            PassImage { width, height, radiance: vec![Vec3::ZERO; pixels], gather: vec![[0.0; 4]; pixels] };
        for (tile, result) in tiles?.into_iter().enumerate() {
            let tile = tile as u32;
            let (x0, y0) = (tile % across * TILE, tile / across * TILE);
            let columns = TILE.min(width - x0);
            times.gather += result.seconds;
            times.pairs += result.pairs;
            for (i, (radiance, gather)) in result.pixels.into_iter().enumerate() {
                let (x, y) = (x0 + i as u32 % columns, y0 + i as u32 / columns);
                let pixel = (y * width + x) as usize;
                image.radiance[pixel] = radiance;
                image.gather[pixel] = gather;
            }
        }
        Some(image)
    }

    fn gather_tile(
        &self,
        index: u32,
        [x0, y0, x1, y1]: [u32; 4],
        tracer: &EyeTracer,
        maps: &[BeamMap],
        radius: &KernelRadius,
        scratch: &mut TileScratch,
    ) -> Tile {
        let start = Instant::now();
        let camera = &self.scene.camera;
        let [jx, jy] = pixel_offset(self.seed, index);
        let mut pixels = Vec::with_capacity((TILE * TILE) as usize);
        let TileScratch { segments, rays, gathered, gather } = scratch;
        segments.clear();
        for y in y0..y1 {
            for x in x0..x1 {
                let direction = camera.direction(x as f32 + jx, y as f32 + jy);
                let mut random = Random::new([self.seed, index, y * camera.width + x, 0xe7e]);
                let surface = tracer.trace(direction, pixels.len() as u32, &mut random, segments);
                pixels.push((surface, [0.0; 4]));
            }
        }
        // Paths that met the same surfaces run side by side.
        segments.sort_by_key(|segment| (segment.medium, segment.signature));
        let mut pairs = 0;
        for group in segments.chunk_by(|a, b| (a.medium, a.signature) == (b.medium, b.signature)) {
            let medium = group[0].medium as usize;
            rays.clear();
            rays.extend(group.iter().map(|segment| segment.ray));
            gathered.clear();
            gathered.resize(group.len(), Gathered::default());
            let fog = &self.fogs[medium];
            maps[medium].gather(rays, fog.medium, &fog.density, radius, gathered, gather);
            for (segment, gathered) in group.iter().zip(gathered.iter()) {
                let (radiance, sums) = &mut pixels[segment.pixel as usize];
                *radiance += segment.throughput * gathered.radiance;
                let seen = segment.throughput.element_sum() / 3.0;
                let add = [
                    seen * gathered.weight,
                    seen * gathered.radius,
                    seen * gathered.sigma,
                    gathered.pairs as f32,
                ];
                for (sum, add) in sums.iter_mut().zip(add) {
                    *sum += add;
                }
                pairs += u64::from(gathered.pairs);
            }
        }
        Tile { pixels, pairs, seconds: start.elapsed().as_secs_f64() }
    }

    fn light_trace(
        &mut self,
        index: u32,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<(PassImage, PassTimes)> {
        let (record, seconds) =
            self.trace(CONNECTION_SEQUENCE, index, self.photons, Record::Connections, cancelled)?;
        self.energy = record.energy;
        let (width, height) = (self.scene.camera.width, self.scene.camera.height);
        let mut radiance = vec![Vec3::ZERO; (width * height) as usize];
        for splat in record.splats {
            radiance[splat.pixel as usize] += splat.radiance;
        }
        let times = PassTimes { trace: seconds, ..PassTimes::default() };
        Some((PassImage { width, height, radiance, gather: Vec::new() }, times))
    }
}

/// What a tile's eye rays saw.
struct Tile {
    pixels: Vec<(Vec3, [f32; 4])>,
    pairs: u64,
    seconds: f64,
}

/// Buffers that a thread keeps from tile to tile.
#[derive(Default)]
struct TileScratch {
    segments: Vec<EyeSegment>,
    rays: Vec<covbeam::EyeRay>,
    gathered: Vec<Gathered>,
    gather: GatherScratch,
}

/// Where in the pixel the eye rays of a pass start: Roberts' R2 sequence, which fills the pixel evenly over the passes.
fn pixel_offset(seed: u32, index: u32) -> [f32; 2] {
    let mut random = Random::new([seed, 0, 0, 0xca3e7a]);
    let turn = |start: f32, step: f64| (f64::from(start) + step * f64::from(index)).fract() as f32;
    [turn(random.uniform(), 0.754_877_666_246_692_7), turn(random.uniform(), 0.569_840_290_998_053_2)]
        .map(|offset| offset.min(1.0 - f32::EPSILON))
}
