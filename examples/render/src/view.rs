//! The eye rays of one pass: through which pixels, and what they see.

use crate::eye::{EyeSegment, EyeTracer};
use crate::film::{PassImage, SparseSample};
use crate::plan::{Plan, Wanted};
use crate::random::Random;
use crate::scene::Scene;
use crate::straight::Straight;
use covbeam::{BeamMap, EyeRay, GatherScratch, Gathered, Kernel, Medium};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Mutex;
use std::time::Instant;

/// Pixels along the side of a tile, whose eye rays are gathered together.
const TILE: u32 = 32;

/// Beams around pieces of eye paths of which less than this reaches the camera are not gathered each time: such a piece costs as much as
/// any other. Of a piece with share t they are with probability (t / FAINT)², which adds as much variance as one with this share has.
const FAINT: f32 = 0.1;
const LEAST: f32 = 0.01;

/// Purpose of random numbers.
const FAINT_KEY: u32 = 0xfa17;

/// Which eye rays a pass traces, and through what.
pub(crate) struct View<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) fogs: &'a [Medium<'a>],
    pub(crate) tracer: EyeTracer<'a>,
    /// Beams by medium.
    pub(crate) maps: &'a [BeamMap],
    pub(crate) kernel: &'a Kernel<'a>,
    pub(crate) seed: u32,
    pub(crate) pass: u32,
    /// Eye rays where the plan wants them; None: one through every pixel.
    pub(crate) plan: Option<Plan>,
    /// Where straight light is not left to beams.
    pub(crate) straight: Option<Straight<'a>>,
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
        let counts: Vec<usize> = tiles.map(|tile| self.wanted(corner(tile)).count()).collect();
        let mut samples = SparseSample::room(&counts);
        let costs: Option<Vec<Cost>> = SparseSample::parts(&mut samples, &counts)
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
        Some((PassImage::of_samples(self.pass, [width, height], self.plan, samples), all))
    }

    /// The pixels of a tile that get an eye ray, and what is wanted from it.
    fn wanted(&self, [x0, y0]: [u32; 2]) -> impl Iterator<Item = (u32, u32, Wanted)> {
        let (width, height) = (self.scene.camera.width, self.scene.camera.height);
        // Along a Z-shaped curve, so that rays that follow each other lie close together however few there are.
        let pixels = (0..TILE * TILE)
            .map(move |place| (x0 + every_second_bit(place), y0 + every_second_bit(place >> 1)));
        pixels.filter(move |(x, y)| *x < width && *y < height).filter_map(|(x, y)| {
            let wanted = self.plan.as_ref().map_or(Wanted::ALL, |plan| plan.wanted(x, y, self.seed));
            (!wanted.is_nothing()).then_some((x, y, wanted))
        })
    }

    /// What the eye rays of a tile see.
    fn tile(&self, corner: [u32; 2], seen: &mut [SparseSample], scratch: &mut Scratch) -> Cost {
        let start = Instant::now();
        let camera = &self.scene.camera;
        let [jx, jy] = pixel_offset(self.seed, self.pass);
        let Scratch { segments, rays, gathered, gather } = scratch;
        segments.clear();
        for ((number, seen), (x, y, wanted)) in (0..).zip(&mut *seen).zip(self.wanted(corner)) {
            let direction = camera.direction(x as f32 + jx, y as f32 + jy);
            let pixel = y * camera.width + x;
            let mut random = Random::new([self.seed, self.pass, pixel, 0xe7e]);
            let surfaces = self.tracer.trace_wanted(direction, number, wanted, &mut random, segments);
            *seen = SparseSample { pixel, wanted, volume: Vec3::ZERO, surfaces, gather: [0.0; 4] };
        }
        if let Some(straight) = &self.straight {
            self.add_straight(straight, segments, seen);
            self.thin_out(segments, seen);
        }
        // Paths that met the same surfaces run side by side.
        segments.sort_by_key(|segment| (segment.medium, segment.signature, segment.pixel));
        let narrow = Kernel { max_radius: self.kernel.min_radius, grid: None, ..*self.kernel };
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
            let kernel = if planned { &narrow } else { self.kernel };
            self.maps[medium].gather(fog, rays, kernel, gathered, gather).expect("its map was built in it");
            for (segment, gathered) in group.iter().zip(gathered.iter()) {
                let seen = &mut seen[segment.pixel as usize];
                seen.add(segment, gathered.radiance);
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
        Cost { seconds: start.elapsed().as_secs_f64(), pairs }
    }

    /// Straight light in all pieces of the eye paths.
    fn add_straight(&self, straight: &Straight, segments: &[EyeSegment], seen: &mut [SparseSample]) {
        let mut knots = Vec::new();
        for segment in segments {
            let seen = &mut seen[segment.pixel as usize];
            let planned = self.plan.as_ref().filter(|_| segment.is_first());
            let density = planned.map_or(1.0, |plan| plan.density()[seen.pixel as usize]);
            let radiance = straight.radiance(segment, seen.pixel, density, &mut knots);
            seen.add(segment, radiance);
        }
    }

    /// Leaves pieces out that the camera hardly sees, and makes up for them.
    fn thin_out(&self, segments: &mut Vec<EyeSegment>, seen: &[SparseSample]) {
        let mut number = 0_u32;
        segments.retain_mut(|segment| {
            number += 1;
            let share = segment.throughput.max_element() / FAINT;
            if segment.is_first() || share >= 1.0 {
                return true;
            }
            let chance = (share * share).max(LEAST);
            segment.throughput /= chance;
            let pixel = seen[segment.pixel as usize].pixel;
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
