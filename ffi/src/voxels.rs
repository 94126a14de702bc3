//! Boxes of voxels: their layout, and the merge of objects that have the same.

use crate::arrays::each;
use crate::handle::{Opaque, shared};
use crate::memory::inputs;
use crate::status::{Failure, covbeam_status::*, fail, refusal};
use covbeam_core::{CovarianceGrid, GridError, GridLayout};

/// Box and resolution of a grid or of a density. Voxels lie in memory x first, then y, then z.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_grid_layout {
    /// Lower corner [m].
    pub min: [f32; 3],
    /// Upper corner [m], above min on every axis.
    pub max: [f32; 3],
    /// Voxels along x, y, z, each >= 1; at most 2^24 in all.
    pub cells: [u32; 3],
}

impl From<covbeam_grid_layout> for GridLayout {
    fn from(layout: covbeam_grid_layout) -> Self {
        Self { min: layout.min.into(), max: layout.max.into(), cells: layout.cells }
    }
}

impl From<GridLayout> for covbeam_grid_layout {
    fn from(layout: GridLayout) -> Self {
        Self { min: layout.min.into(), max: layout.max.into(), cells: layout.cells }
    }
}

/// Number of voxels of a layout that an object may have.
pub(crate) fn sound(layout: GridLayout) -> Result<usize, Failure> {
    // A grid of no cells has the wrong length, unless its layout is refused first.
    match CovarianceGrid::new(layout, &mut []) {
        Err(GridError::Length) => Ok(layout.cell_count()),
        Err(error) => Err(refusal("layout", error)),
        Ok(_) => unreachable!("a sound layout has cells"),
    }
}

/// Hands on what an array of handles stands for, in its order, once all are known to have the layout of
/// `itself`, which they are merged into, and none to be it.
///
/// # Safety
/// NULL, or readable, and the handles alive.
pub(crate) unsafe fn each_other<H: Opaque>(
    (itself, name): (*const H, &str),
    (others, count): (*const *const H, usize),
    has_layout: impl Fn(&H::Object) -> bool,
    mut add: impl FnMut(&H::Object),
) -> Result<(), Failure> {
    inputs!(count, others, size_of::<*const H>());
    let other = |i: usize| {
        let handle = others.get(i).value;
        if handle == itself {
            return Err(fail(COVBEAM_INVALID_ARRAY, format_args!("others[{i}]: is the {name} itself")));
        }
        // SAFETY: by this function's contract.
        let other = unsafe { shared(handle, "others") }?;
        if !has_layout(&other) {
            let message = format_args!("others[{i}]: has another layout than the {name}");
            return Err(fail(COVBEAM_MISMATCH, message));
        }
        Ok(other)
    };
    each(count, other, |_, other| add(&other))
}
