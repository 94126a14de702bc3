//! Where a pass needs eye rays, and how wide their light is filtered: the spectrum of the picture, from the covariance grid.

use crate::camera::Camera;
use crate::eye::straight_irradiance;
use crate::kind::Kind;
use crate::media;
use crate::optics::{Interior, facing_normal};
use crate::random::mix;
use crate::scene::{Material, Scene};
use covbeam::{
    EyeRay, FilmFilterNode, FilmFilters, FilmLattice, FluenceGrid, ImageSpectrum, Medium, film_regions,
    pixel_threshold,
};
use covbeam_geometry::hit::Hit;
use rayon::prelude::*;
use std::sync::Arc;

/// A shadow's border crosses a pixel around which straight light varies by more than this.
const EDGE: f32 = 0.5;

const FITS: &str = "as many nodes and regions as the picture asks for";

/// Share of the passes in which pixels with nothing to see look beyond the fog.
const BLACK_DENSITY: f32 = 0.25;

/// Keep the choices of pixels for both apart.
const FOG_PURPOSE: u64 = 0x00f0_9000_0000;
const SURFACE_PURPOSE: u64 = 0x5afa_ce00_0000;

/// The first surface behind each pixel.
#[derive(Debug, PartialEq)]
pub struct FirstSurfaces {
    camera: Camera,
    /// Along the viewing axis, at the nodes of the lattice; infinite where there is none.
    depth: Vec<f32>,
    /// Of each pixel: whether it and those around it are black, or there is none, and no silhouette crosses it.
    black: Vec<bool>,
    /// Of each pixel: whether a silhouette or the border of a shadow on it crosses it.
    edge: Vec<bool>,
    regions: Arc<Vec<u32>>,
    lattice: FilmLattice,
}

impl FirstSurfaces {
    /// Looks at the scene through the middle of each pixel.
    pub fn new(scene: &Scene) -> Self {
        let camera = scene.camera;
        let pixels = camera.width * camera.height;
        let interior = Interior::at(scene, camera.position);
        let fogs = media::all(scene);
        let (depth, (black, lit)): (Vec<f32>, (Vec<bool>, Vec<f32>)) = (0..pixels)
            .into_par_iter()
            .map(|index| {
                let direction = middle(&camera, index % camera.width, index / camera.width);
                let hit = scene.intersect(camera.position, direction, f32::INFINITY);
                let depth = hit.map_or(f32::INFINITY, |hit| hit.distance * direction.dot(camera.forward));
                let is_black = |hit: Hit| scene.objects[hit.object as usize].material == Material::Black;
                let lit = hit.map_or(0.0, |hit| lit(scene, &fogs, interior, direction, &hit));
                (depth, (hit.is_none_or(is_black), lit))
            })
            .unzip();
        let mut regions = vec![0; pixels as usize];
        film_regions(camera.width, camera.height, &depth, &mut regions)
            .expect("a scene's picture is not too large");
        let lattice =
            FilmLattice::new(camera.width, camera.height).expect("a scene's picture is not too large");
        let at = |[x, y]: [u32; 2]| depth[(y * camera.width + x) as usize];
        let depth = (0..lattice.node_count()).map(|node| at(lattice.pixel(node))).collect();
        let (black, edge) = (0..pixels)
            .into_par_iter()
            .map(|index| {
                let has_silhouette = regions[index as usize] == 0;
                let around = || around(&camera, index % camera.width, index / camera.width);
                let [least, most] = around().fold([f32::INFINITY, 0.0], |[least, most], pixel| {
                    [lit[pixel].min(least), lit[pixel].max(most)]
                });
                let is_black = !has_silhouette && around().all(|pixel| black[pixel]);
                (is_black, has_silhouette || least < EDGE * most)
            })
            .unzip();
        Self { camera, depth, black, edge, regions: Arc::new(regions), lattice }
    }

    /// Whether a pass looks at what is beyond the fog in pixel (x, y): always where there is something to see in it or beside it, and at
    /// silhouettes, which cross pixels; else in a quarter of the passes, for what is smaller than a pixel.
    pub fn are_wanted(&self, x: u32, y: u32, pass: u32, seed: u32) -> bool {
        let density = if self.black[self.index(x, y)] { BLACK_DENSITY } else { 1.0 };
        is_chosen(density, [x, y], pass, seed, SURFACE_PURPOSE)
    }

    /// Whether a silhouette or the border of a shadow on a surface crosses pixel (x, y).
    pub fn has_edge(&self, x: u32, y: u32) -> bool {
        self.edge[self.index(x, y)]
    }

    fn index(&self, x: u32, y: u32) -> usize {
        (y * self.camera.width + x) as usize
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

/// Straight light on a surface, seen from where the ray to it starts, up to a factor.
fn lit(scene: &Scene, fogs: &[Medium], interior: Interior, direction: glam::Vec3, hit: &Hit) -> f32 {
    let albedo = scene.objects[hit.object as usize].material.diffuse();
    if albedo == glam::Vec3::ZERO {
        return 0.0;
    }
    let normal = facing_normal(hit, direction);
    let start = hit.leave(normal);
    let sum = straight_irradiance(scene, fogs, interior, start, |light| {
        let (density, from) = light.flux_density(start, [0.0; 2]);
        (density * (from - start).normalize_or_zero().dot(normal).max(0.0), from)
    });
    (albedo * sum).element_sum()
}

/// The numbers of a pixel and of the eight around it.
fn around(camera: &Camera, x: u32, y: u32) -> impl Iterator<Item = usize> {
    let Camera { width, height, .. } = *camera;
    let near = |at: u32, end: u32| at.saturating_sub(1)..=(at + 1).min(end - 1);
    near(y, height).flat_map(move |y| near(x, width).map(move |x| (y * width + x) as usize))
}

/// Towards the middle of pixel (x, y).
pub(crate) fn middle(camera: &Camera, x: u32, y: u32) -> glam::Vec3 {
    camera.direction(x as f32 + 0.5, y as f32 + 0.5)
}

/// The filters of a layer of the picture's first piece of fog in one pass: what a film keeps of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerFilters {
    /// The layer's light; None: all light.
    pub kind: Option<Kind>,
    /// The pass whose grid they were read from, counted from 1.
    pub pass: u32,
    /// Where they are known.
    pub lattice: FilmLattice,
    /// The region of each pixel, as [`film_regions`] numbers them.
    pub regions: Arc<Vec<u32>>,
    /// One for each node of the lattice: none next to a silhouette, and where the grid has no data.
    pub nodes: Arc<Vec<FilmFilterNode>>,
    /// Eye rays a pixel and pass, row by row.
    pub density: Arc<Vec<f32>>,
}

impl LayerFilters {
    /// To be looked up.
    pub fn filters(&self) -> FilmFilters<'_> {
        FilmFilters::of(self.lattice, &self.regions, &self.nodes).expect(FITS)
    }
}

/// The filters of a layer of the picture's first piece of fog, and the eye rays that it needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    surfaces: Arc<FirstSurfaces>,
    filters: LayerFilters,
}

impl Plan {
    /// Of pass `pass`.
    ///
    /// - `kind`: the layer's light; None: all light.
    /// - `spectra`: of [`FirstSurfaces::spectra`], from that pass' grid; `error`: relative bias that a filter may cause in the pass.
    /// - `paths`: light paths of the pass.
    pub fn new(
        surfaces: Arc<FirstSurfaces>,
        kind: Option<Kind>,
        pass: u32,
        error: f32,
        paths: u32,
        spectra: &[ImageSpectrum],
    ) -> Self {
        let camera = &surfaces.camera;
        let (lattice, regions) = (surfaces.lattice, Arc::clone(&surfaces.regions));
        let mut nodes = vec![FilmFilterNode::default(); lattice.node_count()];
        let filters = FilmFilters::new(lattice, &regions, spectra, error, &mut nodes).expect(FITS);
        let least = lattice.least_density(paths);
        let density = (0..camera.width * camera.height)
            .into_par_iter()
            .map(|pixel| filters.filter(pixel % camera.width, pixel / camera.width).density().max(least))
            .collect();
        let (nodes, density) = (Arc::new(nodes), Arc::new(density));
        Self { filters: LayerFilters { kind, pass, lattice, regions, nodes, density }, surfaces }
    }

    /// The first surface behind each pixel.
    pub fn surfaces(&self) -> &FirstSurfaces {
        &self.surfaces
    }

    /// The filters.
    pub fn filters(&self) -> &LayerFilters {
        &self.filters
    }

    /// Eye rays a pixel and pass, row by row.
    pub fn density(&self) -> &[f32] {
        &self.filters.density
    }

    /// Whether the pass asks pixel (x, y) for an eye ray. Plans of the same pass ask the same pixels, as far as their densities go; each
    /// pass of a seed asks others.
    pub fn wants(&self, x: u32, y: u32, seed: u32) -> bool {
        let pixel = (y * self.surfaces.camera.width + x) as usize;
        is_chosen(self.filters.density[pixel], [x, y], self.filters.pass, seed, FOG_PURPOSE)
    }
}

fn is_chosen(density: f32, [x, y]: [u32; 2], pass: u32, seed: u32, purpose: u64) -> bool {
    let shift = mix(u64::from(seed) ^ purpose) as u32;
    pixel_threshold(x, y, pass, shift) < density
}
