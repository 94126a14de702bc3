//! The mask of a pass: which pixels get an eye ray.

use crate::arrays::write;
use crate::memory::{inputs, outputs};
use crate::status::{covbeam_status, run};
use covbeam_core::pixel_threshold;

/// A pixel's threshold in a pass: the pixel gets an eye ray if its density is above. At any density the pixels
/// chosen are spread evenly over the picture, and a pixel is chosen evenly over the passes.
///
/// @param pass any number; each chooses other pixels.
/// @param seed any number; shifts the pattern.
/// @param count number of pixels; with 0 nothing is done.
/// @param pixels, pixel_stride two numbers: x to the right and y down, any.
/// @param thresholds, threshold_stride in [0, 1).
/// @kinds #any #any <f:ii >f:r
/// @single covbeam_pixel_threshold
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_pixel_threshold_many(
    pass: u32,
    seed: u32,
    count: usize,
    pixels: *const u32,
    pixel_stride: usize,
    thresholds: *mut f32,
    threshold_stride: usize,
) -> covbeam_status {
    run(|| {
        inputs!(count, pixels: [u32; 2], pixel_stride);
        outputs!(count, thresholds, threshold_stride);
        write(thresholds, |i| Ok(pixels.get(i).value), |[x, y]| pixel_threshold(x, y, pass, seed))
    })
}
