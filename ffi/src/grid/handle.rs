//! Covariance grids: what a handle stands for, made, emptied and freed.

use super::cells::{Cells, covbeam_fluence_cell, covbeam_grid_cell};
use crate::handle::{Opaque, free, handle_to, run_on, shared};
use crate::heap::reserved;
use crate::memory::{Slot, aligned, read};
use crate::status::{Failure, covbeam_status, covbeam_status::*, fail, run};
use crate::voxels::{covbeam_grid_layout, sound};
use covbeam_core::{CovarianceGrid, FluenceCell, GridCell, GridLayout, Knot};

/// A grid of fluence spectra. It collects (covbeam_grid_deposit), adds up (covbeam_grid_merge), is resolved
/// once the photons of a pass are in (covbeam_grid_resolve), and is looked up from then on, by
/// covbeam_beam_map_gather too. It keeps what it has collected over the passes of a picture.
///
/// Deposits from several threads: give each *share of the photons*, not each thread, a grid of its own, and
/// merge these in their order. The result is then the same, to the bit, for any number of threads. With one
/// grid for all photons, deposit in order.
pub struct covbeam_grid(());

impl Opaque for covbeam_grid {
    type Object = Grid;
    const TAG: u64 = u64::from_le_bytes(*b"cb-grid ");
    const NAME: &'static str = "covbeam_grid";
}

/// What a `covbeam_grid` is.
pub(crate) struct Grid {
    pub(super) layout: GridLayout,
    pub(super) cells: Cells<GridCell>,
    /// Empty before the first resolve, if the library's.
    pub(super) means: Cells<FluenceCell>,
    pub(super) resolved: bool,
    /// Of one segment's column.
    knots: Vec<Knot>,
}

impl Grid {
    pub(super) fn own(layout: GridLayout) -> Result<Self, Failure> {
        let mut cells = reserved(sound(layout)?)?;
        cells.resize(layout.cell_count(), GridCell::default());
        Ok(Self {
            layout,
            cells: Cells::Own(cells),
            means: Cells::Own(Vec::new()),
            resolved: false,
            knots: Vec::new(),
        })
    }

    pub(super) fn collecting(&mut self) -> (CovarianceGrid<'_>, &mut Vec<Knot>) {
        let grid = CovarianceGrid::new(self.layout, self.cells.all_mut());
        (grid.expect("the layout was checked when the grid was made"), &mut self.knots)
    }
}

/// Makes an empty grid in the library's memory: 56 bytes a voxel, and 28 more from the first
/// covbeam_grid_resolve on.
///
/// @param layout box and resolution.
/// @param out the handle.
/// @kinds <layout +grid
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_grid_new(
    layout: *const covbeam_grid_layout,
    out: *mut *mut covbeam_grid,
) -> covbeam_status {
    run(|| {
        let out = Slot::new(out, "out")?;
        // SAFETY: by the caller's promise.
        let grid = Grid::own(unsafe { read(layout, "layout") }?.into())?;
        out.set(handle_to(grid)?);
        Ok(())
    })
}

/// Makes a grid in the host's memory, which is the grid's until it is freed: between calls on the grid the host
/// may read it, and write it too (numbers that deposits cannot make are voxels without data).
///
/// @param layout box and resolution.
/// @param cells, cell_count as many as the layout has; their content stays: zero them for an empty grid.
/// @param means, mean_count as many as the layout has; written by covbeam_grid_resolve.
/// @param out the handle.
/// @kinds <layout =cell k =mean k +grid
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_grid_new_in(
    layout: *const covbeam_grid_layout,
    cells: *mut covbeam_grid_cell,
    cell_count: usize,
    means: *mut covbeam_fluence_cell,
    mean_count: usize,
    out: *mut *mut covbeam_grid,
) -> covbeam_status {
    run(|| {
        let out = Slot::new(out, "out")?;
        // SAFETY: by the caller's promise.
        let layout = GridLayout::from(unsafe { read(layout, "layout") }?);
        let count = sound(layout)?;
        for (name, given) in [("cell_count", cell_count), ("mean_count", mean_count)] {
            if given != count {
                let message = format_args!("{name}: {given}, but the layout has {count} voxels");
                return Err(fail(COVBEAM_SHORT_BUFFER, message));
            }
        }
        aligned(cells, "cells")?;
        aligned(means, "means")?;
        let grid = Grid {
            layout,
            cells: Cells::Host { first: cells.cast(), count },
            means: Cells::Host { first: means.cast(), count },
            resolved: false,
            knots: Vec::new(),
        };
        out.set(handle_to(grid)?);
        Ok(())
    })
}

/// Frees a grid; memory of the host's stays the host's, with what is in it.
///
/// @param grid NULL is fine.
/// @kinds !grid
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_grid_free(grid: *mut covbeam_grid) -> covbeam_status {
    // SAFETY: by the caller's promise.
    unsafe { free(grid, "grid") }
}

/// The grid's box and resolution.
///
/// @param grid the grid.
/// @param layout receives them.
/// @kinds @grid >layout
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_grid_get_layout(
    grid: *const covbeam_grid,
    layout: *mut covbeam_grid_layout,
) -> covbeam_status {
    run(|| {
        let layout = Slot::new(layout, "layout")?;
        // SAFETY: by the caller's promise.
        layout.set(unsafe { shared(grid, "grid") }?.layout.into());
        Ok(())
    })
}

/// Empties a grid, and forgets what was resolved.
///
/// @param grid the grid.
/// @kinds !grid
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_grid_clear(grid: *mut covbeam_grid) -> covbeam_status {
    let clear = |grid: &mut Grid| {
        grid.cells.all_mut().fill(GridCell::default());
        grid.resolved = false;
        Ok(())
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(grid, "grid", clear) }
}
