//! The eye rays of one pass: through which pixels, and what they see.

use crate::eye::{EyeSegment, EyeTracer};
use crate::film::{PassImage, SparseSample, SparseSamples};
use crate::fog::Fog;
use crate::plan::{Plan, Wanted};
use crate::random::Random;
use crate::scene::Scene;
use covbeam::{BeamMap, EyeRay, GatherScratch, Gathered, KernelRadius};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Mutex;
use std::time::Instant;

/// Pixels along the side of a tile, whose eye rays are gathered together.
const TILE: u32 = 32;

/// Which eye rays a pass traces, and through what.
pub(crate) struct View<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) fogs: &'a [Fog<'a>],
    pub(crate) tracer: EyeTracer<'a>,
    /// Beams by medium.
    pub(crate) maps: &'a [BeamMap],
    pub(crate) radius: &'a KernelRadius<'a>,
    pub(crate) seed: u32,
    pub(crate) pass: u32,
    /// Eye rays where the plan wants them; None: one through every pixel.
    pub(crate) plan: Option<Plan>,
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
        let tiles: Option<Vec<Tile>> = (0..across * down)
            .into_par_iter()
            .with_max_len(1)
            .map(|tile| {
                if cancelled() {
                    return None;
                }
                let mut scratch: Scratch =
                    idle.lock().expect("no thread panics with it").pop().unwrap_or_default();
                let tile = self.tile([tile % across * TILE, tile / across * TILE], &mut scratch);
                idle.lock().expect("no thread panics with it").push(scratch);
                Some(tile)
            })
            .collect();
        let mut cost = Cost { seconds: 0.0, pairs: 0 };
        let mut image = PassImage { pass: self.pass, width, height, ..PassImage::default() };
        let mut samples = Vec::new();
        for tile in tiles? {
            cost.seconds += tile.seconds;
            cost.pairs += tile.pairs;
            samples.extend(tile.seen);
        }
        match self.plan {
            Some(plan) => image.sparse = Some(SparseSamples { plan, samples }),
            None => {
                let pixels = (width * height) as usize;
                image.radiance.resize(pixels, Vec3::ZERO);
                image.gather.resize(pixels, [0.0; 4]);
                for SparseSample { pixel, volume, surfaces, gather, .. } in samples {
                    image.radiance[pixel as usize] = volume + surfaces;
                    image.gather[pixel as usize] = gather;
                }
            }
        }
        Some((image, cost))
    }

    fn tile(&self, [x0, y0]: [u32; 2], scratch: &mut Scratch) -> Tile {
        let start = Instant::now();
        let camera = &self.scene.camera;
        let [jx, jy] = pixel_offset(self.seed, self.pass);
        let Scratch { segments, rays, gathered, gather } = scratch;
        segments.clear();
        let mut all = Vec::new();
        // Along a Z-shaped curve, so that rays that follow each other lie close together however few there are.
        for place in 0..TILE * TILE {
            let (x, y) = (x0 + every_second_bit(place), y0 + every_second_bit(place >> 1));
            if x >= camera.width || y >= camera.height {
                continue;
            }
            let wanted = self.plan.as_ref().map_or(Wanted::ALL, |plan| plan.wanted(x, y, self.seed));
            if wanted.is_nothing() {
                continue;
            }
            let direction = camera.direction(x as f32 + jx, y as f32 + jy);
            let mut random = Random::new([self.seed, self.pass, y * camera.width + x, 0xe7e]);
            let number = all.len() as u32;
            let surfaces = self.tracer.trace_wanted(direction, number, wanted, &mut random, segments);
            all.push(SparseSample {
                pixel: y * camera.width + x,
                wanted,
                volume: Vec3::ZERO,
                surfaces,
                gather: [0.0; 4],
            });
        }
        // Paths that met the same surfaces run side by side.
        segments.sort_by_key(|segment| (segment.medium, segment.signature, segment.pixel));
        let narrow = KernelRadius { ceiling: self.radius.progressive, grid: None, ..*self.radius };
        let mut pairs = 0;
        for group in segments.chunk_by(|a, b| (a.medium, a.signature) == (b.medium, b.signature)) {
            let medium = group[0].medium as usize;
            rays.clear();
            rays.extend(group.iter().map(|segment| segment.ray));
            gathered.clear();
            gathered.resize(group.len(), Gathered::default());
            let fog = &self.fogs[medium];
            // Wide kernels cost more than they are worth to rays that no filter thins out.
            let planned = self.plan.is_some() && !group[0].is_first();
            let radius = if planned { &narrow } else { self.radius };
            self.maps[medium].gather(rays, fog.medium, &fog.density, radius, gathered, gather);
            for (segment, gathered) in group.iter().zip(gathered.iter()) {
                let seen = &mut all[segment.pixel as usize];
                let radiance = segment.throughput * gathered.radiance;
                if segment.is_first() {
                    seen.volume += radiance;
                } else {
                    seen.surfaces += radiance;
                }
                let share = segment.throughput.element_sum() / 3.0;
                let add = [
                    share * gathered.weight,
                    share * gathered.radius,
                    share * gathered.sigma,
                    gathered.pairs as f32,
                ];
                for (sum, add) in seen.gather.iter_mut().zip(add) {
                    *sum += add;
                }
                pairs += u64::from(gathered.pairs);
            }
        }
        Tile { seen: all, pairs, seconds: start.elapsed().as_secs_f64() }
    }
}

/// Bits 0, 2, 4, … of a number below 2¹⁰, side by side.
fn every_second_bit(number: u32) -> u32 {
    (0..5).fold(0, |sum, bit| sum | ((number >> bit) & (1 << bit)))
}

struct Tile {
    seen: Vec<SparseSample>,
    pairs: u64,
    seconds: f64,
}

/// Buffers that a thread keeps from tile to tile.
#[derive(Default)]
struct Scratch {
    segments: Vec<EyeSegment>,
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
