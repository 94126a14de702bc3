//! The picture from the eye rays that were traced, each pixel through its filter.

use super::filter::{Ellipse, WIDEST, bounded};
use super::tilt::Weighed;
use super::{FilmFilters, FilmSizeError, ImageFilter, corners, luminance, pixel_count};
use glam::Vec3;
use libm::{expf, sqrtf};

/// A filter ends at this many standard deviations; what it is there is subtracted from all of it, so that it
/// ends at 0.
const REACH: f32 = 3.0;
const AT_REACH: f32 = 0.011_108_997; // exp(-REACH²/2)

/// Pixels are taken together in blocks no larger than this share of the filter's smallest standard deviation.
const BLOCK_SHARE: f32 = 1.0;

/// And where other regions share a block, than this share of that: the middle of its pixels is not the block's.
const SHARED: f32 = 0.25;

/// Least weight and largest numbers of a sample: sums over 2³¹ pixels and their ratio stay within what `f32`
/// holds.
const LEAST_WEIGHT: f32 = 1e-9;
const LARGEST: f32 = 1e29;

/// Levels of blocks above the pixels.
const LEVELS: usize = 16;

/// What the eye rays of one pixel saw.
///
/// Both over Σ density, the number of rays that was expected over all passes: pixels then count for their
/// area, whatever their density.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilmSample {
    /// Σ radiance / Σ density, per channel.
    pub radiance: Vec3,
    /// Number of rays / Σ density; 0 = no ray yet.
    pub weight: f32,
    /// Σ luminance (Rec. 709) of the odd passes / Σ density of all: how far the two halves of the passes are
    /// apart says how large the error is.
    pub first: f32,
    /// Number of rays of the odd passes / Σ density of all.
    pub first_weight: f32,
}

impl FilmSample {
    fn is_sound(&self) -> bool {
        (LEAST_WEIGHT..=LARGEST).contains(&self.weight)
            && self.radiance.abs().cmple(Vec3::splat(LARGEST)).all()
            && self.first.abs() <= LARGEST
            && (0.0..=LARGEST).contains(&self.first_weight)
    }

    pub(super) fn add(&mut self, share: f32, other: &Self) {
        self.radiance += share * other.radiance;
        self.weight += share * other.weight;
        self.first += share * other.first;
        self.first_weight += share * other.first_weight;
    }

    /// Luminance of the odd and of the even passes; None if one has no rays.
    pub fn halves(&self) -> Option<[f32; 2]> {
        let second_weight = self.weight - self.first_weight;
        let known = self.first_weight > 1e-6 * self.weight && second_weight > 1e-6 * self.weight;
        known.then(|| {
            [self.first / self.first_weight, (luminance(self.radiance) - self.first) / second_weight]
        })
    }
}

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

const NO_RAYS: FilmSample = FilmSample { radiance: Vec3::ZERO, weight: 0.0, first: 0.0, first_weight: 0.0 };

/// A block of pixels: scratch memory of a [`Reconstruction`].
#[derive(Clone, Copy, Debug, Default)]
pub struct FilmNode {
    /// Of up to two regions in it; region 0, of silhouettes, is none.
    parts: [Part; 2],
    /// [`bit`]s of the regions in it.
    regions: u32,
    /// Whether it holds more regions, of which it knows the bits only.
    more: bool,
}

/// The pixels of one region in a block.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    region: u32,
    sample: FilmSample,
}

/// What a block has of a region, or of all.
enum Within<'a> {
    Nothing,
    /// All that it has of it; `shared`: it has other pixels too.
    All {
        sample: &'a FilmSample,
        shared: bool,
    },
    /// What it is made of knows.
    Below,
}

/// What a block of many regions remembers of one; silhouettes have a bit of their own.
fn bit(region: u32) -> u32 {
    if region == 0 { 1 } else { 2 << (region % 31) }
}

impl FilmNode {
    /// One whose sample is not sound has no rays.
    fn add_pixel(&mut self, sample: &FilmSample, region: u32) {
        self.regions |= bit(region);
        if region != 0 {
            self.add_part(region, if sample.is_sound() { sample } else { &NO_RAYS });
        }
    }

    fn add(&mut self, other: &Self) {
        self.regions |= other.regions;
        self.more |= other.more;
        for Part { region, sample } in &other.parts {
            if *region != 0 {
                self.add_part(*region, sample);
            }
        }
    }

    fn add_part(&mut self, region: u32, sample: &FilmSample) {
        for own in &mut self.parts {
            if own.region == region || own.region == 0 {
                own.region = region;
                own.sample.add(1.0, sample);
                return;
            }
        }
        self.more = true;
    }

    /// - `among`: a region other than 0; None: all.
    fn within(&self, among: Option<u32>) -> Within<'_> {
        let [Part { region, sample }, second] = &self.parts;
        let shared = self.more || second.region != 0 || self.regions != bit(*region);
        match among {
            None if shared || *region == 0 => Within::Below,
            None => Within::All { sample, shared },
            Some(wanted) if self.more => match self.regions & bit(wanted) {
                0 => Within::Nothing,
                _ => Within::Below,
            },
            Some(wanted) => match self.parts.iter().find(|part| part.region == wanted) {
                Some(Part { sample, .. }) => Within::All { sample, shared },
                None => Within::Nothing,
            },
        }
    }
}

/// Filters a picture's samples.
///
/// A pixel is the ratio Σ w radiance / Σ w weight over the pixels of its region under its filter: exact where
/// the light is even, whichever pixels have rays. Round filters of any width cost about the same, long ones
/// in proportion to length over width: pixels of one region in a block that is small against the filter are
/// taken as one.
#[derive(Clone, Copy, Debug)]
pub struct Reconstruction<'a> {
    width: u32,
    height: u32,
    samples: &'a [FilmSample],
    regions: &'a [u32],
    nodes: &'a [FilmNode],
    levels: Levels,
}

impl<'a> Reconstruction<'a> {
    /// Number of nodes for a picture of this size: about a third of its pixels; 0 for one that is too large.
    ///
    /// ```
    /// assert_eq!(covbeam::Reconstruction::node_count(5, 3), 3 * 2 + 2 * 1 + 1);
    /// ```
    pub fn node_count(width: u32, height: u32) -> usize {
        pixel_count(width, height).map_or(0, |_| Levels::new(width, height).nodes)
    }

    /// Sums up blocks of pixels. Cost: 5 ns a pixel (bench `film/nodes`).
    ///
    /// - `samples`: one a pixel, row by row from the upper left. One that is not finite, of a weight below
    ///   1e-9, or with a number beyond ±1e29, counts as a pixel without rays.
    /// - `regions`: of [`super::film_regions`], or 1 everywhere.
    /// - `nodes`: [`Reconstruction::node_count`] of them; what they hold does not matter.
    ///
    /// Errors: a slice of another length, or a picture that is too large.
    pub fn new(
        width: u32,
        height: u32,
        samples: &'a [FilmSample],
        regions: &'a [u32],
        nodes: &'a mut [FilmNode],
    ) -> Result<Self, FilmSizeError> {
        let count = pixel_count(width, height)?;
        let levels = Levels::new(width, height);
        if samples.len() != count || regions.len() != count || nodes.len() != levels.nodes {
            return Err(FilmSizeError);
        }
        for level in 1..=levels.top {
            let (across, down) = levels.size[level];
            let (below, here) = nodes.split_at_mut(levels.first[level]);
            for (x, y) in (0..down).flat_map(|y| (0..across).map(move |x| (x, y))) {
                let node = &mut here[y as usize * across as usize + x as usize];
                *node = FilmNode::default();
                for (x, y) in levels.children(level, x, y) {
                    let index = levels.index(level - 1, x, y);
                    if level == 1 {
                        node.add_pixel(&samples[index], regions[index]);
                    } else {
                        node.add(&below[index]);
                    }
                }
            }
        }
        Ok(Self { width, height, samples, regions, nodes, levels })
    }

    /// The radiance of pixel (x, y) through its filter.
    ///
    /// - `filter`: any number that is not finite, or a negative variance, is no filter. Variances count up to
    ///   1e12, a covariance up to what they allow.
    ///
    /// Where no ray lies under the filter, it is widened until one does: first in the pixel's own region,
    /// then anywhere. Zero in a picture without rays, and outside the picture.
    ///
    /// Guarantee: finite; within the range of the samples' means, to rounding. Cost: 0.4 µs for a filter of
    /// half a pixel, 3 µs for any wider round one, 13 µs for one of 1:8 (bench `film/pixel`).
    ///
    /// Source: thesis 5.3.2.
    ///
    /// ```
    /// use covbeam::{FilmNode, FilmSample, ImageFilter, Reconstruction, Vec3};
    /// let mut samples = [FilmSample::default(); 9];
    /// samples[0] = FilmSample { radiance: Vec3::splat(4.0), weight: 2.0, ..FilmSample::default() };
    /// let mut nodes = [FilmNode::default(); 5];
    /// let picture = Reconstruction::new(3, 3, &samples, &[1; 9], &mut nodes)?;
    /// assert_eq!(picture.pixel(2, 2, &ImageFilter { xx: 1.0, xy: 0.0, yy: 1.0 }), Vec3::splat(2.0));
    /// # Ok::<(), covbeam::FilmSizeError>(())
    /// ```
    pub fn pixel(&self, x: u32, y: u32, filter: &ImageFilter) -> Vec3 {
        if x >= self.width || y >= self.height {
            return Vec3::ZERO;
        }
        let index = self.levels.index(0, x, y);
        let (own, region) = (&self.samples[index], self.regions[index]);
        let mut wide = if region == 0 { ImageFilter::NONE } else { bounded(filter) };
        if wide == ImageFilter::NONE && own.is_sound() {
            return own.radiance / own.weight;
        }
        let widest = REACH * self.width.max(self.height) as f32;
        let mut among = if region == 0 { None } else { Some(region) };
        loop {
            let sum = self.gather(x, y, &wide, among);
            if sum.weight > 0.0 {
                return sum.radiance / sum.weight;
            }
            if wide.xx.min(wide.yy) > widest * widest {
                // Nothing in all of the region, and then in all of the picture.
                if among.take().is_none() {
                    return Vec3::ZERO;
                }
                wide = ImageFilter::NONE;
            }
            let wider = |variance: f32| (4.0 * variance + 1.0).min(WIDEST);
            wide = ImageFilter { xx: wider(wide.xx), xy: 0.0, yy: wider(wide.yy) };
        }
    }

    /// The radiance around a pixel without rays of its own: the mean of the smallest block of pixels around
    /// it that has rays and lies in its region; where there is none, as [`Reconstruction::pixel`] without a
    /// filter.
    pub fn nearby(&self, x: u32, y: u32) -> Vec3 {
        if x >= self.width || y >= self.height {
            return Vec3::ZERO;
        }
        let region = self.region(x, y);
        for level in 1..=self.levels.top {
            let node = &self.nodes[self.levels.index(level, x >> level, y >> level)];
            let Within::All { sample, shared: false } = node.within(Some(region)) else { break };
            if sample.weight > 0.0 {
                return sample.radiance / sample.weight;
            }
        }
        self.pixel(x, y, &ImageFilter::NONE)
    }

    /// The sum under a filter, over the pixels of the pixel's own region; nothing for one of a silhouette.
    pub(super) fn sum(&self, x: u32, y: u32, filter: &ImageFilter) -> FilmSample {
        let region = self.region(x, y);
        if region == 0 { FilmSample::default() } else { self.gather(x, y, &bounded(filter), Some(region)) }
    }

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
            let between = found.and_then(|_| nodes.between(self, filters, [px, py], &filter));
            let radiance = between.unwrap_or_else(|| self.pixel(px, py, &filter));
            // What has no filter tells its error itself.
            let own = &self.samples[self.levels.index(0, px, py)];
            let halves = if found.is_none() && own.is_sound() { own.halves() } else { None };
            let difference = halves.map_or(0.0, |[first, second]| first - second);
            *out = FilmPixel { radiance, variance, difference };
        }
    }

    fn region(&self, x: u32, y: u32) -> u32 {
        self.regions[self.levels.index(0, x, y)]
    }

    /// The light under a filter, over the pixels of one region or of all: what a plane through it has at the
    /// pixel.
    ///
    /// At a border the filter lacks a side, and its mean is that of the light some way inside: with a slope
    /// there, off by up to the square root of the filter's accepted error. Weights that are tilted until
    /// their centre is the pixel mend that (local linear regression; J. Fan, Design-adaptive nonparametric
    /// regression, JASA 87, 1992).
    fn gather(&self, x: u32, y: u32, filter: &ImageFilter, among: Option<u32>) -> FilmSample {
        let ellipse = Ellipse::of(filter);
        let mut even = Weighed::default();
        self.under(x, y, &ellipse, among, |weight, at, sample| even.add(weight, at, sample));
        let Some(mut tilted) = even.tilt() else { return even.sum };
        self.under(x, y, &ellipse, among, |weight, at, sample| tilted.add(weight, at, sample));
        tilted.bounded(even.sum)
    }

    /// Calls `found` with weight, place in the filter's standard deviations, and sample of all that lies
    /// under a filter.
    fn under(
        &self,
        x: u32,
        y: u32,
        ellipse: &Ellipse,
        among: Option<u32>,
        mut found: impl FnMut(f32, [f32; 2], &FilmSample),
    ) {
        let Ellipse { axis: [ux, uy], largest, smallest } = *ellipse;
        let (wide, narrow) = (sqrtf(largest), sqrtf(smallest));
        let corner = 0.5 * (ux.abs() + uy.abs());
        let block = BLOCK_SHARE * narrow;
        let (cx, cy) = (x as f32 + 0.5, y as f32 + 0.5);

        // Four children a level wait, of which one is opened.
        let mut stack = [(0, 0_u32, 0_u32); 3 * LEVELS + 4];
        let mut waiting = 1;
        stack[0] = (self.levels.top, 0, 0);
        while waiting > 0 {
            waiting -= 1;
            let (level, nx, ny) = stack[waiting];
            let size = (1_u32 << level) as f32;
            let (dx, dy) = ((nx as f32 + 0.5) * size - cx, (ny as f32 + 0.5) * size - cy);
            let (along, aside) = (ux * dx + uy * dy, ux * dy - uy * dx);
            if along.abs() > REACH * wide + corner * size || aside.abs() > REACH * narrow + corner * size {
                continue;
            }
            let index = self.levels.index(level, nx, ny);
            let sample = if level == 0 {
                let sample = &self.samples[index];
                let is_wanted = sample.is_sound() && among.is_none_or(|wanted| wanted == self.regions[index]);
                is_wanted.then_some(sample)
            } else {
                match self.nodes[index].within(among) {
                    Within::Nothing => continue,
                    // Its middle is that of all its pixels.
                    Within::All { sample, shared } if size <= if shared { SHARED * block } else { block } => {
                        (sample.weight > 0.0).then_some(sample)
                    }
                    _ => {
                        for (x, y) in self.levels.children(level, nx, ny) {
                            stack[waiting] = (level - 1, x, y);
                            waiting += 1;
                        }
                        continue;
                    }
                }
            };
            let Some(sample) = sample else { continue };
            let at = [along / wide, aside / narrow];
            let square = at[0] * at[0] + at[1] * at[1];
            if square < REACH * REACH {
                found(expf(-0.5 * square) - AT_REACH, at, sample);
            }
        }
    }
}

/// The levels of blocks over a picture, up to one block: a block is made of up to four of the level below,
/// and the pixels are level 0.
#[derive(Clone, Copy, Debug)]
struct Levels {
    top: usize,
    /// How many blocks across and down.
    size: [(u32, u32); LEVELS + 1],
    /// The number of each level's first block, among the pixels or among the blocks.
    first: [usize; LEVELS + 1],
    /// How many blocks there are, on all levels above the pixels.
    nodes: usize,
}

impl Levels {
    /// Of a picture that is not too large.
    fn new(width: u32, height: u32) -> Self {
        let mut levels =
            Self { top: 0, size: [(width, height); LEVELS + 1], first: [0; LEVELS + 1], nodes: 0 };
        let (mut across, mut down) = (width, height);
        while across.max(down) > 1 && across.min(down) > 0 {
            (across, down) = (across.div_ceil(2), down.div_ceil(2));
            levels.top += 1;
            levels.size[levels.top] = (across, down);
            levels.first[levels.top] = levels.nodes;
            levels.nodes += across as usize * down as usize;
        }
        levels
    }

    fn index(&self, level: usize, x: u32, y: u32) -> usize {
        self.first[level] + y as usize * self.size[level].0 as usize + x as usize
    }

    /// What a block is made of.
    fn children(&self, level: usize, x: u32, y: u32) -> impl Iterator<Item = (u32, u32)> + use<> {
        let (across, down) = self.size[level - 1];
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (2 * x + dx, 2 * y + dy));
        corners.into_iter().filter(move |(x, y)| *x < across && *y < down)
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
    at: [u32; 2],
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
        let steps = STEPS.into_iter().filter(|step| *step as f32 <= widest);
        steps.into_iter().find_map(|step| self.over(picture, filters, at, step))
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
                Node { at, filter, step: step_of(&filter), light: None }
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
            let node = self.nodes[slots[2 * j + i].0].as_mut()?;
            let Node { at, filter, .. } = *node;
            sum += share * *node.light.get_or_insert_with(|| picture.pixel(at[0], at[1], &filter));
        }
        Some(sum)
    }
}
