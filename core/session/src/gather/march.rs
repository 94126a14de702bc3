//! Light scattered once, by shadow rays from places along the eye rays.

mod guide;
mod placement;
mod shadow_rays;
mod spread;
mod stretch;

pub(crate) use guide::Guide;
pub use placement::Placement;

use crate::color::luminance;
use crate::eye::EyeTracer;
use crate::eye::segment::EyeSegment;
use crate::eye::shown::SmallLamps;
use crate::eye::starts::EyeStarts;
use crate::film::samples::{PassImage, Room, Seen, SparseSample};
use crate::kind::{ByKind, Kind};
use crate::lamps::LampTree;
use crate::plan::Plan;
use crate::random::{Random, spread};
use crate::scene::Scene;
use crate::scene::media;
use crate::surface::SurfaceMap;
use covbeam::{Knot, Medium};
use glam::Vec3;
use placement::Places;
use rayon::prelude::*;
use shadow_rays::ShadowRays;
use spread::Spread;
use std::time::Instant;
use stretch::Stretch;

/// Every so many pixels across and down, one is looked at to find out how the shadow rays are to be spread.
const LATTICE: u32 = 4;

/// Purpose of random numbers.
const MARCH_KEY: u32 = 0x3a7c;

/// What the method `march` does with an eye ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Marching {
    /// How places are chosen.
    pub placement: Placement,
    /// Places for each piece of an eye path in a medium and each light, >= 1. For [`Placement::Adaptive`] it is the mean of the shadow rays
    /// over all pieces that a light may reach: pieces where shadow borders are expected get more.
    pub samples: u32,
    /// Eye rays through the pixels' centres and the same eye paths in all passes and for all seeds: for comparisons.
    pub centred: bool,
}

impl Default for Marching {
    fn default() -> Self {
        Self { placement: Placement::Adaptive, samples: 16, centred: false }
    }
}

/// The eye rays of a pass, and the shadow rays from them.
pub(crate) struct Marcher<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) fogs: &'a [Medium<'a>],
    pub(crate) starts: EyeStarts<'a>,
    pub(crate) small: &'a SmallLamps,
    pub(crate) marching: Marching,
    /// Eye rays where the plan wants them; None: one through every pixel.
    pub(crate) plan: Option<Plan>,
    /// None: nothing is known about the visibility.
    pub(crate) guide: Option<&'a Guide<'a>>,
    /// Seed and pass.
    pub(crate) key: [u32; 2],
    /// Place of the eye ray in the pixel.
    pub(crate) offset: [f32; 2],
    /// Whether anything is wanted from the first surface on.
    pub(crate) beyond: bool,
    /// Whether more is wanted than what the fog before it scatters.
    pub(crate) wants_rest: bool,
}

/// An eye ray that a pass wants.
struct Wanted {
    x: u32,
    /// The fog before the first surface.
    fog: bool,
    /// All else that it sees.
    surfaces: bool,
}

/// What a row of pixels cost.
struct Cost {
    seconds: f64,
    shadow_rays: u64,
}

/// Memory that a thread keeps from pixel to pixel.
#[derive(Default)]
struct Scratch {
    segments: Vec<EyeSegment>,
    column: Vec<Knot>,
    places: Places,
}

/// What a pixel's stretches are expected to need.
struct Pieces<'a> {
    /// Of surfaces.
    radiance: Vec3,
    stretches: Vec<Stretch<'a>>,
    /// Expected luminance.
    expected: f32,
}

impl<'a> Marcher<'a> {
    /// The picture, the core-seconds it took, and the rays: the shadow rays, whose number the gather sums hold by pixel, and those of
    /// the guide.
    pub(crate) fn image(&self, cancelled: &(dyn Fn() -> bool + Sync)) -> Option<(PassImage, f64, u64)> {
        let (width, height) = (self.scene.camera.width, self.scene.camera.height);
        let surfaces = SurfaceMap::empty();
        let (scene, fogs, starts) = (self.scene, self.fogs, self.starts);
        let lamps = LampTree::new(scene);
        let tracer = EyeTracer {
            scene,
            fogs,
            starts,
            lamps: &lamps,
            surfaces: &surfaces,
            beyond: self.beyond,
            shown: Some(self.small),
            is_apart: false,
        };
        let start = Instant::now();
        let spread = self.spread(&tracer);
        let mut seconds = start.elapsed().as_secs_f64();
        let is_filtered = |wanted: &Wanted| wanted.fog && self.plan.is_some();
        let count =
            |[rays, fog]: [usize; 2], wanted: Wanted| [rays + 1, fog + usize::from(is_filtered(&wanted))];
        let counts = (0..height).into_par_iter().map(|y| self.wanted(y).fold([0; 2], count)).collect();
        let mut room = Room::new(counts);
        let costs: Option<Vec<Cost>> = room
            .parts()
            .into_par_iter()
            .zip(0..height)
            .map_init(Scratch::default, |scratch, (mut seen, y)| {
                if cancelled() {
                    return None;
                }
                let start = Instant::now();
                let mut shadow_rays = 0;
                let mut fog = 0;
                for (ray, wanted) in self.wanted(y).enumerate() {
                    let filtered = is_filtered(&wanted).then_some(fog);
                    fog += usize::from(filtered.is_some());
                    let numbers = (ray, filtered);
                    let count = self.pixel(y, wanted, numbers, &tracer, &spread, &mut seen, scratch);
                    shadow_rays += u64::from(count);
                }
                Some(Cost { seconds: start.elapsed().as_secs_f64(), shadow_rays })
            })
            .collect();
        let mut all_rays = self.guide.map_or(0, Guide::rays);
        for cost in costs? {
            seconds += cost.seconds;
            all_rays += cost.shadow_rays;
        }
        let image = room.image(self.key[1], [width, height], self.plan.clone().into_iter().collect());
        Some((image, seconds, all_rays))
    }

    /// The pixels of a row that get an eye ray, and what is wanted from it.
    fn wanted(&self, y: u32) -> impl Iterator<Item = Wanted> {
        let [seed, pass] = self.key;
        (0..self.scene.camera.width).filter_map(move |x| {
            let Some(plan) = &self.plan else {
                return Some(Wanted { x, fog: true, surfaces: self.wants_rest });
            };
            let fog = plan.wants(x, y, seed);
            let surfaces = self.wants_rest && plan.surfaces().are_wanted(x, y, pass, seed);
            (fog || surfaces).then_some(Wanted { x, fog, surfaces })
        })
    }

    /// The eye path through a pixel, and for the adaptive placement what it is expected to need.
    fn look(
        &self,
        [x, y]: [u32; 2],
        asked: [bool; 2],
        tracer: &EyeTracer,
        scratch: &mut Scratch,
    ) -> Pieces<'a> {
        let camera = &self.scene.camera;
        let number = y * camera.width + x;
        let [seed, pass] = if self.marching.centred { [0, 0] } else { self.key };
        let mut random = Random::new([seed, pass, number, 0xe7e]);
        let point = [x as f32 + self.offset[0], y as f32 + self.offset[1]];
        let start = self.starts.at(point, self.starts.place_in_lens(seed, number, pass.saturating_sub(1)));
        scratch.segments.clear();
        let light = tracer.trace_wanted(&start, number, asked, &mut random, &mut scratch.segments);
        let radiance = light.iter().sum();
        let mut seen = Pieces { radiance, stretches: Vec::new(), expected: luminance(radiance) };
        for segment in std::mem::take(&mut scratch.segments) {
            for light in 0..self.scene.lights.len() {
                let Some(stretch) = self.stretch(segment, light, scratch) else { continue };
                seen.stretches.push(stretch);
            }
        }
        if self.marching.placement == Placement::Adaptive {
            for stretch in &mut seen.stretches {
                let [radiance, error] = scratch.places.expected(stretch);
                seen.expected += stretch.share * radiance;
                stretch.error = stretch.share * error;
            }
            seen.stretches.retain(|stretch| stretch.error > 0.0);
        }
        seen
    }

    /// The part of a piece of an eye path that a light may reach; with a table for the adaptive placement.
    fn stretch(&self, segment: EyeSegment, number: usize, scratch: &mut Scratch) -> Option<Stretch<'a>> {
        let links = self.scene.links_of(number);
        if !links.lights_medium(self.scene.medium_of(segment.medium).heed.light_set) {
            return None;
        }
        let (fog, ray) = (&self.fogs[segment.medium as usize], segment.ray);
        let column = media::column(fog, ray.origin, ray.direction, ray.length, &mut scratch.column);
        let is_tabulated = self.marching.placement == Placement::Adaptive;
        let mut stretch =
            Stretch::new(segment, fog, &column, (&self.scene.lights[number], links), is_tabulated)?;
        if is_tabulated {
            stretch.tabulate(self.scene, &column, number, self.guide);
        }
        Some(stretch)
    }

    /// How shadow rays are to be spread, from a look at some pixels.
    fn spread(&self, tracer: &EyeTracer) -> Spread {
        if self.marching.placement != Placement::Adaptive {
            return Spread::default();
        }
        let camera = &self.scene.camera;
        let (across, down) = (camera.width.div_ceil(LATTICE), camera.height.div_ceil(LATTICE));
        let looked: Vec<(f32, Vec<f32>)> = (0..across * down)
            .into_par_iter()
            .map_init(Scratch::default, |scratch, number| {
                // In the middle of the squares, where there is one.
                let middle = |index: u32, end: u32| (index * LATTICE + LATTICE / 2).min(end - 1);
                let (x, y) = (middle(number % across, camera.width), middle(number / across, camera.height));
                let seen = self.look([x, y], [true; 2], tracer, scratch);
                (seen.expected, seen.stretches.iter().map(|stretch| stretch.error).collect())
            })
            .collect();
        Spread::new(&looked)
    }

    /// Adds what the eye ray of a pixel sees; returns the number of shadow rays.
    #[allow(clippy::too_many_arguments)]
    fn pixel(
        &self,
        y: u32,
        wanted: Wanted,
        (ray, fog): (usize, Option<usize>),
        tracer: &EyeTracer,
        spread: &Spread,
        seen: &mut Seen,
        scratch: &mut Scratch,
    ) -> u32 {
        let [seed, pass] = self.key;
        let Wanted { x, surfaces, .. } = wanted;
        let pixel = y * self.scene.camera.width + x;
        let pieces = self.look([x, y], [wanted.fog, surfaces], tracer, scratch);
        let mut light = ByKind::default();
        light[Kind::Straight as usize] = pieces.radiance;
        seen.rays[ray] = SparseSample { pixel, has_surfaces: surfaces, light, gather: [0.0; 4] };
        if let Some(fog) = fog {
            seen.fog[fog].pixel = pixel;
        }
        let mut shadow_rays = 0;
        let mut random = Random::new([seed, pass, pixel, MARCH_KEY]);
        for stretch in &pieces.stretches {
            let mut samples = self.marching.samples as usize;
            if self.marching.placement == Placement::Adaptive {
                samples = spread.samples(self.marching.samples, stretch.error, pieces.expected);
            }
            let (scattered, count) = self.march(stretch, samples, &mut random, scratch);
            seen.add(ray, fog, &stretch.segment, Kind::Straight, scattered);
            shadow_rays += count;
        }
        seen.rays[ray].gather[3] = shadow_rays as f32;
        shadow_rays
    }

    /// Light scattered once along a stretch, and the number of shadow rays.
    fn march(
        &self,
        stretch: &Stretch,
        samples: usize,
        random: &mut Random,
        scratch: &mut Scratch,
    ) -> (Vec3, u32) {
        let Scratch { column, places, .. } = scratch;
        let ray = &stretch.segment.ray;
        let column = &media::column(stretch.fog, ray.origin, ray.direction, ray.length, column);
        let mut rays = ShadowRays { scene: self.scene, fogs: self.fogs, stretch, column, count: 0 };
        places.choose(self.marching.placement, samples, &mut rays, random);
        let shift = [random.uniform(), random.uniform()];
        let mut radiance = Vec3::ZERO;
        let worth = places.samples.iter().enumerate().filter(|(_, sample)| sample.weight > 0.0);
        for (index, sample) in worth {
            let (found, arrives) = rays.ask(sample.distance, spread(shift, index));
            radiance += sample.weight * arrives * found;
        }
        (radiance, rays.count)
    }
}
