//! Arguments that no module should pass: each is refused by a status and a message that says what is wrong and where.

#![allow(unsafe_code, reason = "the C interface is what is tested")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "what is wrong on purpose is refused before it is touched"
)]

mod calls;

use calls::{message, refused};
use core::ffi::c_void;
use covbeam_rays::abi::*;
use covbeam_rays::records::HitRecord;
use std::ptr::{null, null_mut};

const POSITIONS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const TRIANGLES: [[i32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];
const IDENTITY: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

fn geometry() -> *mut c_void {
    let mut geometry = null_mut();
    assert_eq!(unsafe { covbeam_rays_geometry_new(&mut geometry) }, 0);
    geometry
}

fn add(
    geometry: *const c_void,
    positions: &[[f32; 3]],
    triangles: &[[i32; 3]],
    materials: &[i32],
    normals: Option<&[[[f32; 3]; 3]]>,
) -> i32 {
    let (mut mesh, mut dropped) = (0, 0);
    unsafe {
        covbeam_rays_geometry_add_mesh(
            geometry,
            positions.len(),
            positions.as_ptr(),
            triangles.len(),
            triangles.as_ptr(),
            materials.len(),
            materials.as_ptr(),
            normals.map_or(null(), <[_]>::as_ptr),
            &mut mesh,
            &mut dropped,
        )
    }
}

fn built() -> *mut c_void {
    let geometry = geometry();
    assert_eq!(add(geometry, &POSITIONS, &TRIANGLES, &[0], None), 0);
    let mut done = 0;
    unsafe {
        assert_eq!(covbeam_rays_geometry_add_instance(geometry, 0, IDENTITY.as_ptr(), 0, -1), 0);
        assert_eq!(covbeam_rays_geometry_build(geometry), 0);
        while done == 0 {
            assert_eq!(covbeam_rays_geometry_wait(geometry, 1000, &mut done), 0);
        }
    }
    geometry
}

#[test]
fn meshes_that_are_wrong_are_refused_with_what_is_wrong_and_where() {
    let geometry = geometry();
    let with = |index: usize, value: [f32; 3]| {
        let mut positions = POSITIONS;
        positions[index] = value;
        positions
    };
    refused(
        add(geometry, &with(2, [0.0, f32::NAN, 0.0]), &TRIANGLES, &[0], None),
        1,
        &["positions[2]", "finite"],
    );
    refused(add(geometry, &with(3, [2e9, 0.0, 0.0]), &TRIANGLES, &[0], None), 1, &["positions[3]", "1e9"]);
    refused(
        add(geometry, &POSITIONS, &[[0, 1, 2], [0, 1, 4]], &[0], None),
        1,
        &["triangles[1]", "0 to 4 - 1"],
    );
    refused(add(geometry, &POSITIONS, &[[0, 1, -1]], &[0], None), 1, &["triangles[0]", "-1"]);
    refused(add(geometry, &POSITIONS, &TRIANGLES, &[0, 1, 2], None), 1, &["materials", "3", "2 triangles"]);
    refused(add(geometry, &POSITIONS, &TRIANGLES, &[], None), 1, &["materials: 0"]);
    let up = [0.0, 0.0, 1.0];
    for wrong in [[0.0, 0.0, 0.9], [0.0; 3], [f32::NAN, 0.0, 0.0], [f32::INFINITY, 0.0, 0.0]] {
        let normals = [[up; 3], [up, up, wrong]];
        let status = add(geometry, &POSITIONS, &TRIANGLES, &[0], Some(&normals));
        refused(status, 1, &["normals[1, 2]", "length 1"]);
    }
    unsafe {
        let (mut mesh, mut dropped) = (0, 0);
        let mut add = |count: usize, positions: *const [f32; 3], triangles: *const [i32; 3]| {
            let material = 0;
            covbeam_rays_geometry_add_mesh(
                geometry,
                count,
                positions,
                2,
                triangles,
                1,
                &material,
                null(),
                &raw mut mesh,
                &raw mut dropped,
            )
        };
        let (positions, triangles) = (POSITIONS.as_ptr(), TRIANGLES.as_ptr());
        refused(add(4, null(), triangles), 1, &["positions", "NULL"]);
        refused(add(4, positions, null()), 1, &["triangles", "NULL"]);
        refused(add(4, positions.byte_add(2), triangles), 1, &["positions", "multiple of 4"]);
        refused(add(usize::MAX / 2, positions, triangles), 1, &["positions", "more than memory"]);
        refused(add(usize::MAX, positions, triangles), 1, &["positions", "more than memory"]);
        // None of them has become a mesh.
        let place = covbeam_rays_geometry_add_instance(geometry, 0, IDENTITY.as_ptr(), 0, -1);
        refused(place, 1, &["mesh: 0", "there are 0"]);
        assert_eq!(covbeam_rays_geometry_free(geometry), 0);
    }
}

#[test]
fn transforms_that_are_wrong_are_refused() {
    let geometry = geometry();
    assert_eq!(add(geometry, &POSITIONS, &TRIANGLES, &[0], None), 0);
    let place = |changes: &[(usize, f64)]| {
        let mut matrix = IDENTITY;
        changes.iter().for_each(|&(index, value)| matrix[index] = value);
        unsafe { covbeam_rays_geometry_add_instance(geometry, 0, matrix.as_ptr(), 0, -1) }
    };
    refused(place(&[(3, f64::NAN)]), 1, &["matrix", "not finite"]);
    refused(place(&[(0, f64::INFINITY)]), 1, &["matrix", "not finite"]);
    refused(place(&[(12, 0.5)]), 1, &["matrix", "last row", "affine"]);
    refused(place(&[(10, 0.0)]), 1, &["matrix", "flattens", "leave"]);
    // Two columns of the same direction, and a size whose inverse is beyond double precision.
    refused(place(&[(5, 0.0), (1, 1.0)]), 1, &["matrix", "flattens"]);
    refused(place(&[(0, 1e-310), (5, 1e-310), (10, 1e-310)]), 1, &["matrix", "flattens"]);
    refused(place(&[(3, 2e9)]), 1, &["matrix", "1e9"]);
    unsafe {
        refused(covbeam_rays_geometry_add_instance(geometry, 0, null(), 0, -1), 1, &["matrix", "NULL"]);
        refused(covbeam_rays_geometry_add_instance(geometry, 1, IDENTITY.as_ptr(), 0, -1), 1, &["mesh: 1"]);
        // Small and thin is fine.
        assert_eq!(place(&[(0, 1e-9), (5, 1e-9), (10, 1e-3)]), 0, "{}", message());
        assert_eq!(covbeam_rays_geometry_free(geometry), 0);
    }
}

#[test]
fn rays_that_are_wrong_are_refused_by_the_first_of_them() {
    let geometry = built();
    let count = 5000;
    let origins = vec![[0.1f32, 0.1, -1.0]; count];
    let directions = vec![[0.0f32, 0.0, 1.0]; count];
    let mut hits = vec![HitRecord::MISS; count];
    let mut cast = |origins: &[[f32; 3]], directions: &[[f32; 3]], lengths: &[f32]| unsafe {
        covbeam_rays_geometry_cast(
            geometry,
            count,
            origins.as_ptr(),
            directions.as_ptr(),
            lengths.len(),
            lengths.as_ptr(),
            hits.as_mut_ptr(),
        )
    };
    assert_eq!(cast(&origins, &directions, &[f32::INFINITY]), 0);
    let with = |values: &[[f32; 3]], wrong: [f32; 3]| {
        let mut values = values.to_vec();
        (values[1234], values[4000]) = (wrong, wrong);
        values
    };
    let far = [f32::INFINITY];
    refused(cast(&with(&origins, [f32::NAN, 0.0, 0.0]), &directions, &far), 1, &["origins[1234]", "finite"]);
    refused(cast(&origins, &with(&directions, [0.0, 0.0, 1.1]), &far), 1, &["directions[1234]", "length 1"]);
    refused(cast(&origins, &with(&directions, [0.0; 3]), &far), 1, &["directions[1234]"]);
    refused(cast(&origins, &with(&directions, [f32::NAN; 3]), &far), 1, &["directions[1234]"]);
    refused(cast(&origins, &directions, &[f32::NAN]), 1, &["lengths[0]"]);
    refused(cast(&origins, &directions, &[-1.0]), 1, &["lengths[0]"]);
    refused(cast(&origins, &directions, &[1.0, 2.0]), 1, &["lengths: 2 for 5000"]);
    let mut lengths = vec![1.0f32; count];
    lengths[77] = f32::NAN;
    refused(cast(&origins, &directions, &lengths), 1, &["lengths[77]"]);
    // Finite, however far.
    assert_eq!(cast(&with(&origins, [3e38, -3e38, 3e38]), &directions, &far), 0);

    let (mut counts, mut edges) = (vec![0; count], vec![[covbeam::Edge::default(); 4]; count]);
    let (counts, edges) = (counts.as_mut_ptr(), edges.as_mut_ptr());
    let wrong = with(&directions, [0.0; 3]);
    // Nonsense for a hit gives nonsense for edges, and nothing worse.
    let nan = [f32::NAN; 3];
    let nonsense = HitRecord {
        distance: f32::NAN,
        position: nan,
        geometric_normal: nan,
        offset: -1.0,
        ..HitRecord::MISS
    };
    let some = vec![nonsense; count];
    let through = [0, 1];
    unsafe {
        let of = |directions: &[[f32; 3]], hits: *const HitRecord, through: *const u8, counts| {
            covbeam_rays_geometry_edges(
                geometry,
                count,
                origins.as_ptr(),
                directions.as_ptr(),
                hits,
                2,
                through,
                counts,
                edges,
            )
        };
        let through = through.as_ptr();
        refused(of(&wrong, some.as_ptr(), through, counts), 1, &["directions[1234]"]);
        refused(of(&directions, null(), through, counts), 1, &["hits", "NULL"]);
        refused(of(&directions, some.as_ptr(), null(), counts), 1, &["through", "NULL"]);
        refused(of(&directions, some.as_ptr(), through, null_mut()), 1, &["counts", "NULL"]);
        assert_eq!(of(&directions, some.as_ptr(), through, counts), 0);
        assert_eq!(covbeam_rays_geometry_free(geometry), 0);
    }
}

#[test]
fn calls_in_the_wrong_order_and_wrong_handles_are_refused() {
    let (open, ready) = (geometry(), built());
    let (mut done, mut info, mut threads) = (0, covbeam_rays_info::default(), 0);
    let mut hit = HitRecord::MISS;
    unsafe {
        refused(covbeam_rays_geometry_info(open, &mut info), 2, &["not built"]);
        refused(covbeam_rays_geometry_wait(open, 0, &mut done), 2, &["call build"]);
        let cast = covbeam_rays_geometry_cast(open, 1, &[0.0; 3], &[0.0, 0.0, 1.0], 1, &1.0, &mut hit);
        refused(cast, 2, &["not built"]);
        refused(covbeam_rays_geometry_build(ready), 2, &["geometry"]);
        refused(add(ready, &POSITIONS, &TRIANGLES, &[0], None), 2, &["meshes come before the build"]);
        let place = covbeam_rays_geometry_add_instance(ready, 0, IDENTITY.as_ptr(), 0, -1);
        refused(place, 2, &["instances come before the build"]);
        assert_eq!(covbeam_rays_geometry_info(ready, &mut info), 0);

        refused(covbeam_rays_geometry_build(null()), 1, &["geometry: NULL"]);
        refused(covbeam_rays_geometry_build(ready.byte_add(1)), 1, &["geometry", "multiple"]);
        refused(covbeam_rays_gather_stop(ready), 1, &["gather: another kind"]);
        refused(covbeam_rays_geometry_new(null_mut()), 1, &["out: NULL"]);
        refused(covbeam_rays_geometry_info(ready, null_mut()), 1, &["info: NULL"]);
        refused(covbeam_rays_gather_new(null(), &mut null_mut()), 1, &["functions: NULL"]);
        let none = core::mem::zeroed::<covbeam_rays_functions>();
        refused(covbeam_rays_gather_new(&none, &mut null_mut()), 1, &["functions", "one of"]);
        refused(covbeam_rays_set_threads(100_000), 1, &["count: 100000"]);
        refused(covbeam_rays_get_threads(null_mut()), 1, &["out: NULL"]);
        assert_eq!(covbeam_rays_get_threads(&mut threads), 0);
        assert!(threads >= 1);
        assert_eq!(covbeam_rays_geometry_free(null_mut()), 0);
        assert_eq!(covbeam_rays_geometry_free(open), 0);
        assert_eq!(covbeam_rays_geometry_free(ready), 0);
    }
}
