//! Spectra of the fluence around a point.

use crate::arrays::write;
use crate::check::{finite_not_negative, unit};
use crate::memory::{Inputs, inputs, outputs};
use crate::status::{covbeam_status, run};
use crate::types::{covbeam_spectrum, spectrum};

/// A spectrum's variance along an axis: what covbeam_kernel_radius_from_error takes.
///
/// @param spectrum of the fluence.
/// @param axis unit.
/// @param variance [cycles^2/m^2] >= 0, to a few roundings of xx + yy + zz.
/// @note Thesis 5.3.4.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_spectrum_variance_along(
    spectrum: *const covbeam_spectrum,
    axis: *const f32,
    variance: *mut f32,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_spectra_variance_along(1, spectrum, 0, axis, 0, variance, 0) }
}

/// covbeam_spectrum_variance_along for `count` spectra.
///
/// @param count number of spectra; with 0 nothing is done.
/// @param spectra, spectrum_stride as spectrum there; a stride of 0 asks one spectrum for all axes.
/// @param axes, axis_stride as axis there; a stride of 0 gives all spectra the same.
/// @param variances, variance_stride as variance there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_spectra_variance_along(
    count: usize,
    spectra: *const covbeam_spectrum,
    spectrum_stride: usize,
    axes: *const f32,
    axis_stride: usize,
    variances: *mut f32,
    variance_stride: usize,
) -> covbeam_status {
    run(|| {
        inputs!(count, spectra, spectrum_stride);
        inputs!(count, axes: [f32; 3], axis_stride);
        outputs!(count, variances, variance_stride);
        write(
            variances,
            |i| Ok((spectrum(spectra.get(i))?, unit(axes.get(i))?)),
            |(spectrum, axis)| spectrum.variance_along(axis),
        )
    })
}

/// Adds a variance along an axis, such as that of covbeam_light_field_variance_along_ray.
///
/// @param spectrum of the fluence, changed in place.
/// @param axis unit.
/// @param variance [cycles^2/m^2], finite and >= 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_spectrum_add_along(
    spectrum: *mut covbeam_spectrum,
    axis: *const f32,
    variance: f32,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_spectra_add_along(1, spectrum, 0, axis, 0, &variance, 0) }
}

/// covbeam_spectrum_add_along for `count` spectra.
///
/// @param count number of spectra; with 0 nothing is done.
/// @param spectra, spectrum_stride as spectrum there.
/// @param axes, axis_stride as axis there; a stride of 0 gives all spectra the same.
/// @param variances, variance_stride as variance there; a stride of 0 gives all spectra the same.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_spectra_add_along(
    count: usize,
    spectra: *mut covbeam_spectrum,
    spectrum_stride: usize,
    axes: *const f32,
    axis_stride: usize,
    variances: *const f32,
    variance_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise; read here, written below.
        let before = unsafe { Inputs::new(spectra.cast_const(), spectrum_stride, count, "spectra") }?;
        outputs!(count, spectra, spectrum_stride);
        inputs!(count, axes: [f32; 3], axis_stride);
        inputs!(count, variances, variance_stride);
        write(
            spectra,
            |i| Ok((spectrum(before.get(i))?, unit(axes.get(i))?, finite_not_negative(variances.get(i))?)),
            |(mut spectrum, axis, variance)| {
                spectrum.add_along(axis, variance);
                spectrum.into()
            },
        )
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::hostile::{Rule::*, UNTOUCHED, padded, refuses, values};
    use crate::status::covbeam_status::*;

    fn spectrum_of(n: &[f32]) -> covbeam_spectrum {
        covbeam_spectrum { xx: n[0], yy: n[1], zz: n[2], xy: n[3], xz: n[4], yz: n[5] }
    }

    /// A spectrum, then the z axis.
    const NUMBERS: [(f32, crate::hostile::Rule); 9] = [
        (4.0, Finite),
        (5.0, Finite),
        (6.0, Finite),
        (0.1, Finite),
        (0.2, Finite),
        (0.3, Finite),
        (0.0, Across),
        (0.0, Across),
        (1.0, Along),
    ];

    #[test]
    fn a_bad_argument_is_refused_and_nothing_is_written() {
        refuses(3, &NUMBERS, |bad, n| {
            let (spectrum, mut out) = (spectrum_of(n), UNTOUCHED);
            let status = unsafe {
                covbeam_spectrum_variance_along(
                    bad.at(0, &spectrum),
                    bad.at(1, n[6..].as_ptr()),
                    bad.at_mut(2, &mut out),
                )
            };
            (status, out != UNTOUCHED)
        });
        refuses(2, &[&NUMBERS[..], &[(2.0, FiniteNotNegative)]].concat(), |bad, n| {
            let mut spectrum = spectrum_of(n);
            let before = spectrum.xx.to_bits();
            let others = spectrum.zz.to_bits();
            let status = unsafe {
                covbeam_spectrum_add_along(bad.at_mut(0, &mut spectrum), bad.at(1, n[6..9].as_ptr()), n[9])
            };
            (status, (spectrum.xx.to_bits(), spectrum.zz.to_bits()) != (before, others))
        });
    }

    #[test]
    fn many_are_the_same_bits_as_one_each() {
        let spectrum = spectrum_of(&[4.0, 5.0, 6.0, 0.1, 0.2, 0.3]);
        let axes = padded(&[[1.0, 0.0, 0.0], [0.6, 0.8, 0.0], [0.0, 0.6, -0.8]]);
        let stride = size_of_val(&axes[0]);
        let mut found = padded(&[UNTOUCHED; 3]);
        let status = unsafe {
            covbeam_spectra_variance_along(
                3,
                &spectrum,
                0,
                axes.as_ptr().cast(),
                stride,
                &mut found[0].value,
                16,
            )
        };
        assert_eq!(status, COVBEAM_OK);
        let mut spectra = padded(&[spectrum; 3]);
        let spectrum_stride = size_of_val(&spectra[0]);
        let status = unsafe {
            covbeam_spectra_add_along(
                3,
                &mut spectra[0].value,
                spectrum_stride,
                axes.as_ptr().cast(),
                stride,
                &2.0,
                0,
            )
        };
        assert_eq!(status, COVBEAM_OK);
        for ((axis, found), added) in values(&axes).iter().zip(values(&found)).zip(values(&spectra)) {
            let (mut one, mut one_added) = (UNTOUCHED, spectrum);
            assert_eq!(
                unsafe { covbeam_spectrum_variance_along(&spectrum, axis.as_ptr(), &mut one) },
                COVBEAM_OK
            );
            assert_eq!(unsafe { covbeam_spectrum_add_along(&mut one_added, axis.as_ptr(), 2.0) }, COVBEAM_OK);
            assert_eq!((one, one_added), (found, added));
        }
    }
}
