//! The covariance grid: voxels that collect the spectra of the light crossing them, and the look-up of their
//! means.
//!
//! The cells belong to the caller. Accumulation (`CovarianceGrid`) and look-up (`FluenceGrid`) are two types
//! over two slices: sums in f64 that 10⁹ deposits do not stall, and compact f32 means for the gather.

use crate::light_field::medium::DepthShape;
use crate::light_field::{FluenceSpectrum, LightField};
use crate::math::exp;
use crate::medium::{Column, Density, Medium};
use crate::segment::Segment;
use crate::voxels::{Dda, GridError, GridLayout, Lattice, Trilinear};
use glam::Vec3;

/// Least weight of a voxel with data: the dimmest still counts where no other does, with all digits.
const DIMMEST: f32 = 1e-30;

/// Accumulator of one voxel (56 bytes). All zero = empty.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GridCell {
    /// Σ w·(xx, yy, zz, xy, xz, yz).
    pub sum: [f64; 6],
    /// Σ w.
    pub weight: f64,
}

/// One voxel ready for look-up (28 bytes): the mean spectrum.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FluenceCell {
    /// Flux-weighted mean of what was deposited.
    pub spectrum: FluenceSpectrum,
    /// Σ w over that of the brightest voxel, in (0, 1]; 0 = no data.
    pub weight: f32,
}

/// The accumulating side of a grid, over the caller's cells. One per thread; merge them in a fixed order and
/// the result does not depend on the number of threads.
#[derive(Debug)]
pub struct CovarianceGrid<'a> {
    pub(crate) layout: GridLayout,
    scale: Vec3,
    pub(crate) cells: &'a mut [GridCell],
}

impl<'a> CovarianceGrid<'a> {
    /// Wraps the caller's cells, which keep what they hold: zero them for an empty grid.
    ///
    /// - `cells`: `layout.cell_count()` of them.
    pub fn new(layout: GridLayout, cells: &'a mut [GridCell]) -> Result<Self, GridError> {
        let scale = layout.scale()?;
        if cells.len() != layout.cell_count() {
            return Err(GridError::Length);
        }
        Ok(Self { layout, scale, cells })
    }

    /// Adds a spectrum to the voxel around `position`.
    ///
    /// - `position` \[m\]: outside the box (its faces belong to it) or NaN, the deposit is ignored.
    /// - `spectrum` \[cycles²/m²\]: ignored unless all of it is finite.
    /// - `weight`: the contribution to the fluence, power x length; ignored unless finite and above 0.
    ///
    /// Guarantee: cells never become NaN; sums are f64, so 10⁹ equal deposits keep their mean to 1e-7.
    ///
    /// Source: thesis 5.3.1, Eq 5.14 and 5.15.
    pub fn deposit_spectrum(&mut self, position: Vec3, spectrum: &FluenceSpectrum, weight: f32) {
        if let Some(voxel) = self.layout.voxel(position, self.scale) {
            add(&mut self.cells[self.layout.index(voxel)], spectrum, weight);
        }
    }

    /// Adds the spectra along a segment of a light path: to each voxel on the way, the spectrum at the middle
    /// of the stretch inside it.
    ///
    /// The spectrum is that of [`LightField::fluence_within`] up to the voxels' Nyquist frequency, half a
    /// cycle over their smallest side, and past each edge that of the field that the edge has occluded. The
    /// weight in a voxel is `power` x ∫ transmittance ds over that stretch, from `origin`, of the mean
    /// channel. In a medium whose density varies, the field is attenuated on its way as well
    /// ([`LightField::attenuate`]); in a homogeneous one that costs nothing.
    ///
    /// - `medium`: what the segment is in.
    ///
    /// Anything not finite, or out of range, deposits nothing.
    ///
    /// Guarantee: the stretches partition the part of the segment inside the box, so the weights add up to
    /// the closed form over it. Error: 1e-5 over hundreds of voxels (test
    /// `the_weights_of_a_segment_add_up_to_the_closed_form_over_it`); where the density varies, the
    /// transmittance inside a voxel is taken as an exponential between its two ends. Cost: 0.2 µs a voxel,
    /// nearly all of it travel and slice; about 0.7 µs where the density varies.
    ///
    /// Source: thesis 5.3.1, Eq 5.14 and 5.15.
    ///
    /// ```
    /// use covbeam::{Column, CovarianceGrid, GridCell, GridLayout, LightField, Medium, Segment, Vec3};
    /// let layout = GridLayout { min: Vec3::ZERO, max: Vec3::ONE, cells: [1, 1, 2] };
    /// let mut cells = [GridCell::default(); 2];
    /// let mut grid = CovarianceGrid::new(layout, &mut cells)?;
    /// let field = LightField::point(Vec3::Z, 0.1);
    /// let origin = Vec3::new(0.5, 0.5, -1.0);
    /// let column = Column::Uniform;
    /// let segment = Segment { origin, length: 1.75, power: 4.0, unscattered: true, field, edges: &[], column };
    /// grid.deposit(&Medium::default(), &segment);
    /// assert_eq!([cells[0].weight, cells[1].weight], [2.0, 1.0]);
    /// # Ok::<(), covbeam::GridError>(())
    /// ```
    pub fn deposit(&mut self, medium: &Medium, segment: &Segment) {
        let Segment { length, power, .. } = *segment;
        if !(power > 0.0 && power.is_finite() && medium.mean_extinction() >= 0.0) {
            return;
        }
        let (rest, from) = segment
            .pass_edges(medium, length, |field, ends| self.deposit_stretch(medium, segment, field, ends));
        self.deposit_stretch(medium, segment, &rest, [from, length]);
    }

    /// Adds the spectra along the part of a segment between two distances, without edges; `field` is that at
    /// its start.
    fn deposit_stretch(
        &mut self,
        medium: &Medium,
        segment: &Segment,
        field: &LightField,
        [start, end]: [f32; 2],
    ) {
        let Segment { power, unscattered, ref column, .. } = *segment;
        let (extinction, mean_extinction) = (medium.extinction(), medium.mean_extinction());
        let origin = segment.origin + start * field.direction;
        let Some(mut dda) = Dda::new(&self.layout, Lattice::Voxels, origin, field.direction, end - start)
        else {
            return;
        };
        let uniform_column = matches!(column, Column::Uniform);
        let uniform_density = matches!(medium.density, Density::Uniform);
        // Half a cycle a voxel.
        let finest = 0.5 * self.scale.max_element();
        let mut here = *field;
        let mut shape = DepthShape::default();
        let mut reached = 0.0_f64;
        let mut before = column.at(start + dda.position as f32);
        let (_, mut flux) = attenuate_channels(extinction * before);
        flux *= power;
        while let Some((cell, from, to)) = dda.next_cell() {
            let middle = 0.5 * (from + to);
            if uniform_density {
                here.travel((middle - reached) as f32);
            } else {
                let stretch = [reached as f32, middle as f32];
                shape.add(medium, (origin, field.direction), stretch);
                here = shape.carried(field, middle as f32);
            }
            reached = middle;
            let step = (to - from) as f32;
            let through = if uniform_column {
                step
            } else {
                let after = column.at(start + to as f32);
                let through = (after - before).max(0.0);
                before = after;
                through
            };
            let (mean, left) = attenuate_channels(extinction * through);
            let mut spectrum = here.fluence_within(finest);
            if unscattered {
                let along = here.variance_along_ray(mean_extinction * through / step).min(finest * finest);
                spectrum.add_along(field.direction, along);
            }
            add(
                &mut self.cells[self.layout.index(cell)],
                &spectrum,
                (flux * mean).element_sum() / 3.0 * step,
            );
            flux *= left;
        }
    }

    /// Adds the cells of another grid of the same layout, in the order of the cells.
    ///
    /// - `other`: as many cells as this grid has; otherwise `GridError::Length` and nothing changes.
    ///
    /// Guarantee: merging grids in a fixed order gives the same bits whichever threads filled them.
    pub fn merge(&mut self, other: &[GridCell]) -> Result<(), GridError> {
        if other.len() != self.cells.len() {
            return Err(GridError::Length);
        }
        for (cell, more) in self.cells.iter_mut().zip(other) {
            for (sum, term) in cell.sum.iter_mut().zip(more.sum) {
                *sum += term;
            }
            cell.weight += more.weight;
        }
        Ok(())
    }

    /// Writes the mean spectrum of every voxel; voxels without deposits are marked as such by weight 0.
    ///
    /// - `out`: as many cells as this grid has; otherwise `GridError::Length` and nothing changes.
    ///
    /// Guarantee: finite. A voxel whose sums are not (cells not written by a grid) has no data.
    pub fn resolve(&self, out: &mut [FluenceCell]) -> Result<(), GridError> {
        if out.len() != self.cells.len() {
            return Err(GridError::Length);
        }
        let finite = |weight: f64| if weight < f64::INFINITY { weight } else { 0.0 };
        let brightest = self.cells.iter().fold(0.0, |most: f64, cell| most.max(finite(cell.weight)));
        for (out, cell) in out.iter_mut().zip(self.cells.iter()) {
            let spectrum = FluenceSpectrum::from_array(cell.sum.map(|sum| (sum / cell.weight) as f32));
            let has_data = finite(cell.weight) > 0.0 && is_finite(&spectrum);
            *out = if has_data {
                let weight = (cell.weight / brightest) as f32;
                FluenceCell { spectrum, weight: weight.max(DIMMEST) }
            } else {
                FluenceCell::default()
            };
        }
        Ok(())
    }
}

#[inline]
fn add(cell: &mut GridCell, spectrum: &FluenceSpectrum, weight: f32) {
    if !(weight > 0.0 && weight.is_finite() && is_finite(spectrum)) {
        return;
    }
    let weight = f64::from(weight);
    for (sum, value) in cell.sum.iter_mut().zip(spectrum.to_array()) {
        *sum += weight * f64::from(value);
    }
    cell.weight += weight;
}

#[inline]
fn is_finite(spectrum: &FluenceSpectrum) -> bool {
    spectrum.to_array().iter().all(|value| value.is_finite())
}

/// (1 - exp(-x))/x, lowest power first.
const SERIES: [f32; 8] =
    [1.0, -1.0 / 2.0, 1.0 / 6.0, -1.0 / 24.0, 1.0 / 120.0, -1.0 / 720.0, 1.0 / 5040.0, -1.0 / 40320.0];

/// Mean of exp(-s) over [0, depth], and exp(-depth).
#[inline]
fn attenuate(depth: f32) -> (f32, f32) {
    if depth < 0.5 {
        // (1 - exp(-x))/x cancels here: its series instead, whose ninth term is below 1.1e-8.
        let mean = SERIES.iter().rev().fold(0.0, |sum, term| sum * depth + term);
        (mean, 1.0 - depth * mean)
    } else {
        let left = exp(-depth);
        ((1.0 - left) / depth, left)
    }
}

/// Of each channel.
#[inline]
fn attenuate_channels(depth: Vec3) -> (Vec3, Vec3) {
    let (mean, left) = attenuate(depth.x);
    if depth.y == depth.x && depth.z == depth.x {
        return (Vec3::splat(mean), Vec3::splat(left));
    }
    let [(mean_y, left_y), (mean_z, left_z)] = [attenuate(depth.y), attenuate(depth.z)];
    (Vec3::new(mean, mean_y, mean_z), Vec3::new(left, left_y, left_z))
}

/// The look-up side of a grid, over resolved cells.
#[derive(Clone, Copy, Debug)]
pub struct FluenceGrid<'a> {
    pub(crate) voxels: Trilinear,
    pub(crate) cells: &'a [FluenceCell],
}

impl<'a> FluenceGrid<'a> {
    /// Wraps cells that [`CovarianceGrid::resolve`] wrote.
    ///
    /// - `cells`: `layout.cell_count()` of them.
    pub fn new(layout: GridLayout, cells: &'a [FluenceCell]) -> Result<Self, GridError> {
        Ok(Self { voxels: Trilinear::new(layout, cells.len())?, cells })
    }

    /// The spectrum of the fluence around a point: the flux-weighted mean of the eight voxels around it, with
    /// trilinear weights.
    ///
    /// The weight of a voxel is its fluence as well as its nearness, as in the sum over light paths that
    /// defines the spectrum: in the dark beside a shaft, the shaft's border dominates.
    ///
    /// - `position` \[m\]. Within half a voxel of the border the border's value holds.
    ///
    /// None outside the box, for NaN, and where none of the voxels that would count has data.
    ///
    /// Guarantee: exact on a field that is linear in position, where all voxels are equally bright (test
    /// `look_ups_reproduce_a_linear_field_and_hold_it_at_the_border`); always a convex combination, so
    /// positive semi-definite where the cells are. Cost: 20 ns.
    ///
    /// Source: thesis 5.3.1, Eq 5.15; trilinear instead of by voxel, whose steps would print into the radii.
    ///
    /// ```
    /// use covbeam::{FluenceCell, FluenceGrid, GridLayout, Vec3};
    /// let layout = GridLayout { min: Vec3::ZERO, max: Vec3::ONE, cells: [2, 1, 1] };
    /// let mut cells = [FluenceCell::default(); 2];
    /// cells[0].spectrum.xx = 3.0;
    /// cells[0].weight = 1.0;
    /// let grid = FluenceGrid::new(layout, &cells)?;
    /// // The voxel without data does not dilute its neighbour, and says nothing of its own.
    /// assert_eq!(grid.look_up(Vec3::splat(0.5)).map(|spectrum| spectrum.xx), Some(3.0));
    /// assert_eq!(grid.look_up(Vec3::new(0.9, 0.5, 0.5)), None);
    /// # Ok::<(), covbeam::GridError>(())
    /// ```
    #[inline(always)] // As `Kernel::radius_at`.
    #[doc(alias = "trilinear")]
    pub fn look_up(&self, position: Vec3) -> Option<FluenceSpectrum> {
        self.around(position).map(|found| found.spectrum)
    }

    /// All that the voxels around a point say.
    #[inline(always)]
    pub(crate) fn around(&self, position: Vec3) -> Option<Surroundings> {
        let (base, high) = self.voxels.around(position)?;
        let shares = shares(Vec3::ONE - high, high);
        let mut sum = [0.0; 6];
        let (mut flux, mut share_sum, mut inverse) = (0.0, 0.0, 0.0);
        for (corner, share) in shares.into_iter().enumerate() {
            let cell = &self.cells[base + self.voxels.corners[corner]];
            // A weight that is NaN or negative is none.
            let weight = if cell.weight > 0.0 { cell.weight } else { 0.0 };
            let factor = share * weight;
            for (sum, value) in sum.iter_mut().zip(cell.spectrum.to_array()) {
                *sum += value * factor;
            }
            flux += factor;
            if weight > 0.0 {
                share_sum += share;
                inverse += share / weight;
            }
        }
        // Beside voxels without data the harmonic mean is larger.
        (flux > 0.0).then(|| Surroundings {
            spectrum: FluenceSpectrum::from_array(sum.map(|sum| sum / flux)),
            flux,
            dimmest: (share_sum / inverse).min(flux),
        })
    }
}

/// The trilinear shares of the eight voxels around a point, in the order of
/// [`crate::voxels::Trilinear::corners`].
#[inline(always)]
fn shares(low: Vec3, high: Vec3) -> [f32; 8] {
    let [ll, hl, lh, hh] = [low.y * low.z, high.y * low.z, low.y * high.z, high.y * high.z];
    let (lx, hx) = (low.x, high.x);
    [lx * ll, hx * ll, lx * hl, hx * hl, lx * lh, hx * lh, lx * hh, hx * hh]
}

/// What a grid says about a point.
pub(crate) struct Surroundings {
    /// [`FluenceGrid::look_up`].
    pub(crate) spectrum: FluenceSpectrum,
    /// The trilinear mean of the voxels' weights, > 0.
    pub(crate) flux: f32,
    /// The harmonic mean of those above 0, near that of the dimmest voxel, > 0 and at most `flux`. Voxels do
    /// not tell on which side of a shadow's border inside them a point lies: this is the fluence if it is the
    /// dark side.
    pub(crate) dimmest: f32,
}
