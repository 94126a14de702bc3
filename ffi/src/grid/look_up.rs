//! Look-ups of the mean spectra of a grid.

use super::cells::Cells;
use super::handle::{Grid, covbeam_grid};
use crate::arrays::each;
use crate::check::vector;
use crate::handle::{run_on, shared};
use crate::heap::reserved;
use crate::memory::{Outputs, inputs, outputs};
use crate::spectrum::covbeam_spectrum;
use crate::status::{Failure, covbeam_status, covbeam_status::*, fail, run};
use covbeam_core::{CovarianceGrid, FluenceCell, FluenceGrid, FluenceSpectrum};

impl Grid {
    fn resolve(&mut self) -> Result<(), Failure> {
        if let Cells::Own(means) = &mut self.means
            && means.is_empty()
        {
            *means = reserved(self.layout.cell_count())?;
            means.resize(self.layout.cell_count(), FluenceCell::default());
        }
        let grid = CovarianceGrid::new(self.layout, self.cells.all_mut());
        let grid = grid.expect("the layout was checked when the grid was made");
        grid.resolve(self.means.all_mut()).expect("as many means as cells");
        self.resolved = true;
        Ok(())
    }
}

/// The look-ups of a grid that has been resolved.
pub(crate) fn resolved(grid: &Grid) -> Result<FluenceGrid<'_>, Failure> {
    if !grid.resolved {
        let message = format_args!("grid: nothing to look up yet; call covbeam_grid_resolve first");
        return Err(fail(COVBEAM_WRONG_ORDER, message));
    }
    let means = FluenceGrid::new(grid.layout, grid.means.all());
    Ok(means.expect("the layout was checked when the grid was made"))
}

/// Computes the mean spectrum of every voxel, for look-ups; they see the state of this call until the next one.
///
/// @param grid the grid.
/// @note About 10 ns a voxel.
/// @kinds !grid
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_grid_resolve(grid: *mut covbeam_grid) -> covbeam_status {
    // SAFETY: by the caller's promise.
    unsafe { run_on(grid, "grid", Grid::resolve) }
}

/// The spectrum of the fluence around points: the flux-weighted mean of the eight voxels around each, with
/// trilinear weights.
///
/// @param grid a grid that has been resolved.
/// @param count number of points; with 0 nothing is done.
/// @param positions, position_stride points [m].
/// @param spectra, spectrum_stride receive the spectra [cycles^2/m^2]; 0 where the grid has no data.
/// @param found, found_stride receive 1, or 0 where the grid has no data: outside, and where no light has
///     passed. May be NULL.
/// @note Thesis Eq 5.15. 20 ns a point.
/// @kinds @grid.resolved <f:fff >spectrum >flag?
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_grid_look_up(
    grid: *const covbeam_grid,
    count: usize,
    positions: *const f32,
    position_stride: usize,
    spectra: *mut covbeam_spectrum,
    spectrum_stride: usize,
    found: *mut u8,
    found_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let grid = unsafe { shared(grid, "grid") }?;
        let grid = resolved(&grid)?;
        inputs!(count, positions: [f32; 3], position_stride);
        outputs!(count, spectra, spectrum_stride);
        let mut found = if found.is_null() {
            None
        } else {
            // SAFETY: by the caller's promise.
            Some(unsafe { Outputs::new(found, found_stride, count, "found") }?)
        };
        each(
            count,
            |i| vector(positions.get(i)),
            |i, position| {
                let spectrum = grid.look_up(position);
                spectra.set(i, spectrum.unwrap_or(FluenceSpectrum::default()).into());
                if let Some(found) = &mut found {
                    found.set(i, u8::from(spectrum.is_some()));
                }
            },
        )
    })
}
