//! Tests of pairs: what is refused, and that many are the bits of one each.
#![allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]

use super::cross::{covbeam_cross_many, covbeam_crossing};
use super::filter::covbeam_filter_beams;
use super::gather::covbeam_gather_pairs;
use crate::beam::covbeam_beam;
use crate::eye_ray::{covbeam_eye_ray, covbeam_gathered};
use crate::hostile::{Rule, Rule::*, UNTOUCHED, message, padded, refuses, values};
use crate::kernel::options::covbeam_kernel;
use crate::medium::column::{covbeam_column, covbeam_medium_column};
use crate::medium::knots::{covbeam_knot, covbeam_medium_tabulate};
use crate::medium::samples::{Smoke, fog, haze, smoke};
use crate::status::covbeam_status::*;
use core::ptr;
use covbeam_core::Column;

const Z: [f32; 3] = [0.0, 0.0, 1.0];

fn ray_of(n: &[f32]) -> covbeam_eye_ray {
    covbeam_eye_ray { origin: [n[0], n[1], n[2]], direction: [n[3], n[4], n[5]], length: n[6] }
}

fn beam_of(n: &[f32]) -> covbeam_beam {
    let three = |i: usize| [n[i], n[i + 1], n[i + 2]];
    covbeam_beam {
        origin: three(0),
        direction: three(3),
        length: n[6],
        power: three(7),
        start_normal: three(10),
        end_normal: three(13),
    }
}

/// Along z, through the middle of the unit cube.
const RAY: [(f32, Rule); 7] = [
    (0.4, Finite),
    (0.5, Finite),
    (-1.0, Finite),
    (0.0, Across),
    (0.0, Across),
    (1.0, Along),
    (3.0, NotNegative),
];

/// Along x, past it.
const BEAM: [(f32, Rule); 16] = [
    (-1.0, Finite),
    (0.55, Finite),
    (0.4, Finite),
    (1.0, Along),
    (0.0, Across),
    (0.0, Across),
    (3.0, FiniteNotNegative),
    (1.0, Finite),
    (2.0, Finite),
    (3.0, Finite),
    (1.0, Along0),
    (0.0, Across),
    (0.0, Across),
    // None, or a unit vector.
    (0.0, Along0),
    (0.0, Along0),
    (0.0, Along0),
];

fn plain(numbers: &[(f32, Rule)]) -> Vec<f32> {
    numbers.iter().map(|(value, _)| *value).collect()
}

fn ray() -> covbeam_eye_ray {
    ray_of(&plain(&RAY))
}

/// Beams at many heights and slants: some near the ray, some far, one along it.
fn beams() -> Vec<covbeam_beam> {
    let good = beam_of(&plain(&BEAM));
    (0..19)
        .map(|i| {
            let i = i as f32;
            let (sine, cosine) = (0.1 * i - 0.9).sin_cos();
            let origin = [-1.0, 0.3 + 0.02 * i, 0.1 * i - 0.5];
            let direction = if i == 7.0 { Z } else { [cosine, 0.0, sine] };
            covbeam_beam { origin, direction, start_normal: [0.0; 3], ..good }
        })
        .collect()
}

fn kernel() -> covbeam_kernel {
    let struct_size = size_of::<covbeam_kernel>() as u32;
    covbeam_kernel { struct_size, shape: 1, min_radius: 0.1, max_radius: 0.1, error: 0.1 }
}

const NOTHING: covbeam_gathered =
    covbeam_gathered { radiance: [0.0; 3], pairs: 0, weight: 0.0, radius: 0.0, sigma: 0.0 };

/// The column from an origin through the smoke; its knots are never freed.
fn column_in(smoke: &Smoke, origin: [f32; 3], direction: [f32; 3]) -> covbeam_column {
    let (o, d) = (origin.as_ptr(), direction.as_ptr());
    let knots = Box::leak(Box::new([covbeam_knot { distance: 0.0, column: 0.0 }; 400]));
    let (mut count, mut column) = (0, covbeam_column::from(Column::Uniform));
    let statuses = unsafe {
        [
            covbeam_medium_tabulate(&smoke.medium, o, d, 9.0, knots.as_mut_ptr(), 400, &mut count),
            covbeam_medium_column(&smoke.medium, o, d, knots.as_ptr(), count, &mut column),
        ]
    };
    assert_eq!(statuses, [COVBEAM_OK; 2]);
    column
}

#[test]
fn a_bad_argument_of_a_crossing_is_refused_and_nothing_is_written() {
    let none = covbeam_crossing {
        ray_distance: UNTOUCHED,
        beam_distance: UNTOUCHED,
        gap: UNTOUCHED,
        sin_theta: UNTOUCHED,
        axis: [UNTOUCHED; 3],
    };
    refuses(4, &[&RAY[..], &BEAM[..]].concat(), |bad, n| {
        let (ray, beam) = (ray_of(n), beam_of(&n[7..]));
        let (mut crossing, mut crosses) = (none, 77);
        let status = unsafe {
            let to = bad.at_mut(2, &mut crossing);
            covbeam_cross_many(bad.at(0, &ray), 1, bad.at(1, &beam), 0, to, 0, bad.at_mut(3, &mut crosses), 0)
        };
        (status, crosses != 77 || crossing.gap.to_bits() != UNTOUCHED.to_bits())
    });
    let along = covbeam_beam { direction: Z, ..beams()[0] };
    let (mut crossing, mut crosses) = (none, 77);
    let status = unsafe { covbeam_cross_many(&ray(), 1, &along, 0, &mut crossing, 0, &mut crosses, 0) };
    assert_eq!((status, crossing, crosses), (COVBEAM_OK, none, 0));
}

#[test]
fn a_bad_argument_of_a_pair_is_refused_and_nothing_is_written() {
    let smoke = smoke();
    let rest = [
        (0.0, NotNegative),
        (3.0, NotNegative),
        (0.5, Finite),
        (0.5, Finite),
        (0.5, Finite),
        (0.5, Finite),
        (0.5, Finite),
        (0.5, Finite),
    ];
    let numbers = [&RAY[..], &BEAM[..], &rest[..]].concat();
    let ray_column = column_in(&smoke, ray().origin, Z);
    let beam_column = column_in(&smoke, [-1.0, 0.55, 0.4], [1.0, 0.0, 0.0]);
    // The columns may be NULL in the first two media, but not misaligned.
    for (medium, pointers) in [(fog(), 6), (haze(), 6), (smoke.medium, 8)] {
        refuses(pointers, &numbers, |bad, n| {
            let (ray, beam, kernel) = (ray_of(n), beam_of(&n[7..]), kernel());
            let before = covbeam_gathered {
                radiance: [n[25], n[26], n[27]],
                pairs: 1,
                weight: n[28],
                radius: n[29],
                sigma: n[30],
            };
            let (mut gathered, mut accepted) = (before, 77);
            let status = unsafe {
                covbeam_gather_pairs(
                    bad.at(0, &ray),
                    1,
                    bad.at(1, &beam),
                    0,
                    &n[23],
                    0,
                    &n[24],
                    0,
                    bad.at(2, &medium),
                    bad.at(6, &ray_column),
                    bad.at(7, &beam_column),
                    0,
                    bad.at(3, &kernel),
                    ptr::null(),
                    bad.at_mut(4, &mut gathered),
                    bad.at_mut(5, &mut accepted),
                    0,
                )
            };
            (status, accepted != 77 || gathered.pairs != 1)
        });
    }
    let mut full = covbeam_gathered { pairs: u32::MAX, ..NOTHING };
    let mut accepted = 77;
    let status = unsafe {
        let none = ptr::null();
        let (ray, beam) = (ray(), beam_of(&plain(&BEAM)));
        covbeam_gather_pairs(
            &ray,
            1,
            &beam,
            0,
            &0.0,
            0,
            &3.0,
            0,
            &fog(),
            none,
            none,
            0,
            &kernel(),
            ptr::null(),
            &mut full,
            &mut accepted,
            0,
        )
    };
    assert_eq!((status, full.pairs, accepted), (COVBEAM_INVALID_VALUE, u32::MAX, 77));
}

#[test]
fn a_bad_argument_of_the_filter_is_refused_and_nothing_is_written() {
    refuses(3, &[&RAY[..], &BEAM[..], &[(0.1, Positive)]].concat(), |bad, n| {
        let (ray, beam, mut mask) = (ray_of(n), beam_of(&n[7..]), 77);
        let to = bad.at_mut(2, &mut mask);
        let status = unsafe { covbeam_filter_beams(bad.at(0, &ray), 1, bad.at(1, &beam), 0, n[23], to, 0) };
        (status, mask != 77)
    });
}

#[test]
fn many_are_the_same_bits_as_one_each_and_the_filter_keeps_all_that_count() {
    let smoke = smoke();
    let beams = padded(&beams());
    let stride = size_of_val(&beams[0]);
    let count = beams.len();
    let none = ptr::null::<covbeam_column>();
    let ray_column = column_in(&smoke, ray().origin, Z);
    let beam_columns: Vec<_> =
        values(&beams).iter().map(|beam| column_in(&smoke, beam.origin, beam.direction)).collect();
    let mut masks = padded(&vec![77_u8; count]);
    let status =
        unsafe { covbeam_filter_beams(&ray(), count, &beams[0].value, stride, 0.1, &mut masks[0].value, 16) };
    assert_eq!(status, COVBEAM_OK);
    for medium in [fog(), haze(), smoke.medium] {
        let voxels = medium.density == smoke.medium.density;
        let mut all = NOTHING;
        let mut accepted = vec![77_u8; count];
        let (r, b) = if voxels { (&raw const ray_column, beam_columns.as_ptr()) } else { (none, none) };
        let status = unsafe {
            covbeam_gather_pairs(
                &ray(),
                count,
                &beams[0].value,
                stride,
                &0.0,
                0,
                &f32::INFINITY,
                0,
                &medium,
                r,
                b,
                size_of::<covbeam_column>(),
                &kernel(),
                ptr::null(),
                &mut all,
                accepted.as_mut_ptr(),
                1,
            )
        };
        assert_eq!(status, COVBEAM_OK);
        let mut sum = NOTHING;
        for (i, beam) in values(&beams).iter().enumerate() {
            let mut one = 77;
            let status = unsafe {
                let along = if voxels { &raw const beam_columns[i] } else { none };
                let (ray, kernel) = (ray(), kernel());
                covbeam_gather_pairs(
                    &ray,
                    1,
                    beam,
                    0,
                    &0.0,
                    0,
                    &f32::INFINITY,
                    0,
                    &medium,
                    r,
                    along,
                    0,
                    &kernel,
                    ptr::null(),
                    &mut sum,
                    &mut one,
                    0,
                )
            };
            assert_eq!((status, one), (COVBEAM_OK, accepted[i]));
            assert!(one == 0 || values(&masks)[i] == 1, "the filter loses beam {i}");
        }
        assert_eq!(sum, all);
        assert!(all.pairs > 0 && all.radiance[0] > 0.0);
    }
    let passed = values(&masks).iter().filter(|mask| **mask == 1).count();
    assert!(passed > 0 && passed < count, "{passed} of {count}");
}

#[test]
fn many_crossings_are_the_same_bits_as_one_each() {
    let beams = beams();
    let none = covbeam_crossing {
        ray_distance: UNTOUCHED,
        beam_distance: UNTOUCHED,
        gap: UNTOUCHED,
        sin_theta: UNTOUCHED,
        axis: [UNTOUCHED; 3],
    };
    let mut crossings = padded(&vec![none; beams.len()]);
    let mut crosses = vec![77_u8; beams.len()];
    let stride = size_of_val(&crossings[0]);
    let status = unsafe {
        let (from, size) = (beams.as_ptr(), size_of::<covbeam_beam>());
        let to = &raw mut crossings[0].value;
        covbeam_cross_many(&ray(), beams.len(), from, size, to, stride, crosses.as_mut_ptr(), 1)
    };
    assert_eq!(status, COVBEAM_OK);
    for (i, found) in values(&crossings).into_iter().enumerate() {
        let (mut one, mut flag) = (none, 77);
        let status = unsafe { covbeam_cross_many(&ray(), 1, &beams[i], 0, &mut one, 0, &mut flag, 0) };
        assert_eq!((status, one, flag), (COVBEAM_OK, found, crosses[i]));
    }
    assert_eq!((crosses[7], crosses[0]), (0, 1));
}

#[test]
fn voxels_without_columns_are_refused_with_the_remedy() {
    let smoke = smoke();
    let (mut gathered, mut accepted) = (NOTHING, 77);
    let column = column_in(&smoke, ray().origin, Z);
    let (r, none) = (&raw const column, ptr::null());
    for (ray_column, beam_column) in [(none, r), (r, none), (none, none)] {
        let status = unsafe {
            let (ray, beam, kernel) = (ray(), beam_of(&plain(&BEAM)), kernel());
            covbeam_gather_pairs(
                &ray,
                1,
                &beam,
                0,
                &0.0,
                0,
                &3.0,
                0,
                &smoke.medium,
                ray_column,
                beam_column,
                0,
                &kernel,
                ptr::null(),
                &mut gathered,
                &mut accepted,
                0,
            )
        };
        assert_eq!((status, gathered, accepted), (COVBEAM_NULL_POINTER, NOTHING, 77));
        assert!(message().contains("covbeam_medium_column"));
    }
}
