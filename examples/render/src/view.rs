//! The eye rays of one pass: through which pixels, and what they see.

use crate::eye::{EyeSegment, EyeTracer};
use crate::kind::{Kind, MOST_LAYERS};
use crate::plan::Plan;
use crate::random::{Random, spread};
use crate::samples::{PassImage, Room, Seen, SparseSample};
use crate::scene::Scene;
use crate::straight::Straight;
use crate::surface::SurfaceMap;
use covbeam::{BeamMap, EyeRay, GatherScratch, Gathered, Kernel, Medium};
use rayon::prelude::*;
use std::sync::Mutex;
use std::time::Instant;

/// Pixels along the side of a tile, whose eye rays are gathered together.
const TILE: u32 = 32;

/// Beams around pieces of eye paths of which less than this reaches the camera are not gathered each time: such a piece costs as much as
/// any other. Of a piece with share t they are with probability (t / FAINT)², which adds as much variance as one with this share has.
const FAINT: f32 = 0.1;
const LEAST: f32 = 0.01;

/// Eye rays that look for straight light through a pixel that an edge crosses: such pixels have a third of the variance otherwise, and shadow
/// rays cost less than beams.
const LOOKS: u32 = 4;

/// Purpose of random numbers.
const FAINT_KEY: u32 = 0xfa17;
const LOOK_KEY: u32 = 0x100c_0000;

/// Beams of a layer of light that are seen through the same kernel.
pub(crate) struct BeamView<'a> {
    pub(crate) layer: usize,
    /// By medium.
    pub(crate) maps: Vec<BeamMap>,
    pub(crate) kernel: Kernel<'a>,
    /// For pieces of eye paths that no filter thins out: wide kernels cost more than they are worth to them.
    pub(crate) behind: Kernel<'a>,
    /// The last of the layer's kinds.
    pub(crate) kind: Kind,
}

/// Which eye rays a pass traces, and through what.
pub(crate) struct View<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) fogs: &'a [Medium<'a>],
    pub(crate) tracer: EyeTracer<'a>,
    pub(crate) beams: &'a [BeamView<'a>],
    pub(crate) seed: u32,
    pub(crate) pass: u32,
    /// Eye rays where these want them, one a layer; none: one through every pixel.
    pub(crate) plans: Vec<Plan>,
    /// Where straight light is not left to beams; it is of the first layer.
    pub(crate) straight: Option<Straight<'a>>,
}

/// An eye ray that a pass wants.
struct Wanted {
    x: u32,
    y: u32,
    /// By layer: the fog before the first surface.
    fog: [bool; MOST_LAYERS],
    surfaces: bool,
    /// Rays that look for its straight light, itself and others beside it.
    looks: u32,
}

impl Wanted {
    fn fog_count(&self) -> usize {
        self.fog.iter().filter(|wanted| **wanted).count()
    }
}

/// What the eye rays cost.
pub(crate) struct Cost {
    pub(crate) seconds: f64,
    pub(crate) pairs: u64,
}

impl View<'_> {
    /// Traces and gathers all of the pass' eye rays.
    pub(crate) fn image(self, cancelled: &(dyn Fn() -> bool + Sync)) -> Option<(PassImage, Cost)> {
        let (width, height) = (self.scene.camera.width, self.scene.camera.height);
        let (across, down) = (width.div_ceil(TILE), height.div_ceil(TILE));
        // Tiles cost unlike amounts: each is a task, and threads take turns with the buffers.
        let idle = Mutex::new(Vec::new());
        let corner = |tile: usize| [tile as u32 % across * TILE, tile as u32 / across * TILE];
        let tiles = (0..(across * down) as usize).into_par_iter();
        let counts = tiles.map(|tile| {
            let wanted = self.wanted(corner(tile));
            wanted.fold([0; 2], |[rays, fog], wanted| [rays + 1, fog + self.fog_count(&wanted)])
        });
        let mut room = Room::new(counts.collect());
        let costs: Option<Vec<Cost>> = room
            .parts()
            .into_par_iter()
            .enumerate()
            .with_max_len(1)
            .map(|(tile, seen)| {
                if cancelled() {
                    return None;
                }
                let mut scratch: Scratch =
                    idle.lock().expect("no thread panics with it").pop().unwrap_or_default();
                let cost = self.tile(corner(tile), seen, &mut scratch);
                idle.lock().expect("no thread panics with it").push(scratch);
                Some(cost)
            })
            .collect();
        let mut all = Cost { seconds: 0.0, pairs: 0 };
        for cost in costs? {
            all.seconds += cost.seconds;
            all.pairs += cost.pairs;
        }
        Some((room.image(self.pass, [width, height], self.plans), all))
    }

    /// The samples that a ray's fog before the first surface takes: without plans none, since nothing is filtered.
    fn fog_count(&self, wanted: &Wanted) -> usize {
        if self.plans.is_empty() { 0 } else { wanted.fog_count() }
    }

    /// The pixels of a tile that get an eye ray, and what is wanted from it.
    fn wanted(&self, [x0, y0]: [u32; 2]) -> impl Iterator<Item = Wanted> {
        let (width, height) = (self.scene.camera.width, self.scene.camera.height);
        // Along a Z-shaped curve, so that rays that follow each other lie close together however few there are.
        let pixels = (0..TILE * TILE)
            .map(move |place| (x0 + every_second_bit(place), y0 + every_second_bit(place >> 1)));
        pixels.filter(move |(x, y)| *x < width && *y < height).filter_map(|(x, y)| {
            let mut wanted =
                Wanted { x, y, fog: [self.plans.is_empty(); MOST_LAYERS], surfaces: true, looks: 1 };
            if let Some(plan) = self.plans.first() {
                wanted.surfaces = plan.surfaces().are_wanted(x, y, self.pass, self.seed);
                if self.straight.is_some() && plan.surfaces().has_edge(x, y) {
                    wanted.looks = LOOKS;
                }
            }
            for (wanted, plan) in wanted.fog.iter_mut().zip(&self.plans) {
                *wanted = plan.wants(x, y, self.seed);
            }
            (wanted.surfaces || wanted.fog_count() > 0).then_some(wanted)
        })
    }

    /// What the eye rays of a tile see.
    fn tile(&self, corner: [u32; 2], mut seen: Seen, scratch: &mut Scratch) -> Cost {
        let start = Instant::now();
        let Scratch { segments, wanted, .. } = scratch;
        segments.clear();
        wanted.clear();
        let mut fog = 0;
        for (number, ray) in self.wanted(corner).enumerate() {
            let mut samples = [None; MOST_LAYERS];
            for (layer, sample) in samples.iter_mut().enumerate() {
                if ray.fog[layer] && !self.plans.is_empty() {
                    *sample = Some(fog);
                    seen.fog[fog].layer = layer as u32;
                    seen.fog[fog].pixel = ray.y * self.scene.camera.width + ray.x;
                    fog += 1;
                }
            }
            self.trace(number, &ray, &mut seen, segments);
            wanted.push((ray, samples));
        }
        self.add_straight(&mut seen, scratch);
        if self.straight.is_some() {
            self.thin_out(&mut scratch.segments, &seen);
        }
        // Paths that met the same surfaces run side by side.
        scratch.segments.sort_by_key(|segment| (segment.medium, segment.signature, segment.pixel));
        let pairs = self.beams.iter().map(|beams| self.gather(beams, &mut seen, scratch)).sum();
        Cost { seconds: start.elapsed().as_secs_f64(), pairs }
    }

    /// The eye path of a wanted ray.
    fn trace(&self, number: usize, wanted: &Wanted, seen: &mut Seen, segments: &mut Vec<EyeSegment>) {
        let camera = &self.scene.camera;
        let [jx, jy] = pixel_offset(self.seed, self.pass);
        let &Wanted { x, y, surfaces, .. } = wanted;
        let direction = camera.direction(x as f32 + jx, y as f32 + jy);
        let pixel = y * camera.width + x;
        let mut random = Random::new([self.seed, self.pass, pixel, 0xe7e]);
        let asked = [wanted.fog_count() > 0, surfaces];
        let mut light = self.tracer.trace_wanted(direction, number as u32, asked, &mut random, segments);
        light[Kind::Straight as usize] /= wanted.looks as f32;
        seen.rays[number] = SparseSample { pixel, has_surfaces: surfaces, light, gather: [0.0; 4] };
    }

    /// Beams around the pieces of the eye paths.
    fn gather(&self, beams: &BeamView, seen: &mut Seen, scratch: &mut Scratch) -> u64 {
        let Scratch { segments, wanted, rays, pieces, gathered, gather } = scratch;
        let BeamView { layer, maps, kernel, behind, kind } = beams;
        let mut pairs = 0;
        for group in segments.chunk_by(|a, b| (a.medium, a.signature) == (b.medium, b.signature)) {
            let medium = group[0].medium as usize;
            if maps[medium].beams().is_empty() {
                continue;
            }
            let is_wanted =
                |segment: &&EyeSegment| !segment.is_first() || wanted[segment.pixel as usize].0.fog[*layer];
            pieces.clear();
            pieces.extend(group.iter().filter(is_wanted).copied());
            rays.clear();
            rays.extend(pieces.iter().map(|segment| segment.ray));
            gathered.clear();
            gathered.resize(pieces.len(), Gathered::default());
            let fog = &self.fogs[medium];
            let is_behind = !self.plans.is_empty() && !group[0].is_first();
            let kernel = if is_behind { behind } else { kernel };
            maps[medium].gather(fog, rays, kernel, gathered, gather).expect("its map was built in it");
            for (segment, gathered) in pieces.iter().zip(gathered.iter()) {
                let ray = segment.pixel as usize;
                seen.add(ray, wanted[ray].1[*layer], segment, *kind, gathered.radiance);
                let share = segment.throughput.element_sum() / 3.0;
                let add = [
                    share * gathered.weight,
                    share * gathered.radius,
                    share * gathered.sigma,
                    gathered.pairs as f32,
                ];
                for (sum, add) in seen.rays[ray].gather.iter_mut().zip(add) {
                    *sum += add;
                }
                pairs += u64::from(gathered.pairs);
            }
        }
        pairs
    }

    /// Straight light in all pieces of the eye paths.
    fn add_straight(&self, seen: &mut Seen, scratch: &mut Scratch) {
        let Some(straight) = &self.straight else { return };
        let mut knots = Vec::new();
        for segment in &scratch.segments {
            let ray = segment.pixel as usize;
            let (wanted, samples) = &scratch.wanted[ray];
            if segment.is_first() && !wanted.fog[0] {
                continue;
            }
            let pixel = seen.rays[ray].pixel;
            let planned = self.plans.first().filter(|_| segment.is_first());
            let density = planned.map_or(1.0, |plan| plan.density()[pixel as usize]);
            let radiance = straight.radiance(segment, pixel, density, (0, wanted.looks), &mut knots)
                / wanted.looks as f32;
            seen.add(ray, samples[0], segment, Kind::Straight, radiance);
        }
        let no_photons = SurfaceMap::empty();
        let tracer = EyeTracer { surfaces: &no_photons, ..self.tracer };
        let camera = &self.scene.camera;
        let [jx, jy] = pixel_offset(self.seed, self.pass);
        for (ray, (wanted, samples)) in scratch.wanted.iter().enumerate() {
            let pixel = seen.rays[ray].pixel;
            for look in 1..wanted.looks {
                let shift = spread([jx, jy], look as usize);
                let direction = camera.direction(wanted.x as f32 + shift[0], wanted.y as f32 + shift[1]);
                let mut random = Random::new([self.seed, self.pass, pixel, LOOK_KEY ^ look]);
                let asked = [wanted.fog[0], wanted.surfaces];
                let pieces = &mut scratch.pieces;
                pieces.clear();
                let light = tracer.trace_wanted(direction, pixel, asked, &mut random, pieces);
                let share = 1.0 / wanted.looks as f32;
                seen.rays[ray].light[Kind::Straight as usize] += light[Kind::Straight as usize] * share;
                for segment in pieces.iter() {
                    let radiance =
                        straight.radiance(segment, pixel, 1.0, (look, wanted.looks), &mut knots) * share;
                    seen.add(ray, samples[0], segment, Kind::Straight, radiance);
                }
            }
        }
    }

    /// Leaves pieces out that the camera hardly sees, and makes up for them.
    fn thin_out(&self, segments: &mut Vec<EyeSegment>, seen: &Seen) {
        let mut number = 0_u32;
        segments.retain_mut(|segment| {
            number += 1;
            let share = segment.throughput.max_element() / FAINT;
            if segment.is_first() || share >= 1.0 {
                return true;
            }
            let chance = (share * share).max(LEAST);
            segment.throughput /= chance;
            let pixel = seen.rays[segment.pixel as usize].pixel;
            Random::new([self.seed, self.pass, pixel, FAINT_KEY ^ (number << 16)]).uniform() < chance
        });
    }
}

/// Bits 0, 2, 4, … of a number below 2¹⁰, side by side.
fn every_second_bit(number: u32) -> u32 {
    (0..5).fold(0, |sum, bit| sum | ((number >> bit) & (1 << bit)))
}

/// Buffers that a thread keeps from tile to tile.
#[derive(Default)]
struct Scratch {
    segments: Vec<EyeSegment>,
    /// The eye rays, and the sample of each layer of their fog.
    wanted: Vec<(Wanted, [Option<usize>; MOST_LAYERS])>,
    pieces: Vec<EyeSegment>,
    rays: Vec<EyeRay>,
    gathered: Vec<Gathered>,
    gather: GatherScratch,
}

/// Where in the pixel the eye rays of a pass start: Roberts' R2 sequence, which fills the pixel evenly over the passes.
pub(crate) fn pixel_offset(seed: u32, index: u32) -> [f32; 2] {
    let mut random = Random::new([seed, 0, 0, 0xca3e7a]);
    let turn = |start: f32, step: f64| (f64::from(start) + step * f64::from(index)).fract() as f32;
    [turn(random.uniform(), 0.754_877_666_246_692_7), turn(random.uniform(), 0.569_840_290_998_053_2)]
        .map(|offset| offset.min(1.0 - f32::EPSILON))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tile_is_walked_through_each_pixel_once_and_in_blocks() {
        let mut seen = [[false; TILE as usize]; TILE as usize];
        for place in 0..TILE * TILE {
            let (x, y) = (every_second_bit(place), every_second_bit(place >> 1));
            assert!(!std::mem::replace(&mut seen[y as usize][x as usize], true), "({x}, {y}) twice");
            // Sixteen in a row are a block of 4 x 4.
            let first = place & !15;
            assert_eq!((x >> 2, y >> 2), (every_second_bit(first) >> 2, every_second_bit(first >> 1) >> 2));
        }
    }
}
