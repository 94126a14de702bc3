//! Tests of films: what is refused, in which order calls come, and what is the same whatever their order.
#![allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]

use super::error::covbeam_film_errors;
use super::handle::{covbeam_film, covbeam_film_free, covbeam_film_get_memory, covbeam_film_new};
use super::picture::{covbeam_film_picture, covbeam_film_pixel, covbeam_film_verify};
use super::plan::{covbeam_film_density, covbeam_film_get_node_count, covbeam_film_nodes, covbeam_film_plan};
use super::rays::{covbeam_film_add, covbeam_film_ray};
use super::regions::covbeam_film_regions;
use crate::hostile::{Rule, Rule::*, UNTOUCHED, padded, refuses, values};
use crate::image::spectrum::covbeam_image_spectrum;
use crate::status::{covbeam_status, covbeam_status::*};
use core::ffi::c_void;
use core::ptr;

const NO_LABEL: u32 = 77;
const NO_PIXEL: covbeam_film_pixel = covbeam_film_pixel {
    radiance: [UNTOUCHED; 3],
    volume: [UNTOUCHED; 3],
    variance: UNTOUCHED,
    difference: UNTOUCHED,
};
const NONE: covbeam_image_spectrum = covbeam_image_spectrum { xx: 0.0, xy: 0.0, yy: 0.0, weight: 0.0 };
/// As smooth as can be: the widest filter.
const SMOOTH: covbeam_image_spectrum = covbeam_image_spectrum { weight: 1.0, ..NONE };

fn made(width: u32, height: u32, regions: &[u32]) -> *mut covbeam_film {
    let mut film = ptr::null_mut();
    let (count, labels) =
        ((width * height) as usize, if regions.is_empty() { ptr::null() } else { regions.as_ptr() });
    let status = unsafe { covbeam_film_new(width, height, 1.0, count, labels, 4, &mut film) };
    assert_eq!(status, COVBEAM_OK);
    film
}

fn node_count(film: *const covbeam_film) -> usize {
    let mut count = 0;
    assert_eq!(unsafe { covbeam_film_get_node_count(film, &mut count) }, COVBEAM_OK);
    count
}

fn plan(film: *mut covbeam_film, pass: u32, spectrum: &covbeam_image_spectrum) -> covbeam_status {
    unsafe { covbeam_film_plan(film, pass, 0.01, 0, node_count(film), spectrum, 0, None, ptr::null_mut()) }
}

fn ray(x: u32, y: u32, volume: f32, rest: Option<f32>) -> covbeam_film_ray {
    let has_rest = u32::from(rest.is_some());
    let rest = [rest.unwrap_or(0.0); 3];
    covbeam_film_ray { pixel: [x, y], has_volume: 1, has_rest, volume: [volume; 3], rest }
}

/// Adds a pass whose filters are all as wide as `spectrum` allows.
fn add(film: *mut covbeam_film, pass: u32, spectrum: &covbeam_image_spectrum, rays: &[covbeam_film_ray]) {
    let stride = size_of::<covbeam_film_ray>();
    assert_eq!(plan(film, pass, spectrum), COVBEAM_OK);
    assert_eq!(unsafe { covbeam_film_add(film, rays.len(), rays.as_ptr(), stride) }, COVBEAM_OK);
}

fn picture(film: *mut covbeam_film, count: usize) -> Vec<covbeam_film_pixel> {
    let mut pixels = vec![NO_PIXEL; count];
    let statuses = unsafe {
        [
            covbeam_film_verify(film, None, ptr::null_mut()),
            covbeam_film_picture(film, 0, count, pixels.as_mut_ptr(), size_of::<covbeam_film_pixel>()),
        ]
    };
    assert_eq!(statuses, [COVBEAM_OK; 2]);
    pixels
}

/// An eye ray through each pixel.
fn full(width: u32, height: u32, volume: impl Fn(u32) -> f32, rest: Option<f32>) -> Vec<covbeam_film_ray> {
    (0..width * height).map(|i| ray(i % width, i / width, volume(i), rest)).collect()
}

#[test]
fn a_bad_argument_is_refused_and_nothing_is_written() {
    refuses(2, &[], |bad, _| {
        let (depths, mut labels) = ([1.0_f32; 6], [NO_LABEL; 6]);
        let (from, to) = (bad.at(0, depths.as_ptr()), bad.at_mut(1, labels.as_mut_ptr()));
        let status = unsafe { covbeam_film_regions(3, 2, 6, from, 4, to, 4) };
        (status, labels != [NO_LABEL; 6])
    });
    refuses(1, &[(2.0, Positive)], |bad, n| {
        let mut out = ptr::null_mut();
        let status = unsafe { covbeam_film_new(3, 2, n[0], 6, ptr::null(), 0, bad.at_mut(0, &mut out)) };
        let changed = !out.is_null();
        unsafe { covbeam_film_free(out) };
        (status, changed)
    });
    let film = made(3, 2, &[]);
    for get in [covbeam_film_get_memory, covbeam_film_get_node_count] {
        refuses(2, &[], |bad, _| {
            let mut number = 0;
            let status = unsafe { get(bad.at(0, film), bad.at_mut(1, &mut number)) };
            (status, number != 0)
        });
    }
    refuses(2, &[], |bad, _| {
        let mut pixels = [[NO_LABEL; 2]; 2];
        let to = bad.at_mut(1, pixels.as_mut_ptr().cast());
        let status = unsafe { covbeam_film_nodes(bad.at(0, film), 2, to, 8) };
        (status, pixels != [[NO_LABEL; 2]; 2])
    });
    let spectrum = [(0.01, Positive), (4.0, Finite), (0.5, Finite), (9.0, Finite), (1.0, FiniteNotNegative)];
    refuses(2, &spectrum, |bad, n| {
        let film = made(3, 2, &[]);
        let from = bad.at(1, n[1..].as_ptr()).cast();
        let status =
            unsafe { covbeam_film_plan(bad.at_mut(0, film), 1, n[0], 5, 2, from, 0, None, ptr::null_mut()) };
        let planned = unsafe { covbeam_film_add(film, 0, ptr::null(), 0) } == COVBEAM_OK;
        unsafe { covbeam_film_free(film) };
        (status, planned)
    });
    assert_eq!(plan(film, 1, &SMOOTH), COVBEAM_OK);
    refuses(2, &[], |bad, _| {
        let mut densities = [UNTOUCHED; 6];
        let to = bad.at_mut(1, densities.as_mut_ptr());
        let status = unsafe { covbeam_film_density(bad.at(0, film), 6, to, 4) };
        (status, densities != [UNTOUCHED; 6])
    });
    let light: [(f32, Rule); 6] = [(1.0, FiniteNotNegative); 6];
    refuses(2, &light, |bad, n| {
        let film = made(3, 2, &[]);
        assert_eq!(plan(film, 1, &NONE), COVBEAM_OK);
        let mut given = ray(2, 1, 0.0, Some(0.0));
        given.volume.copy_from_slice(&n[..3]);
        given.rest.copy_from_slice(&n[3..]);
        let status = unsafe { covbeam_film_add(bad.at_mut(0, film), 1, bad.at(1, &given), 0) };
        let still_planned = unsafe { covbeam_film_add(film, 0, ptr::null(), 0) } == COVBEAM_OK;
        let dark = picture(film, 6).iter().all(|pixel| pixel.radiance == [0.0; 3]);
        unsafe { covbeam_film_free(film) };
        (status, !still_planned || !dark)
    });
    refuses(1, &[], |bad, _| {
        let film = made(3, 2, &[]);
        let status = unsafe { covbeam_film_verify(bad.at_mut(0, film), None, ptr::null_mut()) };
        let mut pixels = [NO_PIXEL; 6];
        let ready = unsafe { covbeam_film_picture(film, 0, 6, pixels.as_mut_ptr(), 32) } == COVBEAM_OK;
        unsafe { covbeam_film_free(film) };
        (status, ready)
    });
    let pixels = picture(film, 6);
    refuses(2, &[], |bad, _| {
        let mut out = [NO_PIXEL; 6];
        let status =
            unsafe { covbeam_film_picture(bad.at(0, film), 0, 6, bad.at_mut(1, out.as_mut_ptr()), 32) };
        (status, out != [NO_PIXEL; 6])
    });
    refuses(2, &[(0.5, FiniteNotNegative), (-0.5, Finite)], |bad, n| {
        let given = [covbeam_film_pixel { variance: n[0], difference: n[1], ..pixels[0] }; 6];
        let mut errors = [UNTOUCHED; 6];
        let (from, to) = (bad.at(0, given.as_ptr()), bad.at_mut(1, errors.as_mut_ptr()));
        let status = unsafe { covbeam_film_errors(3, 2, 6, from, 32, to, 4) };
        (status, errors != [UNTOUCHED; 6])
    });
    unsafe { covbeam_film_free(film) };
}

#[test]
fn sizes_that_no_picture_has_and_other_counts_are_refused() {
    let (depths, mut labels, mut errors) = ([1.0_f32; 6], [NO_LABEL; 6], [UNTOUCHED; 6]);
    let mut pixels = [covbeam_film_pixel { variance: 0.0, difference: 0.0, ..NO_PIXEL }; 6];
    let mut out = ptr::null_mut();
    for (width, height) in [(0, 4), (4, 0), (65537, 1), (1, u32::MAX), (65536, 65536)] {
        let statuses = unsafe {
            [
                covbeam_film_regions(width, height, 6, depths.as_ptr(), 4, labels.as_mut_ptr(), 4),
                covbeam_film_new(width, height, 1.0, 6, ptr::null(), 0, &mut out),
                covbeam_film_errors(width, height, 6, pixels.as_ptr(), 32, errors.as_mut_ptr(), 4),
            ]
        };
        assert_eq!(statuses, [COVBEAM_INVALID_VALUE; 3], "{width} x {height}");
    }
    let film = made(3, 2, &[]);
    assert_eq!(plan(film, 1, &NONE), COVBEAM_OK);
    let (nodes, mut densities) = (&mut [[NO_LABEL; 2]; 2], [UNTOUCHED; 6]);
    for count in [0, 1, 5, 7, usize::MAX] {
        let statuses = unsafe {
            [
                covbeam_film_regions(3, 2, count, depths.as_ptr(), 4, labels.as_mut_ptr(), 4),
                covbeam_film_new(3, 2, 1.0, count, ptr::null(), 0, &mut out),
                covbeam_film_nodes(film, count, nodes.as_mut_ptr().cast(), 8),
                covbeam_film_plan(film, 1, 0.1, 1, count, &SMOOTH, 0, None, ptr::null_mut()),
                covbeam_film_density(film, count, densities.as_mut_ptr(), 4),
                covbeam_film_errors(3, 2, count, pixels.as_ptr(), 32, errors.as_mut_ptr(), 4),
            ]
        };
        assert_eq!(statuses, [COVBEAM_SHORT_BUFFER; 6], "{count}");
    }
    assert_eq!((labels, out, *nodes), ([NO_LABEL; 6], ptr::null_mut(), [[NO_LABEL; 2]; 2]));
    assert_eq!((densities, errors), ([UNTOUCHED; 6], [UNTOUCHED; 6]));

    for ([x, y], flag) in [([3, 0], 1), ([0, 2], 1), ([u32::MAX, 0], 0), ([0, 0], 2)] {
        let rays = [ray(0, 0, 1.0, None), covbeam_film_ray { has_rest: flag, ..ray(x, y, 1.0, None) }];
        let status = unsafe { covbeam_film_add(film, 2, rays.as_ptr(), 40) };
        assert_eq!(status, COVBEAM_INVALID_VALUE, "{x}, {y}, {flag}");
    }
    assert!(picture(film, 6).iter().all(|pixel| pixel.radiance == [0.0; 3]));
    for (row, count, status) in [
        (0, 3, COVBEAM_SHORT_BUFFER),
        (0, 5, COVBEAM_SHORT_BUFFER),
        (0, usize::MAX, COVBEAM_SHORT_BUFFER),
        (1, 3, COVBEAM_INVALID_VALUE),
        (8, 6, COVBEAM_INVALID_VALUE),
        (0, 0, COVBEAM_OK),
    ] {
        let found = unsafe { covbeam_film_picture(film, row, count, pixels.as_mut_ptr(), 32) };
        assert_eq!(found, status, "{row}, {count}");
    }
    assert_eq!(pixels[0].radiance, [UNTOUCHED; 3]);
    unsafe { covbeam_film_free(film) };
}

#[test]
fn the_steps_of_a_pass_come_in_their_order() {
    let film = made(3, 2, &[]);
    let (mut densities, mut pixels) = ([UNTOUCHED; 6], [NO_PIXEL; 6]);
    let early = || unsafe {
        [
            covbeam_film_density(film, 6, densities.as_ptr().cast_mut(), 4),
            covbeam_film_add(film, 0, ptr::null(), 0),
            covbeam_film_picture(film, 0, 6, pixels.as_ptr().cast_mut(), 32),
        ]
    };
    assert_eq!(early(), [COVBEAM_WRONG_ORDER; 3]);
    let rays = full(3, 2, |_| 4.0, None);
    add(film, 1, &NONE, &rays);
    assert_eq!(early(), [COVBEAM_WRONG_ORDER; 3]);
    assert_eq!((densities, pixels), ([UNTOUCHED; 6], [NO_PIXEL; 6]));
    // A plan that is not added changes nothing of the picture.
    let before = picture(film, 6);
    assert_eq!(plan(film, 2, &SMOOTH), COVBEAM_OK);
    let status = unsafe { covbeam_film_density(film, 6, densities.as_mut_ptr(), 4) };
    assert_eq!(status, COVBEAM_OK);
    let status = unsafe { covbeam_film_picture(film, 0, 6, pixels.as_mut_ptr(), 32) };
    assert_eq!((status, pixels.to_vec()), (COVBEAM_OK, before));
    assert_eq!(pixels[5].radiance, [4.0; 3]);
    // As wide a filter as a picture of 3 x 2 has, 0.15 pixels, is as good as none.
    assert_eq!(densities, [1.0; 6]);
    unsafe { covbeam_film_free(film) };
}

unsafe extern "C" fn refuse(rounds: *mut c_void) -> i32 {
    let rounds = unsafe { &mut *rounds.cast::<u32>() };
    *rounds = rounds.wrapping_sub(1);
    i32::from(*rounds == 0)
}

#[test]
fn a_stopped_call_leaves_the_film_as_it_was() {
    let film = made(9, 7, &[]);
    add(film, 1, &SMOOTH, &full(9, 7, |i| i as f32, None));
    for rounds in 1_u32..3 {
        let mut left = rounds;
        let user = (&raw mut left).cast();
        assert_eq!(unsafe { covbeam_film_verify(film, Some(refuse), user) }, COVBEAM_CANCELLED);
        let mut pixels = [NO_PIXEL; 63];
        let status = unsafe { covbeam_film_picture(film, 0, 63, pixels.as_mut_ptr(), 32) };
        assert_eq!((status, pixels), (COVBEAM_WRONG_ORDER, [NO_PIXEL; 63]));
    }
    let (mut once, count) = (1_u32, node_count(film));
    let user = (&raw mut once).cast();
    let status = unsafe { covbeam_film_plan(film, 2, 0.1, 1, count, &SMOOTH, 0, Some(refuse), user) };
    assert_eq!(status, COVBEAM_CANCELLED);
    assert_eq!(unsafe { covbeam_film_add(film, 0, ptr::null(), 0) }, COVBEAM_WRONG_ORDER);
    unsafe { covbeam_film_free(film) };
}

#[test]
fn a_filter_stays_in_its_region_and_light_from_beyond_in_its_pixel() {
    // A near wall to the left of a far one, and light of 1 and of 8 on them; borders at columns 19 and 20.
    let depths: Vec<f32> = (0..40 * 32).map(|i| if i % 40 < 20 { 1.0 } else { 5.0 }).collect();
    let mut labels = vec![NO_LABEL; depths.len()];
    let status =
        unsafe { covbeam_film_regions(40, 32, depths.len(), depths.as_ptr(), 4, labels.as_mut_ptr(), 4) };
    assert_eq!((status, &labels[17..23]), (COVBEAM_OK, &[1, 1, 0, 0, 22, 22][..]));
    let film = made(40, 32, &labels);
    let light = |i: u32| if i % 40 < 20 { 1.0 } else { 8.0 };
    for pass in 1..5 {
        let mut rays = full(40, 32, light, Some(0.0));
        // A ray in three for the fog, but at the border; and a bright spot beyond it.
        for (i, ray) in rays.iter_mut().enumerate() {
            ray.has_volume = u32::from(i % 3 == pass % 3 || labels[i] == 0);
            ray.rest = [if i == 40 * 9 + 5 { 100.0 } else { 0.0 }; 3];
        }
        add(film, pass as u32, &SMOOTH, &rays);
    }
    for (i, pixel) in picture(film, 40 * 32).iter().enumerate() {
        // The light of each side is the same everywhere: what comes out is that, to the rounding of sums and of shares between nodes.
        let expected = light(i as u32);
        assert!((pixel.volume[1] / expected - 1.0).abs() < 1e-5, "{i}: {:?}", pixel.volume);
        let beyond = pixel.radiance[1] - pixel.volume[1];
        assert!((beyond - if i == 40 * 9 + 5 { 100.0 } else { 0.0 }).abs() < 1e-4, "{i}: {beyond}");
    }
    unsafe { covbeam_film_free(film) };
}

#[test]
fn the_order_of_passes_and_rays_does_not_count_and_rows_are_those_of_the_whole() {
    let (width, height) = (21_u32, 18_u32);
    let count = (width * height) as usize;
    let passes: Vec<(u32, Vec<_>)> = (1..4)
        .map(|pass| {
            (pass, full(width, height, |i| 0.1 * ((i * i + pass) % 17) as f32, Some(0.3 * pass as f32)))
        })
        .collect();
    let (forth, back) = (made(width, height, &[]), made(width, height, &[]));
    for (pass, rays) in &passes {
        add(forth, *pass, &SMOOTH, rays);
    }
    for (pass, rays) in passes.iter().rev() {
        let turned: Vec<_> = rays.iter().rev().copied().collect();
        add(back, *pass, &SMOOTH, &turned);
    }
    let whole = picture(forth, count);
    assert_eq!(whole, picture(back, count));
    let mut rows = padded(&[NO_PIXEL; 21 * 10]);
    let stride = size_of_val(&rows[0]);
    for (first, number) in [(0, 8), (8, 8), (8, 10), (16, 2)] {
        let pixels = &mut rows[..number * 21];
        let to = &raw mut pixels[0].value;
        let status = unsafe { covbeam_film_picture(forth, first, number * 21, to, stride) };
        assert_eq!(status, COVBEAM_OK);
        assert_eq!(values(pixels), &whole[first as usize * 21..][..number * 21]);
    }
    // Errors of rows that are two away from the ends of a part.
    let (mut all, mut part) = (vec![UNTOUCHED; count], padded(&[UNTOUCHED; 21 * 10]));
    let step = size_of_val(&part[0]);
    let statuses = unsafe {
        [
            covbeam_film_errors(width, height, count, whole.as_ptr(), 32, all.as_mut_ptr(), 4),
            covbeam_film_errors(width, 10, 210, whole[4 * 21..].as_ptr(), 32, &mut part[0].value, step),
        ]
    };
    assert_eq!(statuses, [COVBEAM_OK; 2]);
    assert_eq!(values(&part)[2 * 21..8 * 21], all[6 * 21..12 * 21]);
    unsafe {
        covbeam_film_free(forth);
        covbeam_film_free(back);
    }
}
