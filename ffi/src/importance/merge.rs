//! The merge of what several importances have collected.

use super::handle::{Voxels, covbeam_importance};
use crate::handle::run_on;
use crate::status::covbeam_status;
use crate::voxels::each_other;

/// Adds what others of the same layout have collected, in their order.
///
/// @param importance what is added to.
/// @param others array of other_count handles, none of them `importance`; they stay as they are.
/// @param other_count number of handles; with 0 nothing is done.
/// @kinds !importance <importances k
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_importance_merge(
    importance: *mut covbeam_importance,
    others: *const *const covbeam_importance,
    other_count: usize,
) -> covbeam_status {
    let itself = importance.cast_const();
    let merge = |importance: &mut Voxels| {
        let layout = importance.layout;
        let mut sum = importance.collecting();
        let add = |other: &Voxels| sum.merge(&other.sums).expect("the layouts are equal");
        // SAFETY: by the caller's promise.
        unsafe {
            each_other((itself, "importance"), (others, other_count), |other| other.layout == layout, add)
        }
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(importance, "importance", merge) }
}
