//! Sessions.

use super::description::SCENE;
use super::memory::{array, array_mut, fits, free, new_handle, object, set};
use super::run;
use crate::failure::{Result, invalid};
use crate::session::{Session, SessionInfo, SettingsFields, Task};
use core::ffi::c_void;
use covbeam_session::scene::Scene;
use std::sync::Arc;
use std::time::Duration;

/// Of handles.
const SESSION: u64 = u64::from_ne_bytes(*b"session\0");

/// Makes a session of a scene at so many instants, which begins to get ready: wait for that before all else.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_session_new(
    scene_count: usize,
    scenes: *const *const c_void,
    settings: *const SettingsFields,
    out: *mut *mut c_void,
) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        fits(out, 1, "out")?;
        let scenes = array(scenes, scene_count, "scenes")?.iter();
        let scenes = scenes.map(|scene| object::<Arc<Scene>>(*scene, SCENE, "scene").map(Arc::clone));
        let scenes = scenes.collect::<Result<Vec<_>>>()?;
        let settings = array(settings, 1, "settings")?[0];
        new_handle(SESSION, Session::new(&scenes, &settings)?, out)
    })
}

/// Stops what goes on and frees a session; NULL is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_session_free(session: *mut c_void) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe { free::<Session>(session, SESSION, "session") })
}

/// Starts the next pass (`task` = 0), or a picture of the passes done (1).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_session_start(session: *const c_void, task: u32) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        let task = match task {
            0 => Task::Pass,
            1 => Task::Picture,
            _ => return Err(invalid!("task: {task}; give 0 for a pass, or 1 for a picture")),
        };
        object::<Session>(session, SESSION, "session")?.start(task)
    })
}

/// Waits for the end of what was started, at most so long; `done` becomes 1 if it has been reached.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_session_wait(
    session: *const c_void,
    milliseconds: u32,
    done: *mut u32,
) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        fits(done, 1, "done")?;
        let session = object::<Session>(session, SESSION, "session")?;
        let ended = session.wait(Duration::from_millis(milliseconds.into()))?;
        set(done, ended.into(), "done")
    })
}

/// Stops what goes on, without waiting for its threads: it leaves no trace. A pass that is nearly done is done when this returns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_session_stop(session: *const c_void) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        object::<Session>(session, SESSION, "session")?.stop();
        Ok(())
    })
}

/// Forgets all passes; those to come have so many light paths, at most those of the settings. If `plain` is not 0, they are not guided:
/// noisier, but there at once.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_session_restart(
    session: *const c_void,
    photons: u32,
    plain: u32,
) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe { object::<Session>(session, SESSION, "session")?.restart(photons, plain != 0) })
}

/// Where a session stands.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_session_info(session: *const c_void, info: *mut SessionInfo) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe { set(info, object::<Session>(session, SESSION, "session")?.info(), "info") })
}

/// The picture that was started last, once: arrays of `pixel_count` elements, rows from the top.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_session_picture(
    session: *const c_void,
    pixel_count: usize,
    in_scattered: *mut [f32; 3],
    first: *mut [f32; 3],
    radius: *mut f32,
    bandwidth: *mut f32,
    error: *mut f32,
) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        let session = object::<Session>(session, SESSION, "session")?;
        let count = session.pixel_count();
        if pixel_count != count {
            return Err(invalid!("pixel_count: {pixel_count}; the camera has {count}"));
        }
        let colors = [array_mut(in_scattered, count, "in_scattered")?, array_mut(first, count, "first")?];
        let values = [
            array_mut(radius, count, "radius")?,
            array_mut(bandwidth, count, "bandwidth")?,
            array_mut(error, count, "error")?,
        ];
        let picture = session.picture()?;
        for (out, found) in colors.into_iter().zip([&picture.in_scattered, &picture.first]) {
            out.copy_from_slice(found);
        }
        for (out, found) in values.into_iter().zip([&picture.radius, &picture.bandwidth, &picture.error]) {
            out.copy_from_slice(found);
        }
        Ok(())
    })
}
