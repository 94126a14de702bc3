//! The picture in tiles, its light interpolated where it varies little.

use super::{FilmFilters, ImageFilter, Reconstruction, corners};
use glam::Vec3;
use libm::sqrtf;

/// Pixels along the side of a tile, and in it.
pub const FILM_TILE: u32 = 8;
/// Pixels of a tile.
pub const FILM_TILE_PIXELS: usize = (FILM_TILE * FILM_TILE) as usize;

/// Light is interpolated over at most this share of the smallest standard deviation of the filters around.
const STEP_SHARE: f32 = 1.0;

/// A pixel of a picture.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilmPixel {
    /// Through its filter.
    pub radiance: Vec3,
    /// Squared standard error of its luminance, if it has a filter and that was verified; else 0.
    pub variance: f32,
    /// Luminance of the odd passes minus that of the even ones, if it has no filter; else 0.
    pub difference: f32,
}

impl Reconstruction<'_> {
    /// The picture in a tile of [`FILM_TILE`] x [`FILM_TILE`] pixels.
    ///
    /// Where filters are wide, the light is found at some pixels of a region and interpolated between them: a
    /// filter makes it vary slowly. So the cost a pixel does not grow with the filters' width.
    ///
    /// - `x`, `y`: of the tile's upper left pixel, multiples of [`FILM_TILE`].
    /// - `filters`: of a picture of the same size.
    /// - `out`: row by row; pixels outside the picture are left alone.
    ///
    /// Cost: 0.5 to 1 µs a pixel of a picture, with verification and all else (`measure picture`).
    pub fn tile(&self, x: u32, y: u32, filters: &FilmFilters, out: &mut [FilmPixel; FILM_TILE_PIXELS]) {
        if x >= self.width || y >= self.height || filters.lattice.width != self.width {
            return;
        }
        let mut nodes = Nodes::new([x, y]);
        for (index, out) in out.iter_mut().enumerate() {
            let (px, py) = (x + index as u32 % FILM_TILE, y + index as u32 / FILM_TILE);
            if px >= self.width || py >= self.height {
                continue;
            }
            let found = filters.at(px, py);
            let (filter, variance) = found.unwrap_or((ImageFilter::NONE, 0.0));
            let between = nodes.between(self, filters, [px, py], &filter);
            let radiance = between.unwrap_or_else(|| self.pixel(px, py, &filter));
            // What has no filter tells its error itself.
            let own = self.sample(px, py);
            let halves = if found.is_none() && own.is_sound() { own.halves() } else { None };
            let difference = halves.map_or(0.0, |[first, second]| first - second);
            *out = FilmPixel { radiance, variance, difference };
        }
    }
}

/// Pixels between those where the light of a tile is looked up.
const STEPS: [u32; 3] = [8, 4, 2];

/// With the smallest of these.
const NODES_ACROSS: usize = FILM_TILE as usize / 2 + 1;

/// Light at every other pixel of a tile, and of the first row and column beyond it.
struct Nodes {
    corner: [u32; 2],
    /// None: not looked up yet.
    nodes: [Option<Node>; NODES_ACROSS * NODES_ACROSS],
}

#[derive(Clone, Copy)]
struct Node {
    filter: ImageFilter,
    /// Over which light varies little there.
    step: f32,
    light: Option<Vec3>,
}

/// Pixels over which the light through a filter varies little.
fn step_of(filter: &ImageFilter) -> f32 {
    STEP_SHARE * sqrtf(filter.matrix().eigenvalues()[1].max(0.0))
}

impl Nodes {
    fn new(corner: [u32; 2]) -> Self {
        Self { corner, nodes: [None; NODES_ACROSS * NODES_ACROSS] }
    }

    /// Bilinear between four nodes around a pixel, as far apart as its filter and theirs allow; None unless all of it is one region.
    fn between(
        &mut self,
        picture: &Reconstruction,
        filters: &FilmFilters,
        at: [u32; 2],
        filter: &ImageFilter,
    ) -> Option<Vec3> {
        let widest = step_of(filter);
        let mut steps = STEPS.into_iter().filter(|step| *step as f32 <= widest);
        steps.find_map(|step| self.over(picture, filters, at, step))
    }

    fn over(
        &mut self,
        picture: &Reconstruction,
        filters: &FilmFilters,
        [x, y]: [u32; 2],
        step: u32,
    ) -> Option<Vec3> {
        let own = picture.region(x, y);
        // The picture's last pixel stands for those beyond it.
        let last = [picture.width - 1, picture.height - 1];
        let [across, down] = [x - self.corner[0], y - self.corner[1]].map(|at| at - at % step);
        let slot = |[i, j]: [usize; 2]| {
            let [column, row] = [across + step * i as u32, down + step * j as u32];
            let at = [(self.corner[0] + column).min(last[0]), (self.corner[1] + row).min(last[1])];
            ((row / 2) as usize * NODES_ACROSS + (column / 2) as usize, at)
        };
        let slots = [[0, 0], [1, 0], [0, 1], [1, 1]].map(slot);
        for (slot, at) in slots {
            let node = self.nodes[slot].get_or_insert_with(|| {
                let filter = filters.filter(at[0], at[1]);
                Node { filter, step: step_of(&filter), light: None }
            });
            if own == 0 || picture.region(at[0], at[1]) != own || node.step < step as f32 {
                return None;
            }
        }
        let share = |at: u32, low: u32, high: u32| {
            if high > low { (at - low) as f32 / (high - low) as f32 } else { 0.0 }
        };
        let ([low, top], [high, bottom]) = (slots[0].1, slots[3].1);
        let mut sum = Vec3::ZERO;
        for ([i, j], share) in corners([share(x, low, high), share(y, top, bottom)]) {
            let (slot, at) = slots[2 * j + i];
            let node = self.nodes[slot].as_mut()?;
            let filter = node.filter;
            sum += share * *node.light.get_or_insert_with(|| picture.pixel(at[0], at[1], &filter));
        }
        Some(sum)
    }
}
