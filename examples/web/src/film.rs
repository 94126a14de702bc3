//! What the passes add up to, and covbeam's filters of it: few eye rays where the grid says that the picture
//! is smooth.

use crate::eye::{Size, eye_ray};
use crate::scene::Scene;
use covbeam::{
    Column, EyeRay, FILM_TILE, FILM_TILE_PIXELS, FilmFilterNode, FilmFilters, FilmLattice, FilmNode,
    FilmPixel, FilmSample, FilmSums, FilmUnit, FluenceGrid, ImageSpectrum, PixelStep, Reconstruction, Vec3,
    error_bound, film_regions, pixel_threshold, verify_filters,
};

/// Relative bias that a filter may cause in the first pass.
const FILTER_ERROR: f32 = 0.01;

const FITS: &str = "as many elements as pixels or nodes";

/// Sums over passes, a pixel each.
pub(crate) struct Film {
    size: Size,
    unit: FilmUnit,
    /// The fog before the ball, or without end.
    fog: Vec<FilmSums>,
    /// Eye rays that were expected there.
    expected: Vec<f64>,
    /// What is seen in the ball, by an eye ray a pass.
    ball: Vec<Vec3>,
    passes: u32,
}

impl Film {
    /// - `typical` \[W/(m² sr)\]: a radiance of the picture, within a factor of a thousand.
    pub(crate) fn new(size: Size, typical: f32) -> Self {
        let pixels = size.pixels();
        Self {
            size,
            unit: FilmUnit::new(typical),
            fog: vec![FilmSums::default(); pixels],
            expected: vec![0.0; pixels],
            ball: vec![Vec3::ZERO; pixels],
            passes: 0,
        }
    }

    pub(crate) fn passes(&self) -> u32 {
        self.passes
    }

    /// The next pass begins: its number, from 1 on. `densities`: expected eye rays of each pixel.
    pub(crate) fn begin_pass(&mut self, densities: &[f32]) -> u32 {
        self.passes += 1;
        for (expected, density) in self.expected.iter_mut().zip(densities) {
            *expected += f64::from(*density);
        }
        self.passes
    }

    pub(crate) fn add_fog(&mut self, pixel: usize, radiance: Vec3) {
        self.fog[pixel].add(&self.unit, radiance, self.passes % 2 == 1);
    }

    pub(crate) fn add_ball(&mut self, pixel: usize, radiance: Vec3) {
        self.ball[pixel] += radiance;
    }

    fn samples(&self) -> Vec<FilmSample> {
        self.fog
            .iter()
            .zip(&self.expected)
            .map(|(sums, &expected)| sums.sample(&self.unit, expected))
            .collect()
    }

    fn with_ball(&self, pixel: usize, fog: Vec3) -> Vec3 {
        fog + self.ball[pixel] / self.passes.max(1) as f32
    }

    /// The mean of the passes, without filters.
    pub(crate) fn mean(&self, out: &mut [Vec3]) {
        for (pixel, sample) in self.samples().iter().enumerate() {
            out[pixel] = self.with_ball(pixel, sample.radiance / sample.weight.max(f32::MIN_POSITIVE));
        }
    }

    /// The same through the plan's filters, narrowed where the samples disagree with them.
    pub(crate) fn filtered(&self, plan: &Plan, out: &mut [Vec3]) {
        let Size { width, height } = self.size;
        let samples = self.samples();
        let mut blocks = vec![FilmNode::default(); Reconstruction::node_count(width, height)];
        let picture = Reconstruction::new(width, height, &samples, &plan.regions, &mut blocks).expect(FITS);
        let mut nodes = plan.nodes.clone();
        let planned = FilmFilters::of(plan.lattice, &plan.regions, &plan.nodes).expect(FITS);
        let evidence: Vec<_> = (0..nodes.len()).map(|node| planned.evidence(node, &picture)).collect();
        verify_filters(&plan.lattice, &evidence, &mut nodes).expect(FITS);
        let filters = FilmFilters::of(plan.lattice, &plan.regions, &nodes).expect(FITS);
        for y in (0..height).step_by(FILM_TILE as usize) {
            for x in (0..width).step_by(FILM_TILE as usize) {
                let mut tile = [FilmPixel::default(); FILM_TILE_PIXELS];
                picture.tile(x, y, &filters, &mut tile);
                for (i, found) in tile.iter().enumerate() {
                    let [px, py] = [x + i as u32 % FILM_TILE, y + i as u32 / FILM_TILE];
                    let pixel = (py * width + px) as usize;
                    out[pixel] = self.with_ball(pixel, found.radiance);
                }
            }
        }
    }
}

/// Filters of a pass and the eye rays that go with them.
pub(crate) struct Plan {
    lattice: FilmLattice,
    /// The ball's disk, and what is around.
    regions: Vec<u32>,
    nodes: Vec<FilmFilterNode>,
    /// Expected eye rays of each pixel in the pass.
    pub(crate) densities: Vec<f32>,
}

impl Plan {
    pub(crate) fn new(scene: &Scene, size: Size) -> Self {
        let Size { width, height } = size;
        let lattice = FilmLattice::new(width, height).expect("a picture of a screen's size");
        let depth = |pixel: u32| {
            let ray = eye_ray(size, [pixel % width, pixel / width], [0.5; 2]);
            scene.ball.distance(&ray) * ray.direction.z
        };
        let depths: Vec<f32> = (0..width * height).map(depth).collect();
        let mut regions = vec![0; size.pixels()];
        film_regions(width, height, &depths, &mut regions).expect(FITS);
        let nodes = vec![FilmFilterNode::default(); lattice.node_count()];
        Self { lattice, regions, nodes, densities: vec![1.0; size.pixels()] }
    }

    /// Lays out a pass of so many photons, from what the grid knows by now.
    pub(crate) fn lay_out(&mut self, scene: &Scene, grid: &FluenceGrid, size: Size, pass: u32, photons: u32) {
        let spectrum = |node: usize| {
            let [x, y] = self.lattice.pixel(node);
            let direction = |x: u32, y: u32| eye_ray(size, [x, y], [0.5; 2]).direction;
            let ray = eye_ray(size, [x, y], [0.5; 2]);
            let steps = [direction(x + 1, y), direction(x, y + 1)]
                .map(|next| PixelStep { origin: Vec3::ZERO, direction: next - ray.direction });
            let length = scene.ball.distance(&ray);
            let ray = EyeRay { origin: ray.origin, direction: ray.direction, length };
            ImageSpectrum::along(&ray, &steps, grid, &scene.fog, &Column::Uniform)
        };
        let spectra: Vec<_> = (0..self.nodes.len()).map(spectrum).collect();
        let error = error_bound(FILTER_ERROR, pass);
        let filters = FilmFilters::new(self.lattice, &self.regions, &spectra, error, &mut self.nodes);
        let filters = filters.expect(FITS);
        let least = self.lattice.least_density(photons);
        for (pixel, density) in self.densities.iter_mut().enumerate() {
            let [x, y] = [pixel as u32 % size.width, pixel as u32 / size.width];
            *density = filters.filter(x, y).density().max(least);
        }
    }

    /// Whether a pixel's fog gets an eye ray in a pass.
    pub(crate) fn chooses(&self, size: Size, pixel: usize, pass: u32) -> bool {
        let [x, y] = [pixel as u32 % size.width, pixel as u32 / size.width];
        pixel_threshold(x, y, pass, 0) < self.densities[pixel]
    }
}
