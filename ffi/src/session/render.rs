//! Sessions: passes of a scene.

use super::scene::covbeam_scene;
use super::settings::{Chosen, chosen, covbeam_session_settings};
use super::{polled, refused};
use crate::handle::{Opaque, free, handle_to, shared};
use crate::memory::{Slot, inputs, read_options};
use crate::status::{Failure, covbeam_poll, covbeam_status, covbeam_status::*, fail, run};
use crate::voxels::covbeam_grid_layout;
use ::covbeam_session::render::{End, Goal};
use ::covbeam_session::session::{Options, Session};
use core::ffi::c_void;
use std::time::Duration;

/// A render of a scene, pass by pass, on native threads of its own. One call renders at a time; meanwhile other threads may ask for
/// covbeam_session_get_info and for layers of a picture that has been made, and for all else they are told COVBEAM_BUSY.
pub struct covbeam_session(());

impl Opaque for covbeam_session {
    type Object = Session;
    const TAG: u64 = u64::from_le_bytes(*b"cb-sessi");
    const NAME: &'static str = "covbeam_session";
}

/// When a render is finished: as soon as one of these is reached. One pass is always made.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_goal {
    /// sizeof(covbeam_goal).
    pub struct_size: u32,
    /// After so many passes in all; 0: however many.
    pub passes: u32,
    /// So long after the call [s]: a pass that would end later is cut; 0: however long.
    pub seconds: f64,
    /// When the median over the lit pixels of standard error over luminance is below this; 0: however large.
    pub error: f64,
}

/// How covbeam_session_until has ended.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum covbeam_end {
    /// The goal is reached.
    COVBEAM_END_REACHED = 0,
    /// Passes or time were over before the error was small enough.
    COVBEAM_END_NOT_REACHED = 1,
    /// An error was asked for, and no light reaches the picture.
    COVBEAM_END_DARK = 2,
}

/// Instants of a scene.
const MOST_INSTANTS: usize = 1024;

/// Where a session stands.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_session_info {
    /// Seconds that passes have taken, by part, shared out by what the parts took of all threads: light paths; the light fields that some of them
    /// carry; the grid; hierarchies of beams; where eye rays and light paths are needed, the getting ready too; eye rays and the beams around them.
    pub seconds: [f64; 6],
    /// And pictures.
    pub picture_seconds: f64,
    /// Accepted pairs of beam and eye ray, of all passes.
    pub pairs: u64,
    /// What light and picture are expected to take at most [bytes].
    pub memory: u64,
    /// Passes that it holds.
    pub passes: u32,
    /// Light paths of a pass.
    pub photons: u32,
    /// Those that the settings ask for.
    pub most_photons: u32,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// What the scene asks for: box and cells of the covariance grid. Hosts of the kernels alone may take these numbers, too.
    pub grid: covbeam_grid_layout,
    /// Of the kernels in the first pass [m].
    pub radius: f32,
    /// Largest radius [m].
    pub max_radius: f32,
    /// Light paths of a pass, of those that go where their power goes.
    pub plain_photons: u32,
    /// And of those that go where the picture needs them.
    pub guided_photons: u32,
}

/// Makes a session of a scene, or of the same one at several instants while a shutter is open. Numbers that nobody has given are chosen, which
/// takes up to a second or two.
///
/// @param count number of scenes: a power of two, up to 1024. Of n of them each is in two of 2 n passes; what moves is blurred.
/// @param scenes, scene_stride handles; they may be freed afterwards. The stride of one scene may be 0.
/// @param settings how to render.
/// @param poll, user asked at least every 50 ms, in this thread, whether to go on; NULL: it always goes on.
/// @param out the handle.
/// @note COVBEAM_OUT_OF_MEMORY if the picture is expected to need more memory than there is. What is allocated later is not checked
///     again: a system that refuses it ends the process, as it does with any Rust program.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_session_new(
    count: usize,
    scenes: *const *const covbeam_scene,
    scene_stride: usize,
    settings: *const covbeam_session_settings,
    poll: covbeam_poll,
    user: *mut c_void,
    out: *mut *mut covbeam_session,
) -> covbeam_status {
    run(|| {
        let out = Slot::new(out, "out")?;
        inputs!(count, scenes, scene_stride);
        // One that is repeated may be any number of them.
        if count > MOST_INSTANTS {
            let message = format_args!("count: {count} scenes; give up to {MOST_INSTANTS}");
            return Err(fail(COVBEAM_INVALID_ARRAY, message));
        }
        let (mut instants, mut contents) = (Vec::new(), super::identity::Contents::default());
        for index in 0..count {
            // SAFETY: by the caller's promise.
            let one = unsafe { shared(scenes.get(index).value, "scenes") }?;
            contents.array(&one.contents.identity().0);
            instants.push(std::sync::Arc::clone(&one.scene));
        }
        // SAFETY: by the caller's promise.
        let Chosen { given, settings, first_pass, threads, spawn } = unsafe { chosen(settings) }?;
        contents.note(&(&given, &settings));
        let identity = contents.identity();
        let options = Options { given: Some(given), settings, first_pass, identity, threads, spawn };
        let session = polled(poll, user, |go_on| Session::new(&instants, options, go_on))?;
        out.set(handle_to(session)?);
        Ok(())
    })
}

/// Frees a session. If its scene is a host's, none of the host's functions is called any more when this returns (unless one of them calls it).
///
/// @param session NULL is fine.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_session_free(session: *mut covbeam_session) -> covbeam_status {
    // SAFETY: by the caller's promise.
    unsafe { free(session, "session") }
}

/// Renders the next pass. A pass is a function of scenes, settings and its number: the same bits for any number of threads.
///
/// @param session the session.
/// @param poll, user asked at least every 50 ms whether to go on. Where it is to stop the pass is lost, and those before are kept.
/// @note The first one takes up to a second more: a pilot finds out where light paths are needed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_session_pass(
    session: *const covbeam_session,
    poll: covbeam_poll,
    user: *mut c_void,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let session = unsafe { shared(session, "session") }?;
        polled(poll, user, |go_on| session.pass(go_on))
    })
}

/// Renders passes until a goal is reached.
///
/// @param session the session.
/// @param goal when it is.
/// @param poll, user as in covbeam_session_pass; the passes done are kept.
/// @param end receives a value of covbeam_end; NULL is fine.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_session_until(
    session: *const covbeam_session,
    goal: *const covbeam_goal,
    poll: covbeam_poll,
    user: *mut c_void,
    end: *mut u32,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let (session, goal) = unsafe { (shared(session, "session")?, read_goal(goal)?) };
        let end = if end.is_null() { None } else { Some(Slot::new(end, "end")?) };
        let ended = match polled(poll, user, |go_on| session.until(goal, go_on))? {
            End::Reached => covbeam_end::COVBEAM_END_REACHED,
            End::NotReached => covbeam_end::COVBEAM_END_NOT_REACHED,
            End::Dark => covbeam_end::COVBEAM_END_DARK,
            End::Cancelled => return Err(fail(COVBEAM_CANCELLED, format_args!("poll: asked to stop"))),
        };
        if let Some(end) = end {
            end.set(ended as u32);
        }
        Ok(())
    })
}

/// # Safety
/// `goal` is NULL or readable.
unsafe fn read_goal(goal: *const covbeam_goal) -> Result<Goal, Failure> {
    // SAFETY: by this function's contract.
    let given = unsafe { read_options(goal, size_of::<covbeam_goal>(), "goal") }?;
    let wrong = |name: &str, value: f64| {
        fail(COVBEAM_INVALID_VALUE, format_args!("goal.{name}: {value}; give a number >= 0, 0 for none"))
    };
    let time = match given.seconds {
        0.0 => None,
        seconds => Some(Duration::try_from_secs_f64(seconds).map_err(|_| wrong("seconds", seconds))?),
    };
    if !(given.error >= 0.0 && given.error.is_finite()) {
        return Err(wrong("error", given.error));
    }
    let goal = Goal {
        passes: (given.passes > 0).then_some(given.passes),
        time,
        error: (given.error > 0.0).then_some(given.error),
    };
    if goal == Goal::default() {
        return Err(fail(
            COVBEAM_INVALID_VALUE,
            format_args!("goal: it has none; give passes, seconds or an error"),
        ));
    }
    Ok(goal)
}

/// Forgets all passes.
///
/// @param session the session.
/// @param photons light paths of the passes to come, at least one and at most those of the settings.
/// @param plain not 0: light paths do without a pilot that learns where they are needed: far noisier, and there at once.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_session_restart(
    session: *const covbeam_session,
    photons: u32,
    plain: u32,
) -> covbeam_status {
    run(|| {
        // SAFETY: by the caller's promise.
        let session = unsafe { shared(session, "session") }?;
        session.restart(photons, plain != 0).map_err(refused)
    })
}

/// Where a session stands: may be asked while another call renders.
///
/// @param session the session.
/// @param info receives it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_session_get_info(
    session: *const covbeam_session,
    info: *mut covbeam_session_info,
) -> covbeam_status {
    run(|| {
        let info = Slot::new(info, "info")?;
        // SAFETY: by the caller's promise.
        let session = unsafe { shared(session, "session") }?;
        let ([width, height], found) = (session.size(), session.info());
        let (times, chosen) = (found.times, found.chosen);
        info.set(covbeam_session_info {
            seconds: [times.trace, times.light_fields, times.grid, times.build, times.plan, times.gather],
            picture_seconds: found.picture,
            pairs: times.pairs,
            memory: found.memory,
            passes: found.passes,
            photons: found.photons,
            most_photons: found.most_photons,
            width,
            height,
            grid: covbeam_grid_layout {
                min: chosen.grid.min.to_array(),
                max: chosen.grid.max.to_array(),
                cells: chosen.grid.cells,
            },
            radius: chosen.schedule.radius,
            max_radius: chosen.schedule.max_radius,
            plain_photons: chosen.photons,
            guided_photons: chosen.guided_photons,
        });
        Ok(())
    })
}
