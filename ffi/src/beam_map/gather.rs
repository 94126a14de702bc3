//! The gather of the light that beams scatter into eye rays.

use super::handle::{Beams, covbeam_beam_map};
use super::scratch::{Scratch, covbeam_scratch};
use crate::eye_ray::{covbeam_eye_ray, covbeam_gathered, eye_ray};
use crate::grid::handle::covbeam_grid;
use crate::handle::{run_on, shared};
use crate::heap::{grow, out_of_memory};
use crate::kernel::options::{covbeam_kernel, read_kernel};
use crate::memory::{inputs, outputs};
use crate::status::{Failure, cancelled, covbeam_poll, covbeam_status, covbeam_status::*, fail, go_on, run};
use core::ffi::c_void;
use covbeam_core::{BeamMap, Gathered, Kernel, Stop};

/// What both gathers have in common: checks, copies the rays, and writes the results once all of them are
/// there.
pub(super) unsafe fn gather(
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
        let kernel = unsafe { read_kernel(kernel, grid) }?;
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
