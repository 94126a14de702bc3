//! Where a pass needs eye rays, and how wide their light is filtered: the spectrum of the picture, from the covariance grid.

use crate::camera::Camera;
use crate::media;
use crate::random::mix;
use crate::scene::{Material, Scene};
use covbeam::{
    EyeRay, FilmFilterNode, FilmFilters, FilmLattice, FluenceGrid, ImageSpectrum, Medium, film_regions,
    pixel_threshold,
};
use covbeam_geometry::hit::Hit;
use rayon::prelude::*;
use std::sync::Arc;

const FITS: &str = "as many nodes and regions as the picture asks for";

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
    /// Along the viewing axis, at the nodes of the lattice; infinite where there is none.
    depth: Vec<f32>,
    /// Of each pixel: whether it is black, or there is none.
    black: Vec<bool>,
    regions: Vec<u32>,
    lattice: FilmLattice,
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
        let lattice =
            FilmLattice::new(camera.width, camera.height).expect("a scene's picture is not too large");
        let at = |[x, y]: [u32; 2]| depth[(y * camera.width + x) as usize];
        let depth = (0..lattice.node_count()).map(|node| at(lattice.pixel(node))).collect();
        Self { camera, depth, black, regions, lattice }
    }

    /// The region of each pixel, as [`film_regions`] numbers them.
    pub fn regions(&self) -> &[u32] {
        &self.regions
    }

    /// Where the picture's spectrum is found.
    pub fn lattice(&self) -> &FilmLattice {
        &self.lattice
    }

    /// The spectrum of the first piece of fog at the nodes of the lattice, read off the grid.
    ///
    /// - `fog`: what the camera is in.
    pub fn spectra(&self, grid: &FluenceGrid, fog: &Medium) -> Vec<ImageSpectrum> {
        (0..self.lattice.node_count())
            .into_par_iter()
            .map_init(Vec::new, |knots, node| {
                let [x, y] = self.lattice.pixel(node);
                let ray = self.ray(x, y);
                let steps = self.camera.pixel_steps(ray.direction);
                let column = media::column(fog, ray.origin, ray.direction, ray.length, knots);
                ImageSpectrum::along(&ray, &steps, grid, fog, &column)
            })
            .collect()
    }

    fn ray(&self, x: u32, y: u32) -> EyeRay {
        let camera = &self.camera;
        let direction = middle(camera, x, y);
        // Of the node that stands at this pixel.
        let lattice = &self.lattice;
        let depth = self.depth[(y / lattice.spacing * lattice.across + x / lattice.spacing) as usize];
        EyeRay { origin: camera.position, direction, length: depth / direction.dot(camera.forward) }
    }
}

fn middle(camera: &Camera, x: u32, y: u32) -> glam::Vec3 {
    camera.direction(x as f32 + 0.5, y as f32 + 0.5)
}

/// The filters of the picture's first piece of fog, and the eye rays that it needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    surfaces: Arc<FirstSurfaces>,
    pass: u32,
    /// One for each node of the lattice.
    nodes: Arc<Vec<FilmFilterNode>>,
    /// One a pixel.
    density: Arc<Vec<f32>>,
}

impl Plan {
    /// Of pass `pass`.
    ///
    /// - `spectra`: of [`FirstSurfaces::spectra`], from that pass' grid; `error`: relative bias that a filter may cause in the pass.
    /// - `paths`: light paths of the pass.
    pub fn new(
        surfaces: Arc<FirstSurfaces>,
        pass: u32,
        error: f32,
        paths: u32,
        spectra: &[ImageSpectrum],
    ) -> Self {
        let camera = &surfaces.camera;
        let lattice = surfaces.lattice;
        let mut nodes = vec![FilmFilterNode::default(); lattice.node_count()];
        let filters = FilmFilters::new(lattice, &surfaces.regions, spectra, error, &mut nodes).expect(FITS);
        let least = lattice.least_density(paths);
        let density = (0..camera.width * camera.height)
            .into_par_iter()
            .map(|pixel| filters.filter(pixel % camera.width, pixel / camera.width).density().max(least))
            .collect();
        Self { pass, nodes: Arc::new(nodes), density: Arc::new(density), surfaces }
    }

    /// The pass whose grid this was read from.
    pub fn pass(&self) -> u32 {
        self.pass
    }

    /// The first surface behind each pixel.
    pub fn surfaces(&self) -> &FirstSurfaces {
        &self.surfaces
    }

    /// The filters: none next to a silhouette, and where the grid has no data.
    pub fn filters(&self) -> FilmFilters<'_> {
        FilmFilters::of(self.surfaces.lattice, &self.surfaces.regions, &self.nodes).expect(FITS)
    }

    /// The filters at the nodes of the lattice.
    pub fn nodes(&self) -> &[FilmFilterNode] {
        &self.nodes
    }

    /// Eye rays a pixel and pass, row by row.
    pub fn density(&self) -> &[f32] {
        &self.density
    }

    /// What the pass asks pixel (x, y) for: each pass of a seed asks others.
    pub fn wanted(&self, x: u32, y: u32, seed: u32) -> Wanted {
        let pixel = (y * self.surfaces.camera.width + x) as usize;
        let chosen = |density: f32, purpose: u64| {
            let shift = mix(u64::from(seed) ^ purpose) as u32;
            pixel_threshold(x, y, self.pass, shift) < density
        };
        Wanted {
            volume: chosen(self.density[pixel], VOLUME_PURPOSE),
            surfaces: chosen(self.surface_density(pixel), SURFACE_PURPOSE),
        }
    }

    /// How often a pass looks at what is beyond that fog, in (0, 1]: always where there is something to see, and at silhouettes, which
    /// cross pixels; a quarter of the passes, for what is smaller than a pixel, where the middle of the pixel sees black or nothing.
    fn surface_density(&self, pixel: usize) -> f32 {
        if self.surfaces.black[pixel] && self.surfaces.regions[pixel] != 0 { BLACK_DENSITY } else { 1.0 }
    }
}
