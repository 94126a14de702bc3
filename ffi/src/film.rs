//! A picture from the eye rays that were traced: its regions, and each pixel through its filter.

use crate::density::reserved;
use crate::handle::{Opaque, free, handle_to, run_on, shared};
use crate::memory::{Element, Slot, inputs, outputs};
use crate::status::{Failure, covbeam_status, covbeam_status::*, fail, run};
use crate::types::*;
use core::slice;
use covbeam_core::{FilmNode, FilmSample, Reconstruction, film_regions};

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
fn whole(count: usize, width: u32, height: u32) -> Result<(), Failure> {
    let pixels = pixel_count(width, height)?;
    if count == pixels {
        Ok(())
    } else {
        let message = format_args!("count: {count}, but {width} x {height} are {pixels} pixels");
        Err(fail(COVBEAM_SHORT_BUFFER, message))
    }
}

/// Splits a picture into regions in which the depth of the first surface is continuous: filters do not reach
/// from one into another.
///
/// @param width, height of the picture, each 1 to 65536; at most 2^31 pixels.
/// @param count width x height.
/// @param depths, depth_stride of the first surface seen through the middle of each pixel [m], row by row from
///     the upper left, measured along the viewing axis and not along the ray. Infinity where there is none; NaN,
///     0 or less makes the pixel a border.
/// @param labels, label_stride receive each pixel's region: the number of its first pixel, from 1 on; 0 for a
///     pixel at a border, which filters leave alone, because its own light may come from both sides.
/// @note Two neighbours are apart where neither surface, continued as a plane, comes within 1 % of the other in
///     inverse depth: floors seen at a grazing angle are no edges. Needs 8 bytes a pixel for the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_film_regions(
    width: u32,
    height: u32,
    count: usize,
    depths: *const f32,
    depth_stride: usize,
    labels: *mut u32,
    label_stride: usize,
) -> covbeam_status {
    run(|| {
        whole(count, width, height)?;
        inputs!(count, depths, depth_stride);
        outputs!(count, labels, label_stride);
        let mut depth = reserved(count)?;
        depth.extend((0..count).map(|i| depths.get(i).value));
        let mut found = reserved(count)?;
        found.resize(count, 0);
        film_regions(width, height, &depth, &mut found).expect("as many of both as pixels");
        for (i, label) in found.into_iter().enumerate() {
            labels.set(i, label);
        }
        Ok(())
    })
}

/// The samples of a picture, and the memory that filters of any width need to cost about the same: 27 bytes a
/// pixel. Filters pixels by several threads at once.
pub struct covbeam_reconstruction(());

impl Opaque for covbeam_reconstruction {
    type Object = Picture;
    const TAG: u64 = u64::from_le_bytes(*b"cb-recon");
    const NAME: &'static str = "covbeam_reconstruction";
}

/// What a `covbeam_reconstruction` is.
pub(crate) struct Picture {
    width: u32,
    height: u32,
    samples: Vec<FilmSample>,
    regions: Vec<u32>,
    nodes: Vec<FilmNode>,
    /// A view of the three above; None while they change.
    view: Option<Reconstruction<'static>>,
}

impl Picture {
    fn new(width: u32, height: u32) -> Result<Self, Failure> {
        let count = pixel_count(width, height)?;
        let nodes = Reconstruction::node_count(width, height);
        let mut picture = Self {
            width,
            height,
            samples: reserved(count)?,
            regions: reserved(count)?,
            nodes: reserved(nodes)?,
            view: None,
        };
        picture.samples.resize(count, FilmSample::default());
        picture.regions.resize(count, 1);
        picture.nodes.resize(nodes, FilmNode::default());
        picture.sum();
        Ok(picture)
    }

    /// Sums up the blocks of pixels.
    fn sum(&mut self) {
        let Self { width, height, samples, regions, nodes, view } = self;
        // SAFETY: the memory of the vectors stays where it is, and is not written, until `update` has taken the view
        // away; the view is not handed out, and goes with the picture.
        let (samples, regions, nodes) = unsafe {
            (
                slice::from_raw_parts(samples.as_ptr(), samples.len()),
                slice::from_raw_parts(regions.as_ptr(), regions.len()),
                slice::from_raw_parts_mut(nodes.as_mut_ptr(), nodes.len()),
            )
        };
        let made = Reconstruction::new(*width, *height, samples, regions, nodes);
        *view = Some(made.expect("as long as the picture asks for"));
    }

    fn view(&self) -> &Reconstruction<'static> {
        self.view.as_ref().expect("made when the picture was")
    }
}

/// Makes the reconstruction of a picture, without rays and of one region so far: every pixel is 0.
///
/// @param width, height of the picture, each 1 to 65536; at most 2^31 pixels.
/// @param out the handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_reconstruction_new(
    width: u32,
    height: u32,
    out: *mut *mut covbeam_reconstruction,
) -> covbeam_status {
    run(|| {
        let out = Slot::new(out, "out")?;
        out.set(handle_to(Picture::new(width, height)?));
        Ok(())
    })
}

/// Frees a reconstruction.
///
/// @param reconstruction NULL is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_reconstruction_free(reconstruction: *mut covbeam_reconstruction) {
    // SAFETY: by the caller's promise.
    unsafe { free(reconstruction) }
}

/// Takes the samples of the passes so far, in place of those before.
///
/// @param reconstruction of a picture of so many pixels.
/// @param count width x height.
/// @param samples, sample_stride one a pixel, row by row from the upper left, copied. One that is not finite, of
///     a weight below 1e-9, or with a number beyond 1e29, counts as a pixel without rays: no NaN is spread.
/// @param regions, region_stride of covbeam_film_regions, copied; NULL is one region everywhere.
/// @note About 5 ns a pixel.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_reconstruction_update(
    reconstruction: *mut covbeam_reconstruction,
    count: usize,
    samples: *const covbeam_film_sample,
    sample_stride: usize,
    regions: *const u32,
    region_stride: usize,
) -> covbeam_status {
    let update = |picture: &mut Picture| {
        whole(count, picture.width, picture.height)?;
        let one = 1;
        let (regions, region_stride) =
            if regions.is_null() { (&raw const one, 0) } else { (regions, region_stride) };
        inputs!(count, samples, sample_stride);
        inputs!(count, regions, region_stride);
        picture.view = None;
        for i in 0..count {
            picture.samples[i] = samples.get(i).value.into();
            picture.regions[i] = regions.get(i).value;
        }
        picture.sum();
        Ok(())
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(reconstruction, "reconstruction", update) }
}

/// The radiance of a pixel through its filter. Where no ray lies under the filter, it is widened until one does:
/// first in the pixel's own region, then anywhere.
///
/// @param reconstruction the samples.
/// @param pixel two numbers: x to the right and y down, inside the picture.
/// @param filter the pixel's filter; all 0 is the mean of the pixel's own rays.
/// @param radiance three numbers, finite, within the range of the samples' means to rounding; 0 in a picture
///     without rays.
/// @note Thesis 5.3.2. 0.4 us for a filter of half a pixel, 3 us for any wider round one, 13 us for one of 1:8.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_reconstruction_pixel(
    reconstruction: *const covbeam_reconstruction,
    pixel: *const u32,
    filter: *const covbeam_image_filter,
    radiance: *mut f32,
) -> covbeam_status {
    // SAFETY: the caller's promises about single values are those about arrays of one.
    unsafe { covbeam_reconstruction_pixel_many(reconstruction, 1, pixel, 0, filter, 0, radiance, 0) }
}

/// covbeam_reconstruction_pixel for `count` pixels, such as those of a tile.
///
/// @param reconstruction as reconstruction there.
/// @param count number of pixels; with 0 nothing is done.
/// @param pixels, pixel_stride as pixel there.
/// @param filters, filter_stride as filter there; a stride of 0 gives all pixels the same.
/// @param radiances, radiance_stride as radiance there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_reconstruction_pixel_many(
    reconstruction: *const covbeam_reconstruction,
    count: usize,
    pixels: *const u32,
    pixel_stride: usize,
    filters: *const covbeam_image_filter,
    filter_stride: usize,
    radiances: *mut f32,
    radiance_stride: usize,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let picture = unsafe { shared(reconstruction, "reconstruction") }?;
        let Picture { width, height, .. } = *picture;
        inputs!(count, pixels: [u32; 2], pixel_stride);
        inputs!(count, filters, filter_stride);
        outputs!(count, radiances: [f32; 3], radiance_stride);
        let arguments = |i| {
            let pixel = pixels.get(i);
            let [x, y] = pixel.value;
            if x >= width || y >= height {
                return Err(
                    pixel.is(format_args!("({x}, {y}) is outside of the picture, {width} x {height}"))
                );
            }
            Ok((x, y, image_filter(filters.get(i))?))
        };
        for i in 0..count {
            arguments(i)?;
        }
        for i in 0..count {
            let (x, y, filter) = arguments(i)?;
            radiances.set(i, picture.view().pixel(x, y, &filter).into());
        }
        Ok(())
    })
}

#[cfg(test)]
#[allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]
mod tests {
    use super::*;
    use crate::hostile::{Rule::*, UNTOUCHED, padded, refuses, values};
    use core::ptr;

    const NO_LABEL: u32 = 77;
    const WIDE: covbeam_image_filter = covbeam_image_filter { xx: 4.0, xy: 0.0, yy: 4.0 };

    fn sample(value: f32, weight: f32) -> covbeam_film_sample {
        covbeam_film_sample { radiance: [value * weight, 2.0 * value * weight, 0.0], weight }
    }

    fn made(width: u32, height: u32) -> *mut covbeam_reconstruction {
        let mut handle = ptr::null_mut();
        assert_eq!(unsafe { covbeam_reconstruction_new(width, height, &mut handle) }, COVBEAM_OK);
        handle
    }

    fn pixel(of: *mut covbeam_reconstruction, x: u32, y: u32, filter: covbeam_image_filter) -> [f32; 3] {
        let mut out = [UNTOUCHED; 3];
        let status = unsafe { covbeam_reconstruction_pixel(of, [x, y].as_ptr(), &filter, out.as_mut_ptr()) };
        assert_eq!(status, COVBEAM_OK);
        out
    }

    #[test]
    fn a_bad_argument_is_refused_and_nothing_is_written() {
        refuses(2, &[], |bad, _| {
            let (depths, mut labels) = ([1.0_f32; 6], [NO_LABEL; 6]);
            let (from, to) = (bad.at(0, depths.as_ptr()), bad.at_mut(1, labels.as_mut_ptr()));
            let status = unsafe { covbeam_film_regions(3, 2, 6, from, 4, to, 4) };
            (status, labels != [NO_LABEL; 6])
        });
        refuses(1, &[], |bad, _| {
            let mut out = ptr::null_mut();
            let status = unsafe { covbeam_reconstruction_new(3, 2, bad.at_mut(0, &mut out)) };
            let changed = !out.is_null();
            unsafe { covbeam_reconstruction_free(out) };
            (status, changed)
        });
        refuses(2, &[], |bad, _| {
            let handle = made(3, 2);
            let samples = [sample(1.0, 1.0); 6];
            let from = bad.at(1, samples.as_ptr());
            let status =
                unsafe { covbeam_reconstruction_update(bad.at_mut(0, handle), 6, from, 16, ptr::null(), 0) };
            let changed = pixel(handle, 0, 0, WIDE) != [0.0; 3];
            unsafe { covbeam_reconstruction_free(handle) };
            (status, changed)
        });
        let handle = made(3, 2);
        refuses(4, &[(4.0, FiniteNotNegative), (0.5, Finite), (9.0, FiniteNotNegative)], |bad, n| {
            let (at, mut out) = ([1_u32, 1], [UNTOUCHED; 3]);
            let to = bad.at_mut(3, out.as_mut_ptr());
            let filter = bad.at(2, n.as_ptr()).cast();
            let status = unsafe {
                covbeam_reconstruction_pixel(bad.at(0, handle), bad.at(1, at.as_ptr()), filter, to)
            };
            (status, out != [UNTOUCHED; 3])
        });
        unsafe { covbeam_reconstruction_free(handle) };
    }

    #[test]
    fn sizes_that_no_picture_has_and_other_counts_are_refused() {
        let (depths, mut labels) = ([1.0_f32; 6], [NO_LABEL; 6]);
        let mut out = ptr::null_mut();
        for (width, height) in [(0, 4), (4, 0), (65537, 1), (1, u32::MAX), (65536, 65536)] {
            let statuses = unsafe {
                [
                    covbeam_film_regions(width, height, 6, depths.as_ptr(), 4, labels.as_mut_ptr(), 4),
                    covbeam_reconstruction_new(width, height, &mut out),
                ]
            };
            assert_eq!(statuses, [COVBEAM_INVALID_VALUE; 2], "{width} x {height}");
        }
        let handle = made(3, 2);
        let samples = [sample(1.0, 1.0); 7];
        for count in [0, 5, 7, usize::MAX] {
            let statuses = unsafe {
                [
                    covbeam_film_regions(3, 2, count, depths.as_ptr(), 4, labels.as_mut_ptr(), 4),
                    covbeam_reconstruction_update(handle, count, samples.as_ptr(), 16, ptr::null(), 0),
                ]
            };
            assert_eq!(statuses, [COVBEAM_SHORT_BUFFER; 2], "{count}");
        }
        for outside in [[3, 0], [0, 2], [u32::MAX, 0]] {
            let mut out = [UNTOUCHED; 3];
            let status =
                unsafe { covbeam_reconstruction_pixel(handle, outside.as_ptr(), &WIDE, out.as_mut_ptr()) };
            assert_eq!((status, out), (COVBEAM_INVALID_VALUE, [UNTOUCHED; 3]));
        }
        assert_eq!((labels, out, pixel(handle, 0, 0, WIDE)), ([NO_LABEL; 6], ptr::null_mut(), [0.0; 3]));
        unsafe { covbeam_reconstruction_free(handle) };
    }

    #[test]
    fn a_filter_stays_in_its_region_and_spreads_no_nan() {
        // A near wall to the left of a far one, and light of 1 and of 8 on them; borders at columns 3 and 4.
        let depths = padded(&[[1.0_f32, 1.0, 1.0, 1.0, 5.0, 5.0, 5.0, 5.0]; 4].concat());
        let mut labels = padded(&[NO_LABEL; 32]);
        let (stride, label_stride) = (size_of_val(&depths[0]), size_of_val(&labels[0]));
        let mut samples: Vec<_> = (0..32).map(|i| sample(if i % 8 < 4 { 1.0 } else { 8.0 }, 2.0)).collect();
        samples[9] = sample(f32::NAN, 1.0);
        samples[10] = sample(0.0, 0.0);
        let samples = padded(&samples);
        let handle = made(8, 4);
        let statuses = unsafe {
            [
                covbeam_film_regions(8, 4, 32, &depths[0].value, stride, &mut labels[0].value, label_stride),
                covbeam_reconstruction_update(
                    handle,
                    32,
                    &samples[0].value,
                    size_of_val(&samples[0]),
                    &labels[0].value,
                    label_stride,
                ),
            ]
        };
        assert_eq!(statuses, [COVBEAM_OK; 2]);
        assert_eq!(values(&labels)[..8], [1, 1, 1, 0, 0, 6, 6, 6]);
        for x in [0, 1, 2, 5, 6, 7] {
            let mean = if x < 4 { 1.0 } else { 8.0 };
            let [red, green, blue] = pixel(handle, x, 1, WIDE);
            assert!(
                (red / mean - 1.0).abs() < 1e-5 && (green / red - 2.0).abs() < 1e-5,
                "{x}: {red} {green}"
            );
            assert_eq!(blue, 0.0);
        }
        // Without regions the light of both sides mixes.
        let status = unsafe {
            let first = &raw const samples[0].value;
            covbeam_reconstruction_update(handle, 32, first, size_of_val(&samples[0]), ptr::null(), 0)
        };
        assert_eq!(status, COVBEAM_OK);
        let mixed = pixel(handle, 2, 1, WIDE)[0];
        assert!(mixed > 1.5 && mixed < 7.5, "{mixed}");
        unsafe { covbeam_reconstruction_free(handle) };
    }

    #[test]
    fn many_are_the_same_bits_as_one_each() {
        let handle = made(9, 5);
        let samples: Vec<_> = (0..45).map(|i| sample((i * i % 17) as f32, (i % 3) as f32)).collect();
        let status =
            unsafe { covbeam_reconstruction_update(handle, 45, samples.as_ptr(), 16, ptr::null(), 0) };
        assert_eq!(status, COVBEAM_OK);
        let pixels = padded(&[[0_u32, 0], [8, 4], [3, 2]]);
        let filters = padded(&[WIDE, covbeam_image_filter { xx: 0.0, xy: 0.0, yy: 0.0 }, WIDE]);
        let mut radiances = padded(&[[UNTOUCHED; 3]; 3]);
        let status = unsafe {
            covbeam_reconstruction_pixel_many(
                handle,
                3,
                pixels[0].value.as_ptr(),
                size_of_val(&pixels[0]),
                &filters[0].value,
                size_of_val(&filters[0]),
                radiances[0].value.as_mut_ptr(),
                size_of_val(&radiances[1]),
            )
        };
        assert_eq!(status, COVBEAM_OK);
        let all = values(&radiances);
        for (i, [x, y]) in values(&pixels).into_iter().enumerate() {
            assert_eq!(pixel(handle, x, y, values(&filters)[i]), all[i]);
        }
        unsafe { covbeam_reconstruction_free(handle) };
    }
}
