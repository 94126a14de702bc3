//! The light that is expected before any shadow ray is traced.

use super::handle::covbeam_march;
use crate::handle::shared;
use crate::memory::Slot;
use crate::status::{covbeam_status, run};

/// What a table along an eye ray says before any shadow ray is traced.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_march_expected {
    /// The light that is expected to be scattered to the eye [W/(m^2 sr)]: with the knots' visibility, half
    /// where it is not known.
    pub radiance: f32,
    /// Expected standard deviation of the estimate from one round, times the number of its shadow rays
    /// [W/(m^2 sr)]. To spread rays over pixels, give to each in proportion to a power of it.
    pub error: f32,
}

/// What the table says before any shadow ray is traced.
///
/// @param march a march that has a table.
/// @param expected receives it.
/// @kinds @march.resolved >f:qq
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_march_get_expected(
    march: *const covbeam_march,
    expected: *mut covbeam_march_expected,
) -> covbeam_status {
    run(|| {
        let expected = Slot::new(expected, "expected")?;
        // SAFETY: by the caller's promise.
        let march = unsafe { shared(march, "march") }?;
        let march = march.view()?;
        expected.set(covbeam_march_expected {
            radiance: march.expected_radiance(),
            error: march.expected_error(),
        });
        Ok(())
    })
}

/// How many of a ray's shadow rays should be spent on a first round.
///
/// @param march a march that has a table.
/// @param rays shadow rays in all.
/// @param first receives their number; 0 = all in one round, because the expected changes are too many to be
///     found one by one. For a light with an extent one round is better whatever this says: two shadow rays to
///     different points of it differ without a border between them.
/// @kinds @march.resolved #any >size
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_march_get_first_round(
    march: *const covbeam_march,
    rays: usize,
    first: *mut usize,
) -> covbeam_status {
    run(|| {
        let first = Slot::new(first, "first")?;
        // SAFETY: by the caller's promise.
        first.set(unsafe { shared(march, "march") }?.view()?.first_round(rays));
        Ok(())
    })
}
