//! Tests of marches: what is refused, and that two rounds find a shadow.
#![allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]

use super::expected::{covbeam_march_expected, covbeam_march_get_expected, covbeam_march_get_first_round};
use super::handle::{covbeam_march, covbeam_march_free, covbeam_march_new, covbeam_march_update};
use super::knots::{covbeam_march_knot, covbeam_march_lay};
use super::rounds::{covbeam_march_place, covbeam_march_refine, covbeam_march_sample};
use crate::hostile::{Rule, Rule::*, UNTOUCHED, padded, refuses, values};
use crate::status::covbeam_status::*;
use core::ptr;

const NO_KNOT: covbeam_march_knot = covbeam_march_knot {
    distance: UNTOUCHED,
    radiance: UNTOUCHED,
    deviation: UNTOUCHED,
    visibility: UNTOUCHED,
};
const NO_SAMPLE: covbeam_march_sample = covbeam_march_sample {
    distance: UNTOUCHED,
    weight: UNTOUCHED,
    visibility: UNTOUCHED,
    reserved: 9,
    mass: -7.25,
};

fn empty() -> *mut covbeam_march {
    let mut march = ptr::null_mut();
    assert_eq!(unsafe { covbeam_march_new(&mut march) }, COVBEAM_OK);
    march
}

/// As much light everywhere on 4 m of ray, all of which is expected to arrive.
fn even() -> *mut covbeam_march {
    let knots = [1.0, 2.0, 5.0].map(|distance| covbeam_march_knot {
        distance,
        radiance: 0.5,
        visibility: 1.0,
        ..NO_KNOT
    });
    let march = empty();
    assert_eq!(unsafe { covbeam_march_update(march, 3, knots.as_ptr(), 16) }, COVBEAM_OK);
    march
}

#[test]
fn a_bad_argument_is_refused_and_nothing_is_written() {
    refuses(4, &[(0.0, Across), (0.0, Across), (1.0, Along)], |bad, n| {
        let (origin, light, mut knots) = ([0.1, 0.2, 0.3], [0.4, 0.5, 0.6], [NO_KNOT; 5]);
        let (origin, direction) = (bad.at(0, origin.as_ptr()), bad.at(1, n.as_ptr()));
        let (light, to) = (bad.at(2, light.as_ptr()), bad.at_mut(3, knots.as_mut_ptr()));
        let status = unsafe { covbeam_march_lay(origin, direction, 0.5, 3.0, light, 5, to, 16) };
        (status, knots != [NO_KNOT; 5])
    });
    refuses(1, &[], |bad, _| {
        let mut out = ptr::null_mut();
        let status = unsafe { covbeam_march_new(bad.at_mut(0, &mut out)) };
        let changed = !out.is_null();
        unsafe { covbeam_march_free(out) };
        (status, changed)
    });
    // Of a knot only the distance must be a number: it may not fall, and the next lies at 2e30.
    let numbers: [(f32, Rule); 2] = [(-2.0, Finite), (2e30, From(-2.0))];
    refuses(2, &numbers, |bad, n| {
        let march = even();
        let knot = |distance| covbeam_march_knot { distance, radiance: f32::NAN, ..NO_KNOT };
        let knots = [knot(-2e30), knot(n[0]), knot(n[1])];
        let from = bad.at(1, knots.as_ptr());
        let status = unsafe { covbeam_march_update(bad.at_mut(0, march), 3, from, 16) };
        let changed = expected(march) != 2.0;
        unsafe { covbeam_march_free(march) };
        (status, changed)
    });
    let march = even();
    refuses(2, &[], |bad, _| {
        let none = covbeam_march_expected { radiance: UNTOUCHED, error: 0.0 };
        let mut out = none;
        let to = bad.at_mut(1, &mut out);
        (unsafe { covbeam_march_get_expected(bad.at(0, march), to) }, out != none)
    });
    refuses(2, &[], |bad, _| {
        let mut out = 77;
        let to = bad.at_mut(1, &mut out);
        (unsafe { covbeam_march_get_first_round(bad.at(0, march), 50, to) }, out != 77)
    });
    refuses(3, &[(0.5, Random), (0.25, Random)], |bad, n| {
        let mut out = [NO_SAMPLE; 2];
        let (jitters, to) = (bad.at(1, n.as_ptr()), bad.at_mut(2, out.as_mut_ptr()));
        let status = unsafe { covbeam_march_place(bad.at_mut(0, march), 2, jitters, 4, to, 24) };
        (status, out != [NO_SAMPLE; 2])
    });
    let numbers: [(f32, Rule); 4] =
        [(0.5, Random), (2.0, Finite), (1.0, FiniteNotNegative), (0.5, FiniteNotNegative)];
    refuses(4, &numbers, |bad, n| {
        let first = covbeam_march_sample {
            distance: n[1],
            weight: n[2],
            visibility: 0.5,
            reserved: 0,
            mass: f64::from(n[3]),
        };
        let mut out = [NO_SAMPLE; 2];
        let (firsts, jitter) = (bad.at(1, &first), bad.at(2, n.as_ptr()));
        let to = bad.at_mut(3, out.as_mut_ptr());
        let status =
            unsafe { covbeam_march_refine(bad.at_mut(0, march), 1, firsts, 0, 2, jitter, 0, to, 24) };
        (status, out != [NO_SAMPLE; 2])
    });
    unsafe { covbeam_march_free(march) };
}

fn expected(march: *mut covbeam_march) -> f32 {
    let mut out = covbeam_march_expected { radiance: 0.0, error: 0.0 };
    assert_eq!(unsafe { covbeam_march_get_expected(march, &mut out) }, COVBEAM_OK);
    out.radiance
}

#[test]
fn a_stretch_that_is_none_and_a_light_beyond_numbers_are_refused() {
    let mut knots = [NO_KNOT; 2];
    let lay = |from, to, light: f32, count, knots: &mut [covbeam_march_knot; 2]| {
        let (origin, direction, light) = ([0.0; 3], [0.0, 0.0, 1.0], [light, 0.0, 0.0]);
        let (o, d, l) = (origin.as_ptr(), direction.as_ptr(), light.as_ptr());
        unsafe { covbeam_march_lay(o, d, from, to, l, count, knots.as_mut_ptr(), 16) }
    };
    for (from, to, light) in [
        (f32::NAN, 1.0, 1.0),
        (f32::NEG_INFINITY, 1.0, 1.0),
        (1.0, 0.5, 1.0),
        (1.0, f32::NAN, 1.0),
        (0.0, 1.0, f32::NAN),
        (0.0, 1.0, 3e38),
    ] {
        assert_eq!(lay(from, to, light, 2, &mut knots), COVBEAM_INVALID_VALUE, "{from} {to} {light}");
    }
    for count in [0, 1] {
        assert_eq!(lay(0.0, 1.0, 1.0, count, &mut knots), COVBEAM_SHORT_BUFFER);
    }
    assert_eq!(knots, [NO_KNOT; 2]);
    assert_eq!(lay(-1.0, f32::INFINITY, 1.0, 2, &mut knots), COVBEAM_OK);
    assert_eq!(knots[0].distance, -1.0);
    assert!(knots[1].distance >= 1000.0 && knots[1].radiance == 0.0 && knots[1].visibility.is_nan());
}

#[test]
fn a_march_without_a_table_comes_too_early() {
    let march = empty();
    let mut expected = covbeam_march_expected { radiance: UNTOUCHED, error: 0.0 };
    let (mut first, mut out) = (77, NO_SAMPLE);
    let statuses = unsafe {
        [
            covbeam_march_get_expected(march, &mut expected),
            covbeam_march_get_first_round(march, 9, &mut first),
            covbeam_march_place(march, 1, &0.5, 0, &mut out, 0),
            covbeam_march_refine(march, 0, ptr::null(), 0, 1, &0.5, 0, &mut out, 0),
        ]
    };
    assert_eq!(statuses, [COVBEAM_WRONG_ORDER; 4]);
    assert_eq!((expected.radiance, first, out), (UNTOUCHED, 77, NO_SAMPLE));
    unsafe { covbeam_march_free(march) };
}

#[test]
fn two_rounds_find_a_shadow_and_measure_it() {
    // Even light on 8 m of which the last 5.3 lie in shadow: 2.7 x 0.5. Laid from far away, knots are even.
    let (origin, direction, light) = ([0.0; 3], [0.0, 0.0, 1.0], [1e4, 0.0, 0.0]);
    let mut knots = padded(&[NO_KNOT; 33]);
    let stride = size_of_val(&knots[0]);
    let march = empty();
    let mut first = padded(&[NO_SAMPLE; 8]);
    let mut second = padded(&[NO_SAMPLE; 24]);
    let sample_stride = size_of_val(&first[0]);
    unsafe {
        let (o, d, l) = (origin.as_ptr(), direction.as_ptr(), light.as_ptr());
        let to = &raw mut knots[0].value;
        assert_eq!(covbeam_march_lay(o, d, 0.0, 8.0, l, 33, to, stride), COVBEAM_OK);
        for knot in &mut knots {
            knot.value.radiance = 0.5;
        }
        assert_eq!(covbeam_march_update(march, 33, &knots[0].value, stride), COVBEAM_OK);
        // Half of it is expected to arrive, where nothing is known.
        assert!((expected(march) - 2.0).abs() < 1e-6);
        let to = &raw mut first[0].value;
        assert_eq!(covbeam_march_place(march, 8, &0.5, 0, to, sample_stride), COVBEAM_OK);
        for sample in &mut first {
            sample.value.visibility = if sample.value.distance < 2.7 { 1.0 } else { 0.0 };
        }
        let (from, to) = (&raw const first[0].value, &raw mut second[0].value);
        let status = covbeam_march_refine(march, 8, from, sample_stride, 24, &0.5, 0, to, sample_stride);
        assert_eq!(status, COVBEAM_OK);
    }
    let seen = |round: &[covbeam_march_sample]| -> f32 {
        round.iter().filter(|s| s.distance < 2.7).map(|s| 0.5 * s.weight).sum()
    };
    // Half a stratum, 0.5 m x 0.5, is what one round can be off by; the second has strata of a fifth at the border.
    assert!((seen(&values(&first)) - 1.35).abs() <= 0.25);
    assert!((seen(&values(&second)) - 1.35).abs() <= 0.05, "{}", seen(&values(&second)));
    assert!(values(&second).iter().all(|s| s.reserved == 0 && s.visibility == 0.0));
    unsafe { covbeam_march_free(march) };
}

#[test]
fn a_second_round_after_none_is_a_first_one() {
    let (march, jitters) = (even(), [0.1, 0.9, 0.4]);
    let (mut one, mut two) = ([NO_SAMPLE; 3], [NO_SAMPLE; 3]);
    let statuses = unsafe {
        [
            covbeam_march_place(march, 3, jitters.as_ptr(), 4, one.as_mut_ptr(), 24),
            covbeam_march_refine(march, 0, ptr::null(), 0, 3, jitters.as_ptr(), 4, two.as_mut_ptr(), 24),
        ]
    };
    assert_eq!((statuses, one), ([COVBEAM_OK; 2], two));
    assert_ne!(one, [NO_SAMPLE; 3]);
    unsafe { covbeam_march_free(march) };
}
