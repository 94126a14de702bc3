//! The gather in a medium that only the host knows, contact by contact.

use super::gather::gather;
use super::handle::{Beams, covbeam_beam_map};
use super::scratch::{Scratch, covbeam_scratch};
use crate::eye_ray::{covbeam_eye_ray, covbeam_gathered};
use crate::grid::handle::covbeam_grid;
use crate::heap::out_of_memory;
use crate::kernel::options::covbeam_kernel;
use crate::memory::same_layout;
use crate::status::{cancelled, covbeam_poll, covbeam_status, covbeam_status::*, fail, go_on};
use core::ffi::c_void;
use covbeam_core::{BeamMap, Contact, Kernel, Stop};
use glam::Vec3;

/// A place where a beam comes within the kernel radius of an eye ray, for covbeam_beam_map_gather_shaded. A
/// pair of nearly one direction (sine below .05) has eight, along the eye ray.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct covbeam_contact {
    /// The closest point on the eye ray [m].
    pub position: [f32; 3],
    /// Index of the eye ray in the call.
    pub ray: u32,
    /// Index of the beam, in the order in which they were added.
    pub beam: u32,
    /// Distance along the eye ray [m].
    pub ray_distance: f32,
    /// Distance along the beam [m]; at an end on a surface it may be outside the beam by less than radius. At a
    /// negative one, -s, the beam has the optical depth -(the one at s), as if the medium went on behind the
    /// surface.
    pub beam_distance: f32,
    /// Cosine between the light's propagation before and after scattering towards the eye: forward +1.
    pub cos_theta: f32,
    /// The blur kernel over the sine of the angle between beam and ray [1/m], with which the library
    /// multiplies; of the eight places of a pair along the ray, each one's share of its integral.
    pub kernel: f32,
    /// Kernel radius [m].
    pub radius: f32,
    /// Bandwidth along the kernel's axis [cycles/m]; 0 without a grid.
    pub sigma: f32,
}

same_layout!(covbeam_contact, Contact, sigma);

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
            // (asserted above), vectors are three floats, and there are as many of both.
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
