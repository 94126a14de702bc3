//! Phase functions.

use crate::arrays::write;
use crate::check::{cosine, finite, random, random_pair, unit};
use crate::memory::{Element, Slot, field, inputs, outputs};
use crate::status::{Failure, covbeam_status, run};
use covbeam_core::{PhaseFunction, PhaseKind};

/// A phase function: how scattered light is spread over directions.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_phase {
    /// A value of covbeam_phase_kind.
    pub kind: u32,
    /// Mean cosine of Henyey-Greenstein, in (-1, 1), forward positive; ignored by the others.
    pub asymmetry: f32,
}

/// Which phase function.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum covbeam_phase_kind {
    /// The same in all directions.
    COVBEAM_PHASE_ISOTROPIC = 0,
    /// Henyey-Greenstein.
    COVBEAM_PHASE_HENYEY_GREENSTEIN = 1,
    /// Rayleigh.
    COVBEAM_PHASE_RAYLEIGH = 2,
}

pub(super) fn phase(e: Element<covbeam_phase>) -> Result<PhaseFunction, Failure> {
    use covbeam_phase_kind::*;
    let kind = match e.value.kind {
        k if k == COVBEAM_PHASE_ISOTROPIC as u32 => PhaseKind::Isotropic,
        k if k == COVBEAM_PHASE_HENYEY_GREENSTEIN as u32 => PhaseKind::HenyeyGreenstein,
        k if k == COVBEAM_PHASE_RAYLEIGH as u32 => PhaseKind::Rayleigh,
        unknown => return Err(field!(e, kind).is(format_args!("{unknown} is no covbeam_phase_kind"))),
    };
    let asymmetry = if kind == PhaseKind::HenyeyGreenstein {
        let g = finite(field!(e, asymmetry))?;
        if g.abs() >= 1.0 {
            return Err(field!(e, asymmetry).is(format_args!("{g} is not in (-1, 1)")));
        }
        g
    } else {
        0.0
    };
    Ok(PhaseFunction { kind, asymmetry })
}

unsafe fn read_phase(pointer: *const covbeam_phase) -> Result<PhaseFunction, Failure> {
    // SAFETY: by the caller's promise.
    phase(unsafe { Element::read(pointer, "phase") }?)
}

/// The value of a phase function [1/sr]: 1 in all over the sphere.
///
/// @param phase the phase function.
/// @param count number of values; with 0 nothing is done.
/// @param cosines, cosine_stride dot(propagation before, propagation after), forward 1; in [-1, 1], rounding
///     past the ends is harmless.
/// @param values, value_stride [1/sr] >= 0.
/// @kinds <phase <f:c >f:q
/// @single covbeam_phase_evaluate
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_phase_evaluate_many(
    phase: *const covbeam_phase,
    count: usize,
    cosines: *const f32,
    cosine_stride: usize,
    values: *mut f32,
    value_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let phase = unsafe { read_phase(phase) }?;
        inputs!(count, cosines, cosine_stride);
        outputs!(count, values, value_stride);
        write(values, |i| cosine(cosines.get(i)), |cos_theta| phase.evaluate(cos_theta))
    })
}

/// Samples a direction after scattering in proportion to the phase function: the weight (value / density) is 1.
///
/// @param phase the phase function.
/// @param count number of directions; with 0 nothing is done.
/// @param directions, direction_stride of propagation before the event, unit.
/// @param xis, xi_stride two independent uniform numbers in [0, 1).
/// @param scattered, scattered_stride direction of propagation after the event, unit; may be the same array
///     as directions.
/// @note The angle of a narrow lobe is exact: it does not pass through its cosine.
/// @kinds <phase <f:uuu <f:rr >f:uuu
/// @single covbeam_phase_sample
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_phase_sample_many(
    phase: *const covbeam_phase,
    count: usize,
    directions: *const f32,
    direction_stride: usize,
    xis: *const f32,
    xi_stride: usize,
    scattered: *mut f32,
    scattered_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let phase = unsafe { read_phase(phase) }?;
        inputs!(count, directions: [f32; 3], direction_stride);
        inputs!(count, xis: [f32; 2], xi_stride);
        outputs!(count, scattered: [f32; 3], scattered_stride);
        write(
            scattered,
            |i| Ok((unit(directions.get(i))?, random_pair(xis.get(i))?)),
            |(direction, xi)| phase.sample(direction, xi).into(),
        )
    })
}

/// Samples the cosine of the scattering angle in proportion to the phase function.
///
/// @param phase the phase function.
/// @param count number of cosines; with 0 nothing is done.
/// @param xis, xi_stride uniform in [0, 1); 0 gives -1, and the cosine grows with it.
/// @param cosines, cosine_stride in [-1, 1].
/// @kinds <phase <f:r >f:c
/// @single covbeam_phase_sample_cosine
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_phase_sample_cosine_many(
    phase: *const covbeam_phase,
    count: usize,
    xis: *const f32,
    xi_stride: usize,
    cosines: *mut f32,
    cosine_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let phase = unsafe { read_phase(phase) }?;
        inputs!(count, xis, xi_stride);
        outputs!(count, cosines, cosine_stride);
        write(cosines, |i| random(xis.get(i)), |xi| phase.sample_cosine(xi))
    })
}

/// What covbeam_light_field_scatter takes: variance, per axis, of the angular spectrum of the lobe.
///
/// @param phase the phase function.
/// @param variance [cycles^2/rad^2]: 3|g| / (4 pi^2 (1 - |g|)^2) for Henyey-Greenstein, 1/(4 pi^2) for
///     Rayleigh, 0 for isotropic.
/// @note Derived from the lobe's curvature at its peak.
/// @kinds <phase >f:q
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_phase_angular_variance(
    phase: *const covbeam_phase,
    variance: *mut f32,
) -> covbeam_status {
    run(|| {
        let variance = Slot::new(variance, "variance")?;
        // SAFETY: by the caller's promise.
        let phase = unsafe { read_phase(phase) }?;
        variance.set(phase.angular_variance());
        Ok(())
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::hostile::{Rule::*, UNTOUCHED, message, refuses};
    use crate::status::covbeam_status::*;

    #[test]
    fn a_bad_argument_is_refused_and_nothing_is_written() {
        let fog = |asymmetry| covbeam_phase { kind: 1, asymmetry };
        refuses(2, &[(0.5, Asymmetry), (0.25, Cosine)], |bad, n| {
            let (phase, mut out) = (fog(n[0]), UNTOUCHED);
            let status = unsafe {
                covbeam_phase_evaluate_many(bad.at(0, &phase), 1, &n[1], 0, bad.at_mut(1, &mut out), 0)
            };
            (status, out != UNTOUCHED)
        });
        let numbers =
            [(0.5, Asymmetry), (0.0, Across), (0.0, Across), (1.0, Along), (0.5, Random), (0.5, Random)];
        refuses(4, &numbers, |bad, n| {
            let (phase, mut out) = (fog(n[0]), [UNTOUCHED; 3]);
            let status = unsafe {
                covbeam_phase_sample_many(
                    bad.at(0, &phase),
                    1,
                    bad.at(1, n[1..4].as_ptr()),
                    0,
                    bad.at(2, n[4..6].as_ptr()),
                    0,
                    bad.at_mut(3, out.as_mut_ptr()),
                    0,
                )
            };
            (status, out != [UNTOUCHED; 3])
        });
        refuses(2, &[(0.5, Asymmetry), (0.25, Random)], |bad, n| {
            let (phase, mut out) = (fog(n[0]), UNTOUCHED);
            let status = unsafe {
                covbeam_phase_sample_cosine_many(bad.at(0, &phase), 1, &n[1], 0, bad.at_mut(1, &mut out), 0)
            };
            (status, out != UNTOUCHED)
        });
        refuses(2, &[(0.5, Asymmetry)], |bad, n| {
            let (phase, mut out) = (fog(n[0]), UNTOUCHED);
            let status =
                unsafe { covbeam_phase_angular_variance(bad.at(0, &phase), bad.at_mut(1, &mut out)) };
            (status, out != UNTOUCHED)
        });
    }

    #[test]
    fn only_henyey_greenstein_looks_at_the_asymmetry() {
        for (kind, expected) in
            [(0, COVBEAM_OK), (1, COVBEAM_INVALID_VALUE), (2, COVBEAM_OK), (3, COVBEAM_INVALID_VALUE)]
        {
            let phase = covbeam_phase { kind, asymmetry: f32::NAN };
            let mut out = UNTOUCHED;
            assert_eq!(unsafe { covbeam_phase_evaluate_many(&phase, 1, &0.5, 0, &mut out, 0) }, expected);
            assert_eq!(out != UNTOUCHED, expected == COVBEAM_OK);
        }
    }

    #[test]
    fn a_bad_element_is_named_and_keeps_the_others_from_being_written() {
        let phase = covbeam_phase { kind: 0, asymmetry: 0.0 };
        let mut out = [UNTOUCHED; 3];
        let status = unsafe {
            covbeam_phase_evaluate_many(&phase, 3, [0.5, 0.5, 2.0].as_ptr(), 4, out.as_mut_ptr(), 4)
        };
        assert_eq!((status, out), (COVBEAM_INVALID_VALUE, [UNTOUCHED; 3]));
        assert_eq!(message(), "cosines[2]: 2 is not in [-1, 1]: the cosine between unit vectors");
    }
}
