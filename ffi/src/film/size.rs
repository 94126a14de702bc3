//! Sizes of pictures, and of arrays for them.

use crate::memory::Element;
use crate::status::{Failure, covbeam_status::*, fail};

/// Most pixels across or down, and in all.
const MOST_ACROSS: u32 = 1 << 16;
const MOST: u64 = 1 << 31;

/// Number of pixels of a picture that is not too large.
fn pixel_count(width: u32, height: u32) -> Result<usize, Failure> {
    for (name, value) in [("width", width), ("height", height)] {
        if !(1..=MOST_ACROSS).contains(&value) {
            return Err(Element::single(value, name).is(format_args!("{value} is not in 1 to {MOST_ACROSS}")));
        }
    }
    let count = u64::from(width) * u64::from(height);
    if count > MOST {
        let message = format_args!("{width} x {height} pixels are more than {MOST}");
        return Err(Element::single(width, "width").is(message));
    }
    Ok(count as usize)
}

/// Whether arrays have an element a pixel.
pub(super) fn one_a_pixel(count: usize, width: u32, height: u32) -> Result<(), Failure> {
    let pixels = pixel_count(width, height)?;
    as_many(count, pixels, format_args!("{width} x {height} pixels"))
}

pub(super) fn as_many(count: usize, wanted: usize, what: core::fmt::Arguments) -> Result<(), Failure> {
    if count == wanted {
        Ok(())
    } else {
        Err(fail(COVBEAM_SHORT_BUFFER, format_args!("count: {count}, but {what} want {wanted}")))
    }
}
