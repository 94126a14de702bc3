//! Columns along one ray that is asked many times, by value.

use super::knots::{covbeam_knot, ordered_table, table};
use super::options::{covbeam_density_kind, covbeam_medium, read_medium};
use super::rays::ray;
use crate::arrays::write;
use crate::check::{finite_not_negative, not_negative};
use crate::memory::{Element, Slot, field, inputs, outputs};
use crate::status::{Failure, covbeam_status, run};
use core::ptr;
use covbeam_core::{Column, Density, Knot};

/// The column along one ray as a function of the distance. Made by covbeam_medium_column.
///
/// A host with media of its own may write one: VOXELS with a table of its own, whatever the density is made of.
/// @extra
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_column {
    /// A value of covbeam_density_kind; the fields below are read as it needs them.
    pub kind: u32,
    /// Exponential: relative density at the ray's origin, finite and >= 0.
    pub density: f32,
    /// Exponential: the density falls as exp(-rate x distance) [1/m], of either sign.
    pub rate: f32,
    /// Voxels: the host's table, which stays in place and unchanged while the column is used; NULL if
    /// knot_count is 0.
    pub knots: *const covbeam_knot,
    /// Voxels: number of knots; 0 is empty space.
    pub knot_count: usize,
}

/// A column as the host passes it. The order of its knots is not checked.
pub(crate) unsafe fn column<'a>(e: Element<covbeam_column>) -> Result<Column<'a>, Failure> {
    use covbeam_density_kind::*;
    match e.value.kind {
        k if k == COVBEAM_DENSITY_UNIFORM as u32 => Ok(Column::Uniform),
        k if k == COVBEAM_DENSITY_EXPONENTIAL as u32 => {
            let density = finite_not_negative(field!(e, density))?;
            let rate = e.value.rate;
            if rate.is_nan() {
                return Err(field!(e, rate).is(format_args!("is NaN")));
            }
            Ok(Column::Exponential { density, rate })
        }
        k if k == COVBEAM_DENSITY_VOXELS as u32 => {
            // SAFETY: by the caller's promise.
            Ok(Column::Knots(unsafe { table(e.value.knots, e.value.knot_count, "knots of the column") }?))
        }
        unknown => Err(field!(e, kind).is(format_args!("{unknown} is no covbeam_density_kind"))),
    }
}

impl From<Column<'_>> for covbeam_column {
    fn from(column: Column) -> Self {
        use covbeam_density_kind::*;
        let empty = Self { kind: 0, density: 0.0, rate: 0.0, knots: ptr::null(), knot_count: 0 };
        match column {
            Column::Uniform => Self { kind: COVBEAM_DENSITY_UNIFORM as u32, ..empty },
            Column::Exponential { density, rate } => {
                Self { kind: COVBEAM_DENSITY_EXPONENTIAL as u32, density, rate, ..empty }
            }
            Column::Knots([]) => Self { kind: COVBEAM_DENSITY_VOXELS as u32, ..empty },
            Column::Knots(knots) => Self {
                kind: COVBEAM_DENSITY_VOXELS as u32,
                knots: knots.as_ptr().cast(),
                knot_count: knots.len(),
                ..empty
            },
        }
    }
}

/// The column along a ray, by value: a closed form, or the table that covbeam_medium_tabulate made of it.
///
/// @param medium the medium.
/// @param origin of the ray [m].
/// @param direction of the ray, unit.
/// @param knots packed, not copied: they stay in place while the column is used; ignored, and may be NULL,
///     unless the density is voxels.
/// @param knot_count number of knots.
/// @param column the column.
/// @note Checks the table: finite, distances and columns not falling. Nothing that is given a column checks
///     that again.
/// @kinds <medium <f:fff <f:uuu <knot k >column
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_medium_column(
    medium: *const covbeam_medium,
    origin: *const f32,
    direction: *const f32,
    knots: *const covbeam_knot,
    knot_count: usize,
    column: *mut covbeam_column,
) -> covbeam_status {
    run(|| {
        let column = Slot::new(column, "column")?;
        // SAFETY: by the caller's promise.
        let medium = unsafe { read_medium(medium, "medium") }?;
        // SAFETY: by the caller's promise.
        let (origin, direction) = unsafe { ray(origin, direction) }?;
        let knots: &[Knot] = if let Density::Grid(_) = medium.density {
            // SAFETY: by the caller's promise.
            unsafe { ordered_table(knots, knot_count, "knots") }?
        } else {
            &[]
        };
        column.set(medium.density.column(origin, direction, knots).into());
        Ok(())
    })
}

unsafe fn read_column<'a>(pointer: *const covbeam_column) -> Result<Column<'a>, Failure> {
    // SAFETY: by the caller's promise.
    unsafe { column(Element::read(pointer, "column")?) }
}

/// The column up to a distance.
///
/// @param column the column along the ray.
/// @param count number of distances; with 0 nothing is done.
/// @param distances, distance_stride along the ray [m] >= 0; infinity allowed.
/// @param values, value_stride [m] >= 0, never falling with distance.
/// @note Costs nothing, an exponential, or a binary search. The order of the knots is not checked; without
///     it, value means nothing.
/// @kinds <column <f:p >f:p
/// @single covbeam_column_at
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_column_at_many(
    column: *const covbeam_column,
    count: usize,
    distances: *const f32,
    distance_stride: usize,
    values: *mut f32,
    value_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let column = unsafe { read_column(column) }?;
        inputs!(count, distances, distance_stride);
        outputs!(count, values, value_stride);
        write(values, |i| not_negative(distances.get(i)), |distance| column.at(distance))
    })
}

/// The distance at which the column reaches a value: the inverse of covbeam_column_at. See
/// covbeam_medium_distance_at.
///
/// @param column the column along the ray.
/// @param count number of values; with 0 nothing is done.
/// @param values, value_stride [m] >= 0; infinity allowed.
/// @param distances, distance_stride [m]; infinity if it never does.
/// @note Costs nothing, a logarithm, or a binary search. The order of the knots is not checked; without it,
///     distance means nothing.
/// @kinds <column <f:p >f:p
/// @single covbeam_column_distance_at
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_column_distance_at_many(
    column: *const covbeam_column,
    count: usize,
    values: *const f32,
    value_stride: usize,
    distances: *mut f32,
    distance_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let column = unsafe { read_column(column) }?;
        inputs!(count, values, value_stride);
        outputs!(count, distances, distance_stride);
        write(distances, |i| not_negative(values.get(i)), |value| column.distance_at(value))
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::hostile::{Rule::*, UNTOUCHED, refuses};
    use crate::medium::samples::{RAY, smoke};
    use crate::status::covbeam_status::*;

    fn no_column() -> covbeam_column {
        covbeam_column { kind: 77, density: UNTOUCHED, rate: UNTOUCHED, knots: ptr::null(), knot_count: 0 }
    }

    #[test]
    fn a_bad_argument_is_refused_and_nothing_is_written() {
        let smoke = smoke();
        refuses(5, &RAY, |bad, n| {
            let (origin, direction) = (bad.at(1, n.as_ptr()), bad.at(2, n[3..].as_ptr()));
            let knots = [covbeam_knot { distance: 1.0, column: 0.0 }];
            let mut out = no_column();
            let status = unsafe {
                let (medium, knots) = (bad.at(0, &smoke.medium), bad.at(3, knots.as_ptr()));
                covbeam_medium_column(medium, origin, direction, knots, 1, bad.at_mut(4, &mut out))
            };
            (status, out.kind != 77)
        });
        for (distance, column, expected) in [
            (f32::NAN, 1.0, COVBEAM_INVALID_VALUE),
            (f32::INFINITY, 1.0, COVBEAM_INVALID_VALUE),
            (2.0, f32::NAN, COVBEAM_INVALID_VALUE),
            (2.0, f32::INFINITY, COVBEAM_INVALID_VALUE),
            (0.9, 1.0, COVBEAM_INVALID_VALUE),
            (2.0, 0.4, COVBEAM_INVALID_VALUE),
            (1.0, 0.5, COVBEAM_OK),
        ] {
            let knots = [covbeam_knot { distance: 1.0, column: 0.5 }, covbeam_knot { distance, column }];
            let mut out = no_column();
            let (o, d) = ([0.0; 3], [0.0, 0.0, 1.0]);
            let status = unsafe {
                covbeam_medium_column(&smoke.medium, o.as_ptr(), d.as_ptr(), knots.as_ptr(), 2, &mut out)
            };
            assert_eq!((status, out.kind != 77), (expected, expected == COVBEAM_OK), "{distance} {column}");
        }
        for function in [covbeam_column_at_many, covbeam_column_distance_at_many] {
            refuses(2, &[(0.5, FiniteNotNegative), (1.0, NotNegative)], |bad, n| {
                let column =
                    covbeam_column { kind: 1, density: n[0], rate: 0.5, knots: ptr::null(), knot_count: 0 };
                let mut out = UNTOUCHED;
                let status = unsafe { function(bad.at(0, &column), 1, &n[1], 0, bad.at_mut(1, &mut out), 0) };
                (status, out.to_bits() != UNTOUCHED.to_bits())
            });
            let knot = covbeam_knot { distance: 1.0, column: 0.5 };
            let voxels = |knots, knot_count| covbeam_column { kind: 2, knots, knot_count, ..no_column() };
            for (column, expected) in [
                (covbeam_column { kind: 3, ..no_column() }, COVBEAM_INVALID_VALUE),
                (
                    covbeam_column { kind: 1, density: 1.0, rate: f32::NAN, ..no_column() },
                    COVBEAM_INVALID_VALUE,
                ),
                (voxels(ptr::null(), 1), COVBEAM_NULL_POINTER),
                (voxels((&raw const knot).wrapping_byte_add(2), 1), COVBEAM_MISALIGNED),
                (voxels(&raw const knot, usize::MAX), COVBEAM_INVALID_ARRAY),
                (voxels(&raw const knot, 1), COVBEAM_OK),
                (voxels(ptr::null(), 0), COVBEAM_OK),
            ] {
                let mut out = UNTOUCHED;
                assert_eq!(unsafe { function(&column, 1, &0.25, 0, &mut out, 0) }, expected, "{column:?}");
                assert_eq!(out != UNTOUCHED, expected == COVBEAM_OK);
            }
        }
    }
}
