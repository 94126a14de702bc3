//! The reach of light in a medium: where nothing is left to see.

use super::options::{covbeam_medium, read_medium};
use super::rays::Rays;
use crate::arrays::write;
use crate::memory::{Slot, outputs};
use crate::status::{covbeam_status, run};

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
        let medium = unsafe { read_medium(medium, "medium") }?;
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
        let medium = unsafe { read_medium(medium, "medium") }?;
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
    use crate::hostile::{UNTOUCHED, refuses};
    use crate::medium::samples::{RAY, fog, haze, smoke};

    #[test]
    fn a_bad_argument_is_refused_and_nothing_is_written() {
        let smoke = smoke();
        for medium in [fog(), haze(), smoke.medium] {
            let changed = |out: f32| out.to_bits() != UNTOUCHED.to_bits();
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
        }
    }
}
