//! stub
use crate::{FluenceSpectrum, LightField};
use glam::Vec3;

/// Box and resolution of a grid.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridLayout {
    /// Lower corner.
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
    /// Voxels along x, y, z.
    pub cells: [u32; 3],
}

/// Accumulator of one voxel.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GridCell {
    /// Σ w·(xx, yy, zz, xy, xz, yz).
    pub sum: [f64; 6],
    /// Σ w.
    pub weight: f64,
}

/// One voxel ready for look-up: the mean spectrum; `weight` 0 = no data.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FluenceCell {
    /// Mean.
    pub spectrum: FluenceSpectrum,
    /// Σ w.
    pub weight: f32,
}

/// Why a grid was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridError {
    /// A corner is not finite or min >= max, or a resolution is 0 or too large.
    Layout,
    /// The slice's length is not `layout.cell_count()`.
    Length,
}

impl GridLayout {
    /// Number of voxels.
    pub fn cell_count(&self) -> usize {
        todo!()
    }
}

/// Accumulating side.
pub struct CovarianceGrid<'a> {
    layout: GridLayout,
    cells: &'a mut [GridCell],
}

impl<'a> CovarianceGrid<'a> {
    /// Wraps the caller's cells.
    pub fn new(layout: GridLayout, cells: &'a mut [GridCell]) -> Result<Self, GridError> {
        Ok(Self { layout, cells })
    }
    /// One deposit; points outside and weights that are not finite and positive are ignored.
    pub fn deposit(&mut self, position: Vec3, spectrum: &FluenceSpectrum, weight: f32) {
        let _ = (position, spectrum, weight, self.layout, &self.cells);
        todo!()
    }
    /// Deposits along a segment. `field` is the light field at `origin`; weight in each voxel =
    /// power x ∫ exp(-extinction s) ds over the piece of the segment inside.
    pub fn deposit_segment(&mut self, origin: Vec3, length: f32, field: &LightField, power: f32, extinction: f32) {
        let _ = (origin, length, field, power, extinction);
        todo!()
    }
    /// Adds another grid's cells.
    pub fn merge(&mut self, other: &[GridCell]) -> Result<(), GridError> {
        let _ = other;
        todo!()
    }
    /// Writes the means.
    pub fn resolve(&self, out: &mut [FluenceCell]) -> Result<(), GridError> {
        let _ = out;
        todo!()
    }
}

/// Look-up side.
#[derive(Clone, Copy, Debug)]
pub struct FluenceGrid<'a> {
    layout: GridLayout,
    cells: &'a [FluenceCell],
}

impl<'a> FluenceGrid<'a> {
    /// Wraps resolved cells.
    pub fn new(layout: GridLayout, cells: &'a [FluenceCell]) -> Result<Self, GridError> {
        Ok(Self { layout, cells })
    }
    /// Trilinear between voxel centres, over the voxels that have data; None = no data.
    pub fn look_up(&self, position: Vec3) -> Option<FluenceSpectrum> {
        let _ = (position, self.layout, self.cells);
        todo!()
    }
}
