//! Light scattered once, by shadow rays from places along the eye rays, and the ways to choose these places.

use crate::color::luminance;
use crate::eye::EyeTracer;
use crate::eye::segment::EyeSegment;
use crate::eye::shown::SmallLamps;
use crate::eye::starts::EyeStarts;
use crate::film::samples::{PassImage, Room, Seen, SparseSample};
use crate::gather::first_hits::FirstHits;
use crate::kind::{ByKind, Kind};
use crate::lamps::LampTree;
use crate::plan::Plan;
use crate::random::{Random, spread};
use crate::scene::media;
use crate::scene::passage::passage;
use crate::scene::{Light, MediumDensity, Scene};
use crate::surface::SurfaceMap;
use covbeam::{Column, FluenceGrid, Knot, MARCH_KNOTS, March, MarchCell, MarchKnot, MarchSample, Medium};
use glam::Vec3;
use rayon::prelude::*;
use std::time::Instant;

/// Every so many pixels across and down, one is looked at to find out how the shadow rays are to be spread.
const LATTICE: u32 = 4;

/// No pixel gets more than this many times the mean number of shadow rays.
const MOST: f32 = 8.0;

/// Errors below this share of the mean radiance do not count more than others.
const DARK: f32 = 0.01;

/// Rays from each light that tell where its light is to be expected.
const FEWEST_FIRST_HITS: usize = 1024;
const MOST_FIRST_HITS: usize = 1 << 18;

/// Purpose of random numbers.
const MARCH_KEY: u32 = 0x3a7c;

/// How places along an eye ray are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Placement {
    /// By the covariance grid and a first round of shadow rays (thesis 5.3.3, [`March`]).
    #[default]
    Adaptive,
    /// One at random in each of equal steps.
    Uniform,
    /// One at random in each of equal steps of the angle seen from the light (C. Kulla and M. Fajardo 2012).
    EquiAngular,
    /// Where a photon flying along the eye ray collides, by Woodcock's tracking with the greatest density.
    MaximumDensity,
}

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

/// What is known about the light that comes straight from the lights before any shadow ray.
pub(crate) struct Guide<'a> {
    pub(crate) grid: FluenceGrid<'a>,
    /// By light.
    pub(crate) first_hits: Vec<FirstHits>,
}

impl<'a> Guide<'a> {
    /// With an eighth of the shadow rays that `samples` a pixel are. None: it was `cancelled`.
    pub(crate) fn new(
        scene: &Scene,
        grid: FluenceGrid<'a>,
        samples: u32,
        key: [u32; 2],
        cancelled: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let pixels = scene.camera.width as usize * scene.camera.height as usize;
        let rays = (pixels * samples as usize / 8).clamp(FEWEST_FIRST_HITS, MOST_FIRST_HITS);
        let lights = scene.lights.iter().zip(0..);
        let first_hits = lights.map(|(light, index)| {
            (!cancelled()).then(|| FirstHits::new(scene, light, rays, [key[0] ^ index << 16, key[1]]))
        });
        Some(Self { grid, first_hits: first_hits.collect::<Option<_>>()? })
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

/// A stretch of an eye ray that a light may reach.
struct Stretch<'a> {
    segment: EyeSegment,
    light: &'a Light,
    from: f32,
    to: f32,
    knots: Vec<MarchKnot>,
    /// Luminance of the throughput.
    share: f32,
    /// [`March::expected_error`] as the camera sees it.
    error: f32,
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
    cells: Vec<MarchCell>,
    jitter: Vec<f32>,
    first: Vec<MarchSample>,
    samples: Vec<MarchSample>,
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
        let mut all_rays = self.guide.map_or(0, |guide| guide.first_hits.iter().map(FirstHits::rays).sum());
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
                let cells = scratch.cells(stretch.knots.len());
                let march = March::new(&stretch.knots, cells).expect("knots as they were laid");
                seen.expected += stretch.share * march.expected_radiance();
                stretch.error = stretch.share * march.expected_error();
            }
            seen.stretches.retain(|stretch| stretch.error > 0.0);
        }
        seen
    }

    /// The part of a piece of an eye path that a light may reach; with a table for the adaptive placement.
    fn stretch(&self, segment: EyeSegment, number: usize, scratch: &mut Scratch) -> Option<Stretch<'a>> {
        let light = &self.scene.lights[number];
        let fog = &self.fogs[segment.medium as usize];
        let ray = segment.ray;
        let column = media::column(fog, ray.origin, ray.direction, ray.length, &mut scratch.column);
        let mut from = 0.0;
        let mut to = ray.length.min(media::opaque_distance(fog, ray.origin, ray.direction, &column));
        if let Column::Knots(knots) = column {
            from = knots.first()?.distance.max(0.0);
            to = to.min(knots.last()?.distance);
        }
        let adaptive = self.marching.placement == Placement::Adaptive;
        if adaptive {
            (from, to) = light.lit_stretch(ray.origin, ray.direction, from, to)?;
        }
        let mut knots = vec![MarchKnot::default(); if adaptive { MARCH_KNOTS } else { 2 }];
        MarchKnot::lay(ray.origin, ray.direction, from, to, light.position(), &mut knots).ok()?;
        // What stands for infinity.
        to = knots[knots.len() - 1].distance;
        if !(from < to) || fog.scattering == Vec3::ZERO {
            return None;
        }
        let share = luminance(segment.throughput);
        let mut stretch = Stretch { segment, light, from, to, knots: Vec::new(), share, error: 0.0 };
        if adaptive {
            for knot in &mut knots {
                let place = ray.origin + knot.distance * ray.direction;
                let expected = light.expected(place);
                knot.radiance = luminance(self.scattered(&stretch, &column, knot.distance, expected));
                if let (true, Some(guide)) = (knot.radiance > 0.0, self.guide) {
                    knot.visibility = guide.first_hits[number].visibility(place);
                    if let Some(spectrum) = guide.grid.look_up(place) {
                        knot.deviation = spectrum.variance_along(ray.direction).sqrt();
                    }
                }
            }
        }
        stretch.knots = knots;
        Some(stretch)
    }

    /// Radiance that a metre of the stretch scatters to the ray's start if nothing is in the light's way.
    ///
    /// - `density`, `from`: the light's flux density there, and where it comes from.
    fn scattered(
        &self,
        stretch: &Stretch,
        column: &Column,
        distance: f32,
        (density, from): (Vec3, Vec3),
    ) -> Vec3 {
        let fog = &self.fogs[stretch.segment.medium as usize];
        let ray = &stretch.segment.ray;
        let place = ray.origin + distance * ray.direction;
        if density == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let incoming = (place - from).normalize_or_zero();
        let phase = fog.phase.evaluate(-incoming.dot(ray.direction));
        let amount = fog.scattering * (fog.density.at(place) * phase);
        // What other media on its way leave of light is found together with what stands there.
        let left = match self.scene.may_be_seen_through() {
            true => Vec3::ONE,
            false => media::transmittance(fog, place, from),
        };
        density * amount * fog.transmittance(column.at(distance)) * left
    }

    /// The same of a point of the light by two uniform numbers, and where that is.
    fn sent(&self, stretch: &Stretch, column: &Column, distance: f32, xi: [f32; 2]) -> (Vec3, Vec3) {
        let ray = &stretch.segment.ray;
        let sent = stretch.light.flux_density(ray.origin + distance * ray.direction, xi);
        (self.scattered(stretch, column, distance, sent), sent.1)
    }

    /// Mean over some pixels of what decides about the number of shadow rays, and the expected luminance under which errors do not
    /// count more.
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
        let floor = DARK * looked.iter().map(|seen| seen.0).sum::<f32>() / looked.len() as f32;
        let spread = Spread { floor, mean: 1.0 };
        let needs = looked
            .iter()
            .flat_map(|(expected, errors)| errors.iter().map(move |error| spread.need(*error, *expected)));
        let (sum, count) = needs.fold((0.0, 0_u32), |(sum, count), need| (sum + need, count + 1));
        Spread { floor, mean: if sum > 0.0 { sum / count as f32 } else { 1.0 } }
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
                let share = spread.need(stretch.error, pieces.expected) / spread.mean;
                samples = ((self.marching.samples as f32 * share.min(MOST)).round() as usize).max(1);
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
        let fog = &self.fogs[stretch.segment.medium as usize];
        let ray = &stretch.segment.ray;
        let mut knots = std::mem::take(&mut scratch.column);
        let column = media::column(fog, ray.origin, ray.direction, ray.length, &mut knots);
        let mut rays = 0;
        let mut radiance = Vec3::ZERO;
        scratch.samples.clear();
        match self.marching.placement {
            Placement::Adaptive => {
                let mut cells = std::mem::take(&mut scratch.cells);
                let march = March::new(&stretch.knots, &mut cells[..stretch.knots.len()])
                    .expect("knots as they were laid");
                let sparse = if stretch.light.has_size() { 0 } else { march.first_round(samples) };
                let Scratch { jitter, first, .. } = scratch;
                first.clear();
                first.resize(sparse, MarchSample::default());
                march.place(fill(jitter, sparse, random), first);
                let shift = [random.uniform(), random.uniform()];
                for (index, sample) in first.iter_mut().enumerate().filter(|(_, sample)| sample.weight > 0.0)
                {
                    let (found, from) = self.sent(stretch, &column, sample.distance, spread(shift, index));
                    let arrives = self.arrives(stretch, sample.distance, found, from, &mut rays);
                    sample.visibility = arrives.max_element().min(1.0);
                }
                scratch.samples.resize(samples - sparse, MarchSample::default());
                march.refine(
                    &scratch.first,
                    fill(&mut scratch.jitter, samples - sparse, random),
                    &mut scratch.samples,
                );
                scratch.cells = cells;
            }
            Placement::Uniform => {
                let step = (stretch.to - stretch.from) / samples as f32;
                scratch.samples.extend((0..samples).map(|index| MarchSample {
                    distance: stretch.from + (index as f32 + random.uniform()) * step,
                    weight: step,
                    ..MarchSample::default()
                }));
            }
            Placement::EquiAngular => {
                let offset = stretch.light.position() - ray.origin;
                let foot = offset.dot(ray.direction);
                let height = (offset - foot * ray.direction).length().max(f32::MIN_POSITIVE);
                let angle = |distance: f32| ((distance - foot) / height).atan();
                let start = angle(stretch.from);
                let step = (angle(stretch.to) - start) / samples as f32;
                scratch.samples.extend((0..samples).map(|index| {
                    let tangent = (start + (index as f32 + random.uniform()) * step).tan();
                    let distance = (foot + height * tangent).clamp(stretch.from, stretch.to);
                    let weight = step * height * (1.0 + tangent * tangent);
                    MarchSample { distance, weight, ..MarchSample::default() }
                }));
            }
            Placement::MaximumDensity => {
                let greatest = self.greatest_density(stretch);
                for _ in 0..samples {
                    let Some(distance) = fly(fog, ray, stretch, greatest, random) else { continue };
                    let place = ray.origin + distance * ray.direction;
                    let extinction = fog.mean_extinction() * fog.density.at(place);
                    let left =
                        (-fog.mean_extinction() * (column.at(distance) - column.at(stretch.from))).exp();
                    let weight = 1.0 / (samples as f32 * extinction * left);
                    scratch.samples.push(MarchSample { distance, weight, ..MarchSample::default() });
                }
            }
        }
        let shift = [random.uniform(), random.uniform()];
        for (index, sample) in scratch.samples.iter().enumerate().filter(|(_, sample)| sample.weight > 0.0) {
            let (found, from) = self.sent(stretch, &column, sample.distance, spread(shift, index));
            radiance +=
                sample.weight * self.arrives(stretch, sample.distance, found, from, &mut rays) * found;
        }
        scratch.column = knots;
        (radiance, rays)
    }

    /// Share of the light of [`Marcher::sent`] that arrives at a place of a stretch; without a shadow ray where there is none.
    fn arrives(&self, stretch: &Stretch, distance: f32, light: Vec3, from: Vec3, rays: &mut u32) -> Vec3 {
        if light == Vec3::ZERO {
            return Vec3::ZERO;
        }
        *rays += 1;
        let Stretch { segment, .. } = stretch;
        let place = segment.ray.origin + distance * segment.ray.direction;
        match self.scene.may_be_seen_through() {
            true => passage(self.scene, self.fogs, segment.interior, place, from),
            false if self.scene.occluded(place, from) => Vec3::ZERO,
            false => Vec3::ONE,
        }
    }

    /// The greatest density along a stretch.
    fn greatest_density(&self, stretch: &Stretch) -> f32 {
        let ray = &stretch.segment.ray;
        match &self.scene.medium_of(stretch.segment.medium).density {
            MediumDensity::Uniform => 1.0,
            MediumDensity::Exponential(_) => {
                let at = |t: f32| {
                    self.fogs[stretch.segment.medium as usize].density.at(ray.origin + t * ray.direction)
                };
                at(stretch.from).max(at(stretch.to))
            }
            MediumDensity::Grid(volume) => {
                volume.values.iter().fold(0.0, |most: f32, &value| most.max(value))
            }
        }
    }
}

/// How shadow rays are spread over the pieces of eye paths.
#[derive(Clone, Copy, Default)]
struct Spread {
    floor: f32,
    mean: f32,
}

impl Spread {
    /// The sum of (error / n)² / radiance² for a given sum of n is least with n in proportion to this.
    fn need(&self, error: f32, expected: f32) -> f32 {
        let relative = error / (expected * expected + self.floor * self.floor).sqrt().max(f32::MIN_POSITIVE);
        let root = relative.cbrt();
        root * root
    }
}

impl Scratch {
    fn cells(&mut self, count: usize) -> &mut [MarchCell] {
        self.cells.resize(count.max(self.cells.len()), MarchCell::default());
        &mut self.cells[..count]
    }
}

/// So many uniform numbers.
fn fill<'a>(jitter: &'a mut Vec<f32>, count: usize, random: &mut Random) -> &'a [f32] {
    jitter.clear();
    jitter.extend((0..count).map(|_| random.uniform()));
    jitter
}

/// The distance of a collision on a stretch: Woodcock's tracking; None = it flies through.
fn fly(
    fog: &Medium,
    ray: &covbeam::EyeRay,
    stretch: &Stretch,
    greatest: f32,
    random: &mut Random,
) -> Option<f32> {
    let mut distance = stretch.from;
    loop {
        distance -= (-random.uniform()).ln_1p() / (fog.mean_extinction() * greatest);
        if !(distance < stretch.to) {
            return None;
        }
        if random.uniform() * greatest < fog.density.at(ray.origin + distance * ray.direction) {
            return Some(distance);
        }
    }
}
