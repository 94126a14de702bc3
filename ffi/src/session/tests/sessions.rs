//! Sessions: settings, goals, the order of calls, pictures and sums.

use super::scenes::Given;
use super::*;
use crate::session::picture::*;
use crate::session::render::*;
use crate::session::scene::{covbeam_scene, covbeam_scene_free, covbeam_scene_new};
use crate::session::settings::{covbeam_bounce_limits, covbeam_session_settings};
use core::ffi::c_void;

const SETTINGS: covbeam_session_settings = covbeam_session_settings {
    struct_size: size_of::<covbeam_session_settings>() as u32,
    method: 0,
    seed: 0,
    photons: 300,
    grid: 0,
    most_events: 0,
    first_pass: 0,
    threads: 2,
    kinds_apart: 0,
    first_apart: 0,
    first_alone: 0,
    every_pixel: 0,
    radius: 0.0,
    error: 0.0,
    spawn: None,
    spawn_user: core::ptr::null_mut(),
    limits: covbeam_bounce_limits {
        limited: 0,
        total: 0,
        diffuse: 0,
        glossy: 0,
        transmission: 0,
        volume: 0,
        free_reflections: 0,
        free_transmissions: 0,
    },
};

/// Fog everywhere, without anything in it.
fn fog() -> Given {
    Given { world_volume: 2, parts: Vec::new(), ..Given::default() }
}

fn scene(given: &Given) -> *mut covbeam_scene {
    let geometry = built();
    let (status, scene) = given.scene(geometry);
    assert_eq!(status, COVBEAM_OK, "{}", message());
    // SAFETY: a live handle, which the scene does not need any more.
    assert_eq!(unsafe { covbeam_geometry_free(geometry) }, COVBEAM_OK);
    scene
}

fn new(
    scenes: &[*const covbeam_scene],
    settings: &covbeam_session_settings,
    session: &mut *mut covbeam_session,
) -> covbeam_status {
    let stride = size_of::<*const covbeam_scene>();
    // SAFETY: live handles and locals.
    unsafe { covbeam_session_new(scenes.len(), scenes.as_ptr(), stride, settings, None, null_mut(), session) }
}

fn session(scene: *const covbeam_scene, settings: &covbeam_session_settings) -> *mut covbeam_session {
    let mut session = null_mut();
    assert_eq!(new(&[scene], settings, &mut session), COVBEAM_OK, "{}", message());
    session
}

#[test]
fn settings_and_instants_that_are_wrong_are_refused() {
    let scene = scene(&fog());
    let mut session = null_mut();
    let mut refuse = |settings: covbeam_session_settings, part: &str| {
        refused(new(&[scene], &settings, &mut session), COVBEAM_INVALID_VALUE, &[part]);
        assert!(session.is_null());
    };
    for radius in [f64::NAN, f64::INFINITY, -1.0, 3e38, 1e-300] {
        refuse(covbeam_session_settings { radius, ..SETTINGS }, "settings.radius");
    }
    for error in [f64::NAN, -1.0, 1.1, 1e-9] {
        refuse(covbeam_session_settings { error, ..SETTINGS }, "settings.error");
    }
    refuse(covbeam_session_settings { method: 5, ..SETTINGS }, "settings.method: 5");
    refuse(covbeam_session_settings { photons: u32::MAX, ..SETTINGS }, "settings.photons: 4294967295");
    refuse(covbeam_session_settings { grid: 257, ..SETTINGS }, "settings.grid: 257");
    refuse(covbeam_session_settings { threads: 1025, ..SETTINGS }, "settings.threads: 1025");
    refuse(covbeam_session_settings { first_pass: 1 << 31, ..SETTINGS }, "settings.first_pass");
    refuse(covbeam_session_settings { method: 2, kinds_apart: 1, ..SETTINGS }, "settings.kinds_apart");
    refuse(covbeam_session_settings { first_apart: 1, every_pixel: 1, ..SETTINGS }, "settings.first_apart");
    refuse(covbeam_session_settings { method: 1, first_apart: 1, ..SETTINGS }, "settings.first_apart");
    refuse(covbeam_session_settings { struct_size: 8, ..SETTINGS }, "settings: struct_size is 8");
    refused(new(&[], &SETTINGS, &mut session), COVBEAM_INVALID_VALUE, &["scenes: none"]);
    refused(new(&[scene.cast_const(); 3], &SETTINGS, &mut session), COVBEAM_INVALID_VALUE, &["power of two"]);
    for change in [
        &(|given: &mut Given| given.camera.width = 8) as &dyn Fn(&mut Given),
        &|given| given.light.intensity = [0.0; 3],
        &|given| {
            given.world_volume = 1;
            given.volumes.truncate(2);
        },
    ] {
        let mut other = fog();
        change(&mut other);
        let other = self::scene(&other);
        refused(new(&[scene, other], &SETTINGS, &mut session), COVBEAM_INVALID_VALUE, &["scenes[1]: "]);
        // SAFETY: a live handle.
        assert_eq!(unsafe { covbeam_scene_free(other) }, COVBEAM_OK);
    }
    let geometry = built();
    refused(
        new(&[geometry.cast()], &SETTINGS, &mut session),
        COVBEAM_INVALID_HANDLE,
        &["scenes: not a covbeam_scene"],
    );
    // SAFETY: live handles and locals; NULL is refused.
    unsafe {
        let one = &scene.cast_const();
        let status = covbeam_session_new(1 << 40, one, 0, &SETTINGS, None, null_mut(), &mut session);
        refused(status, COVBEAM_INVALID_ARRAY, &["count: 1099511627776", "1024"]);
        let status = covbeam_session_new(1, one, 0, null(), None, null_mut(), &mut session);
        refused(status, COVBEAM_NULL_POINTER, &["settings: NULL"]);
        let status = covbeam_session_new(1, null(), 0, &SETTINGS, None, null_mut(), &mut session);
        refused(status, COVBEAM_NULL_POINTER, &["scenes: NULL"]);
        let status = covbeam_session_new(1, one, 0, &SETTINGS, None, null_mut(), null_mut());
        refused(status, COVBEAM_NULL_POINTER, &["out: NULL"]);
        let status = covbeam_session_new(1, one, 0, &SETTINGS, Some(stop), null_mut(), &mut session);
        assert!([COVBEAM_CANCELLED, COVBEAM_OK].contains(&status), "it may be ready before it is asked");
        assert_eq!([covbeam_geometry_free(geometry), covbeam_scene_free(scene)], [COVBEAM_OK; 2]);
    }
}

unsafe extern "C" fn stop(_: *mut c_void) -> i32 {
    1
}

#[test]
fn goals_pictures_and_calls_out_of_order() {
    let scene = scene(&fog());
    let session = session(scene, &covbeam_session_settings { first_apart: 1, ..SETTINGS });
    let (mut rgb, mut numbers) = (vec![[0.0_f32; 3]; 256], vec![0.0_f32; 256]);
    // SAFETY: live handles and locals.
    unsafe {
        assert_eq!(covbeam_scene_free(scene), COVBEAM_OK);
        let mut picture = |layer: covbeam_layer, count: usize| {
            let out = if layer as u32 >= 5 { numbers.as_mut_ptr() } else { rgb.as_mut_ptr().cast() };
            covbeam_session_picture(session, layer as u32, count, out, 0, None, null_mut())
        };
        use covbeam_layer::*;
        refused(picture(COVBEAM_LAYER_ALL, 256), COVBEAM_WRONG_ORDER, &["a picture needs a pass"]);
        let mut needed = 0;
        let status = covbeam_session_save(session, null_mut(), 0, &mut needed);
        refused(status, COVBEAM_WRONG_ORDER, &["without a pass"]);
        let goal = covbeam_goal {
            struct_size: size_of::<covbeam_goal>() as u32,
            passes: 0,
            seconds: 0.0,
            error: 0.0,
        };
        let until =
            |goal: covbeam_goal, end: *mut u32| covbeam_session_until(session, &goal, None, null_mut(), end);
        refused(until(goal, null_mut()), COVBEAM_INVALID_VALUE, &["goal: it has none"]);
        for wrong in [f64::NAN, -1.0, f64::INFINITY] {
            refused(
                until(covbeam_goal { seconds: wrong, ..goal }, null_mut()),
                COVBEAM_INVALID_VALUE,
                &["goal.seconds"],
            );
            refused(
                until(covbeam_goal { error: wrong, ..goal }, null_mut()),
                COVBEAM_INVALID_VALUE,
                &["goal.error"],
            );
        }
        let mut end = 7;
        assert_eq!(until(covbeam_goal { passes: 2, ..goal }, &mut end), COVBEAM_OK, "{}", message());
        assert_eq!(end, covbeam_end::COVBEAM_END_REACHED as u32);
        assert_eq!(covbeam_session_pass(session, None, null_mut()), COVBEAM_OK, "{}", message());
        refused(picture(COVBEAM_LAYER_ALL, 255), COVBEAM_SHORT_BUFFER, &["count: 255", "256"]);
        refused(picture(COVBEAM_LAYER_FOCUSED, 256), COVBEAM_WRONG_ORDER, &["kinds_apart"]);
        let layers = [
            COVBEAM_LAYER_FIRST,
            COVBEAM_LAYER_ERROR,
            COVBEAM_LAYER_RADIUS,
            COVBEAM_LAYER_BANDWIDTH,
            COVBEAM_LAYER_ALL,
        ];
        for layer in layers {
            assert_eq!(picture(layer, 256), COVBEAM_OK, "{}", message());
        }
        let status = covbeam_session_picture(session, 8, 256, numbers.as_mut_ptr(), 0, None, null_mut());
        refused(status, COVBEAM_INVALID_VALUE, &["layer: 8"]);
        let lit = rgb.iter().filter(|color| color[0] > 0.0).count();
        assert!(lit > 20, "{lit} pixels see the fog");
        let mut info = core::mem::zeroed();
        assert_eq!(covbeam_session_get_info(session, &mut info), COVBEAM_OK);
        assert_eq!((info.passes, info.photons, info.width, info.height), (3, 300, 16, 16));
        assert!(info.radius > 0.0 && info.grid.cells[0] > 1 && info.guided_photons == 300);

        assert_eq!(covbeam_session_save(session, null_mut(), 0, &mut needed), COVBEAM_OK);
        let mut sums = vec![0_u8; needed];
        let status = covbeam_session_save(session, sums.as_mut_ptr().cast(), needed - 1, &mut needed);
        refused(status, COVBEAM_SHORT_BUFFER, &["size"]);
        assert_eq!(covbeam_session_save(session, sums.as_mut_ptr().cast(), needed, &mut needed), COVBEAM_OK);
        let merge =
            |size: usize| covbeam_session_merge(session, sums.as_ptr().cast(), size, None, null_mut());
        refused(merge(needed), COVBEAM_BAD_DATA, &["0..3 are there already"]);
        refused(merge(0), COVBEAM_BAD_DATA, &["sums"]);
        refused(merge(needed - 1), COVBEAM_BAD_DATA, &["sums"]);

        assert_eq!(covbeam_session_restart(session, 0, 7), COVBEAM_OK);
        assert_eq!(covbeam_session_get_info(session, &mut info), COVBEAM_OK);
        assert_eq!((info.passes, info.photons), (0, 1));
        let status = covbeam_session_pass(session, Some(stop), null_mut());
        assert!([COVBEAM_CANCELLED, COVBEAM_OK].contains(&status), "a pass may be done before it is asked");
        refused(covbeam_session_get_info(session, null_mut()), COVBEAM_NULL_POINTER, &["info: NULL"]);
        assert_eq!([covbeam_session_free(session), covbeam_session_free(null_mut())], [COVBEAM_OK; 2]);
    }
}

#[test]
fn layers_of_a_dark_scene_are_black_and_those_that_were_not_asked_for_are_refused() {
    use covbeam_layer::*;
    let mut given = fog();
    given.light.intensity = [0.0; 3];
    let scene = scene(&given);
    let session = session(scene, &covbeam_session_settings { first_apart: 1, kinds_apart: 1, ..SETTINGS });
    // SAFETY: live handles and locals.
    unsafe {
        assert_eq!(covbeam_session_pass(session, None, null_mut()), COVBEAM_OK, "{}", message());
        for layer in [COVBEAM_LAYER_ALL, COVBEAM_LAYER_FIRST, COVBEAM_LAYER_FOCUSED] {
            let mut rgb = vec![[1.0_f32; 3]; 256];
            let out = rgb.as_mut_ptr().cast();
            let status = covbeam_session_picture(session, layer as u32, 256, out, 0, None, null_mut());
            assert_eq!(status, COVBEAM_OK, "{layer:?}: {}", message());
            assert!(rgb.iter().all(|color| *color == [0.0; 3]), "{layer:?}");
        }
        assert_eq!([covbeam_session_free(session), covbeam_scene_free(scene)], [COVBEAM_OK; 2]);
    }
}

/// What a callback does that calls the session that calls it.
unsafe extern "C" fn call_again(session: *mut c_void) -> i32 {
    let session: *mut covbeam_session = session.cast();
    // SAFETY: a live handle.
    unsafe {
        assert_eq!(covbeam_session_pass(session, None, null_mut()), COVBEAM_BUSY);
        assert!(message().contains("busy"), "{}", message());
        assert_eq!(covbeam_session_free(session), COVBEAM_BUSY);
        let mut info = core::mem::zeroed();
        assert_eq!(covbeam_session_get_info(session, &mut info), COVBEAM_OK);
    }
    0
}

#[test]
fn a_poll_that_calls_the_session_is_told_that_it_is_busy() {
    let scene = scene(&fog());
    let settings = covbeam_session_settings { photons: 20_000, ..SETTINGS };
    let session = session(scene, &settings);
    // SAFETY: live handles.
    unsafe {
        assert_eq!(
            covbeam_session_pass(session, Some(call_again), session.cast()),
            COVBEAM_OK,
            "{}",
            message()
        );
        assert_eq!([covbeam_session_free(session), covbeam_scene_free(scene)], [COVBEAM_OK; 2]);
    }
}

#[test]
fn calls_in_the_wrong_order_and_wrong_handles_are_refused() {
    let (open, ready) = (geometry(), built());
    // SAFETY: live handles and locals; what is wrong is refused before it is looked at.
    unsafe {
        let mut info = core::mem::zeroed();
        refused(covbeam_geometry_get_info(open, &mut info), COVBEAM_WRONG_ORDER, &["not built"]);
        refused(Given::default().scene(open).0, COVBEAM_WRONG_ORDER, &["not built"]);
        let mut hit: covbeam_surface_hit = core::mem::zeroed();
        let mut cast = |geometry, origin: *const [f32; 3], direction: [f32; 3]| {
            covbeam_geometry_cast(geometry, 1, origin.cast(), 0, direction.as_ptr(), 0, &mut hit, 0)
        };
        refused(cast(open, &[0.0; 3], [0.0, 0.0, 1.0]), COVBEAM_WRONG_ORDER, &["not built"]);
        let (origins, towards) = ([[0.0_f32; 3], [0.0, f32::NAN, 0.0]], [0.0_f32, 0.0, 1.0]);
        let mut two: [covbeam_surface_hit; 2] = core::mem::zeroed();
        let status = covbeam_geometry_cast(
            ready,
            2,
            origins.as_ptr().cast(),
            size_of::<[f32; 3]>(),
            towards.as_ptr(),
            0,
            two.as_mut_ptr(),
            size_of::<covbeam_surface_hit>(),
        );
        refused(status, COVBEAM_INVALID_VALUE, &["origins[1]", "finite"]);
        refused(cast(ready, null(), [0.0, 0.0, 1.0]), COVBEAM_NULL_POINTER, &["origins: NULL"]);
        refused(
            cast(ready, &[f32::INFINITY; 3], [0.0, 0.0, 1.0]),
            COVBEAM_INVALID_VALUE,
            &["origins[0]", "finite"],
        );
        refused(cast(ready, &[0.0; 3], [f32::NAN; 3]), COVBEAM_INVALID_VALUE, &["directions[0]", "length 1"]);
        assert_eq!(cast(ready, &[0.1, 0.1, -1.0], [0.0, 0.0, 1.0]), COVBEAM_OK, "{}", message());
        assert_eq!((hit.distance, hit.object), (1.0, 0));
        refused(covbeam_geometry_build(ready, None, null_mut()), COVBEAM_WRONG_ORDER, &["geometry"]);
        let late = add(ready, &POSITIONS, &TRIANGLES, &[0], None);
        refused(late, COVBEAM_WRONG_ORDER, &["meshes come before the build"]);
        refused(place(ready, 0, IDENTITY), COVBEAM_WRONG_ORDER, &["instances come before the build"]);
        assert_eq!(covbeam_geometry_get_info(ready, &mut info), COVBEAM_OK);
        assert_eq!((info.triangle_count, info.max), (2, [1.0; 3]));

        refused(
            covbeam_geometry_build(null_mut(), None, null_mut()),
            COVBEAM_NULL_POINTER,
            &["geometry: NULL"],
        );
        let odd = ready.wrapping_byte_add(1);
        refused(covbeam_geometry_build(odd, None, null_mut()), COVBEAM_MISALIGNED, &["geometry", "multiple"]);
        let session: *const covbeam_session = ready.cast();
        refused(covbeam_session_pass(session, None, null_mut()), COVBEAM_INVALID_HANDLE, &["session: not a"]);
        refused(covbeam_geometry_new(null_mut()), COVBEAM_NULL_POINTER, &["out: NULL"]);
        refused(covbeam_geometry_get_info(ready, null_mut()), COVBEAM_NULL_POINTER, &["info: NULL"]);
        let status = covbeam_scene_new(ready, null(), &mut null_mut());
        refused(status, COVBEAM_NULL_POINTER, &["description: NULL"]);
        let freed =
            [covbeam_geometry_free(null_mut()), covbeam_geometry_free(open), covbeam_geometry_free(ready)];
        assert_eq!(freed, [COVBEAM_OK; 3]);
    }
}
