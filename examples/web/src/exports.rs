//! What the page calls. Numbers cross as they are; pictures are read from the module's memory.

// `no_mangle` counts as unsafe, since two functions of one name would be: nothing else here is.
#![expect(unsafe_code)]

use crate::scene::Settings;
use crate::view::View;
use std::sync::{Mutex, MutexGuard};

/// The view, and its picture as the screen shows it.
struct State {
    view: View,
    shown: Vec<u8>,
}

static STATE: Mutex<Option<State>> = Mutex::new(None);

fn state() -> MutexGuard<'static, Option<State>> {
    STATE.lock().expect("a panic ends the module")
}

/// Begins a picture: `width` x `height` pixels of [`Settings`], `adaptive` 0 or 1.
#[unsafe(no_mangle)]
extern "C" fn begin(
    width: u32,
    height: u32,
    adaptive: u32,
    lamp_angle: f32,
    ball_radius: f32,
    index: f32,
    extinction: f32,
    photons: u32,
    plain_radius: f32,
    seed: u32,
) {
    let adaptive = adaptive != 0;
    let settings =
        Settings { lamp_angle, ball_radius, index, extinction, photons, plain_radius, seed, adaptive };
    let view = View::new(&settings, width, height);
    *state() = Some(State { view, shown: Vec::new() });
}

/// Adds a pass to the picture.
#[unsafe(no_mangle)]
extern "C" fn pass() {
    if let Some(state) = state().as_mut() {
        state.view.pass();
    }
}

/// Makes the picture of the passes so far. Returns where its radiance lies, three floats a pixel.
#[unsafe(no_mangle)]
extern "C" fn picture() -> *const f32 {
    state().as_mut().map_or(std::ptr::null(), |state| state.view.picture().as_ptr().cast())
}

/// Where the picture that was made last lies as the screen shows it, RGBA; valid until the next call.
#[unsafe(no_mangle)]
extern "C" fn shown() -> *const u8 {
    state().as_mut().map_or(std::ptr::null(), |state| {
        state.view.tone_map(&mut state.shown);
        state.shown.as_ptr()
    })
}

/// Eye rays of all passes.
#[unsafe(no_mangle)]
extern "C" fn eye_rays() -> f64 {
    state().as_ref().map_or(0.0, |state| state.view.counts()[0] as f64)
}

/// Pairs of beam and eye ray that they gathered.
#[unsafe(no_mangle)]
extern "C" fn pairs() -> f64 {
    state().as_ref().map_or(0.0, |state| state.view.counts()[1] as f64)
}
