//! Columns along rays, and free flight, which ends where a column is reached.

use super::options::{covbeam_medium, read_medium};
use super::rays::Rays;
use crate::arrays::write;
use crate::check::not_negative;
use crate::memory::{inputs, outputs};
use crate::status::{covbeam_status, run};
use covbeam_core::{Column, Density, Knot};
use glam::Vec3;

/// What the inverse of a column may be off by, relatively: as the optical depth of a table at depth 1.
const FLIGHT_ERROR: f32 = 5e-4;

/// The column of a stretch of ray. One of voxels is the last knot of a table that ends there; knots are exact
/// however coarse the table is.
pub(super) fn column_at(density: &Density, origin: Vec3, direction: Vec3, distance: f32) -> f32 {
    if let Density::Grid(_) = density {
        let mut last = 0.0;
        density
            .knots(origin, direction, distance, f32::INFINITY, f32::INFINITY, &mut |knot| last = knot.column);
        last
    } else {
        density.column(origin, direction, &[]).at(distance)
    }
}

/// The distance at which a column is reached; infinity beyond `length`. Of a table of voxels only the two knots
/// around it are kept.
fn distance_at(density: &Density, origin: Vec3, direction: Vec3, length: f32, column: f32) -> f32 {
    let mut around = [Knot::default(); 2];
    let (mut before, mut reached) = (0, false);
    density.knots(origin, direction, length, FLIGHT_ERROR * column, column, &mut |knot| {
        if !reached {
            reached = knot.column >= column;
            around[before] = knot;
            if !reached {
                (around[0], before) = (knot, 1);
            }
        }
    });
    let found = match density {
        Density::Grid(_) if !reached => f32::INFINITY,
        Density::Grid(_) => Column::Knots(&around[..=before]).distance_at(column),
        _ => density.column(origin, direction, &[]).distance_at(column),
    };
    if found <= length { found } else { f32::INFINITY }
}

/// Column along a ray: the integral of the relative density. Extinction x column is the optical depth.
///
/// @param medium the medium.
/// @param count number of rays; with 0 nothing is done.
/// @param origins, origin_stride of the ray [m].
/// @param directions, direction_stride of the ray, unit.
/// @param distances, distance_stride along the ray [m] >= 0; infinity allowed.
/// @param columns, column_stride [m] >= 0; infinite only for an infinite distance in a homogeneous medium.
/// @note Voxels: exact, about 20 ns a voxel passed. For many distances on one ray see covbeam_medium_column.
/// @kinds <medium <f:fff <f:uuu <f:p >f:p
/// @single covbeam_medium_column_at
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_medium_column_at_many(
    medium: *const covbeam_medium,
    count: usize,
    origins: *const f32,
    origin_stride: usize,
    directions: *const f32,
    direction_stride: usize,
    distances: *const f32,
    distance_stride: usize,
    columns: *mut f32,
    column_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let medium = unsafe { read_medium(medium, "medium") }?;
        // SAFETY: by the caller's promise.
        let rays = unsafe { Rays::new(count, origins, origin_stride, directions, direction_stride) }?;
        inputs!(count, distances, distance_stride);
        outputs!(count, columns, column_stride);
        write(
            columns,
            |i| Ok((rays.get(i)?, not_negative(distances.get(i))?)),
            |((origin, direction), distance)| column_at(&medium.density, origin, direction, distance),
        )
    })
}

/// Distance along a ray at which a column is reached: the inverse of covbeam_medium_column_at.
///
/// Free flight is sampled with it: column = -log(1 - u) / extinction for a uniform u in [0, 1) and the
/// extinction of one channel; light that gets infinity reaches the end of the ray.
///
/// @param medium the medium.
/// @param count number of rays; with 0 nothing is done.
/// @param origins, origin_stride of the ray [m].
/// @param directions, direction_stride of the ray, unit.
/// @param lengths, length_stride of the ray [m] >= 0; infinity allowed.
/// @param columns, column_stride [m] >= 0; infinity allowed.
/// @param distances, distance_stride [m]; infinity if the ray ends before.
/// @note Voxels: the column there is within 5e-4 of the one asked for, relatively; about 20 ns a voxel
///     passed.
/// @kinds <medium <f:fff <f:uuu <f:p <f:p >f:p
/// @single covbeam_medium_distance_at
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_medium_distance_at_many(
    medium: *const covbeam_medium,
    count: usize,
    origins: *const f32,
    origin_stride: usize,
    directions: *const f32,
    direction_stride: usize,
    lengths: *const f32,
    length_stride: usize,
    columns: *const f32,
    column_stride: usize,
    distances: *mut f32,
    distance_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let medium = unsafe { read_medium(medium, "medium") }?;
        // SAFETY: by the caller's promise.
        let rays = unsafe { Rays::new(count, origins, origin_stride, directions, direction_stride) }?;
        inputs!(count, lengths, length_stride);
        inputs!(count, columns, column_stride);
        outputs!(count, distances, distance_stride);
        write(
            distances,
            |i| Ok((rays.get(i)?, not_negative(lengths.get(i))?, not_negative(columns.get(i))?)),
            |((origin, direction), length, column)| {
                distance_at(&medium.density, origin, direction, length, column)
            },
        )
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::hostile::{Rule::*, UNTOUCHED, refuses};
    use crate::medium::samples::{RAY, fog, haze, smoke};
    use crate::status::covbeam_status::*;

    #[test]
    fn a_bad_argument_is_refused_and_nothing_is_written() {
        let smoke = smoke();
        for medium in [fog(), haze(), smoke.medium] {
            let changed = |out: f32| out.to_bits() != UNTOUCHED.to_bits();
            refuses(4, &[&RAY[..], &[(1.5, NotNegative)]].concat(), |bad, n| {
                let (origin, direction) = (bad.at(1, n.as_ptr()), bad.at(2, n[3..].as_ptr()));
                let mut out = UNTOUCHED;
                let status = unsafe {
                    covbeam_medium_column_at_many(
                        bad.at(0, &medium),
                        1,
                        origin,
                        0,
                        direction,
                        0,
                        &n[6],
                        0,
                        bad.at_mut(3, &mut out),
                        0,
                    )
                };
                (status, changed(out))
            });
            refuses(4, &[&RAY[..], &[(9.0, NotNegative), (0.5, NotNegative)]].concat(), |bad, n| {
                let (origin, direction) = (bad.at(1, n.as_ptr()), bad.at(2, n[3..].as_ptr()));
                let mut out = UNTOUCHED;
                let to = bad.at_mut(3, &mut out);
                let status = unsafe {
                    covbeam_medium_distance_at_many(
                        bad.at(0, &medium),
                        1,
                        origin,
                        0,
                        direction,
                        0,
                        &n[6],
                        0,
                        &n[7],
                        0,
                        to,
                        0,
                    )
                };
                (status, changed(out))
            });
        }
    }

    #[test]
    fn the_two_knots_kept_give_the_distance_that_the_whole_table_gives() {
        let smoke = smoke();
        let view = unsafe { read_medium(&smoke.medium, "medium") }.unwrap();
        let (origin, direction) = (Vec3::new(0.2, 0.1, -0.3), Vec3::new(0.36, 0.48, 0.8));
        for step in 0..60 {
            let column = 0.03 * step as f32;
            let mut knots = Vec::new();
            let most = f32::INFINITY;
            view.density
                .knots(origin, direction, 9.0, FLIGHT_ERROR * column, most, &mut |knot| knots.push(knot));
            let whole = Column::Knots(&knots).distance_at(column);
            let found = distance_at(&view.density, origin, direction, 9.0, column);
            // The table that stops early may end in another chord. Both are within 5e-4 of the column, so their distances are within
            // twice that over the least density on the way, 0.3.
            let near = (found - whole).abs() <= 2.0 * FLIGHT_ERROR * column / 0.3 + 1e-6;
            assert!(found == whole || near, "{column}: {found} for {whole}");
        }
    }

    #[test]
    fn a_ray_that_ends_before_its_event_gets_infinity() {
        let smoke = smoke();
        let (origin, direction) = ([0.5, 0.5, -1.0], [0.0, 0.0, 1.0]);
        for medium in [fog(), haze(), smoke.medium] {
            let distance = |length| {
                let mut out = UNTOUCHED;
                let status = unsafe {
                    covbeam_medium_distance_at_many(
                        &medium,
                        1,
                        origin.as_ptr(),
                        0,
                        direction.as_ptr(),
                        0,
                        &length,
                        0,
                        &0.5,
                        0,
                        &mut out,
                        0,
                    )
                };
                assert_eq!(status, COVBEAM_OK);
                out
            };
            let there = distance(f32::INFINITY);
            assert!(there.is_finite());
            assert_eq!(distance(0.99 * there), f32::INFINITY);
        }
    }
}
