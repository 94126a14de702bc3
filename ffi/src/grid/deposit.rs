//! Deposits: what light paths leave in a grid.

use super::handle::{Grid, covbeam_grid};
use crate::arrays::each;
use crate::check::{finite_not_negative, vector};
use crate::handle::run_on;
use crate::light_path::segment::{covbeam_segment, whole};
use crate::medium::options::{covbeam_medium, read_medium, reserve_table, tabulated};
use crate::memory::inputs;
use crate::spectrum::{covbeam_spectrum, spectrum};
use crate::status::{cancelled, covbeam_poll, covbeam_status, go_on};
use core::ffi::c_void;
use covbeam_core::{Column, Segment};

/// Voxels that segments cross between two polls: a millisecond.
const VOXELS: usize = 1500;

/// Adds the light fields along segments of light paths, in their order; past each edge what the edge has left.
/// Stopped, the grid keeps what it has of the first segments: covbeam_grid_clear forgets that.
///
/// @param grid the grid.
/// @param medium what the segments run through; what it leaves of light is the channels' mean.
/// @param count number of segments; with 0 nothing is done.
/// @param segments, segment_stride the segments.
/// @param poll may be NULL; asked at least every few milliseconds. Not 0 ends the call with COVBEAM_CANCELLED.
/// @param user given to poll.
/// @note Thesis 5.3.1, Eq 5.14 and 5.15. 0.2 us a voxel on the way, 0.7 us where the density varies; 2 to 40 us
///     a segment. A tenth of a pass' photons is enough.
/// @kinds !grid <medium <segment
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_grid_deposit(
    grid: *mut covbeam_grid,
    medium: *const covbeam_medium,
    count: usize,
    segments: *const covbeam_segment,
    segment_stride: usize,
    poll: covbeam_poll,
    user: *mut c_void,
) -> covbeam_status {
    let deposit = |grid: &mut Grid| {
        let layout = grid.layout;
        // SAFETY: by the caller's promise.
        let medium = unsafe { read_medium(medium, "medium") }?;
        inputs!(count, segments, segment_stride);
        for i in 0..count {
            whole(segments.get(i))?;
        }
        let (mut grid, knots) = grid.collecting();
        reserve_table(&medium, knots)?;
        let (mut go_on, voxels) = (go_on(poll, user), layout.cells.map(|count| count as usize));
        let interval = (VOXELS / voxels.iter().sum::<usize>()).max(1);
        for i in 0..count {
            if i % interval == 0 && !go_on() {
                return Err(cancelled());
            }
            let (way, table) = whole(segments.get(i))?;
            let covbeam_segment { length, power, unscattered, .. } = segments.get(i).value;
            let column = match table {
                Some(table) => Column::Knots(table),
                None => tabulated(&medium, way.origin, way.field.direction, length, knots),
            };
            let unscattered = unscattered == 1;
            grid.deposit(&medium, &Segment { length, power, unscattered, column, ..way.segment() });
        }
        Ok(())
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(grid, "grid", deposit) }
}

/// Adds spectra to the voxels around points, in their order: for hosts that estimate bandwidth in a way of
/// their own.
///
/// @param grid the grid.
/// @param count number of points; with 0 nothing is done.
/// @param positions, position_stride points [m]; one outside the grid adds nothing.
/// @param spectra, spectrum_stride spectra [cycles^2/m^2], finite; covariances, or the grid cannot be saved.
/// @param weights, weight_stride contributions to the fluence [W m], finite and >= 0.
/// @kinds !grid <f:fff <spectrum <f:q
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_grid_deposit_spectra(
    grid: *mut covbeam_grid,
    count: usize,
    positions: *const f32,
    position_stride: usize,
    spectra: *const covbeam_spectrum,
    spectrum_stride: usize,
    weights: *const f32,
    weight_stride: usize,
) -> covbeam_status {
    let deposit = |grid: &mut Grid| {
        inputs!(count, positions: [f32; 3], position_stride);
        inputs!(count, spectra, spectrum_stride);
        inputs!(count, weights, weight_stride);
        let (mut grid, _) = grid.collecting();
        each(
            count,
            |i| {
                let position = vector(positions.get(i))?;
                Ok((position, spectrum(spectra.get(i))?, finite_not_negative(weights.get(i))?))
            },
            |_, (position, spectrum, weight)| grid.deposit_spectrum(position, &spectrum, weight),
        )
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(grid, "grid", deposit) }
}
