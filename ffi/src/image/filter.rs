//! Filters that the spectrum of a picture allows, and the eye rays that they need.

use super::spectrum::{covbeam_image_spectrum, image_spectrum};
use crate::arrays::write;
use crate::check::{finite, finite_not_negative, positive};
use crate::memory::{Element, field, inputs, outputs};
use crate::status::{Failure, covbeam_status, run};
use covbeam_core::ImageFilter;

/// Covariance of a Gaussian reconstruction filter [pixels^2]: x to the right, y down. All 0 is no filter.
/// @extra
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_image_filter {
    /// Variance across.
    pub xx: f32,
    /// Covariance of across and down.
    pub xy: f32,
    /// Variance down.
    pub yy: f32,
}

impl From<ImageFilter> for covbeam_image_filter {
    fn from(ImageFilter { xx, xy, yy }: ImageFilter) -> Self {
        Self { xx, xy, yy }
    }
}

fn image_filter(e: Element<covbeam_image_filter>) -> Result<ImageFilter, Failure> {
    let covbeam_image_filter { xx, xy, yy } = e.value;
    finite(field!(e, xy))?;
    for variance in [field!(e, xx), field!(e, yy)] {
        finite_not_negative(variance)?;
    }
    Ok(ImageFilter { xx, xy, yy })
}

/// The reconstruction filter that blurs the picture by a relative bias: a Gaussian of covariance
/// error / (4 pi^2) x the inverse of the spectrum's, wide where the spectrum is narrow.
///
/// @param count number of pixels; with 0 nothing is done.
/// @param spectra, spectrum_stride the spectrum around the pixel.
/// @param errors, error_stride the relative bias > 0, half of it along each principal axis.
/// @param widests, widest_stride largest standard deviation [pixels] > 0.
/// @param filters, filter_stride all 0 where the spectrum has a weight of 0.
/// @note Thesis 5.3.2, whose filter has an error of 1.
/// @kinds <image <f:+ <f:+ >filter
/// @single covbeam_image_spectrum_filter
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_image_spectra_filter(
    count: usize,
    spectra: *const covbeam_image_spectrum,
    spectrum_stride: usize,
    errors: *const f32,
    error_stride: usize,
    widests: *const f32,
    widest_stride: usize,
    filters: *mut covbeam_image_filter,
    filter_stride: usize,
) -> covbeam_status {
    run(|| {
        inputs!(count, spectra, spectrum_stride);
        inputs!(count, errors, error_stride);
        inputs!(count, widests, widest_stride);
        outputs!(count, filters, filter_stride);
        write(
            filters,
            |i| Ok((image_spectrum(spectra.get(i))?, positive(errors.get(i))?, positive(widests.get(i))?)),
            |(spectrum, error, widest)| spectrum.filter(error, widest).into(),
        )
    })
}

/// Eye rays that a pixel needs in a pass: two under each filter.
///
/// @param count number of pixels; with 0 nothing is done.
/// @param filters, filter_stride the pixel's filter.
/// @param densities, density_stride in (0, 1]; no filter gives 1.
/// @note Thesis 5.3.2.
/// @kinds <filter >f:l
/// @single covbeam_image_filter_density
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_image_filters_density(
    count: usize,
    filters: *const covbeam_image_filter,
    filter_stride: usize,
    densities: *mut f32,
    density_stride: usize,
) -> covbeam_status {
    run(|| {
        inputs!(count, filters, filter_stride);
        outputs!(count, densities, density_stride);
        write(densities, |i| image_filter(filters.get(i)), |filter| filter.density())
    })
}
