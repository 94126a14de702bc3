//! Standard errors of a picture.

use super::picture::covbeam_film_pixel;
use super::size::one_a_pixel;
use crate::check::{finite, finite_not_negative};
use crate::heap::reserved;
use crate::memory::{Element, field, inputs, outputs};
use crate::status::{Failure, covbeam_status, run};
use covbeam_core::{FilmPixel, standard_errors};
use glam::Vec3;

/// What the error of a pixel is found from.
fn film_pixel_of(e: Element<covbeam_film_pixel>) -> Result<FilmPixel, Failure> {
    let covbeam_film_pixel { variance, difference, .. } = e.value;
    finite_not_negative(field!(e, variance))?;
    finite(field!(e, difference))?;
    Ok(FilmPixel { radiance: Vec3::ZERO, variance, difference })
}

/// Standard errors of a picture, from the two halves of its passes: squared differences averaged over 5x5 pixels, and what
/// is known of the filtered light.
///
/// @param width, height of the picture, or of a part of it that threads share: then rows at least 2 away from the
///     part's ends have the errors that they have in the whole.
/// @param count width x height.
/// @param pixels, pixel_stride of covbeam_film_picture.
/// @param errors, error_stride receive the standard error of each pixel's luminance (Rec. 709) [W/(m^2 sr)].
/// @note 40 ns and 20 bytes a pixel for the call.
/// @kinds #extent #extent <pixel >f:q
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_errors(
    width: u32,
    height: u32,
    count: usize,
    pixels: *const covbeam_film_pixel,
    pixel_stride: usize,
    errors: *mut f32,
    error_stride: usize,
) -> covbeam_status {
    run(|| {
        one_a_pixel(count, width, height)?;
        inputs!(count, pixels, pixel_stride);
        outputs!(count, errors, error_stride);
        let (mut given, mut found) = (reserved(count)?, reserved(count)?);
        for i in 0..count {
            given.push(film_pixel_of(pixels.get(i))?);
        }
        found.resize(count, 0.0);
        standard_errors(width, height, &given, 0, &mut found).expect("as many of both as pixels");
        for (i, error) in found.into_iter().enumerate() {
            errors.set(i, error);
        }
        Ok(())
    })
}
