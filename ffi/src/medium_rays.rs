//! What a medium does to light along rays: columns, free flight, transmittance.

use crate::arrays::write;
use crate::check::{not_negative, unit, vector};
use crate::medium::{self, covbeam_medium};
use crate::memory::{Inputs, Slot, inputs, outputs};
use crate::status::{Failure, covbeam_status, run};
use covbeam_core::{Column, Density, Knot};
use glam::Vec3;

/// What the inverse of a column may be off by, relatively: as the optical depth of a table at depth 1.
const FLIGHT_ERROR: f32 = 5e-4;

/// The origins and the directions of an array of rays.
struct Rays<'a> {
    origins: Inputs<'a, [f32; 3]>,
    directions: Inputs<'a, [f32; 3]>,
}

impl Rays<'_> {
    /// # Safety
    /// Both arrays are readable while this lives.
    unsafe fn new(
        count: usize,
        origins: *const f32,
        origin_stride: usize,
        directions: *const f32,
        direction_stride: usize,
    ) -> Result<Self, Failure> {
        inputs!(count, origins: [f32; 3], origin_stride);
        inputs!(count, directions: [f32; 3], direction_stride);
        Ok(Self { origins, directions })
    }

    fn get(&self, index: usize) -> Result<(Vec3, Vec3), Failure> {
        Ok((vector(self.origins.get(index))?, unit(self.directions.get(index))?))
    }
}

/// The column of a stretch of ray. One of voxels is the last knot of a table that ends there; knots are exact
/// however coarse the table is.
fn column_at(density: &Density, origin: Vec3, direction: Vec3, distance: f32) -> f32 {
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
        let medium = unsafe { medium::read(medium, "medium") }?;
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
        let medium = unsafe { medium::read(medium, "medium") }?;
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

/// The share of light that a stretch of medium leaves, per channel.
///
/// @param medium the medium.
/// @param count number of rays; with 0 nothing is done.
/// @param origins, origin_stride of the ray [m].
/// @param directions, direction_stride of the ray, unit.
/// @param distances, distance_stride along the ray [m] >= 0; infinity allowed.
/// @param transmittances, transmittance_stride three numbers in [0, 1]: exp(-extinction x column).
/// @note The column of covbeam_medium_column_at, and one exponential if the channels are equal, else three.
/// @kinds <medium <f:fff <f:uuu <f:p >f:ttt
/// @single covbeam_medium_transmittance
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_medium_transmittance_many(
    medium: *const covbeam_medium,
    count: usize,
    origins: *const f32,
    origin_stride: usize,
    directions: *const f32,
    direction_stride: usize,
    distances: *const f32,
    distance_stride: usize,
    transmittances: *mut f32,
    transmittance_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let medium = unsafe { medium::read(medium, "medium") }?;
        // SAFETY: by the caller's promise.
        let rays = unsafe { Rays::new(count, origins, origin_stride, directions, direction_stride) }?;
        inputs!(count, distances, distance_stride);
        outputs!(count, transmittances: [f32; 3], transmittance_stride);
        write(
            transmittances,
            |i| Ok((rays.get(i)?, not_negative(distances.get(i))?)),
            |((origin, direction), distance)| {
                let column = column_at(&medium.density, origin, direction, distance);
                medium.transmittance(column).into()
            },
        )
    })
}

/// The share of light that a column leaves, per channel: for a host that has the column already.
///
/// @param medium the medium; its density does not matter.
/// @param count number of columns; with 0 nothing is done.
/// @param columns, column_stride [m] >= 0; infinity allowed.
/// @param transmittances, transmittance_stride three numbers in [0, 1]: exp(-extinction x column).
/// @kinds <medium <f:p >f:ttt
/// @single covbeam_medium_column_transmittance
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_medium_column_transmittance_many(
    medium: *const covbeam_medium,
    count: usize,
    columns: *const f32,
    column_stride: usize,
    transmittances: *mut f32,
    transmittance_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let medium = unsafe { medium::read(medium, "medium") }?;
        inputs!(count, columns, column_stride);
        outputs!(count, transmittances: [f32; 3], transmittance_stride);
        write(transmittances, |i| not_negative(columns.get(i)), |column| medium.transmittance(column).into())
    })
}

/// The column after which light of every channel is down to e^-17 = 4e-8. In a homogeneous medium it is a
/// distance: no beam need be longer. For other media see covbeam_medium_reach.
///
/// @param medium the medium.
/// @param column [m]; infinite if a channel has no extinction.
/// @kinds <medium >f:p
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_medium_opaque_column(
    medium: *const covbeam_medium,
    column: *mut f32,
) -> covbeam_status {
    run(|| {
        let column = Slot::new(column, "column")?;
        // SAFETY: by the caller's promise.
        let medium = unsafe { medium::read(medium, "medium") }?;
        column.set(medium.opaque_column());
        Ok(())
    })
}

/// Distance beyond which light that starts on a ray leaves nothing to see: where a host may end an eye ray or a
/// beam that no surface ends.
///
/// @param medium the medium.
/// @param count number of rays; with 0 nothing is done.
/// @param origins, origin_stride of the ray [m].
/// @param directions, direction_stride of the ray, unit.
/// @param distances, distance_stride [m]: where the medium becomes opaque, hardly goes on, or its voxels
///     end; infinite if there is no such place.
/// @note Voxels: about 20 ns a voxel passed.
/// @kinds <medium <f:fff <f:uuu >f:p
/// @single covbeam_medium_reach
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_medium_reach_many(
    medium: *const covbeam_medium,
    count: usize,
    origins: *const f32,
    origin_stride: usize,
    directions: *const f32,
    direction_stride: usize,
    distances: *mut f32,
    distance_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let medium = unsafe { medium::read(medium, "medium") }?;
        // SAFETY: by the caller's promise.
        let rays = unsafe { Rays::new(count, origins, origin_stride, directions, direction_stride) }?;
        outputs!(count, distances, distance_stride);
        let opaque = medium.opaque_column();
        write(
            distances,
            |i| rays.get(i),
            |(origin, direction)| {
                // Of the table only the end is looked at.
                let mut last = None;
                medium.tabulate(origin, direction, f32::INFINITY, &mut |knot| {
                    last = Some(knot);
                });
                medium.density.opaque_distance(origin, direction, opaque, last.as_slice())
            },
        )
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::hostile::{Rule::*, UNTOUCHED, refuses};
    use crate::medium::samples::{fog, haze, smoke};
    use crate::status::covbeam_status::*;

    use crate::hostile::Rule;

    /// Origin, then direction.
    const RAY: [(f32, Rule); 6] =
        [(0.2, Finite), (0.3, Finite), (-1.0, Finite), (0.0, Across), (0.0, Across), (1.0, Along)];

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
            refuses(4, &[&RAY[..], &[(1.5, NotNegative)]].concat(), |bad, n| {
                let (origin, direction) = (bad.at(1, n.as_ptr()), bad.at(2, n[3..].as_ptr()));
                let mut out = [UNTOUCHED; 3];
                let to = bad.at_mut(3, out.as_mut_ptr());
                let status = unsafe {
                    covbeam_medium_transmittance_many(
                        bad.at(0, &medium),
                        1,
                        origin,
                        0,
                        direction,
                        0,
                        &n[6],
                        0,
                        to,
                        0,
                    )
                };
                (status, out.map(f32::to_bits) != [UNTOUCHED.to_bits(); 3])
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
            refuses(4, &RAY, |bad, n| {
                let (origin, direction) = (bad.at(1, n.as_ptr()), bad.at(2, n[3..].as_ptr()));
                let mut out = UNTOUCHED;
                let status = unsafe {
                    covbeam_medium_reach_many(
                        bad.at(0, &medium),
                        1,
                        origin,
                        0,
                        direction,
                        0,
                        bad.at_mut(3, &mut out),
                        0,
                    )
                };
                (status, changed(out))
            });
            refuses(2, &[], |bad, _| {
                let mut out = UNTOUCHED;
                let status =
                    unsafe { covbeam_medium_opaque_column(bad.at(0, &medium), bad.at_mut(1, &mut out)) };
                (status, changed(out))
            });
            refuses(2, &[(0.5, NotNegative)], |bad, n| {
                let mut out = [UNTOUCHED; 3];
                let to = bad.at_mut(1, out.as_mut_ptr());
                let status = unsafe {
                    covbeam_medium_column_transmittance_many(bad.at(0, &medium), 1, &n[0], 0, to, 0)
                };
                (status, out != [UNTOUCHED; 3])
            });
        }
    }

    #[test]
    fn the_two_knots_kept_give_the_distance_that_the_whole_table_gives() {
        let smoke = smoke();
        let view = unsafe { medium::read(&smoke.medium, "medium") }.unwrap();
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
