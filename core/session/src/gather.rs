//! The eye rays of one pass: through which pixels, and what they see.

mod faint;
mod first_hits;
pub mod march;

use crate::color::luminance;
use crate::eye::EyeTracer;
use crate::eye::facet::Facet;
use crate::eye::segment::EyeSegment;
use crate::eye::shown::Pixels;
use crate::eye::starts::EyeStart;
use crate::eye::straight::Straight;
use crate::eye::straight::looks::StraightLooks;
use crate::film::samples::{PassImage, Room, Seen, SparseSample};
use crate::gather::faint::{Runs, is_faint};
use crate::kind::{Kind, MOST_LAYERS};
use crate::plan::Plan;
use crate::random::{Random, spread};
use crate::scene::Scene;
use crate::surface::SurfaceMap;
use covbeam::{BeamMap, EyeRay, FluenceGrid, GatherScratch, Gathered, GridLayout, Kernel, Medium};
use covbeam_geometry::shape::intersect_box;
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Mutex;
use std::time::Instant;

/// Pixels along the side of a tile, whose eye rays are gathered together.
const TILE: u32 = 32;

/// Eye rays that look for straight light through a pixel that an edge crosses: such pixels have a third of the variance otherwise, and shadow
/// rays cost less than beams.
/// Where a lens blurs an edge into a pixel, as many look for all light.
const LOOKS: u32 = 4;

/// Places along a piece of an eye path where its spectra are looked up to be told.
const PLACES: u32 = 16;

/// Purpose of random numbers.
const LOOK_KEY: u32 = 0x100c_0000;

/// The same, of which lamps that are seen are asked whether anything hides them.
const LAMPS_KEY: u32 = 0x1a4b_0000;

/// Sequences of places in a pixel: of a pass' eye rays, and of others beside them.
const OFFSET_KEY: u32 = 0xca3e7a;
const OTHERS_KEY: u32 = 0x07e5;

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
    /// Looks for it that pixels are worth; None: not known.
    pub(crate) looks: Option<&'a StraightLooks>,
    /// Whether more is wanted than what the fog before the first surface scatters.
    pub(crate) wants_rest: bool,
    /// What layer σ tells of where kernels look nothing up: the mean along the eye ray; None: it is 0 there.
    pub(crate) spectra: Option<FluenceGrid<'a>>,
}

/// An eye ray that a pass wants.
#[derive(Clone, Copy)]
struct Wanted {
    x: u32,
    y: u32,
    /// By layer: the fog before the first surface.
    fog: [bool; MOST_LAYERS],
    /// All else that it sees.
    surfaces: bool,
    /// Rays that look for its light, itself and others beside it: for straight light only, unless it is blurred.
    looks: u32,
    is_blurred: bool,
    /// Whether the border of a lamp crosses it: rays that look for nothing else see those straight ahead.
    has_lamp_border: bool,
}

impl Wanted {
    fn fog_count(&self) -> usize {
        self.fog.iter().filter(|wanted| **wanted).count()
    }
}

/// A ray that looks for what is wanted from an eye ray, and that beams are gathered around.
struct Look {
    wanted: Wanted,
    /// Number of the eye ray, and of the sample of each layer of its fog.
    ray: usize,
    samples: [Option<usize>; MOST_LAYERS],
    /// Among the looks of the eye ray.
    number: u32,
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
            let fog = [self.plans.is_empty(); MOST_LAYERS];
            let mut wanted = Wanted {
                x,
                y,
                fog,
                surfaces: self.wants_rest,
                looks: 1,
                is_blurred: false,
                has_lamp_border: false,
            };
            if let Some(plan) = self.plans.first() {
                let surfaces = plan.surfaces();
                wanted.surfaces &= surfaces.are_wanted(x, y, self.pass, self.seed);
                wanted.is_blurred = surfaces.is_blurred(x, y);
                wanted.has_lamp_border =
                    wanted.surfaces && self.tracer.beyond && surfaces.has_lamp_border(x, y);
                if wanted.is_blurred || self.straight.is_some() && surfaces.has_edge(x, y) {
                    wanted.looks = LOOKS;
                }
                if let Some(looks) = self.looks.filter(|_| !wanted.is_blurred) {
                    wanted.looks = looks.at(x, y).max(wanted.looks);
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
        let Scratch { segments, looks, .. } = scratch;
        segments.clear();
        looks.clear();
        let mut fog = 0;
        for (ray, wanted) in self.wanted(corner).enumerate() {
            let mut samples = [None; MOST_LAYERS];
            let pixel = wanted.y * self.scene.camera.width + wanted.x;
            for (layer, sample) in samples.iter_mut().enumerate() {
                if wanted.fog[layer] && !self.plans.is_empty() {
                    *sample = Some(fog);
                    seen.fog[fog].layer = layer as u32;
                    seen.fog[fog].pixel = pixel;
                    fog += 1;
                }
            }
            seen.rays[ray] = SparseSample { pixel, has_surfaces: wanted.surfaces, ..SparseSample::default() };
            for number in 0..if wanted.is_blurred { wanted.looks } else { 1 } {
                let look = Look { wanted, ray, samples, number };
                self.trace(looks.len(), &look, &mut seen, segments);
                looks.push(look);
            }
        }
        self.add_straight(&mut seen, scratch);
        // A plain picture has all of its pieces.
        let Scratch { segments, faint, .. } = scratch;
        faint.clear();
        if self.straight.is_some() {
            faint.extend(segments.extract_if(.., |segment| is_faint(segment)));
        }
        // Paths that met the same surfaces run side by side.
        for pieces in [segments, faint] {
            pieces.sort_by_key(|piece| (piece.path(), piece.pixel));
        }
        let pairs = self.gather(&mut seen, scratch, None) + self.gather_faint(&mut seen, scratch);
        Cost { seconds: start.elapsed().as_secs_f64(), pairs }
    }

    /// The eye path of a look, whose pieces it numbers as it is numbered itself.
    fn trace(&self, index: usize, look: &Look, seen: &mut Seen, segments: &mut Vec<EyeSegment>) {
        let &Look { ref wanted, ray, number, .. } = look;
        let sample = &mut seen.rays[ray];
        let start = self.start(wanted, sample.pixel, (number, wanted.looks));
        let key = if number == 0 { 0xe7e } else { LOOK_KEY ^ number };
        let mut random = Random::new([self.seed, self.pass, sample.pixel, key]);
        let first = segments.len();
        let asked = [wanted.fog_count() > 0, wanted.surfaces];
        let tracer = EyeTracer { is_apart: wanted.has_lamp_border, ..self.tracer };
        let mut light = tracer.trace_wanted(&start, index as u32, asked, &mut random, segments);
        if wanted.is_blurred {
            let share = 1.0 / wanted.looks as f32;
            light.iter_mut().for_each(|light| *light *= share);
            segments[first..].iter_mut().for_each(|segment| segment.throughput *= share);
        } else {
            light[Kind::Straight as usize] /= wanted.looks as f32;
        }
        sample.light.iter_mut().zip(light).for_each(|(sum, light)| *sum += light);
        if let Some(small) = tracer.shown.filter(|_| wanted.has_lamp_border && number == 0) {
            let start = |look, looks| self.start(wanted, sample.pixel, (look, looks));
            let pixels = Pixels { scene: self.scene, small, starts: &tracer.starts };
            let shift = Random::new([self.seed, self.pass, sample.pixel, LAMPS_KEY]).uniform();
            sample.light[Kind::Straight as usize] +=
                pixels.radiance(self.fogs, [wanted.x, wanted.y], start, shift);
        }
    }

    /// Where a look of several rays through a pixel starts.
    fn start(&self, wanted: &Wanted, pixel: u32, (look, looks): (u32, u32)) -> EyeStart {
        let before = u64::from(self.pass - 1);
        let place = match u64::from(look) {
            0 => pixel_offset(self.seed, self.pass),
            // No look of another pass is at the same place.
            look => pixel_point(self.seed, OTHERS_KEY, before * u64::from(looks - 1) + look),
        };
        let starts = &self.tracer.starts;
        let lens = starts.place_in_lens(self.seed, pixel, (self.pass - 1).wrapping_mul(looks) + look);
        let start = starts.at([wanted.x as f32 + place[0], wanted.y as f32 + place[1]], lens);
        let facet = (look == 0).then(|| Facet::of(self.seed, [wanted.x, wanted.y], self.pass));
        EyeStart { facet, ..start }
    }

    /// Beams around the pieces of the eye paths. Returns the number of pairs.
    ///
    /// - `found`: gets the luminance that the camera sees in each of them; for pieces behind the first surface.
    fn gather(&self, seen: &mut Seen, scratch: &mut Scratch, mut found: Option<&mut [f32]>) -> u64 {
        let mut pairs = 0;
        for beams in self.beams {
            pairs += self.gather_layer(beams, seen, scratch, found.as_deref_mut());
        }
        pairs
    }

    fn gather_layer(
        &self,
        beams: &BeamView,
        seen: &mut Seen,
        scratch: &mut Scratch,
        mut found: Option<&mut [f32]>,
    ) -> u64 {
        let Scratch { segments, looks, rays, pieces, gathered, gather, .. } = scratch;
        let BeamView { layer, maps, kernel, behind, kind } = beams;
        let (mut pairs, mut next) = (0, 0);
        for group in segments.chunk_by(|a, b| a.path() == b.path()) {
            let place = next;
            next += group.len();
            let medium = group[0].medium as usize;
            if maps[medium].beams().is_empty() {
                continue;
            }
            let is_wanted = |segment: &&EyeSegment| {
                !segment.is_first() || looks[segment.pixel as usize].wanted.fog[*layer]
            };
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
            let spectra = self.spectra.as_ref().filter(|_| kernel.grid.is_none() && group[0].is_first());
            for (number, (segment, gathered)) in pieces.iter().zip(gathered.iter()).enumerate() {
                let &Look { ray, samples, .. } = &looks[segment.pixel as usize];
                seen.add(ray, samples[*layer], segment, *kind, gathered.radiance);
                if let Some(found) = &mut found {
                    found[place + number] += luminance(segment.throughput * gathered.radiance);
                }
                let share = segment.throughput.element_sum() / 3.0;
                let sigma = spectra
                    .map_or(gathered.sigma, |spectra| gathered.weight * self.sigma(spectra, &segment.ray));
                let add =
                    [share * gathered.weight, share * gathered.radius, share * sigma, gathered.pairs as f32];
                for (sum, add) in seen.rays[ray].gather.iter_mut().zip(add) {
                    *sum += add;
                }
                pairs += u64::from(gathered.pairs);
            }
        }
        pairs
    }

    /// Beams around the faint pieces, as many of these as it takes.
    fn gather_faint(&self, seen: &mut Seen, scratch: &mut Scratch) -> u64 {
        let (faint, mut found) = (std::mem::take(&mut scratch.faint), std::mem::take(&mut scratch.found));
        let tile = seen.rays.first().map_or(0, |ray| ray.pixel);
        let runs = Runs::new(&faint, [self.seed, self.pass, tile]);
        runs.first(&mut scratch.segments);
        found.clear();
        found.resize(scratch.segments.len(), 0.0);
        let mut pairs = self.gather(seen, scratch, Some(&mut found));
        let Scratch { segments, looks, .. } = &mut *scratch;
        let brightness = |piece: &EyeSegment| {
            let Look { ray, samples, .. } = looks[piece.pixel as usize];
            let fog: Vec3 = samples.into_iter().flatten().map(|sample| seen.fog[sample].radiance).sum();
            luminance(seen.rays[ray].light.into_iter().sum::<Vec3>() + fog)
        };
        runs.others(&found, brightness, segments);
        pairs += self.gather(seen, scratch, None);
        (scratch.faint, scratch.found) = (faint, found);
        pairs
    }

    /// Standard deviation of spectra across an eye ray, the mean of places along it; 0 where no light field has been.
    fn sigma(&self, spectra: &FluenceGrid, ray: &EyeRay) -> f32 {
        let GridLayout { min, max, .. } = self.scene.grid;
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let Some((near, far)) = intersect_box(min.as_dvec3(), max.as_dvec3(), origin, direction) else {
            return 0.0;
        };
        let (from, to) = ((near as f32).max(0.0), (far as f32).min(ray.length));
        let (across, aside) = ray.direction.any_orthonormal_pair();
        let (mut sum, mut count) = (0.0, 0.0_f32);
        for place in 0..PLACES {
            let distance = from + (to - from) * (place as f32 + 0.5) / PLACES as f32;
            if let Some(spectrum) =
                spectra.look_up(ray.origin + distance * ray.direction).filter(|_| from < to)
            {
                sum += (0.5 * (spectrum.variance_along(across) + spectrum.variance_along(aside))).sqrt();
                count += 1.0;
            }
        }
        sum / count.max(1.0)
    }

    /// Straight light in all pieces of the eye paths.
    fn add_straight(&self, seen: &mut Seen, scratch: &mut Scratch) {
        let Some(straight) = &self.straight else { return };
        let mut knots = Vec::new();
        for segment in &scratch.segments {
            let &Look { ref wanted, ray, samples, number } = &scratch.looks[segment.pixel as usize];
            if segment.is_first() && !wanted.fog[0] {
                continue;
            }
            let pixel = seen.rays[ray].pixel;
            let planned = self.plans.first().filter(|_| segment.is_first());
            let density = planned.map_or(1.0, |plan| plan.density()[pixel as usize]);
            let radiance = straight.radiance(segment, pixel, density, (number, wanted.looks), &mut knots);
            // A blurred pixel's pieces have their share.
            let radiance = if wanted.is_blurred { radiance } else { radiance / wanted.looks as f32 };
            seen.add(ray, samples[0], segment, Kind::Straight, radiance);
        }
        let no_photons = SurfaceMap::empty();
        let of_light = EyeTracer { surfaces: &no_photons, ..self.tracer };
        for &Look { ref wanted, ray, samples, .. } in
            scratch.looks.iter().filter(|look| !look.wanted.is_blurred)
        {
            let pixel = seen.rays[ray].pixel;
            let tracer = EyeTracer { is_apart: wanted.has_lamp_border, ..of_light };
            for look in 1..wanted.looks {
                let start = self.start(wanted, pixel, (look, wanted.looks));
                let mut random = Random::new([self.seed, self.pass, pixel, LOOK_KEY ^ look]);
                let asked = [wanted.fog[0], wanted.surfaces];
                let pieces = &mut scratch.pieces;
                pieces.clear();
                let light = tracer.trace_wanted(&start, pixel, asked, &mut random, pieces);
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
}

/// Bits 0, 2, 4, … of a number below 2¹⁰, side by side.
fn every_second_bit(number: u32) -> u32 {
    (0..5).fold(0, |sum, bit| sum | ((number >> bit) & (1 << bit)))
}

/// Buffers that a thread keeps from tile to tile.
#[derive(Default)]
struct Scratch {
    segments: Vec<EyeSegment>,
    faint: Vec<EyeSegment>,
    found: Vec<f32>,
    looks: Vec<Look>,
    pieces: Vec<EyeSegment>,
    rays: Vec<EyeRay>,
    gathered: Vec<Gathered>,
    gather: GatherScratch,
}

/// Where in the pixel the eye rays of a pass start: Roberts' R2 sequence, which fills the pixel evenly over the passes.
pub(crate) fn pixel_offset(seed: u32, index: u32) -> [f32; 2] {
    pixel_point(seed, OFFSET_KEY, u64::from(index))
}

/// A point of such a sequence.
fn pixel_point(seed: u32, key: u32, index: u64) -> [f32; 2] {
    let mut random = Random::new([seed, 0, 0, key]);
    spread([random.uniform(), random.uniform()], index as usize)
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
