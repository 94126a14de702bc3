//! Hosts with geometry of their own.

use super::scenes::Given;
use super::*;
use crate::session::host::covbeam_scene_new_of_host;
use crate::session::host::fields::*;
use crate::session::picture::*;
use crate::session::render::*;
use crate::session::scene::{covbeam_scene, covbeam_scene_free};
use crate::session::settings::covbeam_session_settings;
use core::ffi::c_void;
use glam::DVec3;

const RADIUS: f64 = 0.5;

/// A sphere around the origin, in closed form.
unsafe extern "C" fn cast(
    _: *mut c_void,
    count: usize,
    rays: *const covbeam_host_ray,
    hits: *mut covbeam_host_hit,
) {
    for index in 0..count {
        // SAFETY: as many of both as it says.
        let (ray, hit) = unsafe { (&*rays.add(index), &mut *hits.add(index)) };
        let [origin, direction] = [ray.origin, ray.direction].map(DVec3::from);
        let foot = -origin.dot(direction);
        let half = (RADIUS * RADIUS - (origin + foot * direction).length_squared()).max(0.0).sqrt();
        let (near, far) = (foot - half, foot + half);
        let distance = if near > 0.0 { near } else { far };
        if half == 0.0 || !(distance > 0.0 && distance < ray.reach) {
            continue;
        }
        let normal = ((origin + distance * direction) / RADIUS).normalize();
        let normals = normal.as_vec3().to_array();
        *hit = covbeam_host_hit {
            distance: distance as f32,
            position: (RADIUS * normal).as_vec3().to_array(),
            geometric_normal: normals,
            normal: normals,
            offset: 1e-6,
            tangent: normal.as_vec3().any_orthonormal_vector().to_array(),
            along: 1.0 / RADIUS as f32,
            across: 1.0 / RADIUS as f32,
            twist: 0.0,
            object: 0,
            material: 0,
            mark: [0; 3],
        };
    }
}

/// Nothing is there.
unsafe extern "C" fn nothing(_: *mut c_void, _: usize, _: *const covbeam_host_ray, _: *mut covbeam_host_hit) {
}

/// Numbers that mean nothing.
unsafe extern "C" fn lie(
    _: *mut c_void,
    count: usize,
    _: *const covbeam_host_ray,
    hits: *mut covbeam_host_hit,
) {
    for index in 0..count {
        // SAFETY: as many as it says.
        unsafe {
            let hit = &mut *hits.add(index);
            (hit.distance, hit.normal, hit.object, hit.offset) = (1.0, [f32::NAN; 3], u32::MAX, -1.0);
        }
    }
}

fn host(cast: covbeam_host_cast) -> covbeam_host {
    let size = RADIUS as f32;
    covbeam_host {
        struct_size: size_of::<covbeam_host>() as u32,
        version: 1,
        user: null_mut(),
        cast,
        blocked: None,
        lobes: None,
        scatter: None,
        emit: None,
        illuminate: None,
        eye: None,
        min: [-size; 3],
        max: [size; 3],
    }
}

/// Fog everywhere; the shape, if there is one, is where the host's is.
fn given(has_shape: bool) -> Given {
    let mut given = Given { world_volume: 2, parts: Vec::new(), ..Given::default() };
    given.objects[0].volume = -1;
    given.materials[0].transparent = [0.0; 3];
    given.materials[0].diffuse = [0.5; 3];
    (given.shapes[0].material, given.shapes[0].a) = (0, [0.0; 3]);
    if !has_shape {
        given.shapes.clear();
    }
    given
}

/// The mean of a picture of what fog scatters.
fn mean(scene: *mut covbeam_scene) -> f64 {
    // SAFETY: all 0 is a value of it.
    let mut settings: covbeam_session_settings = unsafe { core::mem::zeroed() };
    (settings.struct_size, settings.photons, settings.threads) =
        (size_of::<covbeam_session_settings>() as u32, 2000, 2);
    let (mut session, mut rgb) = (null_mut(), vec![[f32::NAN; 3]; 256]);
    // SAFETY: live handles and locals.
    unsafe {
        let status =
            covbeam_session_new(1, &scene.cast_const(), 0, &settings, None, null_mut(), &mut session);
        assert_eq!(status, COVBEAM_OK, "{}", message());
        for _ in 0..8 {
            assert_eq!(covbeam_session_pass(session, None, null_mut()), COVBEAM_OK, "{}", message());
        }
        let out = rgb.as_mut_ptr().cast();
        let status = covbeam_session_picture(session, 0, 256, out, 0, None, null_mut());
        assert_eq!(status, COVBEAM_OK, "{}", message());
        assert_eq!([covbeam_session_free(session), covbeam_scene_free(scene)], [COVBEAM_OK; 2]);
    }
    assert!(rgb.iter().flatten().all(|value| value.is_finite() && *value >= 0.0));
    rgb.iter().map(|color| f64::from(color[0])).sum::<f64>() / 256.0
}

#[test]
fn a_sphere_of_a_host_is_the_sphere_of_a_description() {
    let (_, ours) = given(true).scene(null());
    let (status, theirs) = given(false).made(|description, out| {
        // SAFETY: locals.
        unsafe { covbeam_scene_new_of_host(&host(Some(cast)), description, out) }
    });
    assert_eq!(status, COVBEAM_OK, "{}", message());
    let [ours, theirs] = [ours, theirs].map(mean);
    // Eight passes of 2000 paths know the mean to half a percent.
    assert!((ours / theirs - 1.0).abs() < 0.02, "{ours} {theirs}");
}

#[test]
fn hosts_that_lie_are_not_believed_and_those_without_functions_are_refused() {
    let make = |host: &covbeam_host| {
        given(false).made(|description, out| {
            // SAFETY: locals.
            unsafe { covbeam_scene_new_of_host(host, description, out) }
        })
    };
    let (status, scene) = make(&host(Some(lie)));
    assert_eq!(status, COVBEAM_OK, "{}", message());
    let (_, empty) = make(&host(Some(nothing)));
    let [liar, empty] = [scene, empty].map(mean);
    assert_eq!(liar, empty, "hits that mean nothing are none");
    refused(make(&host(None)).0, COVBEAM_NULL_POINTER, &["host.cast: NULL"]);
    let nowhere = covbeam_host { max: [f32::NAN; 3], ..host(Some(cast)) };
    refused(make(&nowhere).0, COVBEAM_INVALID_VALUE, &["geometry.bounds"]);
    refused(make(&covbeam_host { struct_size: 3, ..host(Some(cast)) }).0, COVBEAM_INVALID_VALUE, &["host"]);
}
