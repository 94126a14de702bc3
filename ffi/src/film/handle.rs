//! Films: made, freed, and how much memory they hold.

use super::size::one_a_pixel;
use super::state::Film;
use crate::check::positive;
use crate::handle::{Opaque, free, handle_to, shared};
use crate::heap::reserved;
use crate::memory::{Element, Inputs, Slot};
use crate::status::{covbeam_status, run};
use covbeam_core::FilmLattice;

/// Few eye rays for a picture whose light is smooth: where they are needed, what they saw, and the picture from
/// them. A pass:
///
/// covbeam_film_plan from spectra at some pixels; covbeam_film_density, and an eye ray through each pixel whose
/// covbeam_pixel_threshold is below its density; covbeam_film_add what they saw. When a picture is wanted,
/// covbeam_film_verify, then covbeam_film_picture, by several threads at once. About 60 bytes a pixel, 40 more with light
/// from beyond the fog, and 35 or 70 once verified.
pub struct covbeam_film(());

impl Opaque for covbeam_film {
    type Object = Film;
    const TAG: u64 = u64::from_le_bytes(*b"cb-film-");
    const NAME: &'static str = "covbeam_film";
}

/// Makes the film of a picture, without rays so far.
///
/// @param width, height of the picture, each 1 to 65536; at most 2^31 pixels.
/// @param typical_radiance of the picture, give or take a factor of a thousand [W/(m^2 sr)] > 0: light is added up in whole
///     multiples of 2^-32 of it, so that the order of passes and rays does not count; sums stop at 2^31 times it.
/// @param count width x height.
/// @param regions, region_stride of covbeam_film_regions, copied: filters do not reach from one into another, and
///     leave pixels with 0 alone. NULL is one region everywhere.
/// @param out the handle.
/// @kinds #extent #extent $+ <f:i? +picture
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_new(
    width: u32,
    height: u32,
    typical_radiance: f32,
    count: usize,
    regions: *const u32,
    region_stride: usize,
    out: *mut *mut covbeam_film,
) -> covbeam_status {
    run(|| {
        one_a_pixel(count, width, height)?;
        let typical = positive(Element::single(typical_radiance, "typical_radiance"))?;
        // SAFETY: by the caller's promise.
        let regions = unsafe { Inputs::optional(regions, region_stride, count, "regions") }?;
        let out = Slot::new(out, "out")?;
        let mut labels = reserved(count)?;
        labels.extend((0..count).map(|i| regions.as_ref().map_or(1, |regions| regions.get(i).value)));
        let lattice = FilmLattice::new(width, height).expect("checked above");
        out.set(handle_to(Film::new(lattice, typical, labels)?)?);
        Ok(())
    })
}

/// Frees a film.
///
/// @param film NULL is fine.
/// @kinds !picture
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_free(film: *mut covbeam_film) -> covbeam_status {
    // SAFETY: by the caller's promise.
    unsafe { free(film, "film") }
}

/// How much memory a film holds.
///
/// @param film the film.
/// @param bytes receives it.
/// @kinds @picture >size
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_get_memory(
    film: *const covbeam_film,
    bytes: *mut usize,
) -> covbeam_status {
    run(|| {
        let bytes = Slot::new(bytes, "bytes")?;
        // SAFETY: by the caller's promise.
        bytes.set(unsafe { shared(film, "film") }?.memory());
        Ok(())
    })
}
