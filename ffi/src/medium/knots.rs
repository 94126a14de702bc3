//! Knots: tables of columns along one ray, in the host's memory.

use super::options::{covbeam_medium, read_medium};
use super::rays::ray;
use crate::check::{not_negative, positive_or_infinite};
use crate::memory::{Element, Outputs, Slot, array, same_layout};
use crate::status::{Failure, covbeam_status, covbeam_status::*, fail, run};
use covbeam_core::Knot;

/// A point of a table of columns.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_knot {
    /// Distance along the ray [m].
    pub distance: f32,
    /// Integral of the relative density up to there [m].
    pub column: f32,
}

impl From<covbeam_knot> for Knot {
    fn from(knot: covbeam_knot) -> Self {
        Self { distance: knot.distance, column: knot.column }
    }
}

impl From<Knot> for covbeam_knot {
    fn from(knot: Knot) -> Self {
        Self { distance: knot.distance, column: knot.column }
    }
}

same_layout!(covbeam_knot, Knot, column);

/// A packed table of knots, whose numbers have not been looked at.
pub(super) unsafe fn table<'a>(
    first: *const covbeam_knot,
    count: usize,
    name: &str,
) -> Result<&'a [Knot], Failure> {
    // SAFETY: of the same layout; readable by the caller's promise.
    unsafe { array(first.cast(), count, name) }
}

/// A table that is in order. Neighbours may coincide: rounding makes such.
pub(crate) unsafe fn ordered_table<'a>(
    first: *const covbeam_knot,
    count: usize,
    name: &str,
) -> Result<&'a [Knot], Failure> {
    // SAFETY: by the caller's promise.
    let knots = unsafe { table(first, count, name) }?;
    let mut before = Knot { distance: f32::MIN, column: 0.0 };
    for (i, knot) in knots.iter().enumerate() {
        let Knot { distance, column } = *knot;
        if !(distance.is_finite() && column.is_finite()) {
            let message = format_args!("{name}[{i}]: ({distance}, {column}) is not finite");
            return Err(fail(COVBEAM_INVALID_VALUE, message));
        }
        if distance < before.distance || column < before.column {
            let message = format_args!(
                "{name}[{i}]: ({distance}, {column}) falls behind ({}, {})",
                before.distance, before.column
            );
            return Err(fail(COVBEAM_INVALID_VALUE, message));
        }
        before = *knot;
    }
    Ok(knots)
}

/// Writes the knots that `march` gives, or only counts them.
unsafe fn fill(
    knots: *mut covbeam_knot,
    capacity: usize,
    count: *mut usize,
    march: impl Fn(&mut dyn FnMut(Knot)),
) -> Result<(), Failure> {
    let count = Slot::new(count, "count")?;
    let counting = knots.is_null() && capacity == 0;
    // SAFETY: by the caller's promise.
    let mut out = unsafe { Outputs::new(knots, size_of::<covbeam_knot>(), capacity, "knots") }?;
    let mut needed = 0;
    march(&mut |_| needed += 1);
    if !counting {
        if needed > capacity {
            let message = format_args!("capacity: {capacity}, but there are {needed} knots");
            return Err(fail(COVBEAM_SHORT_BUFFER, message));
        }
        let mut index = 0;
        march(&mut |knot| {
            out.set(index, knot.into());
            index += 1;
        });
    }
    count.set(needed);
    Ok(())
}

/// The table of columns along a ray through voxels: points between which a straight line is within `error` of
/// the column. None for other densities, whose columns are closed forms.
///
/// @param medium the medium.
/// @param origin of the ray [m].
/// @param direction of the ray, unit.
/// @param length of the ray [m] >= 0; infinity ends where it leaves the voxels.
/// @param error of a column [m] > 0; infinity keeps the ends alone. Times the extinction it is the error of the
///     optical depth.
/// @param most the table ends at the first point with a larger column [m] >= 0; infinity for the whole ray.
/// @param knots packed, room for `capacity` of them; NULL with a capacity of 0 only counts.
/// @param capacity of knots; 64 x (voxels along x + y + z + 2) is always enough.
/// @param count number of knots.
/// @note If the capacity is too small: COVBEAM_SHORT_BUFFER, and the message says what is needed. About 40 ns a
///     voxel passed.
/// @kinds <medium <f:fff <f:uuu $p $P $p >knot k >size
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_medium_knots(
    medium: *const covbeam_medium,
    origin: *const f32,
    direction: *const f32,
    length: f32,
    error: f32,
    most: f32,
    knots: *mut covbeam_knot,
    capacity: usize,
    count: *mut usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let medium = unsafe { read_medium(medium, "medium") }?;
        // SAFETY: by the caller's promise.
        let (origin, direction) = unsafe { ray(origin, direction) }?;
        let length = not_negative(Element::single(length, "length"))?;
        let error = positive_or_infinite(Element::single(error, "error"))?;
        let most = not_negative(Element::single(most, "most"))?;
        // SAFETY: by the caller's promise.
        unsafe {
            fill(knots, capacity, count, |knot| {
                medium.density.knots(origin, direction, length, error, most, knot)
            })
        }
    })
}

/// covbeam_medium_knots as a gather wants them: within 5e-4 of the optical depth of the channel that is
/// attenuated most, up to where every channel is opaque.
///
/// @param medium the medium.
/// @param origin of the ray [m].
/// @param direction of the ray, unit.
/// @param length of the ray [m] >= 0; infinity ends where it leaves the voxels.
/// @param knots packed, room for `capacity` of them; NULL with a capacity of 0 only counts.
/// @param capacity of knots.
/// @param count number of knots.
/// @note A capacity that is too small is answered as by covbeam_medium_knots. About 40 ns a voxel passed.
/// @kinds <medium <f:fff <f:uuu $p >knot k >size
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_medium_tabulate(
    medium: *const covbeam_medium,
    origin: *const f32,
    direction: *const f32,
    length: f32,
    knots: *mut covbeam_knot,
    capacity: usize,
    count: *mut usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let medium = unsafe { read_medium(medium, "medium") }?;
        // SAFETY: by the caller's promise.
        let (origin, direction) = unsafe { ray(origin, direction) }?;
        let length = not_negative(Element::single(length, "length"))?;
        // SAFETY: by the caller's promise.
        unsafe { fill(knots, capacity, count, |knot| medium.tabulate(origin, direction, length, knot)) }
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::hostile::{Rule::*, UNTOUCHED, message, refuses};
    use crate::medium::samples::{RAY, smoke};
    use core::ptr;

    const NO_KNOT: covbeam_knot = covbeam_knot { distance: UNTOUCHED, column: UNTOUCHED };

    #[test]
    fn a_bad_argument_is_refused_and_nothing_is_written() {
        let smoke = smoke();
        let numbers =
            [&RAY[..], &[(9.0, NotNegative), (1e-3, PositiveOrInfinite), (5.0, NotNegative)]].concat();
        refuses(5, &numbers, |bad, n| {
            let (origin, direction) = (bad.at(1, n.as_ptr()), bad.at(2, n[3..].as_ptr()));
            let (mut knots, mut count) = ([NO_KNOT; 400], 777);
            let to = bad.at_mut(3, knots.as_mut_ptr());
            let status = unsafe {
                let medium = bad.at(0, &smoke.medium);
                covbeam_medium_knots(
                    medium,
                    origin,
                    direction,
                    n[6],
                    n[7],
                    n[8],
                    to,
                    400,
                    bad.at_mut(4, &mut count),
                )
            };
            (status, count != 777 || knots[0] != NO_KNOT)
        });
        refuses(5, &[&RAY[..], &[(9.0, NotNegative)]].concat(), |bad, n| {
            let (origin, direction) = (bad.at(1, n.as_ptr()), bad.at(2, n[3..].as_ptr()));
            let (mut knots, mut count) = ([NO_KNOT; 400], 777);
            let to = bad.at_mut(3, knots.as_mut_ptr());
            let status = unsafe {
                let medium = bad.at(0, &smoke.medium);
                covbeam_medium_tabulate(medium, origin, direction, n[6], to, 400, bad.at_mut(4, &mut count))
            };
            (status, count != 777 || knots[0] != NO_KNOT)
        });
    }

    #[test]
    fn a_table_is_counted_first_and_a_short_buffer_is_not_overrun() {
        let smoke = smoke();
        let (origin, direction) = ([0.2, 0.3, -1.0], [0.0, 0.0, 1.0]);
        let tabulate = |knots: *mut covbeam_knot, capacity, count: &mut usize| unsafe {
            covbeam_medium_tabulate(
                &smoke.medium,
                origin.as_ptr(),
                direction.as_ptr(),
                9.0,
                knots,
                capacity,
                count,
            )
        };
        let mut needed = 0;
        assert_eq!(tabulate(ptr::null_mut(), 0, &mut needed), COVBEAM_OK);
        assert!(needed >= 2);
        let mut knots = vec![NO_KNOT; needed];
        let mut count = 777;
        assert_eq!(tabulate(knots.as_mut_ptr(), needed - 1, &mut count), COVBEAM_SHORT_BUFFER);
        assert!(count == 777 && knots.iter().all(|knot| *knot == NO_KNOT), "nothing is written");
        let expected = format!("capacity: {}, but there are {needed} knots", needed - 1);
        assert_eq!(message(), expected);
        assert_eq!(tabulate(knots.as_mut_ptr(), needed, &mut count), COVBEAM_OK);
        assert_eq!(count, needed);
        assert!(knots.iter().all(|knot| *knot != NO_KNOT));
    }
}
