//! Look-ups of importance: what light is worth.

use super::handle::{Voxels, covbeam_importance};
use crate::arrays::write;
use crate::check::vector;
use crate::eye_ray::{covbeam_eye_ray, eye_ray};
use crate::handle::{run_on, shared};
use crate::heap::reserved;
use crate::medium::options::{covbeam_medium, read_medium};
use crate::memory::{inputs, outputs};
use crate::status::{covbeam_status, run};
use covbeam_core::{EyeRay, ImportanceCell, ImportanceGrid, SegmentImportance};

/// Importance around a point.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_importance_cell {
    /// Of a watt of beam on each metre, with the medium's density [1/(W m)].
    pub beam: f32,
    /// Of a watt that is scattered there, by the medium or by a diffuse surface, into no direction more than
    /// others [1/W].
    pub scattered: f32,
    /// Of a watt that arrives on surfaces there [1/W], but for what they scatter.
    pub surface: f32,
}

/// What a watt that flies along a segment is worth.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_segment_importance {
    /// As a beam, of a watt at the segment's start [1/W].
    pub beam: f32,
    /// Of what the medium scatters from a watt on its way [1/W].
    pub scattered: f32,
    /// What is left of a watt where it leaves the voxels, or at its end if that is before.
    pub transmittance: f32,
}

/// Computes the importance of every voxel, smoothed over its neighbours, for look-ups; they see the state of this
/// call until the next one. Where there is any, it is at least a thousandth of its mean everywhere.
///
/// @param importance what is resolved.
/// @kinds !importance
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_resolve(importance: *mut covbeam_importance) -> covbeam_status {
    let resolve = |importance: &mut Voxels| {
        let count = importance.sums.len();
        if importance.cells.is_empty() {
            importance.cells = reserved(count)?;
            importance.cells.resize(count, ImportanceCell::default());
        }
        let grid = ImportanceGrid::new(importance.layout, &mut importance.sums);
        let grid = grid.expect("the layout was checked when it was made");
        grid.resolve(&mut importance.cells).expect("as many cells as sums");
        Ok(())
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(importance, "importance", resolve) }
}

/// The importance around points: of light that is scattered there, or arrives on a surface.
///
/// @param importance one that has been resolved.
/// @param count number of points; with 0 nothing is done.
/// @param positions, position_stride the points [m]; outside the box that of the nearest voxel.
/// @param cells, cell_stride receive it.
/// @kinds @importance.resolved <f:fff >worth
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_at(
    importance: *const covbeam_importance,
    count: usize,
    positions: *const f32,
    position_stride: usize,
    cells: *mut covbeam_importance_cell,
    cell_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let importance = unsafe { shared(importance, "importance") }?;
        let importance = importance.resolved()?;
        inputs!(count, positions: [f32; 3], position_stride);
        outputs!(count, cells, cell_stride);
        write(
            cells,
            |i| vector(positions.get(i)),
            |position| {
                let ImportanceCell { beam, scattered, surface } = importance.at(position);
                covbeam_importance_cell { beam, scattered, surface }
            },
        )
    })
}

/// What a watt that flies along segments of light paths is worth: to weigh directions in which a path may go on,
/// and collisions on its way. Nothing outside the box.
///
/// @param importance one that has been resolved.
/// @param medium what the segments run through; the means of the channels count.
/// @param count number of segments; with 0 nothing is done.
/// @param segments, segment_stride the segments, each to the next surface, with the direction of the light.
/// @param worths, worth_stride receive it. On a surface behind, worth there is transmittance times what
///     covbeam_importance_at says: surface, and albedo times scattered.
/// @note About 5 ns a voxel on the way.
/// @kinds @importance.resolved <medium <ray >worth
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_of_segments(
    importance: *const covbeam_importance,
    medium: *const covbeam_medium,
    count: usize,
    segments: *const covbeam_eye_ray,
    segment_stride: usize,
    worths: *mut covbeam_segment_importance,
    worth_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let importance = unsafe { shared(importance, "importance") }?;
        let importance = importance.resolved()?;
        // SAFETY: by the caller's promise.
        let medium = unsafe { read_medium(medium, "medium") }?;
        inputs!(count, segments, segment_stride);
        outputs!(count, worths, worth_stride);
        write(
            worths,
            |i| eye_ray(segments.get(i)),
            |EyeRay { origin, direction, length }| {
                let worth = importance.of_segment(&medium, origin, direction, length);
                let SegmentImportance { beam, scattered, transmittance } = worth;
                covbeam_segment_importance { beam, scattered, transmittance }
            },
        )
    })
}
