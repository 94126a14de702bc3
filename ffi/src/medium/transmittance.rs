//! Transmittance: the share of light that a medium leaves.

use super::flight::column_at;
use super::options::{covbeam_medium, read_medium};
use super::rays::Rays;
use crate::arrays::write;
use crate::check::not_negative;
use crate::memory::{inputs, outputs};
use crate::status::{covbeam_status, run};

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
        let medium = unsafe { read_medium(medium, "medium") }?;
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
        let medium = unsafe { read_medium(medium, "medium") }?;
        inputs!(count, columns, column_stride);
        outputs!(count, transmittances: [f32; 3], transmittance_stride);
        write(transmittances, |i| not_negative(columns.get(i)), |column| medium.transmittance(column).into())
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::hostile::{Rule::*, UNTOUCHED, refuses};
    use crate::medium::samples::{RAY, fog, haze, smoke};

    #[test]
    fn a_bad_argument_is_refused_and_nothing_is_written() {
        let smoke = smoke();
        for medium in [fog(), haze(), smoke.medium] {
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
}
