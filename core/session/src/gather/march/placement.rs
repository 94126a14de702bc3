//! Placement of shadow rays: the ways to choose places along a stretch of an eye ray.

use super::shadow_rays::ShadowRays;
use super::stretch::Stretch;
use crate::random::{Random, spread};
use covbeam::{March, MarchCell, MarchKnot, MarchSample};

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

/// Places along a stretch, and memory to choose them.
#[derive(Default)]
pub(super) struct Places {
    cells: Vec<MarchCell>,
    jitter: Vec<f32>,
    first: Vec<MarchSample>,
    /// The places.
    pub(super) samples: Vec<MarchSample>,
}

impl Places {
    /// Expected radiance of a stretch with a table, and [`March::expected_error`].
    pub(super) fn expected(&mut self, stretch: &Stretch) -> [f32; 2] {
        let march = march(&stretch.knots, &mut self.cells);
        [march.expected_radiance(), march.expected_error()]
    }

    /// Chooses places of a stretch.
    ///
    /// - `rays`: those of a first round.
    pub(super) fn choose(
        &mut self,
        placement: Placement,
        count: usize,
        rays: &mut ShadowRays,
        random: &mut Random,
    ) {
        self.samples.clear();
        match placement {
            Placement::Adaptive => self.adaptive(count, rays, random),
            Placement::Uniform => self.uniform(count, rays.stretch, random),
            Placement::EquiAngular => self.equi_angular(count, rays.stretch, random),
            Placement::MaximumDensity => self.at_collisions(count, rays, random),
        }
    }

    /// [`Placement::Adaptive`].
    fn adaptive(&mut self, count: usize, rays: &mut ShadowRays, random: &mut Random) {
        let Self { cells, jitter, first, samples } = self;
        let march = march(&rays.stretch.knots, cells);
        let sparse = if rays.stretch.light.has_size() { 0 } else { march.first_round(count) };
        first.clear();
        first.resize(sparse, MarchSample::default());
        march.place(fill(jitter, sparse, random), first);
        let shift = [random.uniform(), random.uniform()];
        for (index, sample) in first.iter_mut().enumerate().filter(|(_, sample)| sample.weight > 0.0) {
            let (_, arrives) = rays.ask(sample.distance, spread(shift, index));
            sample.visibility = arrives.max_element().min(1.0);
        }
        samples.resize(count - sparse, MarchSample::default());
        march.refine(first, fill(jitter, count - sparse, random), samples);
    }

    /// [`Placement::Uniform`].
    fn uniform(&mut self, count: usize, stretch: &Stretch, random: &mut Random) {
        let step = (stretch.to - stretch.from) / count as f32;
        self.samples.extend((0..count).map(|index| MarchSample {
            distance: stretch.from + (index as f32 + random.uniform()) * step,
            weight: step,
            ..MarchSample::default()
        }));
    }

    /// [`Placement::EquiAngular`].
    fn equi_angular(&mut self, count: usize, stretch: &Stretch, random: &mut Random) {
        let ray = &stretch.segment.ray;
        let offset = stretch.light.position() - ray.origin;
        let foot = offset.dot(ray.direction);
        let height = (offset - foot * ray.direction).length().max(f32::MIN_POSITIVE);
        let angle = |distance: f32| libm::atanf((distance - foot) / height);
        let start = angle(stretch.from);
        let step = (angle(stretch.to) - start) / count as f32;
        self.samples.extend((0..count).map(|index| {
            let tangent = libm::tanf(start + (index as f32 + random.uniform()) * step);
            let distance = (foot + height * tangent).clamp(stretch.from, stretch.to);
            let weight = step * height * (1.0 + tangent * tangent);
            MarchSample { distance, weight, ..MarchSample::default() }
        }));
    }

    /// [`Placement::MaximumDensity`].
    fn at_collisions(&mut self, count: usize, rays: &ShadowRays, random: &mut Random) {
        let ShadowRays { scene, stretch, column, .. } = *rays;
        let (fog, ray) = (stretch.fog, &stretch.segment.ray);
        let greatest = stretch.greatest_density(scene);
        for _ in 0..count {
            let Some(distance) = collision(stretch, greatest, random) else { continue };
            let place = ray.origin + distance * ray.direction;
            let extinction = fog.mean_extinction() * fog.density.at(place);
            let left = libm::expf(-fog.mean_extinction() * (column.at(distance) - column.at(stretch.from)));
            let weight = 1.0 / (count as f32 * extinction * left);
            self.samples.push(MarchSample { distance, weight, ..MarchSample::default() });
        }
    }
}

/// The distance of a collision on a stretch: Woodcock's tracking; None = it flies through.
fn collision(stretch: &Stretch, greatest: f32, random: &mut Random) -> Option<f32> {
    let (fog, ray) = (stretch.fog, &stretch.segment.ray);
    let mut distance = stretch.from;
    loop {
        distance -= libm::log1pf(-random.uniform()) / (fog.mean_extinction() * greatest);
        if !(distance < stretch.to) {
            return None;
        }
        if random.uniform() * greatest < fog.density.at(ray.origin + distance * ray.direction) {
            return Some(distance);
        }
    }
}

/// Of the table of a stretch.
fn march<'a>(knots: &'a [MarchKnot], cells: &'a mut Vec<MarchCell>) -> March<'a> {
    cells.resize(knots.len().max(cells.len()), MarchCell::default());
    March::new(knots, &mut cells[..knots.len()]).expect("knots as they were laid")
}

/// So many uniform numbers.
fn fill<'a>(jitter: &'a mut Vec<f32>, count: usize, random: &mut Random) -> &'a [f32] {
    jitter.clear();
    jitter.extend((0..count).map(|_| random.uniform()));
    jitter
}
