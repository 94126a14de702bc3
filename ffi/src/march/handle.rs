//! The table along one eye ray, and the memory for shadow rays: made, freed, and taken anew for each ray.

use super::knots::{covbeam_march_knot, enough};
use crate::check::finite;
use crate::handle::{Opaque, free, handle_to, run_on};
use crate::heap::reserved;
use crate::memory::{Slot, field, inputs};
use crate::status::{Failure, covbeam_status, covbeam_status::*, fail, run};
use core::slice;
use covbeam_core::{March, MarchCell, MarchKnot, MarchSample};

/// The table along one eye ray, and the memory that placing shadow rays needs: one a thread, for one ray after
/// the other. For each ray: covbeam_march_lay and the host's radiances make the knots; covbeam_march_update;
/// covbeam_march_place, and the shadow rays of the round; covbeam_march_refine, and those of a second one.
pub struct covbeam_march(());

impl Opaque for covbeam_march {
    type Object = Table;
    const TAG: u64 = u64::from_le_bytes(*b"cb-march");
    const NAME: &'static str = "covbeam_march";
}

/// What a `covbeam_march` is.
#[derive(Default)]
pub(crate) struct Table {
    knots: Vec<MarchKnot>,
    cells: Vec<MarchCell>,
    /// A view of the two above; None before the first update and while they change.
    pub(super) view: Option<March<'static>>,
    /// Of one call.
    pub(super) first: Vec<MarchSample>,
    pub(super) jitters: Vec<f32>,
    pub(super) samples: Vec<MarchSample>,
}

impl Table {
    pub(super) fn view(&self) -> Result<&March<'static>, Failure> {
        let message = format_args!("march: no table yet; call covbeam_march_update first");
        self.view.as_ref().ok_or_else(|| fail(COVBEAM_WRONG_ORDER, message))
    }
}

/// Makes the memory of a thread's marches.
///
/// @param out the handle.
/// @kinds +march
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_march_new(out: *mut *mut covbeam_march) -> covbeam_status {
    run(|| {
        let out = Slot::new(out, "out")?;
        out.set(handle_to(Table::default())?);
        Ok(())
    })
}

/// Frees a thread's memory.
///
/// @param march NULL is fine.
/// @kinds !march
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_march_free(march: *mut covbeam_march) -> covbeam_status {
    // SAFETY: by the caller's promise.
    unsafe { free(march, "march") }
}

/// Takes the table of the next eye ray, in place of the one before.
///
/// @param march the thread's memory.
/// @param count number of knots >= 2.
/// @param knots, knot_stride by distance, which are finite and do not fall; copied. Between them the radiance is
///     taken as linear, and where two neighbours are dark no shadow ray is placed: lay them where light is, such
///     as inside a spot's cone.
/// @note 25 ns a knot.
/// @kinds !march <place
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_march_update(
    march: *mut covbeam_march,
    count: usize,
    knots: *const covbeam_march_knot,
    knot_stride: usize,
) -> covbeam_status {
    let update = |table: &mut Table| {
        enough(count)?;
        inputs!(count, knots, knot_stride);
        let mut before = f32::MIN;
        for i in 0..count {
            let knot = knots.get(i);
            let distance = finite(field!(knot, distance))?;
            if distance < before {
                return Err(
                    field!(knot, distance).is(format_args!("{distance} is below that before, {before}"))
                );
            }
            before = distance;
        }
        let (mut taken, mut cells) = (reserved(count)?, reserved(count)?);
        taken.extend((0..count).map(|i| MarchKnot::from(knots.get(i).value)));
        cells.resize(count, MarchCell::default());
        table.view = None;
        (table.knots, table.cells) = (taken, cells);
        // SAFETY: the memory of the vectors stays where it is, and is not written, until the next `update` has taken the
        // view away; the view is not handed out, and goes with the table.
        let (knots, cells) = unsafe {
            (
                slice::from_raw_parts(table.knots.as_ptr(), count),
                slice::from_raw_parts_mut(table.cells.as_mut_ptr(), count),
            )
        };
        table.view = Some(March::new(knots, cells).expect("ordered, and as many of both"));
        Ok(())
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(march, "march", update) }
}
