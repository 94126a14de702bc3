//! Where the picture needs photons: the importance of light in voxels, and what follows from it for a light
//! path, how its lamp emits it and when it is split or ended.
//!
//! Importance is the share of the picture's light, relative to its brightness, that a watt brings about, the
//! sum over the pixels of what it adds to a pixel over what the pixel has. Light paths whose power times
//! importance is the same everywhere bring about as many photons in a dark pixel as in a bright one. Only
//! probabilities follow from it: a wrong importance costs noise and never makes a picture wrong.

use crate::medium::{Density, Medium};
use crate::voxels::{Dda, GridError, GridLayout, Lattice};
use core::f64::consts::PI;
use glam::Vec3;
use libm::pow;

/// More copies of one candidate of a path than this are never asked for.
const MOST_COPIES: f32 = 1e6;

/// No voxel's importance is below this share of the mean: what no path from the camera has found may matter.
const LEAST: f64 = 1e-3;

/// Sums of one voxel while importance is collected (24 bytes). All zero = empty.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImportanceSums {
    /// Σ weight x length of eye rays, times their media's scattering.
    pub seen: f64,
    /// Σ weight x length of paths from the camera after their first scattering.
    pub scattered: f64,
    /// Σ weight of places on surfaces.
    pub surface: f64,
}

/// Importance of one voxel (12 bytes), where a host looks it up with [`Importance`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImportanceCell {
    /// Of a watt of beam on each metre, with the medium's density \[1/(W m)\].
    pub beam: f32,
    /// Of a watt that is scattered there, by the medium or by a diffuse surface, into no direction more than
    /// others \[1/W\].
    pub scattered: f32,
    /// Of a watt that arrives on surfaces there \[1/W\], but for what they scatter.
    pub surface: f32,
}

/// Collects importance over the caller's cells: from eye rays, which see beams, and from paths that start at
/// the camera as light paths start at a lamp, and are scattered.
///
/// A path starts with the weight 1/(N L), for N pixels and its pixel's luminance L: pixels count by their
/// relative errors. Where L is next to nothing the weight should be bounded.
#[derive(Debug)]
pub struct ImportanceGrid<'a> {
    layout: GridLayout,
    scale: Vec3,
    cells: &'a mut [ImportanceSums],
}

impl<'a> ImportanceGrid<'a> {
    /// Wraps the caller's cells, which keep what they hold: zero them for an empty grid.
    ///
    /// - `cells`: `layout.cell_count()` of them.
    pub fn new(layout: GridLayout, cells: &'a mut [ImportanceSums]) -> Result<Self, GridError> {
        let scale = layout.scale()?;
        if cells.len() != layout.cell_count() {
            return Err(GridError::Length);
        }
        Ok(Self { layout, scale, cells })
    }

    /// Adds a piece of an eye ray: beams that cross it are seen.
    ///
    /// - `weight`: of the path at `origin`; ignored unless finite and above 0.
    /// - `direction`: unit; `length` \[m\]: may be infinite.
    pub fn add_eye_ray(&mut self, medium: &Medium, origin: Vec3, direction: Vec3, length: f32, weight: f32) {
        self.add(medium, origin, direction, length, weight, |cell, stretch, weight| {
            let scattered = stretch.seen_length.dot(medium.scattering) / 3.0;
            cell.seen += weight * f64::from(stretch.density) * f64::from(scattered);
        });
    }

    /// Adds a segment that a path from the camera flies after it was scattered, by the medium or by a diffuse
    /// surface. Arguments as for [`ImportanceGrid::add_eye_ray`].
    pub fn add_path(&mut self, medium: &Medium, origin: Vec3, direction: Vec3, length: f32, weight: f32) {
        self.add(medium, origin, direction, length, weight, |cell, stretch, weight| {
            cell.scattered += weight * f64::from(mean(stretch.seen_length));
        });
    }

    /// Adds a place on a diffuse surface that a path from the camera sees. Outside the box it is ignored.
    ///
    /// - `weight`: of the path there times albedo/π; ignored unless finite and above 0.
    pub fn add_surface(&mut self, position: Vec3, weight: f32) {
        if let (Some(voxel), true) = (self.layout.voxel(position, self.scale), is_weight(weight)) {
            self.cells[self.layout.index(voxel)].surface += f64::from(weight);
        }
    }

    fn add(
        &mut self,
        medium: &Medium,
        origin: Vec3,
        direction: Vec3,
        length: f32,
        weight: f32,
        mut deposit: impl FnMut(&mut ImportanceSums, &Stretch, f64),
    ) {
        if !is_weight(weight) {
            return;
        }
        let Some(mut walk) = Walk::new(&self.layout, medium, origin, direction, length) else { return };
        while let Some(stretch) = walk.next(medium) {
            deposit(&mut self.cells[stretch.cell], &stretch, f64::from(weight));
        }
    }

    /// Adds the cells of another grid of the same layout.
    ///
    /// - `other`: as many cells as this grid has; otherwise `GridError::Length` and nothing changes.
    ///
    /// Guarantee: merging grids in a fixed order gives the same bits whichever threads filled them.
    pub fn merge(&mut self, other: &[ImportanceSums]) -> Result<(), GridError> {
        if other.len() != self.cells.len() {
            return Err(GridError::Length);
        }
        for (cell, more) in self.cells.iter_mut().zip(other) {
            cell.seen += more.seen;
            cell.scattered += more.scattered;
            cell.surface += more.surface;
        }
        Ok(())
    }

    /// Writes the importance of every voxel, smoothed over neighbours (¼, ½, ¼ along each axis).
    ///
    /// A beam in a voxel is seen in all directions alike, a surface has the area of a voxel's side.
    ///
    /// - `out`: as many cells as this grid has; otherwise `GridError::Length` and nothing changes.
    ///
    /// Guarantee: finite; where there is any importance, at least a thousandth of its mean everywhere.
    pub fn resolve(&self, out: &mut [ImportanceCell]) -> Result<(), GridError> {
        if out.len() != self.cells.len() {
            return Err(GridError::Length);
        }
        let side = 1.0 / self.scale.as_dvec3();
        let volume = side.element_product();
        let area = pow(volume, 2.0 / 3.0);
        let isotropic = 1.0 / (4.0 * PI * volume);
        // Of the sums, once for all axes.
        let mut mean = ImportanceSums::default();
        let share = 1.0 / self.cells.len() as f64;
        for cell in self.cells.iter() {
            mean.seen += cell.seen * share;
            mean.scattered += cell.scattered * share;
            mean.surface += cell.surface * share;
        }
        let [nx, ny, nz] = self.layout.cells;
        for (index, out) in out.iter_mut().enumerate() {
            let index = index as u32;
            let place = [index % nx, index / nx % ny, index / (nx * ny)];
            let mut sum = ImportanceSums::default();
            for dz in 0..3 {
                for dy in 0..3 {
                    for dx in 0..3 {
                        let near = |at: u32, step: u32, count: u32| (at + step).clamp(1, count) - 1;
                        let voxel = [near(place[0], dx, nx), near(place[1], dy, ny), near(place[2], dz, nz)];
                        let weight = [dx, dy, dz].map(|step| if step == 1 { 0.5 } else { 0.25 });
                        let weight: f64 = weight.iter().product();
                        let cell = &self.cells[self.layout.index(voxel)];
                        sum.seen += weight * cell.seen;
                        sum.scattered += weight * cell.scattered;
                        sum.surface += weight * cell.surface;
                    }
                }
            }
            let value = |sum: f64, mean: f64, factor: f64| {
                let value = (factor * sum.max(LEAST * mean)) as f32;
                if value.is_finite() { value } else { 0.0 }
            };
            *out = ImportanceCell {
                beam: value(sum.seen, mean.seen, isotropic),
                scattered: value(sum.scattered, mean.scattered, isotropic),
                surface: value(sum.surface, mean.surface, 1.0 / area),
            };
        }
        Ok(())
    }
}

fn is_weight(weight: f32) -> bool {
    weight > 0.0 && weight < f32::INFINITY
}

/// What a segment of a light path is worth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SegmentImportance {
    /// Of a watt at its start, as a beam \[1/W\].
    pub beam: f32,
    /// Of what the medium scatters from a watt on its way.
    pub scattered: f32,
    /// What is left of a watt where it leaves the voxels, or at its end if that is before.
    pub transmittance: f32,
}

/// The importance in voxels, for look-up.
#[derive(Clone, Copy, Debug)]
pub struct Importance<'a> {
    layout: GridLayout,
    scale: Vec3,
    cells: &'a [ImportanceCell],
}

impl<'a> Importance<'a> {
    /// Wraps cells that [`ImportanceGrid::resolve`] wrote.
    pub fn new(layout: GridLayout, cells: &'a [ImportanceCell]) -> Result<Self, GridError> {
        let scale = layout.scale()?;
        if cells.len() != layout.cell_count() {
            return Err(GridError::Length);
        }
        Ok(Self { layout, scale, cells })
    }

    /// That of the voxel around a point; outside the box, of the nearest one. Zero for NaN.
    pub fn at(&self, position: Vec3) -> ImportanceCell {
        if position.is_nan() {
            return ImportanceCell::default();
        }
        let place = position.clamp(self.layout.min, self.layout.max);
        let voxel = self.layout.voxel(place, self.scale);
        voxel.map_or(ImportanceCell::default(), |voxel| self.cells[self.layout.index(voxel)])
    }

    /// What a watt that flies along a segment is worth; nothing outside the box.
    ///
    /// - `direction`: unit; `length` \[m\]: to the next surface, may be infinite.
    ///
    /// Cost: about 5 ns a voxel.
    pub fn of_segment(
        &self,
        medium: &Medium,
        origin: Vec3,
        direction: Vec3,
        length: f32,
    ) -> SegmentImportance {
        let mut sum = SegmentImportance { transmittance: 1.0, ..SegmentImportance::default() };
        let Some(mut walk) = Walk::new(&self.layout, medium, origin, direction, length) else { return sum };
        while let Some(Stretch { cell, density, seen_length }) = walk.next(medium) {
            let cell = &self.cells[cell];
            sum.beam += cell.beam * mean(seen_length);
            sum.scattered += cell.scattered * density * (seen_length.dot(medium.scattering) / 3.0);
        }
        sum.transmittance = medium.mean_transmittance(walk.column);
        sum
    }
}

/// Of the channels.
fn mean(color: Vec3) -> f32 {
    color.element_sum() / 3.0
}

/// A stretch of a segment in one voxel.
struct Stretch {
    cell: usize,
    /// Relative density of the medium in its middle.
    density: f32,
    /// ∫ transmittance ds, of each channel.
    seen_length: Vec3,
}

/// The walk of a segment through the voxels, with what is left of its light.
struct Walk {
    dda: Dda,
    layout: GridLayout,
    origin: Vec3,
    direction: Vec3,
    uniform: bool,
    column: f32,
}

impl Walk {
    fn new(layout: &GridLayout, medium: &Medium, origin: Vec3, direction: Vec3, length: f32) -> Option<Self> {
        let extinction = medium.extinction();
        let dda = Dda::new(layout, Lattice::Voxels, origin, direction, length)?;
        let uniform = matches!(medium.density, Density::Uniform);
        // Up to the box, as if it were as dense as there.
        let before = dda.position as f32;
        let entry = if uniform { 1.0 } else { medium.density.at(origin + before * direction) };
        let column = entry * before;
        let sound = extinction.min_element() >= 0.0 && extinction.is_finite() && column >= 0.0;
        sound.then_some(Self { dda, layout: *layout, origin, direction, uniform, column })
    }

    #[inline(always)]
    fn next(&mut self, medium: &Medium) -> Option<Stretch> {
        let (voxel, from, to) = self.dda.next_cell()?;
        let (middle, length) = ((0.5 * (from + to)) as f32, (to - from) as f32);
        let density =
            if self.uniform { 1.0 } else { medium.density.at(self.origin + middle * self.direction) };
        let column = density * length;
        let seen_length = length * medium.transmittance(self.column + 0.5 * column);
        self.column += column;
        let cell = self.layout.index(voxel);
        Some(Stretch { cell, density, seen_length })
    }
}

/// Splits and ends light paths: of some candidates, such as directions in which a path may go on, which do,
/// and by what their power is multiplied.
///
/// - `expected`: in, of each candidate, how many of it should go on: its power times its importance, over
///   what power times importance is to be; >= 0. Out: the factor of its power, 0 where it ends. It goes on
///   once, also where it could more often.
/// - `u`: uniform in [0, 1).
///
/// Guarantee: the mean of each factor over `u` is 1 wherever `expected` is above 0, so that nothing is added
/// to the light or lost; of all candidates together as many are chosen as are expected, up to one. What is
/// not finite or below 0 is taken for 0: that candidate's light is lost.
///
/// Source: T. Booth and J. Hendricks, *Importance estimation in forward Monte Carlo calculations* (1984);
/// systematic resampling, J. Baker (1987).
///
/// ```
/// let mut factors = [0.5, 0.25, 2.0, 0.25];
/// covbeam::weight_window(&mut factors, 0.4);
/// // Three are expected. The third, which two are, keeps its power.
/// assert_eq!(factors, [0.0, 4.0, 1.0, 0.0]);
/// ```
#[doc(alias = "Russian roulette")]
#[doc(alias = "splitting")]
pub fn weight_window(expected: &mut [f32], u: f32) {
    let mut sum = f64::from(u);
    for value in expected {
        let number = if *value > 0.0 && *value < f32::INFINITY { value.min(MOST_COPIES) } else { 0.0 };
        let before = sum as i64;
        sum += f64::from(number);
        let copies = (sum as i64 - before) as f32;
        *value = if copies > 0.0 { copies / number } else { 0.0 };
    }
}
