//! Covariance grids: what photons leave in them, and what a gather looks up.

use crate::check::{finite_not_negative, vector};
use crate::handle::{Opaque, free, handle_to, run_on, shared};
use crate::heap::reserved;
use crate::medium::{self, covbeam_medium};
use crate::memory::{Outputs, Slot, aligned, array, inputs, outputs, read};
use crate::segment::whole;
use crate::status::{
    Failure, cancelled, covbeam_poll, covbeam_status, covbeam_status::*, fail, go_on, refusal, run,
};
use crate::types::*;
use core::ffi::c_void;
use core::slice;
use covbeam_core::{
    Column, CovarianceGrid, FluenceCell, FluenceGrid, FluenceSpectrum, GridCell, GridError, GridLayout, Knot,
    Segment,
};

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

/// Voxels that segments cross between two polls: a millisecond.
const VOXELS: usize = 1500;

/// Cells of the library's or of the host's.
enum Cells<T> {
    Own(Vec<T>),
    Host { first: *mut T, count: usize },
}

impl<T> Cells<T> {
    fn all(&self) -> &[T] {
        match *self {
            Cells::Own(ref cells) => cells,
            // SAFETY: the host promised `covbeam_grid_new_in` that the memory is the grid's until it is freed; it was
            // checked there, and holds plain numbers.
            Cells::Host { first, count } => unsafe { slice::from_raw_parts(first, count) },
        }
    }

    fn all_mut(&mut self) -> &mut [T] {
        match *self {
            Cells::Own(ref mut cells) => cells,
            // SAFETY: as above; `self` is exclusive.
            Cells::Host { first, count } => unsafe { slice::from_raw_parts_mut(first, count) },
        }
    }
}

/// What a `covbeam_grid` is.
pub(crate) struct Grid {
    layout: GridLayout,
    cells: Cells<GridCell>,
    /// Empty before the first resolve, if the library's.
    means: Cells<FluenceCell>,
    resolved: bool,
    /// Of one segment's column.
    knots: Vec<Knot>,
}

impl Grid {
    fn own(layout: GridLayout) -> Result<Self, Failure> {
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

    fn collecting(&mut self) -> (CovarianceGrid<'_>, &mut Vec<Knot>) {
        let grid = CovarianceGrid::new(self.layout, self.cells.all_mut());
        (grid.expect("the layout was checked when the grid was made"), &mut self.knots)
    }

    /// For look-ups; None before the first resolve.
    pub(crate) fn fluence(&self) -> Option<FluenceGrid<'_>> {
        let grid = || FluenceGrid::new(self.layout, self.means.all());
        self.resolved.then(|| grid().expect("the layout was checked when the grid was made"))
    }

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

/// Number of voxels of a layout that a grid may have.
pub(crate) fn sound(layout: GridLayout) -> Result<usize, Failure> {
    // A grid of no cells has the wrong length, unless its layout is refused first.
    match CovarianceGrid::new(layout, &mut []) {
        Err(GridError::Length) => Ok(layout.cell_count()),
        Err(error) => Err(refusal("layout", error)),
        Ok(_) => unreachable!("a sound layout has cells"),
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
        let medium = unsafe { medium::read(medium, "medium") }?;
        inputs!(count, segments, segment_stride);
        for i in 0..count {
            whole(segments.get(i))?;
        }
        let (mut grid, knots) = grid.collecting();
        medium::reserve_table(&medium, knots)?;
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
                None => medium::tabulated(&medium, way.origin, way.field.direction, length, knots),
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
        let deposit = |i: usize| -> Result<_, Failure> {
            Ok((vector(positions.get(i))?, spectrum(spectra.get(i))?, finite_not_negative(weights.get(i))?))
        };
        for i in 0..count {
            deposit(i)?;
        }
        let (mut grid, _) = grid.collecting();
        for i in 0..count {
            let (position, spectrum, weight) = deposit(i)?;
            grid.deposit_spectrum(position, &spectrum, weight);
        }
        Ok(())
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(grid, "grid", deposit) }
}

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
        inputs!(other_count, others, size_of::<*const covbeam_grid>());
        let other = |i: usize| {
            let handle = others.get(i).value;
            if handle == itself {
                return Err(fail(COVBEAM_INVALID_ARRAY, format_args!("others[{i}]: is the grid itself")));
            }
            // SAFETY: by the caller's promise.
            unsafe { shared(handle, "others") }
        };
        for i in 0..other_count {
            if other(i)?.layout != grid.layout {
                return Err(fail(
                    COVBEAM_MISMATCH,
                    format_args!("others[{i}]: has another layout than the grid"),
                ));
            }
        }
        let (mut sum, _) = grid.collecting();
        for i in 0..other_count {
            sum.merge(other(i)?.cells.all()).expect("the layouts are equal");
        }
        Ok(())
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(grid, "grid", merge) }
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
        for i in 0..count {
            vector(positions.get(i))?;
        }
        for i in 0..count {
            let spectrum = grid.look_up(vector(positions.get(i))?);
            spectra.set(i, spectrum.unwrap_or(FluenceSpectrum::default()).into());
            if let Some(found) = &mut found {
                found.set(i, u8::from(spectrum.is_some()));
            }
        }
        Ok(())
    })
}

/// The look-ups of a grid that has been resolved.
pub(crate) fn resolved(grid: &Grid) -> Result<FluenceGrid<'_>, Failure> {
    let message = format_args!("grid: nothing to look up yet; call covbeam_grid_resolve first");
    grid.fluence().ok_or_else(|| fail(COVBEAM_WRONG_ORDER, message))
}

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
