//! The beams of a pass: added, committed to a hierarchy, gathered by eye rays.

use crate::check::positive;
use crate::grid::covbeam_grid;
use crate::handle::{Opaque, free, handle_to, run_on, shared};
use crate::heap::{grow, out_of_memory};
use crate::kernel::{self, covbeam_kernel};
use crate::medium::{KeptMedium, covbeam_medium};
use crate::memory::{Element, Slot, inputs, outputs};
use crate::status::{Failure, cancelled, covbeam_poll, covbeam_status, covbeam_status::*, fail, go_on, run};
use crate::types::*;
use core::ffi::c_void;
use core::mem::take;
use covbeam_core::{Beam, BeamMap, Contact, EyeRay, GatherScratch, Gathered, Kernel, MAX_BEAMS, Stop};
use glam::Vec3;

/// The beams of one medium and one pass. The cycle of a pass: clear, add (any number of times), commit, gather
/// (any number of times, from any number of threads).
pub struct covbeam_beam_map(());

impl Opaque for covbeam_beam_map {
    type Object = Beams;
    const TAG: u64 = u64::from_le_bytes(*b"cb-beams");
    const NAME: &'static str = "covbeam_beam_map";
}

/// Memory that gathers need, kept from call to call: one a thread.
pub struct covbeam_scratch(());

impl Opaque for covbeam_scratch {
    type Object = Scratch;
    const TAG: u64 = u64::from_le_bytes(*b"cb-scrat");
    const NAME: &'static str = "covbeam_scratch";
}

/// Fills values with three floats a contact: scattering coefficient x phase function x transmittance along the
/// eye ray up to the contact x transmittance along the beam up to it, per channel [1/(m sr)]. Return 0, or
/// anything else to give up.
pub type covbeam_shade = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        contacts: *const covbeam_contact,
        count: usize,
        values: *mut f32,
    ) -> i32,
>;

/// What a `covbeam_beam_map` is.
pub(crate) struct Beams {
    medium: KeptMedium,
    state: State,
}

// One a map: what it takes does not matter.
#[expect(clippy::large_enum_variant)]
enum State {
    Adding(Vec<Beam>),
    Committed(BeamMap),
}

/// What a `covbeam_scratch` is.
#[derive(Default)]
pub(crate) struct Scratch {
    core: GatherScratch,
    rays: Vec<EyeRay>,
    gathered: Vec<Gathered>,
}

impl Beams {
    fn adding(&mut self) -> Result<&mut Vec<Beam>, Failure> {
        match &mut self.state {
            State::Adding(beams) => Ok(beams),
            State::Committed(_) => {
                let message = format_args!("map: committed; covbeam_beam_map_clear begins the next pass");
                Err(fail(COVBEAM_WRONG_ORDER, message))
            }
        }
    }

    fn committed(&self) -> Result<&BeamMap, Failure> {
        match &self.state {
            State::Committed(map) => Ok(map),
            State::Adding(_) => {
                let message = format_args!("map: not committed yet; call covbeam_beam_map_commit first");
                Err(fail(COVBEAM_WRONG_ORDER, message))
            }
        }
    }
}

/// Makes a map without beams.
///
/// @param medium what its beams run through; copied, for all gathers too, and voxels are kept alive. For
///     covbeam_beam_map_gather_shaded: any homogeneous one.
/// @param out the handle.
/// @kinds <medium +map
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_beam_map_new(
    medium: *const covbeam_medium,
    out: *mut *mut covbeam_beam_map,
) -> covbeam_status {
    run(|| {
        let out = Slot::new(out, "out")?;
        // SAFETY: by the caller's promise.
        let medium = unsafe { KeptMedium::read(medium, "medium") }?;
        out.set(handle_to(Beams { medium, state: State::Adding(Vec::new()) })?);
        Ok(())
    })
}

/// Frees a map.
///
/// @param map NULL is fine.
/// @kinds !map
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_beam_map_free(map: *mut covbeam_beam_map) -> covbeam_status {
    // SAFETY: by the caller's promise.
    unsafe { free(map, "map") }
}

/// Begins a pass: forgets all beams, keeps their memory.
///
/// @param map the map.
/// @kinds !map
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_beam_map_clear(map: *mut covbeam_beam_map) -> covbeam_status {
    let clear = |map: &mut Beams| {
        let mut beams = match take(&mut map.state) {
            State::Adding(beams) => beams,
            State::Committed(map) => map.into_beams(),
        };
        beams.clear();
        map.state = State::Adding(beams);
        Ok(())
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(map, "map", clear) }
}

impl Default for State {
    fn default() -> Self {
        State::Adding(Vec::new())
    }
}

/// Adds beams. What a map gathers depends on their order only, not on how they were cut into batches.
///
/// @param map a map that is not committed.
/// @param count number of beams; with 0 nothing is done. At most 2^28 beams in all.
/// @param beams, beam_stride the beams, copied.
/// @kinds !map.adding <beam
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_beam_map_add(
    map: *mut covbeam_beam_map,
    count: usize,
    beams: *const covbeam_beam,
    beam_stride: usize,
) -> covbeam_status {
    let add = |map: &mut Beams| {
        let all = map.adding()?;
        inputs!(count, beams, beam_stride);
        let before = all.len();
        if count > MAX_BEAMS - before {
            let message = format_args!("count: {before} and {count} beams are more than {MAX_BEAMS}");
            return Err(fail(COVBEAM_INVALID_ARRAY, message));
        }
        grow(all, count)?;
        for i in 0..count {
            match beam(beams.get(i)) {
                Ok(beam) => all.push(beam),
                Err(failure) => {
                    all.truncate(before);
                    return Err(failure);
                }
            }
        }
        Ok(())
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(map, "map", add) }
}

/// Builds the hierarchy over the beams. Stopped, the map is as before.
///
/// @param map a map that is not committed.
/// @param max_radius largest kernel radius that it will be gathered with [m] > 0: covbeam_kernel's max_radius.
/// @param poll may be NULL; asked at least every few milliseconds. Not 0 ends the call with COVBEAM_CANCELLED.
/// @param user given to poll.
/// @note n log n in the number of beams: at a million, 0.7 us a beam in a homogeneous medium and 2.8 us in
///     voxels; 190 and about 390 bytes a beam afterwards.
/// @kinds !map.adding $+
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_beam_map_commit(
    map: *mut covbeam_beam_map,
    max_radius: f32,
    poll: covbeam_poll,
    user: *mut c_void,
) -> covbeam_status {
    let commit = |map: &mut Beams| {
        let max_radius = positive(Element::single(max_radius, "max_radius"))?;
        let beams = take(map.adding()?);
        match BeamMap::build_while(beams, max_radius, &map.medium.view(), &mut go_on(poll, user)) {
            Ok(built) => {
                map.state = State::Committed(built);
                Ok(())
            }
            Err(unfinished) => {
                map.state = State::Adding(unfinished.beams);
                Err(match unfinished.reason {
                    Stop::Cancelled => cancelled(),
                    Stop::TooMany => unreachable!("covbeam_beam_map_add takes no more than MAX_BEAMS"),
                    Stop::OtherMedium => unreachable!("no medium was there before"),
                    Stop::OutOfMemory { bytes } => out_of_memory(bytes),
                })
            }
        }
    };
    // SAFETY: by the caller's promise.
    unsafe { run_on(map, "map", commit) }
}

/// How many beams a map has.
///
/// @param map the map, committed or not.
/// @param count receives their number.
/// @kinds @map >size
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_beam_map_get_count(
    map: *const covbeam_beam_map,
    count: *mut usize,
) -> covbeam_status {
    run(|| {
        let count = Slot::new(count, "count")?;
        // SAFETY: by the caller's promise.
        count.set(match &unsafe { shared(map, "map") }?.state {
            State::Adding(beams) => beams.len(),
            State::Committed(built) => built.beams().len(),
        });
        Ok(())
    })
}

/// How much memory a map holds.
///
/// @param map the map, committed or not.
/// @param bytes receives it.
/// @kinds @map >size
/// @extra
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_beam_map_get_memory(
    map: *const covbeam_beam_map,
    bytes: *mut usize,
) -> covbeam_status {
    run(|| {
        let bytes = Slot::new(bytes, "bytes")?;
        // SAFETY: by the caller's promise.
        bytes.set(match &unsafe { shared(map, "map") }?.state {
            State::Adding(beams) => beams.capacity() * size_of::<Beam>(),
            State::Committed(built) => built.memory(),
        });
        Ok(())
    })
}

/// Makes the memory of a thread's gathers.
///
/// @param out the handle.
/// @kinds +scratch
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_scratch_new(out: *mut *mut covbeam_scratch) -> covbeam_status {
    run(|| {
        let out = Slot::new(out, "out")?;
        out.set(handle_to(Scratch::default())?);
        Ok(())
    })
}

/// Frees a thread's memory.
///
/// @param scratch NULL is fine.
/// @kinds !scratch?
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_scratch_free(scratch: *mut covbeam_scratch) -> covbeam_status {
    // SAFETY: by the caller's promise.
    unsafe { free(scratch, "scratch") }
}

/// What both gathers have in common: checks, copies the rays, and writes the results once all of them are
/// there.
unsafe fn gather(
    map: *const covbeam_beam_map,
    kernel: *const covbeam_kernel,
    grid: *const covbeam_grid,
    count: usize,
    rays: *const covbeam_eye_ray,
    ray_stride: usize,
    gathered: *mut covbeam_gathered,
    gathered_stride: usize,
    scratch: *mut covbeam_scratch,
    body: impl FnOnce(&Beams, &BeamMap, &Kernel, &mut Scratch) -> Result<(), Failure>,
) -> covbeam_status {
    let body = |scratch: &mut Scratch| {
        // SAFETY: by the caller's promise.
        let beams = unsafe { shared(map, "map") }?;
        let built = beams.committed()?;
        // SAFETY: by the caller's promise.
        let kernel = unsafe { kernel::read(kernel, grid) }?;
        if kernel.max_radius > built.max_radius() {
            let (wanted, most) = (kernel.max_radius, built.max_radius());
            let message =
                format_args!("kernel: a max_radius of {wanted}, but the map was committed with {most}");
            return Err(fail(COVBEAM_MISMATCH, message));
        }
        inputs!(count, rays, ray_stride);
        outputs!(count, gathered, gathered_stride);
        scratch.rays.clear();
        scratch.gathered.clear();
        grow(&mut scratch.rays, count)?;
        grow(&mut scratch.gathered, count)?;
        for i in 0..count {
            scratch.rays.push(eye_ray(rays.get(i))?);
        }
        scratch.gathered.resize(count, Gathered::default());
        body(&beams, built, &kernel, scratch)?;
        for (i, result) in scratch.gathered.iter().enumerate() {
            gathered.set(i, (*result).into());
        }
        Ok(())
    };
    if scratch.is_null() {
        run(|| body(&mut Scratch::default()))
    } else {
        // SAFETY: by the caller's promise.
        unsafe { run_on(scratch, "scratch", body) }
    }
}

/// Gathers the light that beams scatter into eye rays. Stopped or failed, nothing is written.
///
/// @param map a map that has been committed.
/// @param kernel the kernel and how wide it may be; its max_radius at most the map's.
/// @param grid a grid that has been resolved, for kernels as wide as the light's bandwidth allows. NULL: all
///     kernels have the radius kernel->min_radius, and the max_radius may be that too.
/// @param count number of rays; with 0 nothing is done. Each 256 that follow each other share one walk through
///     the hierarchy: give those of a tile of 8x8 pixels together.
/// @param rays, ray_stride the eye rays, all in the map's medium.
/// @param gathered, gathered_stride receive what each ray gathers.
/// @param scratch the thread's memory; NULL allocates for this call.
/// @param poll may be NULL; asked at least every few milliseconds. Not 0 ends the call with COVBEAM_CANCELLED.
/// @param user given to poll.
/// @note Thesis 5.3.4. An accepted pair costs 38 ns in a homogeneous medium, 59 ns in an exponential one, 61 ns
///     in voxels and 3.3 us a ray.
/// @kinds @map.committed <kernel @grid.resolved? <ray >gathered !scratch?
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_beam_map_gather(
    map: *const covbeam_beam_map,
    kernel: *const covbeam_kernel,
    grid: *const covbeam_grid,
    count: usize,
    rays: *const covbeam_eye_ray,
    ray_stride: usize,
    gathered: *mut covbeam_gathered,
    gathered_stride: usize,
    scratch: *mut covbeam_scratch,
    poll: covbeam_poll,
    user: *mut c_void,
) -> covbeam_status {
    let body = |beams: &Beams, built: &BeamMap, kernel: &Kernel, scratch: &mut Scratch| {
        let Scratch { core, rays, gathered } = scratch;
        let mut go_on = go_on(poll, user);
        let medium = beams.medium.view();
        built.gather_while(&medium, rays, kernel, gathered, core, &mut go_on).map_err(|reason| match reason {
            Stop::Cancelled => cancelled(),
            Stop::OutOfMemory { bytes } => out_of_memory(bytes),
            other => unreachable!("a gather in the map's own medium ends with {other}"),
        })
    };
    // SAFETY: by the caller's promise.
    unsafe { gather(map, kernel, grid, count, rays, ray_stride, gathered, gathered_stride, scratch, body) }
}

/// covbeam_beam_map_gather in a medium that only the host knows: shade says how much light each contact lets
/// through.
///
/// @param map, kernel, grid, count, rays, ray_stride, gathered, gathered_stride, scratch as there. The map's
///     own medium does not matter.
/// @param shade called with up to 256 contacts at a time.
/// @param poll may be NULL, as there.
/// @param user given to shade and to poll.
/// @note About 30 ns a pair on top of what shade takes.
/// @kinds @map.committed <kernel @grid.resolved? <ray >gathered !scratch?
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_beam_map_gather_shaded(
    map: *const covbeam_beam_map,
    kernel: *const covbeam_kernel,
    grid: *const covbeam_grid,
    count: usize,
    rays: *const covbeam_eye_ray,
    ray_stride: usize,
    gathered: *mut covbeam_gathered,
    gathered_stride: usize,
    scratch: *mut covbeam_scratch,
    shade: covbeam_shade,
    poll: covbeam_poll,
    user: *mut c_void,
) -> covbeam_status {
    let body = |_: &Beams, built: &BeamMap, kernel: &Kernel, scratch: &mut Scratch| {
        let Some(shade) = shade else {
            return Err(fail(COVBEAM_NULL_POINTER, format_args!("shade: NULL")));
        };
        let Scratch { core, rays, gathered } = scratch;
        let mut returned = 0;
        let mut shade = |contacts: &[Contact], values: &mut [Vec3]| {
            values.fill(Vec3::ZERO);
            // SAFETY: the host promises that it may be called with `user`; contacts have the layout of covbeam_contact
            // (asserted in `types.rs`), vectors are three floats, and there are as many of both.
            returned =
                unsafe { shade(user, contacts.as_ptr().cast(), contacts.len(), values.as_mut_ptr().cast()) };
            returned == 0
        };
        let found = built.gather_contacts(rays, kernel, gathered, core, &mut shade, &mut go_on(poll, user));
        found.map_err(|reason| match reason {
            Stop::OutOfMemory { bytes } => out_of_memory(bytes),
            _ if returned != 0 => fail(COVBEAM_CALLBACK_FAILED, format_args!("shade: returned {returned}")),
            _ => cancelled(),
        })
    };
    // SAFETY: by the caller's promise.
    unsafe { gather(map, kernel, grid, count, rays, ray_stride, gathered, gathered_stride, scratch, body) }
}
