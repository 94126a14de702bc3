//! The merge of grids.

use super::handle::{Grid, covbeam_grid};
use crate::handle::run_on;
use crate::status::covbeam_status;
use crate::voxels::each_other;

/// Adds what other grids of the same layout have collected, in their order.
///
/// @param grid the grid that is added to.
/// @param others array of other_count handles, none of them `grid`; they stay as they are.
/// @param other_count number of handles; with 0 nothing is done.
/// @note The sums are f64: 10^9 equal deposits keep their mean to 1e-7.
/// @kinds !grid <grids k
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_grid_merge(
    grid: *mut covbeam_grid,
    others: *const *const covbeam_grid,
    other_count: usize,
) -> covbeam_status {
    let itself = grid.cast_const();
    let merge = |grid: &mut Grid| {
        let layout = grid.layout;
        let (mut sum, _) = grid.collecting();
        let add = |other: &Grid| sum.merge(other.cells.all()).expect("the layouts are equal");
        // SAFETY: by the caller's promise.
        unsafe { each_other((itself, "grid"), (others, other_count), |other| other.layout == layout, add) }
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(grid, "grid", merge) }
}
