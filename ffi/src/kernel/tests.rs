//! Tests of kernels: what is refused, and that a schedule is its parts.
#![allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]

use super::options::{covbeam_kernel, read_kernel};
use super::radius::{covbeam_kernel_radius_at_many, covbeam_kernel_radius_from_error};
use super::schedule::{
    covbeam_error_bound, covbeam_progressive_radius, covbeam_schedule, covbeam_schedule_kernel,
};
use super::shape::{covbeam_kernel_evaluate, covbeam_kernel_second_moment};
use crate::grid::handle::{covbeam_grid_free, covbeam_grid_new};
use crate::hostile::{Rule::*, UNTOUCHED, message, refuses};
use crate::status::covbeam_status::*;
use crate::voxels::covbeam_grid_layout;
use core::ptr;

const SIZE: u32 = size_of::<covbeam_kernel>() as u32;
const BLANK: covbeam_kernel = covbeam_kernel {
    struct_size: SIZE,
    shape: 9,
    min_radius: UNTOUCHED,
    max_radius: UNTOUCHED,
    error: UNTOUCHED,
};

fn schedule() -> covbeam_schedule {
    let struct_size = size_of::<covbeam_schedule>() as u32;
    covbeam_schedule { struct_size, shape: 1, radius: 0.1, alpha: 0.5, max_radius: 0.2, error: 0.02 }
}

#[test]
fn a_bad_argument_is_refused_and_nothing_is_written() {
    let numbers = [(0.5, Positive), (0.5, Alpha), (0.5, Positive), (0.5, Positive)];
    refuses(2, &numbers, |bad, n| {
        let schedule =
            covbeam_schedule { radius: n[0], alpha: n[1], max_radius: n[2], error: n[3], ..schedule() };
        let mut out = BLANK;
        let status = unsafe { covbeam_schedule_kernel(bad.at(0, &schedule), 1, bad.at_mut(1, &mut out)) };
        (status, out != BLANK)
    });
    refuses(1, &[(0.5, Positive), (0.5, Alpha)], |bad, n| {
        let mut out = UNTOUCHED;
        let status = unsafe { covbeam_progressive_radius(n[0], n[1], 3, bad.at_mut(0, &mut out)) };
        (status, out != UNTOUCHED)
    });
    refuses(1, &[(0.5, Positive)], |bad, n| {
        let mut out = UNTOUCHED;
        let status = unsafe { covbeam_error_bound(n[0], 3, bad.at_mut(0, &mut out)) };
        (status, out != UNTOUCHED)
    });
    refuses(1, &[(0.5, Finite), (0.75, Positive)], |bad, n| {
        let mut out = UNTOUCHED;
        let status = unsafe { covbeam_kernel_evaluate(2, n[0], n[1], bad.at_mut(0, &mut out)) };
        (status, out != UNTOUCHED)
    });
    refuses(1, &[], |bad, _| {
        let mut out = UNTOUCHED;
        (unsafe { covbeam_kernel_second_moment(2, bad.at_mut(0, &mut out)) }, out != UNTOUCHED)
    });
    refuses(1, &[(0.5, Positive), (0.75, NotNegative)], |bad, n| {
        let mut out = UNTOUCHED;
        let status = unsafe { covbeam_kernel_radius_from_error(2, n[0], n[1], bad.at_mut(0, &mut out)) };
        (status, out != UNTOUCHED)
    });
    // Position, axis, kernel. A max_radius below the progressive radius is refused; so is a radius above the max_radius.
    let numbers = [
        (0.2, Finite),
        (0.3, Finite),
        (0.4, Finite),
        (0.0, Across),
        (1.0, Along),
        (0.0, Across),
        (0.75, From(0.75)),
        (0.5, Positive),
    ];
    refuses(5, &numbers, |bad, n| {
        let kernel = covbeam_kernel { shape: 0, min_radius: 0.75, max_radius: n[6], error: n[7], ..BLANK };
        let (mut radius, mut sigma) = (UNTOUCHED, UNTOUCHED);
        let status = unsafe {
            covbeam_kernel_radius_at_many(
                bad.at(0, &kernel),
                ptr::null(),
                1,
                bad.at(1, n.as_ptr()),
                0,
                bad.at(2, n[3..].as_ptr()),
                0,
                bad.at_mut(3, &mut radius),
                0,
                bad.at_mut(4, &mut sigma),
                0,
            )
        };
        (status, (radius, sigma) != (UNTOUCHED, UNTOUCHED))
    });
    for min_radius in [f32::NAN, f32::INFINITY, 0.0, -1.0, 2.5] {
        let kernel = covbeam_kernel { shape: 0, min_radius, max_radius: 2.0, error: 0.1, ..BLANK };
        let refused = unsafe { read_kernel(&kernel, ptr::null()) }.map(|_| ()).map_err(|failure| failure.0);
        assert_eq!(refused, Err(COVBEAM_INVALID_VALUE), "{min_radius}");
    }
}

#[test]
fn an_unknown_shape_and_a_pass_0_are_refused() {
    let mut out = UNTOUCHED;
    let mut kernel = BLANK;
    let bad_shape = covbeam_schedule { shape: 3, ..schedule() };
    let statuses = unsafe {
        [
            covbeam_kernel_evaluate(3, 0.0, 1.0, &mut out),
            covbeam_kernel_second_moment(u32::MAX, &mut out),
            covbeam_kernel_radius_from_error(3, 0.1, 1.0, &mut out),
            covbeam_progressive_radius(1.0, 0.5, 0, &mut out),
            covbeam_error_bound(1.0, 0, &mut out),
            covbeam_schedule_kernel(&schedule(), 0, &mut kernel),
            covbeam_schedule_kernel(&bad_shape, 1, &mut kernel),
        ]
    };
    assert_eq!(statuses, [COVBEAM_INVALID_VALUE; 7]);
    assert_eq!((out, kernel), (UNTOUCHED, BLANK));
}

#[test]
fn a_radius_that_shrinks_to_nothing_is_refused() {
    let tiny = covbeam_schedule { radius: 1e-45, ..schedule() };
    let mut kernel = BLANK;
    assert_eq!(unsafe { covbeam_schedule_kernel(&tiny, 1000, &mut kernel) }, COVBEAM_INVALID_VALUE);
    assert_eq!(kernel, BLANK);
}

#[test]
fn a_struct_of_another_size_is_known_by_what_it_says() {
    #[repr(C)]
    struct Later {
        now: covbeam_schedule,
        option: u32,
    }
    let later = |size: usize, option| Later {
        now: covbeam_schedule { struct_size: size as u32, ..schedule() },
        option,
    };
    let full = size_of::<Later>();
    for (later, expected) in [
        (later(full, 0), COVBEAM_OK),
        (later(full, 1), COVBEAM_INVALID_VALUE),
        (later(0, 0), COVBEAM_INVALID_VALUE),
        (later(size_of::<covbeam_schedule>() - 1, 0), COVBEAM_INVALID_VALUE),
        (later(5000, 0), COVBEAM_INVALID_VALUE),
    ] {
        let mut kernel = BLANK;
        let status = unsafe { covbeam_schedule_kernel((&raw const later).cast(), 1, &mut kernel) };
        assert_eq!((status, kernel != BLANK), (expected, expected == COVBEAM_OK));
    }
    for struct_size in [0, SIZE - 1, 5000] {
        let before = covbeam_kernel { struct_size, ..BLANK };
        let mut kernel = before;
        assert_eq!(unsafe { covbeam_schedule_kernel(&schedule(), 1, &mut kernel) }, COVBEAM_INVALID_VALUE);
        assert_eq!(kernel, before);
    }
}

#[test]
fn a_schedule_makes_the_kernel_of_its_parts() {
    let mut kernel = BLANK;
    let (mut radius, mut error) = (UNTOUCHED, UNTOUCHED);
    let statuses = unsafe {
        [
            covbeam_schedule_kernel(&schedule(), 7, &mut kernel),
            covbeam_progressive_radius(0.1, 0.5, 7, &mut radius),
            covbeam_error_bound(0.02, 7, &mut error),
        ]
    };
    assert_eq!(statuses, [COVBEAM_OK; 3]);
    let expected = covbeam_kernel { shape: 1, min_radius: radius, max_radius: 0.2, error, ..BLANK };
    assert_eq!(kernel, expected);
    // A progressive radius that is larger than the largest wanted one is the max_radius itself.
    let wide = covbeam_schedule { max_radius: 0.01, ..schedule() };
    assert_eq!(unsafe { covbeam_schedule_kernel(&wide, 7, &mut kernel) }, COVBEAM_OK);
    assert_eq!(kernel, covbeam_kernel { max_radius: radius, ..expected });
}

#[test]
fn a_grid_that_is_not_resolved_comes_too_early() {
    let layout = covbeam_grid_layout { min: [0.0; 3], max: [1.0; 3], cells: [2; 3] };
    let mut grid = ptr::null_mut();
    assert_eq!(unsafe { covbeam_grid_new(&layout, &mut grid) }, COVBEAM_OK);
    let kernel = covbeam_kernel { shape: 1, min_radius: 0.1, max_radius: 0.2, error: 0.1, ..BLANK };
    let (position, axis) = ([0.5; 3], [1.0, 0.0, 0.0]);
    let (mut radius, mut sigma) = (UNTOUCHED, UNTOUCHED);
    let status = unsafe {
        covbeam_kernel_radius_at_many(
            &kernel,
            grid,
            1,
            position.as_ptr(),
            0,
            axis.as_ptr(),
            0,
            &mut radius,
            0,
            &mut sigma,
            0,
        )
    };
    assert_eq!((status, radius, sigma), (COVBEAM_WRONG_ORDER, UNTOUCHED, UNTOUCHED));
    assert!(message().contains("covbeam_grid_resolve"));
    unsafe { covbeam_grid_free(grid) };
}
