//! Tests of importance: what is refused, and that many are the bits of the core.
#![allow(clippy::undocumented_unsafe_blocks, reason = "every argument is a local, or refused")]

use super::add::{
    covbeam_importance_add_eye_rays, covbeam_importance_add_paths, covbeam_importance_add_surfaces,
};
use super::handle::{covbeam_importance, covbeam_importance_free, covbeam_importance_new};
use super::look_up::{
    covbeam_importance_at, covbeam_importance_cell, covbeam_importance_of_segments,
    covbeam_importance_resolve, covbeam_segment_importance,
};
use super::merge::covbeam_importance_merge;
use super::weight_window::covbeam_weight_window;
use crate::eye_ray::covbeam_eye_ray;
use crate::hostile::{Rule::*, UNTOUCHED, padded, refuses, values};
use crate::medium::options::read_medium;
use crate::medium::samples::{fog, haze};
use crate::status::covbeam_status::*;
use crate::voxels::covbeam_grid_layout;
use core::ptr;
use covbeam_core::{Importance, ImportanceCell, ImportanceGrid, ImportanceSums, SegmentImportance};
use glam::Vec3;

const LAYOUT: covbeam_grid_layout = covbeam_grid_layout { min: [-1.0; 3], max: [1.0; 3], cells: [4, 3, 2] };

fn made(layout: &covbeam_grid_layout) -> *mut covbeam_importance {
    let mut importance = ptr::null_mut();
    assert_eq!(unsafe { covbeam_importance_new(layout, &mut importance) }, COVBEAM_OK);
    importance
}

fn ray(origin: [f32; 3], direction: [f32; 3], length: f32) -> covbeam_eye_ray {
    covbeam_eye_ray { origin, direction, length }
}

/// What look-ups see at a place, once resolved.
fn seen(importance: *mut covbeam_importance) -> covbeam_importance_cell {
    let mut cell = covbeam_importance_cell { beam: UNTOUCHED, scattered: UNTOUCHED, surface: UNTOUCHED };
    unsafe {
        assert_eq!(covbeam_importance_resolve(importance), COVBEAM_OK);
        assert_eq!(covbeam_importance_at(importance, 1, [0.1; 3].as_ptr(), 0, &mut cell, 0), COVBEAM_OK);
    }
    cell
}

#[test]
fn a_bad_argument_is_refused_and_nothing_changes() {
    let numbers = [
        (-2.0, Finite),
        (0.1, Finite),
        (0.2, Finite),
        (1.0, Along),
        (0.0, Across),
        (0.0, Across),
        (5.0, NotNegative),
        (0.75, FiniteNotNegative),
    ];
    for add in [covbeam_importance_add_eye_rays, covbeam_importance_add_paths] {
        refuses(4, &numbers, |bad, n| {
            let (importance, fog) = (made(&LAYOUT), fog());
            let piece = ray([n[0], n[1], n[2]], [n[3], n[4], n[5]], n[6]);
            let status = unsafe {
                let (to, medium) = (bad.at_mut(0, importance), bad.at(1, &fog));
                add(to, medium, 1, bad.at(2, &piece), 0, bad.at(3, &n[7]), 0)
            };
            let none = covbeam_importance_cell { beam: 0.0, scattered: 0.0, surface: 0.0 };
            // Good arguments may add nothing: a weight of 0.
            let changed = seen(importance) != none || status == COVBEAM_OK;
            unsafe { covbeam_importance_free(importance) };
            (status, changed)
        });
    }
    let place = [(0.1, Finite), (0.2, Finite), (0.3, Finite), (0.75, FiniteNotNegative)];
    refuses(3, &place, |bad, n| {
        let importance = made(&LAYOUT);
        let (to, at, weight) = (bad.at_mut(0, importance), bad.at(1, n.as_ptr()), bad.at(2, &n[3]));
        let status = unsafe { covbeam_importance_add_surfaces(to, 1, at, 0, weight, 0) };
        let changed = seen(importance).surface != 0.0 || status == COVBEAM_OK;
        unsafe { covbeam_importance_free(importance) };
        (status, changed)
    });
    refuses(4, &numbers[..7], |bad, n| {
        let (importance, fog) = (made(&LAYOUT), fog());
        let segment = ray([n[0], n[1], n[2]], [n[3], n[4], n[5]], n[6]);
        let untouched =
            covbeam_segment_importance { beam: UNTOUCHED, scattered: UNTOUCHED, transmittance: UNTOUCHED };
        let mut worth = untouched;
        let status = unsafe {
            assert_eq!(covbeam_importance_resolve(importance), COVBEAM_OK);
            let (from, medium) = (bad.at(0, importance), bad.at(1, &fog));
            let (segment, to) = (bad.at(2, &segment), bad.at_mut(3, &mut worth));
            covbeam_importance_of_segments(from, medium, 1, segment, 0, to, 0)
        };
        unsafe { covbeam_importance_free(importance) };
        (status, worth != untouched)
    });
    refuses(1, &[(0.75, FiniteNotNegative), (0.5, FiniteNotNegative), (0.25, Random)], |bad, n| {
        // A third, that nothing is asked of, shows that the call has written.
        let given = [n[0], n[1], 0.25];
        let mut factors = given;
        let status = unsafe { covbeam_weight_window(3, bad.at_mut(0, factors.as_mut_ptr()), 4, n[2]) };
        // NaN is not itself.
        (status, factors.map(f32::to_bits) != given.map(f32::to_bits))
    });
}

#[test]
fn calls_out_of_order_and_what_does_not_fit_are_refused() {
    let importance = made(&LAYOUT);
    let other = made(&covbeam_grid_layout { cells: [4, 3, 3], ..LAYOUT });
    let mut cell = covbeam_importance_cell { beam: UNTOUCHED, scattered: UNTOUCHED, surface: UNTOUCHED };
    unsafe {
        let status = covbeam_importance_at(importance, 1, [0.0; 3].as_ptr(), 0, &mut cell, 0);
        assert_eq!((status, cell.beam), (COVBEAM_WRONG_ORDER, UNTOUCHED));
        let merge = |one: *const covbeam_importance| covbeam_importance_merge(importance, &one, 1);
        assert_eq!(merge(other), COVBEAM_MISMATCH);
        assert_eq!(merge(importance), COVBEAM_INVALID_ARRAY);
        assert_eq!(merge(ptr::null()), COVBEAM_NULL_POINTER);
        covbeam_importance_free(other);
        covbeam_importance_free(importance);
        covbeam_importance_free(ptr::null_mut());
    }
    for cells in [[0, 1, 1], [1 << 24, 2, 1]] {
        let (layout, mut out) = (covbeam_grid_layout { cells, ..LAYOUT }, ptr::null_mut());
        assert_eq!(unsafe { covbeam_importance_new(&layout, &mut out) }, COVBEAM_INVALID_VALUE);
        assert!(out.is_null());
    }
}

#[test]
fn many_are_the_bits_of_the_core() {
    let rays = padded(&[
        ray([-3.0, 0.1, 0.2], [1.0, 0.0, 0.0], f32::INFINITY),
        ray([0.1, 0.2, 0.3], [0.0, 0.6, -0.8], 0.7),
        ray([5.0, 5.0, 5.0], [0.0, 0.0, 1.0], 1.0),
    ]);
    let (weights, points) =
        (padded(&[0.5, 2.0, 1.0]), padded(&[[0.1, 0.2, 0.3], [9.0, 0.0, 0.0], [-0.9; 3]]));
    for c_medium in [fog(), haze()] {
        let (first, second) = (made(&LAYOUT), made(&LAYOUT));
        let none = covbeam_importance_cell { beam: UNTOUCHED, scattered: UNTOUCHED, surface: UNTOUCHED };
        let nothing =
            covbeam_segment_importance { beam: UNTOUCHED, scattered: UNTOUCHED, transmittance: UNTOUCHED };
        let (mut cells, mut worths) = (padded(&[none; 3]), padded(&[nothing; 3]));
        let statuses = unsafe {
            let (ray, ray_step) = (&raw const rays[0].value, size_of_val(&rays[0]));
            let (weight, step) = (&raw const weights[0].value, size_of_val(&weights[0]));
            let (point, point_step) = (points[0].value.as_ptr(), size_of_val(&points[0]));
            let (cell, cell_step) = (&raw mut cells[0].value, size_of_val(&cells[0]));
            let (worth, worth_step) = (&raw mut worths[0].value, size_of_val(&worths[0]));
            let medium = &raw const c_medium;
            [
                covbeam_importance_add_eye_rays(first, medium, 3, ray, ray_step, weight, step),
                covbeam_importance_add_paths(second, medium, 3, ray, ray_step, weight, step),
                covbeam_importance_add_surfaces(second, 3, point, point_step, weight, step),
                covbeam_importance_merge(first, [second.cast_const()].as_ptr(), 1),
                covbeam_importance_resolve(first),
                covbeam_importance_at(first, 3, point, point_step, cell, cell_step),
                covbeam_importance_of_segments(first, medium, 3, ray, ray_step, worth, worth_step),
            ]
        };
        assert_eq!(statuses, [COVBEAM_OK; 7]);
        unsafe {
            covbeam_importance_free(first);
            covbeam_importance_free(second);
        }
        let Ok(medium) = (unsafe { read_medium(&c_medium, "medium") }) else { panic!("a sound medium") };
        let mut sums = [ImportanceSums::default(); 24];
        let mut grid = ImportanceGrid::new(LAYOUT.into(), &mut sums).unwrap();
        let pieces = values(&rays).into_iter().zip(values(&weights)).zip(values(&points));
        for ((covbeam_eye_ray { origin, direction, length }, weight), point) in pieces {
            grid.add_eye_ray(&medium, origin.into(), direction.into(), length, weight);
            grid.add_path(&medium, origin.into(), direction.into(), length, weight);
            grid.add_surface(point.into(), weight);
        }
        let mut core = [ImportanceCell::default(); 24];
        grid.resolve(&mut core).unwrap();
        let importance = Importance::new(LAYOUT.into(), &core).unwrap();
        for (cell, point) in values(&cells).into_iter().zip(values(&points)) {
            let ImportanceCell { beam, scattered, surface } = importance.at(Vec3::from(point));
            assert_eq!(cell, covbeam_importance_cell { beam, scattered, surface });
        }
        for (worth, segment) in values(&worths).into_iter().zip(values(&rays)) {
            let covbeam_eye_ray { origin, direction, length } = segment;
            let found = importance.of_segment(&medium, origin.into(), direction.into(), length);
            let SegmentImportance { beam, scattered, transmittance } = found;
            assert_eq!(worth, covbeam_segment_importance { beam, scattered, transmittance });
        }
        assert!(values(&worths)[1].beam > 0.0);
    }
    let mut factors = padded(&[0.5, 0.25, 2.0, 0.25]);
    let (first, stride) = (&raw mut factors[0].value, size_of_val(&factors[0]));
    assert_eq!(unsafe { covbeam_weight_window(4, first, stride, 0.4) }, COVBEAM_OK);
    assert_eq!(values(&factors), [0.0, 4.0, 1.0, 0.0]);
}
