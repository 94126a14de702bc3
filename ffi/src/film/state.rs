//! What a `covbeam_film` is: the sums of a picture, the plan of its next pass, and the picture that they make.
//!
//! The sums are the handle's own memory: blocks of them are summed once and then read by all threads, and
//! must not change in between.

use super::layer::{FITS, Layer, filled};
use crate::heap::reserved;
use crate::status::{Failure, cancelled};
use covbeam_core::{
    FILM_TILE, FILM_TILE_PIXELS, FilmFilterNode, FilmFilters, FilmLattice, FilmPixel, FilmSums, FilmUnit,
    ImageSpectrum, verify_filters,
};
use glam::Vec3;

/// Units of the sums of densities in 1: whole numbers, so that the order of the passes does not count.
const UNITS: f64 = (1_u64 << 32) as f64;

/// Pixels, and nodes of the lattice, between two polls: a millisecond.
const PIXELS: usize = 1 << 15;
const NODES: usize = 16;

/// What one eye ray saw.
pub(super) struct Seen {
    pub(super) pixel: usize,
    pub(super) volume: Option<Vec3>,
    pub(super) rest: Option<Vec3>,
}

pub(crate) struct Film {
    lattice: FilmLattice,
    unit: FilmUnit,
    regions: Vec<u32>,
    volume: Vec<FilmSums>,
    /// Empty as long as no eye ray has brought any.
    rest: Vec<FilmSums>,
    /// Sum of the densities of all passes.
    expected: Vec<u64>,
    plan: Plan,
    /// Number of the latest pass, and its filters.
    latest: Option<u32>,
    filters: Vec<FilmFilterNode>,
    verified: Option<Verified>,
}

/// Of the pass that comes next.
struct Plan {
    /// None: no pass has been planned since the latest one was added.
    pass: Option<u32>,
    filters: Vec<FilmFilterNode>,
    density: Vec<f32>,
}

/// What the samples make of the picture.
struct Verified {
    filters: Vec<FilmFilterNode>,
    volume: Layer,
    rest: Option<Layer>,
}

impl Film {
    /// - `regions`: one a pixel.
    pub(super) fn new(lattice: FilmLattice, typical: f32, regions: Vec<u32>) -> Result<Self, Failure> {
        let (pixels, nodes) = (regions.len(), lattice.node_count());
        Ok(Self {
            lattice,
            unit: FilmUnit::new(typical),
            volume: filled(pixels, FilmSums::default())?,
            rest: Vec::new(),
            expected: filled(pixels, 0)?,
            plan: Plan {
                pass: None,
                filters: filled(nodes, FilmFilterNode::default())?,
                density: filled(pixels, 0.0)?,
            },
            latest: None,
            filters: filled(nodes, FilmFilterNode::default())?,
            verified: None,
            regions,
        })
    }

    pub(super) fn lattice(&self) -> &FilmLattice {
        &self.lattice
    }

    /// Number of bytes.
    pub(super) fn memory(&self) -> usize {
        let sums =
            size_of_val(&self.volume[..]) + size_of_val(&self.rest[..]) + size_of_val(&self.expected[..]);
        let plan = size_of_val(&self.plan.density[..]) + size_of_val(&self.regions[..]);
        let layer = |layer: &Layer| size_of_val(&layer.samples[..]) + size_of_val(&layer.blocks[..]);
        let layers = |v: &Verified| layer(&v.volume) + v.rest.as_ref().map_or(0, layer);
        sums + plan + 3 * size_of_val(&self.filters[..]) + self.verified.as_ref().map_or(0, layers)
    }

    /// Finds filters and densities of a pass. Stopped, the plan is as it was.
    pub(super) fn plan(
        &mut self,
        pass: u32,
        error: f32,
        paths: u32,
        spectra: &[ImageSpectrum],
        go_on: &mut impl FnMut() -> bool,
    ) -> Result<(), Failure> {
        let mut nodes = filled(spectra.len(), FilmFilterNode::default())?;
        let filters = FilmFilters::new(self.lattice, &self.regions, spectra, error, &mut nodes).expect(FITS);
        let (width, least) = (self.lattice.width as usize, self.lattice.least_density(paths));
        let mut density = reserved(self.regions.len())?;
        for pixel in 0..self.regions.len() {
            if pixel % PIXELS == 0 && !go_on() {
                return Err(cancelled());
            }
            let filter = filters.filter((pixel % width) as u32, (pixel / width) as u32);
            density.push(filter.density().max(least));
        }
        self.plan = Plan { pass: Some(pass), filters: nodes, density };
        Ok(())
    }

    /// Eye rays a pixel in the pass that is planned.
    pub(super) fn density(&self) -> Option<&[f32]> {
        self.plan.pass.map(|_| &self.plan.density[..])
    }

    /// Memory for what is seen beyond the fog, which not every picture needs.
    pub(super) fn want_rest(&mut self) -> Result<(), Failure> {
        if self.rest.is_empty() {
            self.rest = filled(self.regions.len(), FilmSums::default())?;
        }
        Ok(())
    }

    /// Adds the pass that is planned.
    pub(super) fn add(&mut self, rays: impl Iterator<Item = Seen>) {
        let Some(pass) = self.plan.pass.take() else { return };
        self.verified = None;
        for Seen { pixel, volume, rest } in rays {
            for (sums, seen) in [(&mut self.volume, volume), (&mut self.rest, rest)] {
                if let Some(radiance) = seen {
                    sums[pixel].add(&self.unit, radiance, pass % 2 == 1);
                }
            }
        }
        for (sum, density) in self.expected.iter_mut().zip(&self.plan.density) {
            *sum = sum.saturating_add((f64::from(*density) * UNITS).round_ties_even() as u64);
        }
        if self.latest.is_none_or(|latest| latest < pass) {
            self.latest = Some(pass);
            self.filters.copy_from_slice(&self.plan.filters);
        }
    }

    /// Lets the samples verify the filters. Stopped, the film is as it was.
    pub(super) fn verify(&mut self, go_on: &mut impl FnMut() -> bool) -> Result<(), Failure> {
        let unit = self.unit;
        let expected = |i: usize| self.expected[i] as f64 / UNITS;
        let volume = self.layer(&self.volume, expected, &unit, go_on)?;
        let rest = if self.rest.is_empty() {
            None
        } else {
            Some(self.layer(&self.rest, |i| f64::from(self.rest[i].rays()), &unit, go_on)?)
        };
        let predicted = FilmFilters::of(self.lattice, &self.regions, &self.filters).expect(FITS);
        let mut evidence = reserved(self.filters.len())?;
        for node in 0..self.filters.len() {
            if node % NODES == 0 && !go_on() {
                return Err(cancelled());
            }
            evidence.push(predicted.evidence(node, &volume.view));
        }
        let mut filters = reserved(self.filters.len())?;
        filters.extend_from_slice(&self.filters);
        verify_filters(&self.lattice, &evidence, &mut filters).expect(FITS);
        self.verified = Some(Verified { filters, volume, rest });
        Ok(())
    }

    fn layer(
        &self,
        sums: &[FilmSums],
        expected: impl Fn(usize) -> f64,
        unit: &FilmUnit,
        go_on: &mut impl FnMut() -> bool,
    ) -> Result<Layer, Failure> {
        let mut samples = reserved(sums.len())?;
        for (i, sums) in sums.iter().enumerate() {
            if i % PIXELS == 0 && !go_on() {
                return Err(cancelled());
            }
            samples.push(sums.sample(unit, expected(i)));
        }
        // SAFETY: the film's regions are never changed, and dropped or moved only with the layers.
        unsafe { Layer::new(&self.lattice, samples, &self.regions) }
    }

    pub(super) fn is_verified(&self) -> bool {
        self.verified.is_some()
    }

    /// Hands out the pixels of whole tiles of a verified film, each with its number: all in it, and the light before the first surface alone.
    pub(super) fn rows(&self, rows: core::ops::Range<u32>, mut give: impl FnMut(usize, FilmPixel, Vec3)) {
        let Some(Verified { filters, volume, rest }) = &self.verified else { return };
        let filters = FilmFilters::of(self.lattice, &self.regions, filters).expect(FITS);
        let FilmLattice { width, height, .. } = self.lattice;
        let mut tile = [FilmPixel::default(); FILM_TILE_PIXELS];
        for top in rows.step_by(FILM_TILE as usize) {
            for left in (0..width).step_by(FILM_TILE as usize) {
                volume.view.tile(left, top, &filters, &mut tile);
                for (i, found) in tile.iter().enumerate() {
                    let (x, y) = (left + i as u32 % FILM_TILE, top + i as u32 / FILM_TILE);
                    if x >= width || y >= height {
                        continue;
                    }
                    let index = y as usize * width as usize + x as usize;
                    let mut pixel = *found;
                    if let Some(rest) = rest {
                        add_rest(rest, index, [x, y], &mut pixel);
                    }
                    give(index, pixel, found.radiance);
                }
            }
        }
    }
}

/// Adds the light from beyond, which pixels keep to themselves; those without an eye ray take that of the nearest ones as long as they have
/// none.
fn add_rest(rest: &Layer, index: usize, [x, y]: [u32; 2], pixel: &mut FilmPixel) {
    let own = &rest.samples[index];
    if own.weight > 0.0 {
        pixel.radiance += own.radiance / own.weight;
        pixel.difference += own.halves().map_or(0.0, |[odd, even]| odd - even);
    } else {
        pixel.radiance += rest.view.nearby(x, y);
    }
}
