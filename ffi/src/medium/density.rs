//! The density of a medium at points.

use super::options::{covbeam_medium, read_medium};
use crate::arrays::write;
use crate::check::vector;
use crate::memory::{Slot, inputs, outputs};
use crate::status::{covbeam_status, run};
use covbeam_core::Derivatives;

/// Derivatives of a relative density, in world axes.
/// @extra
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_derivatives {
    /// First derivatives [1/m].
    pub gradient: [f32; 3],
    /// Second derivatives xx, yy, zz, xy, xz, yz [1/m^2].
    pub hessian: [f32; 6],
}

impl From<Derivatives> for covbeam_derivatives {
    fn from(d: Derivatives) -> Self {
        Self { gradient: d.gradient.into(), hessian: d.hessian }
    }
}

/// Relative density of a medium at a point.
///
/// @param medium the medium.
/// @param count number of points; with 0 nothing is done.
/// @param positions, position_stride [m].
/// @param densities, density_stride >= 0: 1 where the medium's coefficients hold. An exponential one is held
///     beyond e^80 and e^-80.
/// @note Costs nothing, an exponential, or a trilinear look-up.
/// @kinds <medium <f:fff >f:q
/// @single covbeam_medium_density_at
/// @extra
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
        let medium = unsafe { read_medium(medium, "medium") }?;
        inputs!(count, positions: [f32; 3], position_stride);
        outputs!(count, densities, density_stride);
        write(densities, |i| vector(positions.get(i)), |position| medium.density.at(position))
    })
}

/// Derivatives of the relative density at a point. Their integrals along a way, times the extinction, are what
/// covbeam_light_field_attenuate takes.
///
/// @param medium the medium.
/// @param count number of points; with 0 nothing is done.
/// @param positions, position_stride [m].
/// @param derivatives, derivative_stride exact for an exponential density; differences between neighbouring
///     voxels, 0 outside the box.
/// @kinds <medium <f:fff >derivatives
/// @single covbeam_medium_derivatives_at
/// @extra
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
        let medium = unsafe { read_medium(medium, "medium") }?;
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
/// @kinds <medium >f:P
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_medium_step(
    medium: *const covbeam_medium,
    step: *mut f32,
) -> covbeam_status {
    run(|| {
        let step = Slot::new(step, "step")?;
        // SAFETY: by the caller's promise.
        let medium = unsafe { read_medium(medium, "medium") }?;
        step.set(medium.density.step());
        Ok(())
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::hostile::{Rule, Rule::*, UNTOUCHED, refuses};
    use crate::medium::samples::{fog, haze, smoke};

    const POSITION: [(f32, Rule); 3] = [(0.3, Finite), (0.4, Finite), (0.5, Finite)];

    #[test]
    fn a_bad_argument_is_refused_and_nothing_is_written() {
        let smoke = smoke();
        for medium in [fog(), haze(), smoke.medium] {
            refuses(3, &POSITION, |bad, n| {
                let mut out = UNTOUCHED;
                let status = unsafe {
                    covbeam_medium_density_at_many(
                        bad.at(0, &medium),
                        1,
                        bad.at(1, n.as_ptr()),
                        0,
                        bad.at_mut(2, &mut out),
                        0,
                    )
                };
                (status, out.to_bits() != UNTOUCHED.to_bits())
            });
            refuses(3, &POSITION, |bad, n| {
                let before = covbeam_derivatives { gradient: [UNTOUCHED; 3], hessian: [UNTOUCHED; 6] };
                let mut out = before;
                let status = unsafe {
                    covbeam_medium_derivatives_at_many(
                        bad.at(0, &medium),
                        1,
                        bad.at(1, n.as_ptr()),
                        0,
                        bad.at_mut(2, &mut out),
                        0,
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
}
