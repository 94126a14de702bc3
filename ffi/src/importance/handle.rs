//! Importance in voxels: what a handle stands for, made and freed.

use crate::handle::{Opaque, free, handle_to};
use crate::heap::reserved;
use crate::memory::{Slot, read};
use crate::status::{Failure, covbeam_status, covbeam_status::*, fail, run};
use crate::voxels::{covbeam_grid_layout, sound};
use covbeam_core::{GridLayout, Importance, ImportanceCell, ImportanceGrid, ImportanceSums};

/// Where the picture needs photons. Importance is the share of the picture's light, relative to its brightness,
/// that a watt brings about. It collects what the camera sees (covbeam_importance_add_eye_rays, _add_paths,
/// _add_surfaces), is resolved once, before the first pass, and is looked up from then on by what traces the
/// light. Only probabilities follow from it: a wrong importance costs noise and never makes a picture wrong.
///
/// Several threads: as for covbeam_grid, one for each *share of the paths*, merged in order.
pub struct covbeam_importance(());

impl Opaque for covbeam_importance {
    type Object = Voxels;
    const TAG: u64 = u64::from_le_bytes(*b"cb-impor");
    const NAME: &'static str = "covbeam_importance";
}

/// What a `covbeam_importance` is.
pub(crate) struct Voxels {
    pub(super) layout: GridLayout,
    pub(super) sums: Vec<ImportanceSums>,
    /// Empty before the first resolve.
    pub(super) cells: Vec<ImportanceCell>,
}

impl Voxels {
    pub(super) fn collecting(&mut self) -> ImportanceGrid<'_> {
        ImportanceGrid::new(self.layout, &mut self.sums).expect("the layout was checked when it was made")
    }

    pub(super) fn resolved(&self) -> Result<Importance<'_>, Failure> {
        Importance::new(self.layout, &self.cells).map_err(|_| {
            let message =
                format_args!("importance: nothing to look up yet; call covbeam_importance_resolve first");
            fail(COVBEAM_WRONG_ORDER, message)
        })
    }
}

/// Makes an empty importance: 24 bytes a voxel, and 12 more from the first covbeam_importance_resolve on.
///
/// @param layout box and resolution: of the lit fog, and coarse. Importance is smooth.
/// @param out the handle.
/// @kinds <layout +importance
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_new(
    layout: *const covbeam_grid_layout,
    out: *mut *mut covbeam_importance,
) -> covbeam_status {
    run(|| {
        let out = Slot::new(out, "out")?;
        // SAFETY: by the caller's promise.
        let layout = GridLayout::from(unsafe { read(layout, "layout") }?);
        let count = sound(layout)?;
        let mut sums = reserved(count)?;
        sums.resize(count, ImportanceSums::default());
        out.set(handle_to(Voxels { layout, sums, cells: Vec::new() })?);
        Ok(())
    })
}

/// Frees an importance.
///
/// @param importance NULL is ignored.
/// @kinds !importance
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_free(importance: *mut covbeam_importance) -> covbeam_status {
    // SAFETY: by the caller's promise.
    unsafe { free(importance, "importance") }
}
