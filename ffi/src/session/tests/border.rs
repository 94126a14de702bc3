//! What a host's functions behind the C border cost a pass: `cargo test -p covbeam-ffi --release -- --ignored --nocapture border`.
//!
//! The same meshes twice: built by the library, and cast by functions of a host that does the same.
#![allow(clippy::print_stdout)]

use super::scenes::Given;
use super::*;
use crate::handle::shared;
use crate::session::host::covbeam_scene_new_of_host;
use crate::session::host::fields::*;
use crate::session::render::*;
use crate::session::scene::{covbeam_scene, covbeam_scene_free};
use crate::session::settings::covbeam_session_settings;
use ::covbeam_geometry::instances::Instances;
use core::ffi::c_void;
use glam::DVec3;
use std::sync::Arc;
use std::time::Instant;

/// Rows of the ball's triangles.
const ROWS: u32 = 96;

struct Ball {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[i32; 3]>,
    /// At the corners.
    normals: Vec<[[f32; 3]; 3]>,
}

/// A ball of radius 1 around the origin.
fn ball() -> Ball {
    let point = |row: u32, column: u32| {
        let (theta, phi) = (
            std::f64::consts::PI * f64::from(row) / f64::from(ROWS),
            std::f64::consts::TAU * f64::from(column % (2 * ROWS)) / f64::from(2 * ROWS),
        );
        [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()].map(|x| x as f32)
    };
    let all = (0..=ROWS).flat_map(|row| (0..2 * ROWS).map(move |column| point(row, column)));
    let positions: Vec<[f32; 3]> = all.collect();
    let number = |row: u32, column: u32| (row * 2 * ROWS + column % (2 * ROWS)) as i32;
    let mut triangles = Vec::new();
    for (row, column) in (0..ROWS).flat_map(|row| (0..2 * ROWS).map(move |column| (row, column))) {
        let [a, b] = [number(row, column), number(row, column + 1)];
        let [c, d] = [number(row + 1, column), number(row + 1, column + 1)];
        triangles.extend([[a, b, d], [a, d, c]]);
    }
    let normals = triangles.iter().map(|corners: &[i32; 3]| corners.map(|corner| positions[corner as usize]));
    let normals = normals.collect();
    Ball { positions, triangles, normals }
}

unsafe extern "C" fn cast(
    user: *mut c_void,
    count: usize,
    rays: *const covbeam_host_ray,
    hits: *mut covbeam_host_hit,
) {
    for index in 0..count {
        // SAFETY: the meshes, and as many of both as it says.
        let (meshes, ray, hit) =
            unsafe { (&*user.cast::<Instances>(), &*rays.add(index), &mut *hits.add(index)) };
        let Some(met) = meshes.intersect(ray.origin.into(), ray.direction.into(), ray.reach) else {
            continue;
        };
        let met = meshes.describe(&met);
        *hit = covbeam_host_hit {
            distance: met.distance,
            position: met.position.into(),
            geometric_normal: met.geometric_normal.into(),
            normal: met.normal.into(),
            offset: met.offset,
            tangent: met.curvature.tangent.into(),
            along: met.curvature.along,
            across: met.curvature.across,
            twist: met.curvature.twist,
            object: met.object,
            material: met.material,
            mark: [0; 3],
        };
    }
}

unsafe extern "C" fn blocked(
    user: *mut c_void,
    count: usize,
    rays: *const covbeam_host_ray,
    blocked: *mut u8,
) {
    for index in 0..count {
        // SAFETY: as above.
        unsafe {
            let ray = &*rays.add(index);
            let direction = DVec3::from(ray.direction);
            let meets = (*user.cast::<Instances>()).occluded(ray.origin.into(), direction, ray.reach);
            *blocked.add(index) = u8::from(meets);
        }
    }
}

fn session(scene: *mut covbeam_scene) -> *mut covbeam_session {
    // SAFETY: all 0 is a value of it.
    let mut settings: covbeam_session_settings = unsafe { core::mem::zeroed() };
    (settings.struct_size, settings.threads) = (size_of::<covbeam_session_settings>() as u32, 1);
    let mut session = null_mut();
    // SAFETY: live handles and locals.
    let status =
        unsafe { covbeam_session_new(1, &scene.cast_const(), 0, &settings, None, null_mut(), &mut session) };
    assert_eq!(status, COVBEAM_OK, "{}", message());
    session
}

#[test]
#[ignore = "a measurement, to be run alone and in release"]
fn cost_of_the_border() {
    let Ball { positions, triangles, normals } = ball();
    let geometry = geometry();
    assert_eq!(add(geometry, &positions, &triangles, &[1], Some(&normals)), COVBEAM_OK, "{}", message());
    assert_eq!(place(geometry, 0, IDENTITY), COVBEAM_OK);
    // SAFETY: a live handle.
    let meshes = unsafe {
        assert_eq!(covbeam_geometry_build(geometry, None, null_mut()), COVBEAM_OK);
        shared(geometry, "geometry").expect("live").geometry.built().expect("built")
    };
    let mut given = Given { world_volume: 2, parts: Vec::new(), ..Given::default() };
    given.shapes.clear();
    given.objects[0].volume = -1;
    (given.camera.width, given.camera.height, given.camera.step) = (64, 64, [0.8 / 64.0; 2]);
    let (status, ours) = given.scene(geometry);
    assert_eq!(status, COVBEAM_OK, "{}", message());
    let host = covbeam_host {
        struct_size: size_of::<covbeam_host>() as u32,
        version: 1,
        user: Arc::as_ptr(&meshes).cast_mut().cast(),
        cast: Some(cast),
        blocked: Some(blocked),
        lobes: None,
        scatter: None,
        emit: None,
        illuminate: None,
        eye: None,
        min: [-1.0; 3],
        max: [1.0; 3],
    };
    // SAFETY: locals.
    let (status, theirs) =
        given.made(|description, out| unsafe { covbeam_scene_new_of_host(&host, description, out) });
    assert_eq!(status, COVBEAM_OK, "{}", message());
    let [ours, theirs] = [ours, theirs].map(|scene| {
        let made = session(scene);
        // SAFETY: a live handle.
        assert_eq!(unsafe { covbeam_scene_free(scene) }, COVBEAM_OK);
        made
    });
    let pass = |session: *mut covbeam_session| {
        let start = Instant::now();
        // SAFETY: a live handle.
        assert_eq!(unsafe { covbeam_session_pass(session, None, null_mut()) }, COVBEAM_OK, "{}", message());
        start.elapsed().as_secs_f64()
    };
    for session in [ours, theirs] {
        pass(session);
    }
    // In turn: what else the machine does hits both alike.
    let mut ratios: Vec<f64> = (0..31)
        .map(|index| match index % 2 {
            0 => pass(theirs) / pass(ours),
            _ => (pass(ours) / pass(theirs)).recip(),
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    let [low, middle, high] = [7, 15, 23].map(|index| ratios[index]);
    println!("pass of a host / of meshes = {middle:.4} (median of 31; quartiles {low:.4}, {high:.4})");
    // SAFETY: live handles.
    unsafe {
        assert_eq!([ours, theirs].map(|session| covbeam_session_free(session)), [COVBEAM_OK; 2]);
        assert_eq!(covbeam_geometry_free(geometry), COVBEAM_OK);
    }
}
