//! Calls of covbeam on many threads.

use super::memory::{array, fits, free, new_handle, object, set};
use super::run;
use crate::failure::{Failure, Result, invalid};
use crate::job::Job;
use crate::{tasks, threads};
use core::ffi::{CStr, c_char, c_void};
use std::ptr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Of handles.
const GATHER: u64 = u64::from_ne_bytes(*b"gatherer");

type Poll = extern "C" fn(*mut c_void) -> i32;

type BeamMapGather = unsafe extern "C" fn(
    map: *const c_void,
    kernel: *const c_void,
    grid: *const c_void,
    count: usize,
    rays: *const c_void,
    ray_stride: usize,
    gathered: *mut c_void,
    gathered_stride: usize,
    scratch: *mut c_void,
    poll: Option<Poll>,
    user: *mut c_void,
) -> i32;

type FilmPicture = unsafe extern "C" fn(
    film: *const c_void,
    first_row: u32,
    count: usize,
    pixels: *mut c_void,
    pixel_stride: usize,
) -> i32;

/// Rows of a picture that a thread takes at a time; covbeam wants a multiple of 8.
const ROWS: u32 = 8;

/// The functions of covbeam that are called: addresses of those of the same names in covbeam.h, so that this library is
/// linked to none.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct covbeam_rays_functions {
    /// covbeam_beam_map_gather.
    pub beam_map_gather: Option<BeamMapGather>,
    /// covbeam_film_picture.
    pub film_picture: Option<FilmPicture>,
    /// covbeam_scratch_new.
    pub scratch_new: Option<unsafe extern "C" fn(out: *mut *mut c_void) -> i32>,
    /// covbeam_scratch_free.
    pub scratch_free: Option<unsafe extern "C" fn(scratch: *mut c_void)>,
    /// covbeam_last_error.
    pub last_error: Option<unsafe extern "C" fn() -> *const c_char>,
}

/// Calls covbeam on many threads, each with a scratch of its own.
struct Gather {
    functions: covbeam_rays_functions,
    /// covbeam_scratch, as many as threads were ever used.
    scratches: Mutex<Vec<Shared>>,
    job: Mutex<Option<Arc<Job<()>>>>,
}

/// A pointer of the caller that threads use: to what is only read, or of which each task writes a part of its own.
#[derive(Clone, Copy)]
struct Shared(*mut c_void);

// SAFETY: the caller promises that covbeam's objects and the arrays stay until the work has ended; covbeam.h allows
// threads to share maps, kernels, grids and films; a scratch is one worker's, and tasks write apart.
unsafe impl Send for Shared {}
// SAFETY: as above.
unsafe impl Sync for Shared {}

impl Shared {
    fn new(pointer: *const c_void) -> Self {
        Self(pointer.cast_mut())
    }

    /// Element `index` of an array.
    fn at(&self, index: usize, stride: usize) -> *mut c_void {
        self.0.wrapping_byte_add(index * stride)
    }
}

impl Gather {
    /// Starts tasks; `task` gets a scratch, the number of the task, and the flag that stops it.
    fn start(
        &self,
        count: usize,
        task: impl Fn(*mut c_void, usize, &AtomicBool) -> i32 + Send + Sync + 'static,
    ) -> Result<()> {
        let mut job = self.job.lock().unwrap_or_else(PoisonError::into_inner);
        if job.is_some() {
            return Err(Failure::Order("gather: work goes on; wait for its end, or stop it".into()));
        }
        let workers = threads::pool()?.current_num_threads();
        let scratches = self.scratches(workers)?;
        let last_error = self.functions.last_error.expect("checked by covbeam_rays_gather_new");
        *job = Some(Job::start(move |pool, job| {
            tasks::run(pool, workers, count, job.cancelled(), |worker, index| {
                let scratches = &scratches;
                match task(scratches[worker].0, index, job.cancelled()) {
                    0 => Ok(()),
                    _ if job.cancelled().load(Ordering::Relaxed) => Err(Failure::Cancelled),
                    status => {
                        // SAFETY: covbeam's promise: never NULL, ends with NUL, stays until this thread's next call.
                        let message = unsafe { CStr::from_ptr(last_error()) };
                        Err(Failure::Covbeam(status, message.to_string_lossy().into_owned()))
                    }
                }
            })
        })?);
        Ok(())
    }

    fn scratches(&self, workers: usize) -> Result<Vec<Shared>> {
        let make = self.functions.scratch_new.expect("checked by covbeam_rays_gather_new");
        let mut scratches = self.scratches.lock().unwrap_or_else(PoisonError::into_inner);
        while scratches.len() < workers {
            let mut scratch = ptr::null_mut();
            // SAFETY: shows a local.
            let status = unsafe { make(&mut scratch) };
            if status != 0 {
                return Err(Failure::Covbeam(status, "no memory for a thread's scratch".into()));
            }
            scratches.push(Shared(scratch));
        }
        Ok(scratches.clone())
    }

    /// Some while work goes on.
    fn job(&self) -> Option<Arc<Job<()>>> {
        self.job.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn ended(&self) {
        *self.job.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    fn stop(&self) {
        if let Some(job) = self.job() {
            job.stop();
            self.ended();
        }
    }
}

impl Drop for Gather {
    fn drop(&mut self) {
        self.stop();
        let free = self.functions.scratch_free.expect("checked by covbeam_rays_gather_new");
        for scratch in self.scratches.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
            // SAFETY: made by covbeam_scratch_new; the work that used it has ended.
            unsafe { free(scratch.0) };
        }
    }
}

/// covbeam's poll while it gathers: `user` is the flag that stops the work.
extern "C" fn poll(user: *mut c_void) -> i32 {
    // SAFETY: the flag of the job, which lives while its tasks run.
    unsafe { &*user.cast::<AtomicBool>() }.load(Ordering::Relaxed).into()
}

/// Makes an object that calls covbeam on many threads.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_gather_new(
    functions: *const covbeam_rays_functions,
    out: *mut *mut c_void,
) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        let functions = array(functions, 1, "functions")?[0];
        let given = functions.beam_map_gather.is_some()
            && functions.film_picture.is_some()
            && functions.scratch_new.is_some()
            && functions.scratch_free.is_some()
            && functions.last_error.is_some();
        if !given {
            return Err(invalid!("functions: one of the addresses is NULL"));
        }
        new_handle(GATHER, Gather { functions, scratches: Mutex::default(), job: Mutex::default() }, out)
    })
}

/// Stops what goes on and frees the object; NULL is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_gather_free(gather: *mut c_void) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe { free::<Gather>(gather, GATHER, "gather") })
}

/// Starts covbeam_beam_map_gather for `task_count` tasks: task i has the rays from `starts[i]` to before `starts[i +
/// 1]`. `starts` is copied; all else must stay until the work has ended.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_gather_start(
    gather: *const c_void,
    map: *const c_void,
    kernel: *const c_void,
    grid: *const c_void,
    ray_count: usize,
    rays: *const c_void,
    ray_stride: usize,
    task_count: usize,
    starts: *const isize,
    gathered: *mut c_void,
    gathered_stride: usize,
) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        let gather = object::<Gather>(gather, GATHER, "gather")?;
        let count = task_count.checked_add(1).ok_or_else(|| invalid!("starts: {task_count} tasks"))?;
        let starts = array(starts, count, "starts")?;
        if let Some(wrong) = starts.windows(2).position(|pair| pair[0] > pair[1]) {
            return Err(invalid!("starts[{}]: smaller than the one before; give them ascending", wrong + 1));
        }
        if starts[0] != 0 || starts[task_count].cast_unsigned() != ray_count {
            let (first, last) = (starts[0], starts[task_count]);
            return Err(invalid!(
                "starts: from {first} to {last}; give 0 first and the {ray_count} rays last"
            ));
        }
        let starts: Vec<usize> = starts.iter().map(|start| start.cast_unsigned()).collect();
        let call = gather.functions.beam_map_gather.expect("checked by covbeam_rays_gather_new");
        let [map, kernel, grid, rays, gathered] = [map, kernel, grid, rays, gathered].map(Shared::new);
        gather.start(task_count, move |scratch, task, stop| {
            // All of them, not their fields.
            let (map, kernel, grid, rays, gathered) = (&map, &kernel, &grid, &rays, &gathered);
            let (from, to) = (starts[task], starts[task + 1]);
            let user = ptr::from_ref(stop).cast_mut().cast();
            // SAFETY: covbeam's contract, which the caller has promised to keep; the scratch is this worker's own.
            call(
                map.0,
                kernel.0,
                grid.0,
                to - from,
                rays.at(from, ray_stride),
                ray_stride,
                gathered.at(from, gathered_stride),
                gathered_stride,
                scratch,
                Some(poll),
                user,
            )
        })
    })
}

/// Starts covbeam_film_picture for all rows of a picture. The film and the pixels, `pixel_stride` bytes apart, must stay until the
/// work has ended.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_picture_start(
    gather: *const c_void,
    film: *const c_void,
    width: u32,
    height: u32,
    pixels: *mut c_void,
    pixel_stride: usize,
) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        let gather = object::<Gather>(gather, GATHER, "gather")?;
        let call = gather.functions.film_picture.expect("checked by covbeam_rays_gather_new");
        let [film, pixels] = [film, pixels.cast_const()].map(Shared::new);
        gather.start(height.div_ceil(ROWS) as usize, move |_, task, _| {
            let (film, pixels) = (&film, &pixels);
            let first = task as u32 * ROWS;
            let (before, count) =
                (first as usize * width as usize, ROWS.min(height - first) as usize * width as usize);
            // SAFETY: covbeam's contract, which the caller has promised to keep.
            call(film.0, first, count, pixels.at(before, pixel_stride), pixel_stride)
        })
    })
}

/// Waits for the work, at most so long; `done` becomes 1 if it has ended. If a function of covbeam failed, `status`
/// becomes its covbeam_status and the message is covbeam's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_gather_wait(
    gather: *const c_void,
    milliseconds: u32,
    done: *mut u32,
    status: *mut i32,
) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        fits(done, 1, "done")?;
        fits(status, 1, "status")?;
        let gather = object::<Gather>(gather, GATHER, "gather")?;
        let job = gather.job().ok_or_else(|| Failure::Order("gather: no work goes on; start some".into()))?;
        let Some(result) = job.wait(Duration::from_millis(milliseconds.into())) else {
            return set(done, 0, "done");
        };
        gather.ended();
        set(done, 1, "done")?;
        if let Err(Failure::Covbeam(number, _)) = &result {
            set(status, *number, "status")?;
        }
        result
    })
}

/// Stops the work, if some goes on, and waits until its threads have left off.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn covbeam_rays_gather_stop(gather: *const c_void) -> i32 {
    // SAFETY: the contract of this module.
    run(|| unsafe {
        object::<Gather>(gather, GATHER, "gather")?.stop();
        Ok(())
    })
}
