//! Grids as bytes.

use super::handle::{Grid, covbeam_grid};
use crate::handle::{handle_to, shared};
use crate::heap::reserved;
use crate::memory::{Slot, aligned, array};
use crate::status::{covbeam_status, covbeam_status::*, fail, refusal, run};
use core::ffi::c_void;
use covbeam_core::{GridError, GridLayout};

/// Number of bytes that covbeam_grid_save writes.
///
/// @param grid the grid.
/// @param size receives it: 56 and 56 a voxel.
/// @kinds @grid >size
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_grid_get_saved_size(
    grid: *const covbeam_grid,
    size: *mut usize,
) -> covbeam_status {
    run(|| {
        let size = Slot::new(size, "size")?;
        // SAFETY: by the caller's promise.
        size.set(unsafe { shared(grid, "grid") }?.layout.saved_size());
        Ok(())
    })
}

/// Writes what the grid has collected as bytes, the same on every machine.
///
/// @param grid the grid.
/// @param bytes, size memory of covbeam_grid_get_saved_size bytes.
/// @note 0.1 us a voxel. Cells that covariances cannot add up to are refused: written by the host, or deposited
///     as spectra that are none.
/// @kinds @grid >byte k
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_grid_save(
    grid: *const covbeam_grid,
    bytes: *mut c_void,
    size: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let grid = unsafe { shared(grid, "grid") }?;
        let Grid { layout, cells, .. } = &*grid;
        let needed = layout.saved_size();
        aligned(bytes.cast::<u8>(), "bytes")?;
        if size != needed {
            let message = format_args!("size: {size}, but covbeam_grid_get_saved_size says {needed}");
            return Err(fail(COVBEAM_SHORT_BUFFER, message));
        }
        let mut copy = reserved(size)?;
        copy.resize(size, 0);
        layout.save(cells.all(), &mut copy).map_err(|error| refusal("grid", error))?;
        // SAFETY: not NULL; writable by the caller's promise, and as long as the copy.
        unsafe { bytes.cast::<u8>().copy_from_nonoverlapping(copy.as_ptr(), size) };
        Ok(())
    })
}

/// Makes a grid from the bytes of covbeam_grid_save. Bytes that it has not written are refused.
///
/// @param bytes, size the bytes.
/// @param out the handle; the grid is not resolved yet.
/// @note Memory is had only for as many voxels as there are bytes for.
/// @kinds <saved k +grid
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_grid_load(
    bytes: *const c_void,
    size: usize,
    out: *mut *mut covbeam_grid,
) -> covbeam_status {
    run(|| {
        let out = Slot::new(out, "out")?;
        // SAFETY: by the caller's promise.
        let bytes = unsafe { array(bytes.cast::<u8>(), size, "bytes") }?;
        let damaged = |error| match error {
            GridError::OtherLayout => refusal("bytes", error),
            error => fail(COVBEAM_BAD_DATA, format_args!("bytes: {error}")),
        };
        let mut grid = Grid::own(GridLayout::of_saved(bytes).map_err(damaged)?)?;
        grid.collecting().0.load(bytes).map_err(damaged)?;
        out.set(handle_to(grid)?);
        Ok(())
    })
}
