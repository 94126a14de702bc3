//! The error metric, on pictures small enough to do it by hand.

use covbeam_render::study::compare::{CompareError, Comparison, compare};
use covbeam_session::film::Picture;
use glam::Vec3;

fn grey(width: u32, values: &[f32]) -> Picture {
    let radiance = values.iter().map(|v| Vec3::splat(*v)).collect();
    Picture { width, height: values.len() as u32 / width, radiance, ..Picture::default() }
}

/// Luminance of grey is grey to a few f32 roundings (6e-8 each).
fn assert_near(value: f64, expected: f64) {
    assert!((value - expected).abs() <= 1e-6 * expected.abs().max(1e-3), "{value} instead of {expected}");
}

#[test]
fn the_whole_picture_by_hand() {
    let found =
        compare(&grey(2, &[1.0, 2.0, 3.0, 6.0]), &grey(2, &[2.0, 2.0, 2.0, 2.0]), |_, _| true).unwrap();
    // Squared errors 1, 0, 1, 16; each over 2² + (0.01 * 2)² = 4.0004; mean of four.
    assert_near(found.rel_mse, 18.0 / 4.0 / 4.0004);
    // Means 3 and 2.
    assert_near(found.bias, 0.5);
    assert_near(found.mean, 3.0);
    assert_near(found.reference_mean, 2.0);
}

#[test]
fn a_region_is_relative_to_the_mean_of_the_whole_reference() {
    // Mean of the reference 25, so the floor is 0.0625: the black pixel's error is 1 / 0.0625 = 16.
    let found = compare(&grey(2, &[1.0, 50.0]), &grey(2, &[0.0, 50.0]), |x, _| x == 0).unwrap();
    assert_near(found.rel_mse, 16.0);
    assert_near(found.mean, 1.0);
    assert_eq!((found.reference_mean, found.bias), (0.0, f64::INFINITY));
}

#[test]
fn a_mask_gets_column_and_row_from_the_upper_left() {
    let picture = grey(3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let found = compare(&picture, &picture, |x, y| x == 2 && y == 1).unwrap();
    assert_near(found.mean, 6.0);
    assert_eq!((found.rel_mse, found.bias), (0.0, 0.0));
}

#[test]
fn colours_count_by_their_luminance_of_rec_709() {
    let mut picture = grey(1, &[1.0]);
    picture.radiance[0] = Vec3::new(10.0, 20.0, 30.0);
    // 2.126 + 14.304 + 2.166
    assert_near(compare(&picture, &grey(1, &[1.0]), |_, _| true).unwrap().mean, 18.596);
}

#[test]
fn the_metric_does_not_depend_on_the_unit() {
    let (values, reference) = ([1.0, 2.5, 3.0], [1.5, 2.0, 3.5]);
    let Comparison { rel_mse, bias, .. } =
        compare(&grey(3, &values), &grey(3, &reference), |_, _| true).unwrap();
    for unit in [1e-15_f32, 1e-3, 1e12] {
        let (values, reference) = (values.map(|v| v * unit), reference.map(|v| v * unit));
        let scaled = compare(&grey(3, &values), &grey(3, &reference), |_, _| true).unwrap();
        assert_near(scaled.rel_mse, rel_mse);
        assert_near(scaled.bias, bias);
    }
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let all = |_: u32, _: u32| true;
    let good = grey(2, &[1.0, 2.0]);
    let sizes = compare(&good, &grey(1, &[1.0, 2.0]), all).unwrap_err();
    assert_eq!(sizes, CompareError::Size(2, 1, 1, 2));
    assert!(sizes.to_string().contains("2 x 1") && sizes.to_string().contains("1 x 2"));
    let mut bad = grey(2, &[1.0, 1.0, f32::NAN, f32::INFINITY]);
    let reference = grey(2, &[1.0; 4]);
    let error = compare(&bad, &reference, |_, y| y == 0).unwrap_err();
    assert_eq!(error, CompareError::NotFinite { which: "picture", count: 2, x: 0, y: 1 });
    bad.radiance[2] = Vec3::ONE;
    let error = compare(&reference, &bad, all).unwrap_err();
    assert_eq!(error, CompareError::NotFinite { which: "reference", count: 1, x: 1, y: 1 });
    assert_eq!(compare(&good, &grey(2, &[0.0, 0.0]), all).unwrap_err(), CompareError::BlackReference);
    assert_eq!(compare(&good, &good, |_, _| false).unwrap_err(), CompareError::EmptyRegion);
}
