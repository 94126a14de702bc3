//! Where a pass needs eye rays, and how wide their light is filtered: the spectrum of the picture, from the covariance grid.

use crate::camera::Camera;
use crate::fog::Fog;
use crate::geometry::Hit;
use crate::random::mix;
use crate::scene::{Material, Scene};
use covbeam::{EyeRay, FluenceGrid, ImageFilter, ImageSpectrum, film_regions, pixel_threshold};
use rayon::prelude::*;
use std::sync::Arc;

/// The picture's spectrum is found for every sixth pixel across and down, and interpolated between them: voxels are larger.
const SPACING: u32 = 6;

/// Largest standard deviation of a filter, as a share of the side of a square as large as the picture.
const WIDEST_SHARE: f32 = 1.0 / 16.0;

/// Share of the passes in which pixels with nothing to see look beyond the fog.
const BLACK_DENSITY: f32 = 0.25;

/// Keep the choices of pixels for both apart.
const VOLUME_PURPOSE: u64 = 0x00f0_9000_0000;
const SURFACE_PURPOSE: u64 = 0x5afa_ce00_0000;

/// What an eye ray through a pixel is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// The fog before the first surface.
    pub volume: bool,
    /// What is beyond it.
    pub surfaces: bool,
}

impl Wanted {
    /// Everything.
    pub const ALL: Self = Self { volume: true, surfaces: true };

    /// Whether there is no eye ray at all.
    pub fn is_nothing(self) -> bool {
        !(self.volume || self.surfaces)
    }
}

/// The first surface behind each pixel.
#[derive(Debug, PartialEq)]
pub struct FirstSurfaces {
    camera: Camera,
    /// Along the viewing axis; infinite where there is none.
    depth: Vec<f32>,
    /// Whether it is black, or there is none.
    black: Vec<bool>,
    regions: Vec<u32>,
}

impl FirstSurfaces {
    /// Looks at the scene through the middle of each pixel.
    pub fn new(scene: &Scene) -> Self {
        let camera = scene.camera;
        let pixels = camera.width * camera.height;
        let (depth, black): (Vec<f32>, Vec<bool>) = (0..pixels)
            .into_par_iter()
            .map(|index| {
                let direction = middle(&camera, index % camera.width, index / camera.width);
                let hit = scene.intersect(camera.position, direction, f32::INFINITY);
                let depth = hit.map_or(f32::INFINITY, |hit| hit.distance * direction.dot(camera.forward));
                let is_black = |hit: Hit| scene.objects[hit.object as usize].material == Material::Black;
                (depth, hit.is_none_or(is_black))
            })
            .unzip();
        let mut regions = vec![0; pixels as usize];
        film_regions(camera.width, camera.height, &depth, &mut regions)
            .expect("a scene's picture is not too large");
        Self { camera, depth, black, regions }
    }

    /// The region of each pixel, as [`film_regions`] numbers them.
    pub fn regions(&self) -> &[u32] {
        &self.regions
    }

    fn ray(&self, x: u32, y: u32) -> EyeRay {
        let camera = &self.camera;
        let direction = middle(camera, x, y);
        let depth = self.depth[(y * camera.width + x) as usize];
        EyeRay { origin: camera.position, direction, length: depth / direction.dot(camera.forward) }
    }
}

fn middle(camera: &Camera, x: u32, y: u32) -> glam::Vec3 {
    camera.direction(x as f32 + 0.5, y as f32 + 0.5)
}

/// The spectrum of the picture's first piece of fog, and the filters that follow from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    surfaces: Arc<FirstSurfaces>,
    pass: u32,
    /// One a pixel.
    filters: Arc<Vec<ImageFilter>>,
}

/// The picture's spectrum at some pixels.
struct Lattice<'a> {
    surfaces: &'a FirstSurfaces,
    /// Number of them across.
    across: u32,
    spectra: Vec<ImageSpectrum>,
}

impl Plan {
    /// Reads the spectrum off the grid.
    ///
    /// - `pass`: which pass' grid it is; `error`: relative bias that a filter may cause in it.
    /// - `fog`: what the camera is in.
    pub fn new(surfaces: Arc<FirstSurfaces>, pass: u32, error: f32, grid: &FluenceGrid, fog: &Fog) -> Self {
        let camera = &surfaces.camera;
        let (across, down) = (camera.width.div_ceil(SPACING), camera.height.div_ceil(SPACING));
        let spectra = (0..across * down)
            .into_par_iter()
            .map_init(Vec::new, |knots, node| {
                let [x, y] = place(camera, [node % across, node / across]);
                let ray = surfaces.ray(x, y);
                let steps = camera.pixel_steps(ray.direction);
                let column = fog.column(ray.origin, ray.direction, ray.length, knots);
                ImageSpectrum::along(&ray, &steps, grid, fog.medium, &fog.density, &column)
            })
            .collect();
        let widest = WIDEST_SHARE * (camera.width as f32 * camera.height as f32).sqrt();
        let lattice = Lattice { surfaces: &surfaces, across, spectra };
        let filters = (0..camera.width * camera.height).into_par_iter().map(|pixel| {
            let spectrum = lattice.spectrum(pixel % camera.width, pixel / camera.width);
            spectrum.map_or(ImageFilter::NONE, |spectrum| spectrum.filter(error, widest))
        });
        let filters = Arc::new(filters.collect());
        Self { pass, filters, surfaces }
    }

    /// The pass whose grid this was read from.
    pub fn pass(&self) -> u32 {
        self.pass
    }

    /// The first surface behind each pixel.
    pub fn surfaces(&self) -> &FirstSurfaces {
        &self.surfaces
    }

    /// The filter of each pixel, row by row: none next to a silhouette, and where the grid has no opinion.
    pub fn filters(&self) -> &[ImageFilter] {
        &self.filters
    }

    /// What the pass asks pixel (x, y) for: each pass of a seed asks others.
    pub fn wanted(&self, x: u32, y: u32, seed: u32) -> Wanted {
        let pixel = (y * self.surfaces.camera.width + x) as usize;
        let chosen = |density: f32, purpose: u64| {
            let shift = mix(u64::from(seed) ^ purpose) as u32;
            pixel_threshold(x, y, self.pass, shift) < density
        };
        Wanted {
            volume: chosen(self.filters[pixel].density(), VOLUME_PURPOSE),
            surfaces: chosen(self.surface_density(pixel), SURFACE_PURPOSE),
        }
    }

    /// How often a pass looks at what is beyond that fog, in (0, 1]: always where there is something to see; a quarter of the passes, for
    /// what is smaller than a pixel, where the middle of the pixel sees black or nothing.
    fn surface_density(&self, pixel: usize) -> f32 {
        if self.surfaces.black[pixel] { BLACK_DENSITY } else { 1.0 }
    }
}

impl Lattice<'_> {
    /// Bilinear between the lattice's pixels that lie in the same region.
    fn spectrum(&self, x: u32, y: u32) -> Option<ImageSpectrum> {
        let camera = &self.surfaces.camera;
        let regions = &self.surfaces.regions;
        let region = regions[(y * camera.width + x) as usize];
        if region == 0 {
            return None;
        }
        let down = self.spectra.len() as u32 / self.across;
        let along = |at: u32, count: u32| {
            let position =
                ((at as f32 - (SPACING / 2) as f32) / SPACING as f32).clamp(0.0, (count - 1) as f32);
            let low = (position as u32).min(count.saturating_sub(2));
            (low, position - low as f32)
        };
        let ((column, right), (row, below)) = (along(x, self.across), along(y, down));
        let mut sum = ImageSpectrum::default();
        for (i, wx) in [(0, 1.0 - right), (1, right)] {
            for (j, wy) in [(0, 1.0 - below), (1, below)] {
                let (i, j) = (column + i, row + j);
                if wx * wy == 0.0 || i >= self.across || j >= down {
                    continue;
                }
                let [px, py] = place(camera, [i, j]);
                let node = &self.spectra[(j * self.across + i) as usize];
                if regions[(py * camera.width + px) as usize] != region || node.weight == 0.0 {
                    continue;
                }
                // Weighted by light, as along the ray.
                let weight = wx * wy * node.weight;
                sum.xx += weight * node.xx;
                sum.xy += weight * node.xy;
                sum.yy += weight * node.yy;
                sum.weight += weight;
            }
        }
        let ImageSpectrum { xx, xy, yy, weight } = sum;
        (weight > 0.0).then(|| ImageSpectrum { xx: xx / weight, xy: xy / weight, yy: yy / weight, weight })
    }
}

/// The pixel that a point of the lattice stands for.
fn place(camera: &Camera, [i, j]: [u32; 2]) -> [u32; 2] {
    let at = |i: u32, count: u32| (i * SPACING + SPACING / 2).min(count - 1);
    [at(i, camera.width), at(j, camera.height)]
}
