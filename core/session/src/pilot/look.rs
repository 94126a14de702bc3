//! A coarse picture, of all instants while a shutter is open.

use super::instant::{Instant, Poll};
use super::trial;
use crate::color::luminance;
use crate::eye::EyeTracer;
use crate::eye::segment::EyeSegment;
use crate::eye::starts::{EyeStart, EyeStarts};
use crate::eye::straight::{Straight, rays_of_piece, rays_of_surface};
use crate::kind::{ByKind, Kind};
use crate::paths::{PhotonRecord, PhotonTracer, Record};
use crate::random::{Emission, Random};
use crate::scene::Scene;
use crate::surface::{Disks, SurfaceMap};
use covbeam::{Beam, BeamMap, GatherScratch, Gathered, Kernel, Knot, Medium};
use glam::Vec3;
use rayon::prelude::*;

/// Eye rays across and down.
pub(super) const LATTICE: u32 = 32;

/// Light paths of all instants, and of one at least.
const PATHS: u32 = 4096;
const LEAST_PATHS: u32 = 1024;

/// Kernels are as many times as wide as those of the first pass, and disks of surface photons as many times wider.
const WIDER: f32 = 2.0;
const DISKS: [f32; 2] = [20.0, 8.0];

/// A pixel's brightness is taken for at least this share of that of the nine around it: the coarse picture is noisy.
const LEAST_OF_NEIGHBOURS: f32 = 0.3;

/// And for at least this share of the picture's: what is darker is as good as black.
pub(super) const LEAST_OF_PICTURE: f32 = 0.01;

/// Purpose of random numbers, and sequence of light paths.
const KEY: u32 = 0x100c;

/// An eye ray of the coarse picture.
pub(super) struct Pixel {
    /// Index of the instant that it sees.
    pub(super) instant: usize,
    pub(super) start: EyeStart,
    /// 1/(pixels x luminance).
    pub(super) weight: f32,
}

/// The coarse picture's eye rays, as many of each instant; None if it is black.
pub(super) fn pixels(instants: &[Instant], cancelled: Poll) -> Option<Vec<Pixel>> {
    let tracers: Vec<PhotonTracer> =
        instants.iter().map(|at| PhotonTracer::new(at.scene, 0, Emission::LowDiscrepancy)).collect();
    let paths = (PATHS / instants.len() as u32).max(LEAST_PATHS);
    let both = tracers.iter().zip(instants);
    let looks: Vec<Look> =
        both.map(|(tracer, at)| Look::new(tracer, at.fogs, [KEY, paths], 1, cancelled)).collect();
    let seen: Vec<Seen> = (0..LATTICE * LATTICE)
        .into_par_iter()
        .map_init(Memory::default, |memory, node| {
            let (x, y) = (node % LATTICE, node / LATTICE);
            // Of eight there are all in each row and column, far from others of their own.
            let instant = (x + 3 * y) as usize % instants.len();
            let look = &looks[instant];
            let mut random = Random::new([0, node, 0, KEY]);
            let place = [random.uniform(), random.uniform()];
            let camera = &look.scene.camera;
            let at =
                |index: u32, place: f32, count: u32| (index as f32 + place) / LATTICE as f32 * count as f32;
            let point = [at(x, place[0], camera.width), at(y, place[1], camera.height)];
            let start = look.starts.anywhere(point, &mut random);
            if cancelled() {
                return Seen { instant, start, luminance: 0.0 };
            }
            let radiance = look.radiance(&start, node, &mut random, memory);
            Seen { instant, start, luminance: luminance(radiance.iter().sum()) }
        })
        .collect();
    weigh(&seen)
}

/// What an eye ray of the coarse picture sees.
struct Seen {
    instant: usize,
    start: EyeStart,
    luminance: f32,
}

/// Some light paths, and what eye rays see of them.
pub(super) struct Look<'a> {
    pub(super) scene: &'a Scene,
    fogs: &'a [Medium<'a>],
    maps: Vec<BeamMap>,
    /// In the maps.
    pub(super) beams: usize,
    /// What each guided path brings about; of plain paths nothing is known yet.
    pub(super) worth: Vec<f32>,
    kernel: Kernel<'static>,
    surfaces: SurfaceMap,
    straight: Straight<'a>,
    /// Where eye rays start.
    pub(super) starts: EyeStarts<'a>,
}

/// A thread's, from ray to ray.
#[derive(Default)]
pub(super) struct Memory {
    scratch: GatherScratch,
    knots: Vec<Knot>,
    segments: Vec<EyeSegment>,
    /// Pairs with beams, of all rays since it was last set.
    pub(super) pairs: u32,
    /// Shadow rays that straight light takes in a pass, of all rays since it was last set, or what costs as much.
    pub(super) shadow_rays: u32,
}

impl<'a> Look<'a> {
    /// Traces `paths` light paths of a sequence; `pass`: straight light's numbers.
    pub(super) fn new(
        tracer: &'a PhotonTracer<'a>,
        fogs: &'a [Medium<'a>],
        [sequence, paths]: [u32; 2],
        pass: u32,
        cancelled: Poll,
    ) -> Self {
        let scene = tracer.scene();
        let (mut record, mut worth) = (PhotonRecord::default(), Vec::new());
        for index in (0..paths).take_while(|_| !cancelled()) {
            let before = [record.beams.len(), record.surface.len()];
            tracer.trace(sequence, index, paths, Record::Beams, &mut record);
            let of_path = |guidance| trial::worth(guidance, fogs, &record, before);
            worth.extend(tracer.guidance().map(of_path));
        }
        let radius = WIDER * scene.settings.schedule.radius;
        let mut beams: Vec<Vec<Beam>> = vec![Vec::new(); fogs.len()];
        for found in record.beams {
            if trial::is_gathered(&found) {
                beams[found.medium as usize].push(found.beam);
            }
        }
        let count = beams.iter().map(Vec::len).sum();
        let build = |(beams, fog)| BeamMap::build(beams, radius, fog);
        let maps = beams.into_iter().zip(fogs).map(build).collect();
        let [diffuse, caustic] = DISKS.map(|factor| factor * scene.settings.schedule.radius);
        // A pilot asks where noise is, not how bright borders are.
        let disks = Disks { diffuse, caustic, crowd: None, within: false };
        let surfaces = SurfaceMap::build(record.surface, disks);
        let (min_radius, max_radius) = (radius, radius);
        let shape = scene.settings.schedule.shape;
        let kernel = Kernel { shape, min_radius, max_radius, error: 1.0, grid: None };
        let straight = Straight { scene, fogs, lamps: tracer.lamps(), seed: 0, pass, near: None };
        let starts = EyeStarts::new(scene);
        Self { scene, fogs, maps, beams: count, worth, kernel, surfaces, straight, starts }
    }

    /// What an eye ray sees; of light in media, all that is not straight counts as scattered.
    ///
    /// - `number`: of the ray, for its random numbers.
    pub(super) fn radiance(
        &self,
        start: &EyeStart,
        number: u32,
        random: &mut Random,
        memory: &mut Memory,
    ) -> ByKind {
        let Self { scene, fogs, starts, ref surfaces, .. } = *self;
        let lamps = self.straight.lamps;
        // Lamps have no noise that paths could be spent on, and what is dark beside them counts as much as ever.
        let eye =
            EyeTracer { scene, fogs, starts, lamps, surfaces, beyond: true, shown: None, is_apart: false };
        memory.segments.clear();
        let mut radiance = eye.trace(start, number, random, &mut memory.segments);
        if radiance[Kind::Straight as usize] != Vec3::ZERO {
            memory.shadow_rays += rays_of_surface(lamps);
        }
        for segment in &memory.segments {
            let mut gathered = [Gathered::default()];
            let medium = segment.medium as usize;
            self.maps[medium]
                .gather(&self.fogs[medium], &[segment.ray], &self.kernel, &mut gathered, &mut memory.scratch)
                .expect("its map was built in it");
            memory.pairs += gathered[0].pairs;
            memory.shadow_rays += rays_of_piece(scene, segment);
            let straight = self.straight.radiance(segment, number, 1.0, (0, 1), &mut memory.knots);
            radiance[Kind::Straight as usize] += segment.throughput * straight;
            radiance[Kind::Scattered as usize] += segment.throughput * gathered[0].radiance;
        }
        radiance
    }
}

fn weigh(seen: &[Seen]) -> Option<Vec<Pixel>> {
    let count = seen.len() as f32;
    let mean = seen.iter().map(|ray| ray.luminance).sum::<f32>() / count;
    if !(mean > 0.0 && mean.is_finite()) {
        return None;
    }
    let around = |node: u32| {
        let (x, y) = (node % LATTICE, node / LATTICE);
        let near = |at: u32| at.saturating_sub(1)..=(at + 1).min(LATTICE - 1);
        let nodes = near(y).flat_map(|y| near(x).map(move |x| (y * LATTICE + x) as usize));
        let (sum, count) =
            nodes.fold((0.0, 0.0), |(sum, count), node| (sum + seen[node].luminance, count + 1.0_f32));
        sum / count
    };
    let pixels = seen.iter().zip(0..).map(|(&Seen { instant, start, luminance }, node)| {
        let least = (LEAST_OF_NEIGHBOURS * around(node)).max(LEAST_OF_PICTURE * mean);
        Pixel { instant, start, weight: 1.0 / (count * luminance.max(least)) }
    });
    Some(pixels.collect())
}
