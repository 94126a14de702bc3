//! How a session renders.

use crate::memory::read_options;
use crate::status::{Failure, covbeam_status::*, fail, work};
use ::covbeam_geometry::MAX_COORDINATE;
use ::covbeam_session::pilot::defaults::{Cells, Given};
use ::covbeam_session::scene::MAX_PHOTONS;
use ::covbeam_session::scene::bounces::BounceLimits;
use ::covbeam_session::settings::{Layers, Method, Settings};
use ::covbeam_session::work::threads::{self, Spawn, Worker};
use core::ffi::c_void;
use core::mem::offset_of;
use std::fmt::Display;

/// Methods, from the catalogue of the reference renderer.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum covbeam_method {
    /// covbeam's: guided light paths, straight light by shadow rays, adaptive kernels for the rest, few eye rays and verified filters.
    COVBEAM_METHOD_COVBEAM = 0,
    /// Section 5.3 of the thesis alone: adaptive kernels from a grid of covariances.
    COVBEAM_METHOD_THESIS = 1,
    /// Plain photon beams: kernels of one radius a pass.
    COVBEAM_METHOD_PLAIN = 2,
    /// Light paths connected with the camera, without kernels: an oracle without bias.
    COVBEAM_METHOD_LIGHT_TRACE = 3,
    /// Light scattered once, by shadow rays along eye rays.
    COVBEAM_METHOD_MARCH = 4,
}

/// Starts a thread of the host's that calls `body(argument)` once, which returns when the session is freed, and returns 0 at once; or anything
/// else, without having started one: the session is refused then.
pub type covbeam_spawn = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        body: unsafe extern "C" fn(argument: *mut c_void),
        argument: *mut c_void,
    ) -> i32,
>;

/// How a session renders. With all fields but struct_size 0: covbeam's method, with what the scene asks for.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct covbeam_session_settings {
    /// sizeof(covbeam_session_settings).
    pub struct_size: u32,
    /// A value of covbeam_method.
    pub method: u32,
    /// Another seed gives another noise, the same seed the same bits.
    pub seed: u32,
    /// Light paths a pass, up to 2^28; 0: as many as the scene asks for. Guided ones that leave few beams are up to 8 times as many.
    pub photons: u32,
    /// Voxels along the longest side of the covariance grid, up to 256; 0: the scene's own.
    pub grid: u32,
    /// Largest number of scatterings and reflections of light on its way, that which sends it to the camera included; 0: any.
    pub most_events: u32,
    /// Number of the first pass, from 0: other machines render others, and covbeam_session_merge adds them.
    pub first_pass: u32,
    /// Threads, up to 1024; 0: one a core. Results do not depend on it.
    pub threads: u32,
    /// Not 0: kinds of light are kept apart, for COVBEAM_LAYER_STRAIGHT and its kin.
    pub kinds_apart: u32,
    /// Not 0: the fog before the first surface is kept apart, for COVBEAM_LAYER_FIRST.
    pub first_apart: u32,
    /// Not 0: there is nothing from the first surface on.
    pub first_alone: u32,
    /// Not 0: each pass has an eye ray through every pixel.
    pub every_pixel: u32,
    /// Of the beams' kernels in the first pass [m]; 0: the scene's own.
    pub radius: f64,
    /// Relative bias that kernels and filters of the first pass may cause, 1e-6 to 1; 0: 0.01. It falls with the passes.
    pub error: f64,
    /// Starts its threads, once for each; NULL: they are the library's own.
    pub spawn: covbeam_spawn,
    /// What it is called with.
    pub spawn_user: *mut c_void,
    /// Limits of events by kind, beside most_events.
    pub limits: covbeam_bounce_limits,
}

/// Limits of scatterings and reflections by kind, as path tracers have them: they count from the camera, every event on the way but the last one
/// before the lamp. With limited 0 there are none, and the other fields count for nothing.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct covbeam_bounce_limits {
    /// Not 0: the other fields hold, 0 included.
    pub limited: u32,
    /// Of all kinds together.
    pub total: u32,
    /// Diffuse reflections.
    pub diffuse: u32,
    /// Other reflections.
    pub glossy: u32,
    /// Transmissions, but for what goes straight on.
    pub transmission: u32,
    /// Scatterings by media, the one that sends light to the camera included: with 0 media scatter what comes straight from the lamps alone.
    pub volume: u32,
    /// Not 0: sharp reflections on the way from a lamp count as glossy alone, from the second one on, as if the lamp were there: caustics of
    /// mirrors, of which path tracers find little, are there whatever the other limits say.
    pub free_reflections: u32,
    /// The same of sharp transmissions: caustics of glass and water.
    pub free_transmissions: u32,
}

fn limits(given: &covbeam_bounce_limits) -> Option<BounceLimits> {
    let &covbeam_bounce_limits { limited, total, diffuse, glossy, transmission, volume, .. } = given;
    let (free_reflections, free_transmissions) = (given.free_reflections != 0, given.free_transmissions != 0);
    (limited != 0).then_some(BounceLimits {
        total,
        diffuse,
        glossy,
        transmission,
        volume,
        free_reflections,
        free_transmissions,
    })
}

type Start =
    unsafe extern "C" fn(*mut c_void, unsafe extern "C" fn(argument: *mut c_void), *mut c_void) -> i32;

/// Voxels along a side of the grid.
const MOST_VOXELS: u32 = 256;

/// What the session takes of it.
pub(super) struct Chosen {
    pub(super) given: Given,
    pub(super) settings: Settings,
    pub(super) first_pass: u32,
    pub(super) threads: u32,
    pub(super) spawn: Option<Spawn>,
}

/// Reads and checks settings.
///
/// # Safety
/// `settings` is NULL or readable.
pub(super) unsafe fn chosen(settings: *const covbeam_session_settings) -> Result<Chosen, Failure> {
    // What came later may be missing.
    const LEAST: usize = offset_of!(covbeam_session_settings, limits);
    // SAFETY: by this function's contract.
    let given = unsafe { read_options(settings, LEAST, "settings") }?;
    let covbeam_session_settings { seed, photons, grid, most_events, threads, radius, error, .. } = given;
    let method = method(given.method)?;
    if !(radius == 0.0 || (1e-9..=f64::from(MAX_COORDINATE)).contains(&radius)) {
        return Err(wrong("radius", radius, "a number from 1e-9 to 1e9, or 0 for the scene's own"));
    }
    if !(error == 0.0 || (1e-6..=1.0).contains(&error)) {
        return Err(wrong("error", error, "a number from 1e-6 to 1, or 0 for 0.01"));
    }
    for (name, value, most) in
        [("photons", photons, MAX_PHOTONS), ("grid", grid, MOST_VOXELS), ("threads", threads, threads::MOST)]
    {
        if value > most {
            return Err(wrong(name, value, &format!("a number up to {most}, 0 for the default")));
        }
    }
    if given.first_pass > i32::MAX as u32 {
        return Err(wrong("first_pass", given.first_pass, "a number below 2^31"));
    }
    let mut numbers = Given {
        cells: (grid > 0).then_some(Cells::Longest(grid)),
        photons: (photons > 0).then_some(photons),
        radius: (radius > 0.0).then_some(radius as f32),
        ..Given::default()
    };
    // Of a scene that is dark.
    numbers.settings.guided_photons = numbers.photons.unwrap_or(numbers.settings.guided_photons);
    numbers.settings.seed = seed;
    if error > 0.0 {
        numbers.settings.schedule.error = error as f32;
    }
    numbers.settings.bounces = most_events.checked_sub(1);
    numbers.settings.limits = limits(&given.limits);
    let mut settings = Settings::of(method, photons, seed);
    settings.first_apart = given.first_apart != 0;
    settings.beyond = given.first_alone == 0;
    settings.planned &= given.every_pixel == 0;
    if given.first_apart != 0 && !settings.planned {
        let wanted = "0 with this method, or with an eye ray through every pixel";
        return Err(wrong("first_apart", given.first_apart, wanted));
    }
    if given.kinds_apart != 0 {
        if !matches!(method, Method::Covbeam | Method::Thesis) {
            return Err(wrong("kinds_apart", given.kinds_apart, "0 with this method"));
        }
        settings.layers = Layers::EachKind;
    }
    let spawn = given.spawn.map(|start| spawn(start, given.spawn_user));
    Ok(Chosen { given: numbers, settings, first_pass: given.first_pass, threads, spawn })
}

fn method(given: u32) -> Result<Method, Failure> {
    match given {
        m if m == covbeam_method::COVBEAM_METHOD_COVBEAM as u32 => Ok(Method::Covbeam),
        m if m == covbeam_method::COVBEAM_METHOD_THESIS as u32 => Ok(Method::Thesis),
        m if m == covbeam_method::COVBEAM_METHOD_PLAIN as u32 => Ok(Method::Plain),
        m if m == covbeam_method::COVBEAM_METHOD_LIGHT_TRACE as u32 => Ok(Method::LightTrace),
        m if m == covbeam_method::COVBEAM_METHOD_MARCH as u32 => Ok(Method::March),
        other => Err(wrong("method", other, "a covbeam_method")),
    }
}

/// Threads that a host starts.
fn spawn(start: Start, user: *mut c_void) -> Spawn {
    struct Host(Start, *mut c_void);
    // SAFETY: it is called from the thread that makes the session, one call at a time.
    unsafe impl Send for Host {}
    // SAFETY: as above.
    unsafe impl Sync for Host {}
    impl Host {
        fn start(&self, worker: Worker) -> bool {
            let worker = Box::into_raw(Box::new(worker));
            // SAFETY: the host's function, with what the host gave for it.
            let is_started = unsafe { (self.0)(self.1, body, worker.cast()) } == 0;
            if !is_started {
                // SAFETY: nobody else has it.
                drop(unsafe { Box::from_raw(worker) });
            }
            is_started
        }
    }
    let host = Host(start, user);
    Spawn::new(move |worker| host.start(worker))
}

/// What a thread of the host does.
unsafe extern "C" fn body(worker: *mut c_void) {
    // SAFETY: the host passes on what it was given, once.
    let worker = unsafe { Box::from_raw(worker.cast::<Worker>()) };
    // Work that panics is caught where it is done.
    work(|| worker.run());
}

fn wrong(name: &str, value: impl Display, wanted: &str) -> Failure {
    fail(COVBEAM_INVALID_VALUE, format_args!("settings.{name}: {value}; give {wanted}"))
}
