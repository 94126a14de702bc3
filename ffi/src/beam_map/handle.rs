//! The beams of a pass: added, and committed to a hierarchy.

use crate::beam::{beam, covbeam_beam};
use crate::check::positive;
use crate::handle::{Opaque, free, handle_to, run_on, shared};
use crate::heap::{grow, out_of_memory};
use crate::medium::kept::KeptMedium;
use crate::medium::options::covbeam_medium;
use crate::memory::{Element, Slot, inputs};
use crate::status::{Failure, cancelled, covbeam_poll, covbeam_status, covbeam_status::*, fail, go_on, run};
use core::ffi::c_void;
use core::mem::take;
use covbeam_core::{Beam, BeamMap, MAX_BEAMS, Stop};

/// The beams of one medium and one pass. The cycle of a pass: clear, add (any number of times), commit, gather
/// (any number of times, from any number of threads).
pub struct covbeam_beam_map(());

impl Opaque for covbeam_beam_map {
    type Object = Beams;
    const TAG: u64 = u64::from_le_bytes(*b"cb-beams");
    const NAME: &'static str = "covbeam_beam_map";
}

/// What a `covbeam_beam_map` is.
pub(crate) struct Beams {
    pub(super) medium: KeptMedium,
    state: State,
}

// One a map: what it takes does not matter.
#[expect(clippy::large_enum_variant)]
enum State {
    Adding(Vec<Beam>),
    Committed(BeamMap),
}

impl Default for State {
    fn default() -> Self {
        State::Adding(Vec::new())
    }
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

    pub(super) fn committed(&self) -> Result<&BeamMap, Failure> {
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
        out.set(handle_to(Beams { medium, state: State::default() })?);
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
