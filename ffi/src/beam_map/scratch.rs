//! Memory that gathers need.

use crate::handle::{Opaque, free, handle_to};
use crate::memory::Slot;
use crate::status::{covbeam_status, run};
use covbeam_core::{EyeRay, GatherScratch, Gathered};

/// Memory that gathers need, kept from call to call: one a thread.
pub struct covbeam_scratch(());

impl Opaque for covbeam_scratch {
    type Object = Scratch;
    const TAG: u64 = u64::from_le_bytes(*b"cb-scrat");
    const NAME: &'static str = "covbeam_scratch";
}

/// What a `covbeam_scratch` is.
#[derive(Default)]
pub(crate) struct Scratch {
    pub(super) core: GatherScratch,
    pub(super) rays: Vec<EyeRay>,
    pub(super) gathered: Vec<Gathered>,
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
