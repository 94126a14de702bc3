//! Cells of a grid, in the library's or in the host's memory.

use crate::memory::same_layout;
use crate::spectrum::covbeam_spectrum;
use core::slice;
use covbeam_core::{FluenceCell, GridCell};

/// What one voxel has collected. All 0 is empty.
/// @extra
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_grid_cell {
    /// Sum of weight x (xx, yy, zz, xy, xz, yz).
    pub sum: [f64; 6],
    /// Sum of the weights.
    pub weight: f64,
}

/// The mean spectrum of one voxel, for look-ups.
/// @extra
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_fluence_cell {
    /// Flux-weighted mean of what was deposited.
    pub spectrum: covbeam_spectrum,
    /// Fluence over that of the brightest voxel, in (0, 1]; 0 = no data.
    pub weight: f32,
}

same_layout!(covbeam_grid_cell, GridCell, weight);
same_layout!(covbeam_fluence_cell, FluenceCell, weight);

/// Cells of the library's or of the host's.
pub(super) enum Cells<T> {
    Own(Vec<T>),
    Host { first: *mut T, count: usize },
}

impl<T> Cells<T> {
    pub(super) fn all(&self) -> &[T] {
        match *self {
            Cells::Own(ref cells) => cells,
            // SAFETY: the host promised `covbeam_grid_new_in` that the memory is the grid's until it is freed; it was
            // checked there, and holds plain numbers.
            Cells::Host { first, count } => unsafe { slice::from_raw_parts(first, count) },
        }
    }

    pub(super) fn all_mut(&mut self) -> &mut [T] {
        match *self {
            Cells::Own(ref mut cells) => cells,
            // SAFETY: as above; `self` is exclusive.
            Cells::Host { first, count } => unsafe { slice::from_raw_parts_mut(first, count) },
        }
    }
}
