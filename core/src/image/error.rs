//! How far a pixel is from what endless passes would give.

use super::{FilmPixel, FilmSizeError, pixel_count};
use libm::sqrtf;

/// Pixels to each side over which the squared difference of the two halves is averaged: one difference alone
/// says little.
const WINDOW: i64 = 2;

/// Standard error of each pixel's luminance, from the two halves of the passes.
///
/// - `pixels`: of [`super::Reconstruction::tile`], with the `difference` of everything that was not filtered.
/// - `rows`: receives the errors of some rows, the first of them `first_row`: all of them, or a share of a
///   thread.
///
/// Half the difference of two halves with independent errors has the variance of their mean. Its square is
/// averaged over 5 x 5 pixels, and the filtered light's variance added.
///
/// Errors: a slice of another length, or no whole rows.
pub fn standard_errors(
    width: u32,
    height: u32,
    pixels: &[FilmPixel],
    first_row: u32,
    rows: &mut [f32],
) -> Result<(), FilmSizeError> {
    let count = pixel_count(width, height)?;
    let columns = width as usize;
    let whole = columns > 0 && rows.len() % columns == 0;
    if pixels.len() != count || !whole || first_row as usize * columns + rows.len() > count {
        return Err(FilmSizeError);
    }
    for (index, out) in rows.iter_mut().enumerate() {
        let (x, y) = (index % columns, first_row as usize + index / columns);
        let around = |at: usize, count: u32| {
            let low = (at as i64 - WINDOW).max(0) as usize;
            let high = (at as i64 + WINDOW).min(i64::from(count) - 1) as usize;
            low..=high
        };
        let (mut sum, mut number) = (0.0, 0.0);
        for row in around(y, height) {
            for pixel in &pixels[row * columns..][around(x, width)] {
                sum += pixel.difference * pixel.difference;
                number += 1.0;
            }
        }
        *out = sqrtf(pixels[y * columns + x].variance + 0.25 * sum / number);
    }
    Ok(())
}
