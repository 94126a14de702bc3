//! Gathers and pictures on many threads, with a stand-in for covbeam: every task once, failures passed on,
//! stopped at once. That covbeam's own results come out is tested with the Python module.

#![allow(unsafe_code, reason = "the C interface is what is tested")]
#![allow(clippy::undocumented_unsafe_blocks, reason = "what is shown are locals that outlive the work")]

mod calls;

use calls::refused;
use core::ffi::c_void;
use covbeam_rays::abi::*;
use std::ptr::{null, null_mut};
use std::time::{Duration, Instant};

/// Stands in for covbeam: fails at the ray that is 13 and says so, or counts the rays.
mod stand_in {
    use core::ffi::{c_char, c_void};
    use std::time::Duration;

    pub(super) unsafe extern "C" fn gather(
        _map: *const c_void,
        _kernel: *const c_void,
        _grid: *const c_void,
        count: usize,
        rays: *const c_void,
        _ray_stride: usize,
        gathered: *mut c_void,
        _gathered_stride: usize,
        _scratch: *mut c_void,
        poll: Option<extern "C" fn(*mut c_void) -> i32>,
        user: *mut c_void,
    ) -> i32 {
        for i in 0..count {
            // 99: takes long.
            let ray = unsafe { rays.cast::<u32>().add(i).read() };
            let mut rounds = if ray == 99 { 5000 } else { 0 };
            while rounds > 0 {
                if poll.is_some_and(|poll| poll(user) != 0) {
                    return 11;
                }
                std::thread::sleep(Duration::from_millis(1));
                rounds -= 1;
            }
            if ray == 13 {
                return 3;
            }
            unsafe { gathered.cast::<u32>().add(i).write(ray + 1) };
        }
        0
    }

    pub(super) unsafe extern "C" fn picture(
        film: *const c_void,
        first_row: u32,
        count: usize,
        pixels: *mut c_void,
        pixel_stride: usize,
    ) -> i32 {
        for i in 0..count {
            let value = first_row + film.addr() as u32;
            unsafe { pixels.byte_add(i * pixel_stride).cast::<u32>().write(value) };
        }
        0
    }

    pub(super) unsafe extern "C" fn scratch_new(out: *mut *mut c_void) -> i32 {
        unsafe { out.write(Box::into_raw(Box::new(7u64)).cast()) };
        0
    }

    pub(super) unsafe extern "C" fn scratch_free(scratch: *mut c_void) {
        drop(unsafe { Box::from_raw(scratch.cast::<u64>()) });
    }

    pub(super) unsafe extern "C" fn last_error() -> *const c_char {
        c"the ray is unlucky".as_ptr()
    }
}

fn gatherer() -> *mut c_void {
    let functions = covbeam_rays_functions {
        beam_map_gather: Some(stand_in::gather),
        film_picture: Some(stand_in::picture),
        scratch_new: Some(stand_in::scratch_new),
        scratch_free: Some(stand_in::scratch_free),
        last_error: Some(stand_in::last_error),
    };
    let mut gather = null_mut();
    assert_eq!(unsafe { covbeam_rays_gather_new(&functions, &mut gather) }, 0);
    gather
}

fn start(gather: *const c_void, rays: &[u32], starts: &[isize], out: &mut [u32]) -> i32 {
    let (rays, count, out) = (rays.as_ptr().cast(), rays.len(), out.as_mut_ptr().cast());
    let tasks = starts.len() - 1;
    unsafe {
        covbeam_rays_gather_start(
            gather,
            null(),
            null(),
            null(),
            count,
            rays,
            4,
            tasks,
            starts.as_ptr(),
            out,
            4,
        )
    }
}

/// What the work ends with, and covbeam's status.
fn wait(gather: *const c_void) -> (i32, i32) {
    let (mut done, mut status) = (0, 0);
    loop {
        let ended = unsafe { covbeam_rays_gather_wait(gather, 100, &mut done, &mut status) };
        if ended != 0 || done != 0 {
            assert_eq!(done, 1);
            return (ended, status);
        }
    }
}

#[test]
fn a_gather_does_all_tasks_passes_failures_on_and_stops_at_once() {
    let gather = gatherer();
    let rays: Vec<u32> = (100..400).collect();
    let mut out = vec![0; 300];
    assert_eq!(start(gather, &rays, &[0, 10, 10, 299, 300], &mut out), 0);
    assert_eq!(wait(gather), (0, 0));
    assert!(out.iter().zip(&rays).all(|(out, ray)| *out == ray + 1));
    // Nothing to do.
    assert_eq!(start(gather, &[], &[0], &mut []), 0);
    assert_eq!(wait(gather), (0, 0));

    refused(start(gather, &rays, &[0, 20, 10, 300], &mut out), 1, &["starts[2]", "ascending"]);
    refused(start(gather, &rays, &[1, 300], &mut out), 1, &["starts: from 1 to 300"]);
    refused(start(gather, &rays, &[0, 299], &mut out), 1, &["starts: from 0 to 299"]);
    refused(start(gather, &rays, &[-5, 300], &mut out), 1, &["starts: from -5"]);

    assert_eq!(start(gather, &[1, 13, 2], &[0, 1, 2, 3], &mut out), 0);
    assert_eq!(wait(gather), (4, 3));
    refused(4, 4, &["the ray is unlucky"]);

    assert_eq!(start(gather, &[99], &[0, 1], &mut out), 0);
    refused(start(gather, &rays, &[0, 300], &mut out), 2, &["gather", "goes on"]);
    let (mut done, mut status) = (9, 0);
    unsafe {
        assert_eq!(covbeam_rays_gather_wait(gather, 20, &mut done, &mut status), 0);
        assert_eq!(done, 0);
        let begun = Instant::now();
        assert_eq!(covbeam_rays_gather_stop(gather), 0);
        // covbeam asks every few milliseconds.
        assert!(begun.elapsed() < Duration::from_millis(100), "{:?}", begun.elapsed());
        refused(covbeam_rays_gather_wait(gather, 0, &mut done, &mut status), 2, &["no work"]);
        // Freed while it works.
        assert_eq!(start(gather, &[99], &[0, 1], &mut out), 0);
        assert_eq!(covbeam_rays_gather_free(gather), 0);
        assert!(begun.elapsed() < Duration::from_millis(500));
    }
}

#[test]
fn a_picture_has_all_rows() {
    let gather = gatherer();
    for (width, height) in [(3_u32, 21_u32), (1, 1), (5, 64)] {
        let mut out = vec![u32::MAX; (2 * width * height) as usize];
        let film = std::ptr::without_provenance(1000);
        let pixels = out.as_mut_ptr().cast();
        unsafe {
            assert_eq!(covbeam_rays_picture_start(gather, film, width, height, pixels, 8), 0);
        }
        assert_eq!(wait(gather), (0, 0));
        for (i, pixel) in out.chunks(2).enumerate() {
            assert_eq!(pixel, [1000 + i as u32 / width / 8 * 8, u32::MAX], "{i} of {width} x {height}");
        }
    }
    assert_eq!(unsafe { covbeam_rays_gather_free(gather) }, 0);
}
