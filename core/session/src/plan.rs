//! Where a pass needs eye rays, and how wide their light is filtered: the spectrum of the picture, from the covariance grid.

mod bend;
mod blurred;
mod first_surfaces;
pub(crate) mod grids;
pub mod radius;

pub use first_surfaces::FirstSurfaces;

use crate::kind::Kind;
use crate::random::mix;
use covbeam::{FilmFilterNode, FilmFilters, FilmLattice, ImageSpectrum, pixel_threshold};
use rayon::prelude::*;
use std::sync::Arc;

const FITS: &str = "as many nodes and regions as the picture asks for";

/// Keeps the choice of pixels apart from others.
const FOG_PURPOSE: u64 = 0x00f0_9000_0000;

/// The filters of a layer of the picture's first piece of fog in one pass: what a film keeps of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerFilters {
    /// The layer's light; None: all light.
    pub kind: Option<Kind>,
    /// The pass whose grid they were read from, counted from 1.
    pub pass: u32,
    /// Where they are known.
    pub lattice: FilmLattice,
    /// The region of each pixel, as [`film_regions`](covbeam::film_regions) numbers them.
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
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let (lattice, regions) = (*surfaces.lattice(), Arc::clone(surfaces.regions()));
        let mut nodes = vec![FilmFilterNode::default(); lattice.node_count()];
        let filters = FilmFilters::new(lattice, &regions, spectra, error, &mut nodes).expect(FITS);
        let least = lattice.least_density(paths);
        let of_pixel = |pixel: u32| {
            let (x, y) = (pixel % lattice.width, pixel / lattice.width);
            (x > 0 || !cancelled()).then(|| filters.filter(x, y).density().max(least))
        };
        let density: Option<Vec<f32>> =
            (0..lattice.width * lattice.height).into_par_iter().map(of_pixel).collect();
        let density = density?;
        let (nodes, density) = (Arc::new(nodes), Arc::new(density));
        Some(Self { filters: LayerFilters { kind, pass, lattice, regions, nodes, density }, surfaces })
    }

    /// The same with an eye ray through each pixel.
    pub fn everywhere(mut self) -> Self {
        self.filters.density = Arc::new(vec![1.0; self.filters.density.len()]);
        self
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
        let pixel = (y * self.filters.lattice.width + x) as usize;
        is_chosen(self.filters.density[pixel], [x, y], self.filters.pass, seed, FOG_PURPOSE)
    }
}

fn is_chosen(density: f32, [x, y]: [u32; 2], pass: u32, seed: u32, purpose: u64) -> bool {
    let shift = mix(u64::from(seed) ^ purpose) as u32;
    pixel_threshold(x, y, pass, shift) < density
}
