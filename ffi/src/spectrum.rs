//! Spectra of the fluence around a point.

use crate::arrays::write;
use crate::check::{finite, finite_not_negative, unit};
use crate::memory::{Element, Inputs, field, inputs, outputs};
use crate::status::{Failure, covbeam_status, run};
use covbeam_core::FluenceSpectrum;

/// Covariance of the spectrum of the fluence around a point, in world axes [cycles^2/m^2].
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_spectrum {
    /// Variance along world x.
    pub xx: f32,
    /// Variance along world y.
    pub yy: f32,
    /// Variance along world z.
    pub zz: f32,
    /// Covariance of x and y.
    pub xy: f32,
    /// Covariance of x and z.
    pub xz: f32,
    /// Covariance of y and z.
    pub yz: f32,
}

impl From<FluenceSpectrum> for covbeam_spectrum {
    fn from(s: FluenceSpectrum) -> Self {
        let [xx, yy, zz, xy, xz, yz] = s.to_array();
        Self { xx, yy, zz, xy, xz, yz }
    }
}

impl From<covbeam_spectrum> for FluenceSpectrum {
    fn from(s: covbeam_spectrum) -> Self {
        Self::from_array([s.xx, s.yy, s.zz, s.xy, s.xz, s.yz])
    }
}

pub(crate) fn spectrum(e: Element<covbeam_spectrum>) -> Result<FluenceSpectrum, Failure> {
    let diagonal = [field!(e, xx), field!(e, yy), field!(e, zz)];
    for variance in diagonal.into_iter().chain([field!(e, xy), field!(e, xz), field!(e, yz)]) {
        finite(variance)?;
    }
    Ok(e.value.into())
}

/// A spectrum's variance along an axis: what covbeam_kernel_radius_from_error takes.
///
/// @param count number of spectra; with 0 nothing is done.
/// @param spectra, spectrum_stride of the fluence.
/// @param axes, axis_stride unit.
/// @param variances, variance_stride [cycles^2/m^2] >= 0, to a few roundings of xx + yy + zz.
/// @note Thesis 5.3.4.
/// @kinds <spectrum <f:uuu >f:q
/// @single covbeam_spectrum_variance_along
/// @extra
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
/// @param count number of spectra; with 0 nothing is done.
/// @param spectra, spectrum_stride of the fluence, changed in place.
/// @param axes, axis_stride unit.
/// @param variances, variance_stride [cycles^2/m^2], finite and >= 0.
/// @kinds =spectrum <f:uuu <f:q
/// @single covbeam_spectrum_add_along
/// @extra
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
    use crate::hostile::{Rule, Rule::*, UNTOUCHED, refuses};

    fn spectrum_of(n: &[f32]) -> covbeam_spectrum {
        covbeam_spectrum { xx: n[0], yy: n[1], zz: n[2], xy: n[3], xz: n[4], yz: n[5] }
    }

    /// A spectrum, then the z axis.
    const NUMBERS: [(f32, Rule); 9] = [
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
                covbeam_spectra_variance_along(
                    1,
                    bad.at(0, &spectrum),
                    0,
                    bad.at(1, n[6..].as_ptr()),
                    0,
                    bad.at_mut(2, &mut out),
                    0,
                )
            };
            (status, out != UNTOUCHED)
        });
        refuses(2, &[&NUMBERS[..], &[(2.0, FiniteNotNegative)]].concat(), |bad, n| {
            let mut spectrum = spectrum_of(n);
            let before = spectrum.xx.to_bits();
            let others = spectrum.zz.to_bits();
            let status = unsafe {
                covbeam_spectra_add_along(
                    1,
                    bad.at_mut(0, &mut spectrum),
                    0,
                    bad.at(1, n[6..9].as_ptr()),
                    0,
                    &n[9],
                    0,
                )
            };
            (status, (spectrum.xx.to_bits(), spectrum.zz.to_bits()) != (before, others))
        });
    }
}
