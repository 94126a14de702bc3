//! The picture from the eye rays that were traced, each pixel through its filter.

use super::blocks::{FilmNode, LEVELS, Levels, Within};
use super::filter::{Ellipse, WIDEST, bounded};
use super::tilt::Weighed;
use super::{FilmSizeError, ImageFilter, luminance, pixel_count};
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
    pub(super) fn is_sound(&self) -> bool {
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

/// Filters a picture's samples.
///
/// A pixel is the ratio Σ w radiance / Σ w weight over the pixels of its region under its filter: exact where
/// the light is even, whichever pixels have rays. Round filters of any width cost about the same, long ones
/// in proportion to length over width: pixels of one region in a block that is small against the filter are
/// taken as one.
#[derive(Clone, Copy, Debug)]
pub struct Reconstruction<'a> {
    pub(super) width: u32,
    pub(super) height: u32,
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

    /// What its rays saw.
    pub(super) fn sample(&self, x: u32, y: u32) -> &FilmSample {
        &self.samples[self.levels.index(0, x, y)]
    }

    pub(super) fn region(&self, x: u32, y: u32) -> u32 {
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
