//! The filters of a picture: known at some pixels, interpolated between them, and none reaching where a
//! narrower one is asked for.

use super::{FilmSizeError, ImageFilter, ImageSpectrum, corners, pixel_count};
use crate::math::Sym2;
use libm::{roundf, sqrtf};

/// Nodes along the side of a square picture.
const NODES: f32 = 43.0;

/// Largest standard deviation of a filter, as a share of the side of a square as large as the picture.
const WIDEST_SHARE: f32 = 1.0 / 16.0;

/// Standard deviation that a filter may gain a pixel: a filter ends at three of them.
pub(super) const SLOPE: f32 = 1.0 / 3.0;

/// Least variance of a filter at a node: what is narrower is none.
const NARROWEST: f32 = 1e-6;

/// Eye rays for each light path of a pass, at least.
const RAYS_A_PATH: f32 = 0.5;

/// Rounds of limiting: one is enough where no silhouette is in the way.
const ROUNDS: u32 = 2;

/// Where the picture's spectrum is found: at the middle of each of a lattice of square blocks of pixels, some
/// 43 across and down whatever the picture's size, because the voxels that it is read from do not shrink with
/// the pixels.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FilmLattice {
    /// Pixels across, of the picture.
    pub width: u32,
    /// Pixels down, of the picture.
    pub height: u32,
    /// Pixels from one node to the next.
    pub spacing: u32,
    /// Nodes across.
    pub across: u32,
    /// Nodes down.
    pub down: u32,
}

impl FilmLattice {
    /// That of a picture.
    ///
    /// Errors: a picture that is too large.
    ///
    /// ```
    /// let lattice = covbeam::FilmLattice::new(256, 256)?;
    /// assert_eq!((lattice.spacing, lattice.node_count()), (6, 43 * 43));
    /// assert_eq!(lattice.pixel(1), [9, 3]);
    /// # Ok::<(), covbeam::FilmSizeError>(())
    /// ```
    pub fn new(width: u32, height: u32) -> Result<Self, FilmSizeError> {
        pixel_count(width, height)?;
        let spacing = (roundf(side(width, height) / NODES) as u32).max(2);
        Ok(Self { width, height, spacing, across: width.div_ceil(spacing), down: height.div_ceil(spacing) })
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.across as usize * self.down as usize
    }

    /// The pixel \[x, y\] that a node stands for. Nodes are numbered row by row from the upper left.
    pub fn pixel(&self, node: usize) -> [u32; 2] {
        let across = (self.across as usize).max(1);
        let at = |i: usize, count: u32| (i as u32 * self.spacing + self.spacing / 2).min(count.max(1) - 1);
        [at(node % across, self.width), at(node / across, self.height)]
    }

    /// Least density of eye rays in a pass of so many light paths, in \[0, 1\]: half a ray a path, however
    /// smooth the light is. With fewer, most beams pass between the rays and are traced for nothing.
    pub fn least_density(&self, paths: u32) -> f32 {
        let pixels = self.width as f32 * self.height as f32;
        if pixels > 0.0 { (RAYS_A_PATH * paths as f32 / pixels).min(1.0) } else { 1.0 }
    }

    /// Largest standard deviation that a filter has \[pixels\].
    pub fn widest(&self) -> f32 {
        WIDEST_SHARE * side(self.width, self.height)
    }

    /// Number of a node's pixel.
    pub(super) fn index(&self, node: usize) -> usize {
        let [x, y] = self.pixel(node);
        y as usize * self.width as usize + x as usize
    }

    /// The node so many columns and rows away.
    pub(super) fn neighbour(&self, node: usize, [columns, rows]: [i32; 2]) -> Option<usize> {
        let (across, down) = (i64::from(self.across), i64::from(self.down));
        let column = node as i64 % across + i64::from(columns);
        let row = node as i64 / across + i64::from(rows);
        let inside = (0..across).contains(&column) && (0..down).contains(&row);
        inside.then_some((row * across + column) as usize)
    }
}

fn side(width: u32, height: u32) -> f32 {
    sqrtf(width as f32 * height as f32)
}

/// A filter at one pixel: an element of the memory of [`FilmFilters`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilmFilterNode {
    /// Inverse of the filter's covariance \[1/pixels²\].
    pub(super) inverse: Sym2,
    /// In-scattered light, the node's weight between nodes; 0 = no filter.
    pub(super) weight: f32,
    /// Region of its pixel.
    pub(super) region: u32,
    /// Squared standard error of the filtered luminance; 0 = not known.
    pub(super) variance: f32,
}

impl FilmFilterNode {
    /// The node as bits that a file can hold.
    pub fn to_words(&self) -> [u32; 6] {
        let Self { inverse: Sym2 { xx, xy, yy }, weight, region, variance } = *self;
        [xx.to_bits(), xy.to_bits(), yy.to_bits(), weight.to_bits(), region, variance.to_bits()]
    }

    /// What [`FilmFilterNode::to_words`] was called on.
    pub fn from_words([xx, xy, yy, weight, region, variance]: [u32; 6]) -> Self {
        let [xx, xy, yy, weight, variance] = [xx, xy, yy, weight, variance].map(f32::from_bits);
        Self { inverse: Sym2 { xx, xy, yy }, weight, region, variance }
    }
}

/// The filter of each pixel of a picture.
#[derive(Clone, Copy, Debug)]
pub struct FilmFilters<'a> {
    pub(super) lattice: FilmLattice,
    pub(super) regions: &'a [u32],
    pub(super) nodes: &'a [FilmFilterNode],
}

impl<'a> FilmFilters<'a> {
    /// Finds the filters of a lattice's nodes: as wide as the spectrum allows, and no wider than a narrower
    /// one nearby.
    ///
    /// A spectrum tells how the light varies close by, and nothing of what lies a few widths away. A filter
    /// ends at three standard deviations; so that none reaches where a narrower one is asked for, its
    /// standard deviation in any direction is at most that of any other in its region plus a third of the
    /// distance.
    ///
    /// - `regions`: of [`super::film_regions`], one a pixel, or 1 everywhere. At a border (0) there is no
    ///   filter.
    /// - `spectra`: one a node, of the eye ray through the middle of its pixel.
    /// - `error` > 0: relative bias that a filter may cause, as [`ImageSpectrum::filter`] takes it.
    /// - `nodes`: as many; receive the filters.
    ///
    /// Errors: a slice of another length; nothing changes.
    ///
    /// Source: thesis 5.3.2; the bound is the gradation of meshes (F. Alauzet, *Size gradation control of
    /// anisotropic meshes*, 2010).
    pub fn new(
        lattice: FilmLattice,
        regions: &'a [u32],
        spectra: &[ImageSpectrum],
        error: f32,
        nodes: &'a mut [FilmFilterNode],
    ) -> Result<Self, FilmSizeError> {
        let count = lattice.node_count();
        if spectra.len() != count {
            return Err(FilmSizeError);
        }
        FilmFilters::of(lattice, regions, nodes)?;
        for (index, (node, spectrum)) in nodes.iter_mut().zip(spectra).enumerate() {
            let region = regions[lattice.index(index)];
            let filter = spectrum.filter(error, lattice.widest());
            let known = region != 0 && filter != ImageFilter::NONE;
            // Until the inverse is taken below, the field holds the covariance.
            *node = FilmFilterNode {
                inverse: Sym2 { xx: filter.xx + NARROWEST, xy: filter.xy, yy: filter.yy + NARROWEST },
                weight: if known { spectrum.weight } else { 0.0 },
                region,
                variance: 0.0,
            };
        }
        for _ in 0..ROUNDS {
            for index in 0..count {
                limit(&lattice, nodes, index, [[-1, 0], [-1, -1], [0, -1], [1, -1]]);
            }
            for index in (0..count).rev() {
                limit(&lattice, nodes, index, [[1, 0], [1, 1], [0, 1], [-1, 1]]);
            }
        }
        for node in nodes.iter_mut() {
            node.inverse = node.inverse.inverse();
        }
        Ok(Self { lattice, regions, nodes })
    }

    /// Filters that [`FilmFilters::new`] or [`super::verify_filters`] found before, of the same lattice and
    /// regions.
    ///
    /// Errors: a slice of another length.
    pub fn of(
        lattice: FilmLattice,
        regions: &'a [u32],
        nodes: &'a [FilmFilterNode],
    ) -> Result<Self, FilmSizeError> {
        let fits = regions.len() == pixel_count(lattice.width, lattice.height)?
            && nodes.len() == lattice.node_count();
        if fits { Ok(Self { lattice, regions, nodes }) } else { Err(FilmSizeError) }
    }

    /// The lattice.
    pub fn lattice(&self) -> &FilmLattice {
        &self.lattice
    }

    /// The filter of pixel (x, y): none at a border of regions, where the grid has no data, and outside the
    /// picture.
    ///
    /// Inverse covariances are interpolated between the nodes around that lie in the pixel's region, weighted
    /// by light.
    pub fn filter(&self, x: u32, y: u32) -> ImageFilter {
        self.at(x, y).map_or(ImageFilter::NONE, |(filter, _)| filter)
    }

    /// The filter, and the squared standard error of the light that it lets through.
    pub(super) fn at(&self, x: u32, y: u32) -> Option<(ImageFilter, f32)> {
        let lattice = &self.lattice;
        if x >= lattice.width || y >= lattice.height {
            return None;
        }
        let region = self.regions[y as usize * lattice.width as usize + x as usize];
        if region == 0 {
            return None;
        }
        let along = |at: u32, count: u32| {
            let spacing = lattice.spacing;
            let position =
                ((at as f32 - (spacing / 2) as f32) / spacing as f32).clamp(0.0, (count - 1) as f32);
            let low = (position as u32).min(count.saturating_sub(2));
            (low as usize, position - low as f32)
        };
        let ((column, right), (row, below)) = (along(x, lattice.across), along(y, lattice.down));
        let (mut inverse, mut variance, mut sum, mut shares) = (Sym2::default(), 0.0, 0.0, 0.0);
        for ([i, j], share) in corners([right, below]) {
            let node = &self.nodes[(row + j) * lattice.across as usize + column + i];
            if node.region != region || !(node.weight > 0.0) {
                continue;
            }
            // Weighted by light, as along the ray.
            let weight = share * node.weight;
            inverse.add(weight, &node.inverse);
            sum += weight;
            variance += share * node.variance;
            shares += share;
        }
        if !(sum > 0.0) {
            return None;
        }
        let filter = ImageFilter::from(inverse.map(|value| value / sum).inverse());
        let sound = (filter.xx + filter.xy + filter.yy).is_finite();
        Some((if sound { filter } else { ImageFilter::NONE }, variance / shares))
    }
}

/// Narrows a node's filter to what its neighbours allow. Nodes hold covariances.
fn limit(lattice: &FilmLattice, nodes: &mut [FilmFilterNode], index: usize, neighbours: [[i32; 2]; 4]) {
    let here = nodes[index];
    if !(here.weight > 0.0) {
        return;
    }
    let mut own = here.inverse;
    for steps in neighbours {
        let Some(there) = lattice.neighbour(index, steps).map(|there| &nodes[there]) else { continue };
        if there.region != here.region || !(there.weight > 0.0) {
            continue;
        }
        let distance = lattice.spacing as f32 * sqrtf((steps[0] * steps[0] + steps[1] * steps[1]) as f32);
        let grown = |variance: f32| {
            let deviation = sqrtf(variance.max(0.0)) + SLOPE * distance;
            deviation * deviation
        };
        if own.eigenvalues()[0] <= grown(there.inverse.eigenvalues()[1]) {
            continue;
        }
        let bound = there.inverse.through_eigenvalues(grown);
        own = bound.and_then(|bound| own.within(&bound)).unwrap_or(own);
    }
    nodes[index].inverse = own;
}
