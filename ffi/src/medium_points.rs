//! The density of a medium at points.

use crate::arrays::write;
use crate::check::vector;
use crate::medium::{self, covbeam_medium};
use crate::memory::{Slot, inputs, outputs};
use crate::status::{covbeam_status, run};
use crate::types::covbeam_derivatives;

/// Relative density of a medium at a point.
///
/// @param medium the medium.
/// @param position [m].
/// @param density >= 0: 1 where the medium's coefficients hold. An exponential one is held beyond e^80 and
///     e^-80.
/// @note Costs nothing, an exponential, or a trilinear look-up.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_medium_density_at(
    medium: *const covbeam_medium,
    position: *const f32,
    density: *mut f32,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_medium_density_at_many(medium, 1, position, 0, density, 0) }
}

/// covbeam_medium_density_at for `count` points.
///
/// @param medium as medium there.
/// @param count number of points; with 0 nothing is done.
/// @param positions, position_stride as position there.
/// @param densities, density_stride as density there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_medium_density_at_many(
    medium: *const covbeam_medium,
    count: usize,
    positions: *const f32,
    position_stride: usize,
    densities: *mut f32,
    density_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let medium = unsafe { medium::read(medium, "medium") }?;
        inputs!(count, positions: [f32; 3], position_stride);
        outputs!(count, densities, density_stride);
        write(densities, |i| vector(positions.get(i)), |position| medium.density.at(position))
    })
}

/// Derivatives of the relative density at a point. Their integrals along a way, times the extinction, are what
/// covbeam_light_field_attenuate takes.
///
/// @param medium the medium.
/// @param position [m].
/// @param derivatives exact for an exponential density; differences between neighbouring voxels, 0 outside the
///     box.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_medium_derivatives_at(
    medium: *const covbeam_medium,
    position: *const f32,
    derivatives: *mut covbeam_derivatives,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_medium_derivatives_at_many(medium, 1, position, 0, derivatives, 0) }
}

/// covbeam_medium_derivatives_at for `count` points.
///
/// @param medium as medium there.
/// @param count number of points; with 0 nothing is done.
/// @param positions, position_stride as position there.
/// @param derivatives, derivative_stride as derivatives there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_medium_derivatives_at_many(
    medium: *const covbeam_medium,
    count: usize,
    positions: *const f32,
    position_stride: usize,
    derivatives: *mut covbeam_derivatives,
    derivative_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let medium = unsafe { medium::read(medium, "medium") }?;
        inputs!(count, positions: [f32; 3], position_stride);
        outputs!(count, derivatives, derivative_stride);
        write(
            derivatives,
            |i| vector(positions.get(i)),
            |position| medium.density.derivatives(position).into(),
        )
    })
}

/// Largest step [m] over which the second derivatives may be taken as constant, for a host that sums them
/// itself.
///
/// @param medium the medium.
/// @param step [m] > 0: infinity where the medium is homogeneous, half the scale height, or a voxel's smallest
///     side.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_medium_step(
    medium: *const covbeam_medium,
    step: *mut f32,
) -> covbeam_status {
    run(|| {
        let step = Slot::new(step, "step")?;
        // SAFETY: by the caller's promise.
        let medium = unsafe { medium::read(medium, "medium") }?;
        step.set(medium.density.step());
        Ok(())
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::hostile::{Rule::*, UNTOUCHED, padded, refuses, values};
    use crate::medium::samples::{fog, haze, smoke};
    use crate::status::covbeam_status::*;

    const POSITION: [(f32, crate::hostile::Rule); 3] = [(0.3, Finite), (0.4, Finite), (0.5, Finite)];

    #[test]
    fn a_bad_argument_is_refused_and_nothing_is_written() {
        let smoke = smoke();
        for medium in [fog(), haze(), smoke.medium] {
            refuses(3, &POSITION, |bad, n| {
                let mut out = UNTOUCHED;
                let status = unsafe {
                    covbeam_medium_density_at(
                        bad.at(0, &medium),
                        bad.at(1, n.as_ptr()),
                        bad.at_mut(2, &mut out),
                    )
                };
                (status, out.to_bits() != UNTOUCHED.to_bits())
            });
            refuses(3, &POSITION, |bad, n| {
                let before = covbeam_derivatives { gradient: [UNTOUCHED; 3], hessian: [UNTOUCHED; 6] };
                let mut out = before;
                let status = unsafe {
                    covbeam_medium_derivatives_at(
                        bad.at(0, &medium),
                        bad.at(1, n.as_ptr()),
                        bad.at_mut(2, &mut out),
                    )
                };
                (status, out != before)
            });
            refuses(2, &[], |bad, _| {
                let mut out = UNTOUCHED;
                let status = unsafe { covbeam_medium_step(bad.at(0, &medium), bad.at_mut(1, &mut out)) };
                (status, out != UNTOUCHED)
            });
        }
    }

    #[test]
    fn many_are_the_same_bits_as_one_each() {
        let smoke = smoke();
        let positions = padded(&[[0.3, 0.4, 0.5], [0.9, 0.1, 0.2], [2.0, 0.0, 0.0]]);
        let stride = size_of_val(&positions[0]);
        for medium in [fog(), haze(), smoke.medium] {
            let mut densities = padded(&[UNTOUCHED; 3]);
            let zero = covbeam_derivatives { gradient: [UNTOUCHED; 3], hessian: [UNTOUCHED; 6] };
            let mut derivatives = padded(&[zero; 3]);
            let derivative_stride = size_of_val(&derivatives[0]);
            let status = unsafe {
                covbeam_medium_density_at_many(
                    &medium,
                    3,
                    positions.as_ptr().cast(),
                    stride,
                    &mut densities[0].value,
                    16,
                )
            };
            assert_eq!(status, COVBEAM_OK);
            let status = unsafe {
                let out = &raw mut derivatives[0].value;
                covbeam_medium_derivatives_at_many(
                    &medium,
                    3,
                    positions.as_ptr().cast(),
                    stride,
                    out,
                    derivative_stride,
                )
            };
            assert_eq!(status, COVBEAM_OK);
            for ((position, density), found) in
                values(&positions).iter().zip(values(&densities)).zip(values(&derivatives))
            {
                let (mut one, mut one_derivatives) = (UNTOUCHED, zero);
                let status = unsafe { covbeam_medium_density_at(&medium, position.as_ptr(), &mut one) };
                assert_eq!((status, one), (COVBEAM_OK, density));
                let status = unsafe {
                    covbeam_medium_derivatives_at(&medium, position.as_ptr(), &mut one_derivatives)
                };
                assert_eq!((status, one_derivatives), (COVBEAM_OK, found));
            }
        }
    }
}
