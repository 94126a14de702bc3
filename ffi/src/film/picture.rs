//! The picture, each pixel through its filter.

use super::handle::covbeam_film;
use super::state::Film;
use crate::handle::{run_on, shared};
use crate::memory::{Element, outputs};
use crate::status::{covbeam_poll, covbeam_status, covbeam_status::*, fail, go_on, run};
use core::ffi::c_void;
use covbeam_core::{FILM_TILE, FilmLattice, FilmPixel};
use glam::Vec3;

/// A pixel of a picture.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_film_pixel {
    /// All light, per channel [W/(m^2 sr)].
    pub radiance: [f32; 3],
    /// That of the fog before the first surface.
    pub volume: [f32; 3],
    /// Squared standard error of the filtered luminance; 0 = not known, or none is.
    pub variance: f32,
    /// Luminance of the odd passes minus that of the even ones, of the light that is not filtered.
    pub difference: f32,
}

/// - `volume`: the filtered light alone.
fn film_pixel(pixel: FilmPixel, volume: Vec3) -> covbeam_film_pixel {
    let FilmPixel { radiance, variance, difference } = pixel;
    covbeam_film_pixel { radiance: radiance.into(), volume: volume.into(), variance, difference }
}

/// Makes a film ready for covbeam_film_picture: where a filter of the latest pass disagrees with narrower ones by more
/// than the noise of the two halves of the passes, it is narrowed. Stopped, the film is as before.
///
/// @param film the film.
/// @param poll may be NULL; asked at least every few milliseconds, in a picture of a million pixels. Not 0 ends the call with
///     COVBEAM_CANCELLED.
/// @param user given to poll.
/// @note After O. V. Lepski (1991): the widest filter that agrees with all narrower ones. 50 ms, and 30 ns a pixel.
/// @kinds !picture
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_verify(
    film: *mut covbeam_film,
    poll: covbeam_poll,
    user: *mut c_void,
) -> covbeam_status {
    // SAFETY: by the caller's promise.
    unsafe { run_on(film, "film", |film: &mut Film| film.verify(&mut go_on(poll, user))) }
}

/// Some rows of the picture. Threads may share the work, each with rows of its own.
///
/// @param film a film that has been verified since the latest pass was added.
/// @param first_row a multiple of 8.
/// @param count width x number of rows, which is a multiple of 8 or reaches the last row.
/// @param pixels, pixel_stride receive the rows; 0 in a picture without rays.
/// @note 0.2 us a pixel where filters are wide, up to 3 us where they are not.
/// @kinds @picture.committed #row >shown
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_picture(
    film: *const covbeam_film,
    first_row: u32,
    count: usize,
    pixels: *mut covbeam_film_pixel,
    pixel_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let film = unsafe { shared(film, "film") }?;
        let FilmLattice { width, height, .. } = *film.lattice();
        if first_row >= height || !first_row.is_multiple_of(FILM_TILE) {
            let row = Element::single(first_row, "first_row");
            return Err(row.is(format_args!("{first_row} is no multiple of {FILM_TILE} below {height}")));
        }
        let (columns, left) = (width as usize, (height - first_row) as usize);
        let rows = count / columns;
        let whole = count.is_multiple_of(columns)
            && (rows == left || (rows < left && rows.is_multiple_of(FILM_TILE as usize)));
        if !whole {
            let message = format_args!(
                "count: {count} is not {width} x a multiple of {FILM_TILE}, or the {left} rows left"
            );
            return Err(fail(COVBEAM_SHORT_BUFFER, message));
        }
        outputs!(count, pixels, pixel_stride);
        if !film.is_verified() {
            let message =
                format_args!("film: not verified since a pass was added; call covbeam_film_verify first");
            return Err(fail(COVBEAM_WRONG_ORDER, message));
        }
        let before = first_row as usize * columns;
        film.rows(first_row..first_row + rows as u32, |index, pixel, volume| {
            pixels.set(index - before, film_pixel(pixel, volume));
        });
        Ok(())
    })
}
