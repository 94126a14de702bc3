//! Boxes of voxels: their layout, trilinear interpolation between their centres, and the walk of a segment
//! over them (3D-DDA).

use core::fmt;
use glam::Vec3;

/// Largest number of voxels that a grid may have.
const MAX_CELLS: usize = 1 << 24;

/// Box and resolution of a grid. Voxels are stored x first, then y, then z.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias = "voxel grid")]
pub struct GridLayout {
    /// Lower corner \[m\].
    pub min: Vec3,
    /// Upper corner \[m\], above `min` on every axis.
    pub max: Vec3,
    /// Voxels along x, y, z, each >= 1; at most 2²⁴ in all.
    pub cells: [u32; 3],
}

/// Why a grid was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridError {
    /// A corner or the size of a voxel is not finite, min >= max, or a resolution is 0 or too large.
    Layout,
    /// The slice's length is not `layout.cell_count()`, or that of the bytes not [`GridLayout::saved_size`].
    Length,
    /// A density is negative or not finite, or the sums of a voxel are none that deposits of covariances add
    /// up to.
    Value,
    /// The bytes are no saved grid, or one of another version.
    Format,
    /// The bytes of a saved grid are not those that were written: their checksum differs.
    Damaged,
    /// The saved grid has another box or resolution than the grid that should load it.
    OtherLayout,
}

impl fmt::Display for GridError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            GridError::Layout => {
                "the grid's box is empty or not finite, or its resolution is 0 or above 2^24 voxels"
            }
            GridError::Length => "the length of the slice is not the one that the grid's layout asks for",
            GridError::Value => {
                "a density is negative or not finite, or a voxel's sums are none that deposits add up to"
            }
            GridError::Format => "the bytes are not a saved grid of a known version",
            GridError::Damaged => "the saved grid is damaged: its checksum does not match",
            GridError::OtherLayout => "the saved grid has another box or resolution than this one",
        })
    }
}

impl core::error::Error for GridError {}

impl GridLayout {
    /// Number of voxels, which is the length of the slices that a grid takes (saturating at the largest
    /// `usize`).
    pub fn cell_count(&self) -> usize {
        self.cells.iter().fold(1_usize, |count, &n| count.saturating_mul(n as usize))
    }

    /// Voxels per metre along each axis, if the layout is sound.
    pub(crate) fn scale(&self) -> Result<Vec3, GridError> {
        let count = self.cell_count();
        let scale = self.resolution() / (self.max - self.min);
        let sound = self.min.is_finite()
            && self.max.is_finite()
            && self.min.cmplt(self.max).all()
            && scale.is_finite()
            && scale.min_element() > 0.0
            && (1..=MAX_CELLS).contains(&count);
        if sound { Ok(scale) } else { Err(GridError::Layout) }
    }

    pub(crate) fn resolution(&self) -> Vec3 {
        Vec3::new(self.cells[0] as f32, self.cells[1] as f32, self.cells[2] as f32)
    }

    #[inline]
    pub(crate) fn contains(&self, position: Vec3) -> bool {
        position.cmpge(self.min).all() && position.cmple(self.max).all()
    }

    /// The voxel around a point, given [`GridLayout::scale`]; None outside the box and for NaN.
    pub(crate) fn voxel(&self, position: Vec3, scale: Vec3) -> Option<[u32; 3]> {
        let at = (position - self.min) * scale;
        let voxel = [0, 1, 2].map(|axis| (at[axis] as u32).min(self.cells[axis] - 1));
        self.contains(position).then_some(voxel)
    }

    pub(crate) fn index(&self, [x, y, z]: [u32; 3]) -> usize {
        (z as usize * self.cells[1] as usize + y as usize) * self.cells[0] as usize + x as usize
    }
}

/// Trilinear interpolation between the centres of a layout's voxels, held over the half voxel at the border
/// of the box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trilinear {
    pub(crate) layout: GridLayout,
    /// Voxels per metre.
    pub(crate) scale: Vec3,
    /// Index of the last voxel on each axis.
    pub(crate) last: Vec3,
    /// Steps to the next voxel on each axis; 0 where there is but one.
    pub(crate) strides: [usize; 3],
    /// Steps from the lowest of the eight voxels around a point to each of them: x first, then y, then z.
    pub(crate) corners: [usize; 8],
}

impl Trilinear {
    /// Of a layout with this number of values, one a voxel.
    pub(crate) fn new(layout: GridLayout, values: usize) -> Result<Self, GridError> {
        let scale = layout.scale()?;
        if values != layout.cell_count() {
            return Err(GridError::Length);
        }
        let [nx, ny, nz] = layout.cells.map(|n| n as usize);
        let stride = |count: usize, stride: usize| if count > 1 { stride } else { 0 };
        let strides @ [dx, dy, dz] = [stride(nx, 1), stride(ny, nx), stride(nz, nx * ny)];
        let corners = [0, dx, dy, dx + dy, dz, dx + dz, dy + dz, dx + dy + dz];
        Ok(Self { layout, scale, last: layout.resolution() - 1.0, strides, corners })
    }

    /// Index of the lowest of the eight voxels around a point, and the share of the next one on each axis, in
    /// \[0, 1\]. None outside the box and for NaN.
    // Eight-wide twin: beam_map/eight.rs.
    #[inline(always)]
    pub(crate) fn around(&self, position: Vec3) -> Option<(usize, Vec3)> {
        if !self.layout.contains(position) {
            return None;
        }
        let at = ((position - self.layout.min) * self.scale - 0.5).clamp(Vec3::ZERO, self.last);
        // The last centre is reached with weight 1 from the voxel before it.
        let corner = at.min(self.last - 1.0).max(Vec3::ZERO);
        let [x, y, z] = [corner.x as u32, corner.y as u32, corner.z as u32];
        let high = at - Vec3::new(x as f32, y as f32, z as f32);
        let [dx, dy, dz] = self.strides;
        Some((x as usize * dx + y as usize * dy + z as usize * dz, high))
    }
}

/// Which cells a walk visits.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Lattice {
    /// The voxels themselves.
    Voxels,
    /// The cells between the voxels' centres: `n + 1` on each axis, the outer ones half outside the box. Cell
    /// i lies between the centres i - 1 and i.
    Centres,
}

/// A 3D-DDA: the walk over the cells that a segment crosses inside the box, in f64: planes are computed
/// afresh at each step, so nothing drifts.
///
/// Source: Amanatides and Woo (1987).
pub(crate) struct Dda {
    /// The segment in units of cells: `start + s slope`.
    start: [f64; 3],
    inverse_slope: [f64; 3],
    /// Distance along the segment of the next plane on each axis.
    next: [f64; 3],
    cell: [u32; 3],
    /// Distance along the segment that the walk has reached, and where it ends.
    pub(crate) position: f64,
    pub(crate) end: f64,
    done: bool,
}

impl Dda {
    /// None where the segment misses the box, is none (no direction, no length), or is not finite; an
    /// infinite `length` ends at the box.
    pub(crate) fn new(
        layout: &GridLayout,
        lattice: Lattice,
        origin: Vec3,
        direction: Vec3,
        length: f32,
    ) -> Option<Self> {
        if !(origin.is_finite() && direction.is_finite() && direction != Vec3::ZERO && length > 0.0) {
            return None;
        }
        let mut dda = Self {
            start: [0.0; 3],
            inverse_slope: [0.0; 3],
            next: [f64::INFINITY; 3],
            cell: [0; 3],
            position: 0.0,
            end: f64::from(length),
            done: false,
        };
        let (shift, more) = if lattice == Lattice::Centres { (0.5, 1) } else { (0.0, 0) };
        let mut slope = [0.0; 3];
        for axis in 0..3 {
            let min = f64::from(layout.min[axis]);
            let count = f64::from(layout.cells[axis]);
            let scale = count / (f64::from(layout.max[axis]) - min);
            let start = (f64::from(origin[axis]) - min) * scale + shift;
            slope[axis] = f64::from(direction[axis]) * scale;
            dda.start[axis] = start;
            if slope[axis] == 0.0 {
                if !(shift..=count + shift).contains(&start) {
                    return None;
                }
                continue;
            }
            let inverse = 1.0 / slope[axis];
            dda.inverse_slope[axis] = inverse;
            let (low, high) = ((shift - start) * inverse, (count + shift - start) * inverse);
            dda.position = dda.position.max(low.min(high));
            dda.end = dda.end.min(low.max(high));
        }
        if dda.position >= dda.end {
            return None;
        }
        for (axis, slope) in slope.iter().enumerate() {
            let entry = dda.start[axis] + dda.position * slope;
            dda.cell[axis] = (entry as u32).min(layout.cells[axis] + more - 1);
            dda.update_next(axis);
        }
        Some(dda)
    }

    fn update_next(&mut self, axis: usize) {
        let inverse = self.inverse_slope[axis];
        if inverse != 0.0 {
            let plane = f64::from(self.cell[axis]) + if inverse > 0.0 { 1.0 } else { 0.0 };
            self.next[axis] = (plane - self.start[axis]) * inverse;
        }
    }

    /// The next cell that holds a stretch of positive length, and where it starts and ends along the segment.
    pub(crate) fn next_cell(&mut self) -> Option<([u32; 3], f64, f64)> {
        while !self.done {
            let [x, y, z] = self.next;
            let axis = if x <= y && x <= z {
                0
            } else if y <= z {
                1
            } else {
                2
            };
            let cell = self.cell;
            let from = self.position;
            let to = self.next[axis].min(self.end);
            // The border's plane is computed as `end` was, so this also stops the walk at the border.
            if to >= self.end {
                self.done = true;
                return (to > from).then_some((cell, from, to));
            }
            let forward = self.inverse_slope[axis] > 0.0;
            self.cell[axis] = if forward { self.cell[axis] + 1 } else { self.cell[axis] - 1 };
            self.update_next(axis);
            if to > from {
                self.position = to;
                return Some((cell, from, to));
            }
        }
        None
    }
}
