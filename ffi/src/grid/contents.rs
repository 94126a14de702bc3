//! Contents of a grid, to read or to upload.

use super::cells::{covbeam_fluence_cell, covbeam_grid_cell};
use super::handle::covbeam_grid;
use super::look_up::resolved;
use crate::handle::shared;
use crate::memory::Slot;
use crate::status::{covbeam_status, run};

/// What the voxels have collected, to read or to upload.
///
/// @param grid the grid.
/// @param cells receives the first; valid until the grid is changed or freed.
/// @param count receives their number.
/// @kinds @grid >pointer >size
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_grid_get_cells(
    grid: *const covbeam_grid,
    cells: *mut *const covbeam_grid_cell,
    count: *mut usize,
) -> covbeam_status {
    run(|| {
        let (cells, count) = (Slot::new(cells, "cells")?, Slot::new(count, "count")?);
        // SAFETY: by the caller's promise.
        let grid = unsafe { shared(grid, "grid") }?;
        let all = grid.cells.all();
        cells.set(all.as_ptr().cast());
        count.set(all.len());
        Ok(())
    })
}

/// The mean spectra that look-ups see, to read or to upload.
///
/// @param grid a grid that has been resolved.
/// @param means receives the first; valid until the grid is changed or freed.
/// @param count receives their number.
/// @kinds @grid.resolved >pointer >size
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_grid_get_means(
    grid: *const covbeam_grid,
    means: *mut *const covbeam_fluence_cell,
    count: *mut usize,
) -> covbeam_status {
    run(|| {
        let (means, count) = (Slot::new(means, "means")?, Slot::new(count, "count")?);
        // SAFETY: by the caller's promise.
        let grid = unsafe { shared(grid, "grid") }?;
        resolved(&grid)?;
        means.set(grid.means.all().as_ptr().cast());
        count.set(grid.means.all().len());
        Ok(())
    })
}
