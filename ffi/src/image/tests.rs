//! Tests of spectra and filters of the picture: what is refused, and one by hand.
#![allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]

use super::filter::{covbeam_image_filter, covbeam_image_filters_density, covbeam_image_spectra_filter};
use super::mask::covbeam_pixel_threshold_many;
use super::spectrum::{covbeam_image_spectra_along, covbeam_image_spectrum, covbeam_pixel_step};
use crate::eye_ray::covbeam_eye_ray;
use crate::grid::deposit::covbeam_grid_deposit_spectra;
use crate::grid::handle::{covbeam_grid, covbeam_grid_free, covbeam_grid_new};
use crate::grid::look_up::covbeam_grid_resolve;
use crate::hostile::{Rule, Rule::*, UNTOUCHED, refuses};
use crate::medium::samples::{fog, haze, smoke};
use crate::spectrum::covbeam_spectrum;
use crate::status::covbeam_status::*;
use crate::voxels::covbeam_grid_layout;
use core::ptr;

const NO_SPECTRUM: covbeam_image_spectrum =
    covbeam_image_spectrum { xx: UNTOUCHED, xy: UNTOUCHED, yy: UNTOUCHED, weight: UNTOUCHED };
const NO_FILTER: covbeam_image_filter = covbeam_image_filter { xx: UNTOUCHED, xy: UNTOUCHED, yy: UNTOUCHED };

/// One voxel of 1 m with a variance of its own on each axis.
fn lit() -> *mut covbeam_grid {
    let layout = covbeam_grid_layout { min: [0.0; 3], max: [1.0; 3], cells: [1; 3] };
    let spectrum = covbeam_spectrum { xx: 4.0, yy: 9.0, zz: 1.0, xy: 0.5, xz: 0.0, yz: 0.0 };
    let mut grid = ptr::null_mut();
    unsafe {
        assert_eq!(covbeam_grid_new(&layout, &mut grid), COVBEAM_OK);
        let middle = [0.5_f32; 3];
        let status = covbeam_grid_deposit_spectra(grid, 1, middle.as_ptr(), 0, &spectrum, 0, &1.0, 0);
        assert_eq!(status, COVBEAM_OK);
        assert_eq!(covbeam_grid_resolve(grid), COVBEAM_OK);
    }
    grid
}

/// Along z through the voxel; a pixel is 0.1 m to the right and 0.2 m down, wherever it is.
const RAY: covbeam_eye_ray =
    covbeam_eye_ray { origin: [0.5, 0.5, -1.0], direction: [0.0, 0.0, 1.0], length: 9.0 };
const STEPS: [covbeam_pixel_step; 2] = [
    covbeam_pixel_step { origin: [0.1, 0.0, 0.0], direction: [0.0; 3] },
    covbeam_pixel_step { origin: [0.0, 0.2, 0.0], direction: [0.0; 3] },
];

#[test]
fn a_bad_argument_is_refused_and_nothing_is_written() {
    let (grid, smoke) = (lit(), smoke());
    let step = [(0.1, Finite); 6];
    let ray: [(f32, Rule); 7] = [
        (0.5, Finite),
        (0.5, Finite),
        (-1.0, Finite),
        (0.0, Across),
        (0.0, Across),
        (1.0, Along),
        (9.0, NotNegative),
    ];
    for medium in [fog(), haze(), smoke.medium] {
        refuses(5, &[&ray[..], &step, &step].concat(), |bad, n| {
            let mut out = NO_SPECTRUM;
            let status = unsafe {
                covbeam_image_spectra_along(
                    bad.at(0, grid),
                    bad.at(1, &medium),
                    1,
                    bad.at(2, n.as_ptr()).cast(),
                    0,
                    bad.at(3, n[7..].as_ptr()).cast(),
                    0,
                    bad.at_mut(4, &mut out),
                    0,
                )
            };
            (status, out != NO_SPECTRUM)
        });
    }
    let numbers = [
        (4.0, Finite),
        (0.5, Finite),
        (9.0, Finite),
        (1.0, FiniteNotNegative),
        (0.1, Positive),
        (50.0, Positive),
    ];
    refuses(2, &numbers, |bad, n| {
        let mut out = NO_FILTER;
        let spectrum = bad.at(0, n.as_ptr()).cast();
        let to = bad.at_mut(1, &mut out);
        let status = unsafe { covbeam_image_spectra_filter(1, spectrum, 0, &n[4], 0, &n[5], 0, to, 0) };
        (status, out != NO_FILTER)
    });
    refuses(2, &[(4.0, FiniteNotNegative), (0.5, Finite), (9.0, FiniteNotNegative)], |bad, n| {
        let mut out = UNTOUCHED;
        let to = bad.at_mut(1, &mut out);
        let status = unsafe { covbeam_image_filters_density(1, bad.at(0, n.as_ptr()).cast(), 0, to, 0) };
        (status, out != UNTOUCHED)
    });
    refuses(2, &[], |bad, _| {
        let (pixel, mut out) = ([3_u32, 4], UNTOUCHED);
        let to = bad.at_mut(1, &mut out);
        let status = unsafe { covbeam_pixel_threshold_many(1, 2, 1, bad.at(0, pixel.as_ptr()), 0, to, 0) };
        (status, out != UNTOUCHED)
    });
    unsafe { covbeam_grid_free(grid) };
}

#[test]
fn the_spectrum_of_a_pixel_is_the_grids_in_pixels() {
    let grid = lit();
    let mut found = NO_SPECTRUM;
    let status =
        unsafe { covbeam_image_spectra_along(grid, &fog(), 1, &RAY, 0, STEPS.as_ptr(), 0, &mut found, 0) };
    assert_eq!(status, COVBEAM_OK);
    // 4 x 0.1^2, 0.5 x 0.1 x 0.2, 9 x 0.2^2, to a few roundings.
    for (found, expected) in [(found.xx, 0.04), (found.xy, 0.01), (found.yy, 0.36)] {
        assert!((found / expected - 1.0_f32).abs() < 1e-5, "{found} for {expected}");
    }
    assert!(found.weight > 0.0);
    // An error of 1 and the covariance matrix is inverted: det = 0.0143.
    let mut filter = NO_FILTER;
    assert_eq!(
        unsafe { covbeam_image_spectra_filter(1, &found, 0, &1.0, 0, &1e3, 0, &mut filter, 0) },
        COVBEAM_OK
    );
    let scale = 1.0 / (4.0 * core::f32::consts::PI.powi(2) * 0.0143);
    for (found, expected) in [(filter.xx, 0.36), (filter.xy, -0.01), (filter.yy, 0.04)] {
        assert!((found / (scale * expected) - 1.0).abs() < 1e-4, "{found} for {expected}");
    }
    unsafe { covbeam_grid_free(grid) };
}

#[test]
fn a_grid_that_is_not_resolved_comes_too_early() {
    let layout = covbeam_grid_layout { min: [0.0; 3], max: [1.0; 3], cells: [2; 3] };
    let (mut grid, mut out) = (ptr::null_mut(), NO_SPECTRUM);
    let statuses = unsafe {
        [
            covbeam_grid_new(&layout, &mut grid),
            covbeam_image_spectra_along(grid, &fog(), 1, &RAY, 0, STEPS.as_ptr(), 0, &mut out, 0),
        ]
    };
    assert_eq!((statuses, out), ([COVBEAM_OK, COVBEAM_WRONG_ORDER], NO_SPECTRUM));
    unsafe { covbeam_grid_free(grid) };
}
