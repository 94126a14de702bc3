//! Opaque handles: made, checked, used and freed here and nowhere else.

use crate::heap::boxed;
use crate::memory::aligned;
use crate::status::{Failure, covbeam_status, covbeam_status::*, fail, is_nested, run};
use core::ops::Deref;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// What a C type stands for.
pub(crate) trait Opaque {
    /// The object behind the handle.
    type Object;
    /// Tells handles apart; eight letters, so that a debugger shows them.
    const TAG: u64;
    /// In messages.
    const NAME: &'static str;
}

#[repr(C)]
struct Boxed<T> {
    tag: u64,
    /// How many calls look at the object, or [`CHANGING`].
    users: AtomicU32,
    /// The process that counts them.
    process: AtomicU32,
    poisoned: AtomicBool,
    object: T,
}

/// Users of an object that one call has for itself.
const CHANGING: u32 = u32::MAX;

/// Moves an object to memory of its own, and returns its handle.
pub(crate) fn handle_to<H: Opaque>(object: H::Object) -> Result<*mut H, Failure> {
    let (users, poisoned) = (AtomicU32::new(0), AtomicBool::new(false));
    let process = AtomicU32::new(std::process::id());
    Ok(Box::into_raw(boxed(Boxed { tag: H::TAG, users, process, poisoned, object })?).cast())
}

/// The memory of a handle, checked to be of its kind. Nobody's reference to all of it ever exists: what another call
/// changes is only looked at as `users` allows.
unsafe fn of_kind<H: Opaque>(handle: *const H, name: &str) -> Result<*mut Boxed<H::Object>, Failure> {
    let boxed: *const Boxed<H::Object> = handle.cast();
    aligned(boxed, name)?;
    // SAFETY: not NULL and aligned; that it points to a live handle of some kind is the host's promise, and every
    // kind begins with a tag.
    if unsafe { boxed.cast::<u64>().read() } != H::TAG {
        return Err(fail(COVBEAM_INVALID_HANDLE, format_args!("{name}: not a {}, or freed", H::NAME)));
    }
    Ok(boxed.cast_mut())
}

/// Like [`of_kind`], and fit to be used.
unsafe fn checked<H: Opaque>(handle: *const H, name: &str) -> Result<*mut Boxed<H::Object>, Failure> {
    // SAFETY: the host's promise.
    let boxed = unsafe { of_kind(handle, name) }?;
    // SAFETY: the tag says that `handle_to` made it of this type.
    if unsafe { &(*boxed).poisoned }.load(Ordering::Relaxed) {
        let message = format_args!("{name}: an earlier call on this {} panicked; free it", H::NAME);
        return Err(fail(COVBEAM_POISONED, message));
    }
    Ok(boxed)
}

fn busy<H: Opaque>(name: &str) -> Failure {
    let message = format_args!("{name}: busy, another call on this {} has not returned yet", H::NAME);
    fail(COVBEAM_BUSY, message)
}

/// An object that calls look at, as long as this lives.
pub(crate) struct Shared<'a, T> {
    object: &'a T,
    users: &'a AtomicU32,
}

impl<'a, T> Shared<'a, T> {
    /// The object, for a [`View`] of it.
    pub(crate) fn object(&self) -> &'a T {
        self.object
    }
}

impl<T> Deref for Shared<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.object
    }
}

impl<T> Drop for Shared<'_, T> {
    fn drop(&mut self) {
        self.users.fetch_sub(1, Ordering::Release);
    }
}

/// A view of an object that calls look at, as long as this lives; or a value that needs none.
pub(crate) struct View<'a, V, T> {
    pub(crate) value: V,
    pub(crate) object: Option<Shared<'a, T>>,
}

impl<V, T> Deref for View<'_, V, T> {
    type Target = V;

    fn deref(&self) -> &V {
        &self.value
    }
}

/// The object behind a `const` handle.
pub(crate) unsafe fn shared<'a, H: Opaque>(
    handle: *const H,
    name: &str,
) -> Result<Shared<'a, H::Object>, Failure> {
    // SAFETY: the host's promise: a live handle.
    let boxed = unsafe { checked(handle, name) }?;
    // SAFETY: checked above; an atomic may be looked at whoever uses the object.
    let users = unsafe { &(*boxed).users };
    let one_more = |users: u32| (users < CHANGING - 1).then(|| users + 1);
    let counted = users.fetch_update(Ordering::Acquire, Ordering::Relaxed, one_more);
    counted.map_err(|_| busy::<H>(name))?;
    // SAFETY: no call changes the object before `users` is 0 again.
    Ok(Shared { object: unsafe { &(*boxed).object }, users })
}

/// Like [`shared`], for a handle that may be NULL.
pub(crate) unsafe fn optional<'a, H: Opaque>(
    handle: *const H,
    name: &str,
) -> Result<Option<Shared<'a, H::Object>>, Failure> {
    if handle.is_null() {
        return Ok(None);
    }
    // SAFETY: as for `shared`.
    unsafe { shared(handle, name) }.map(Some)
}

/// An object that one call has for itself, as long as this lives.
struct Alone<'a>(&'a AtomicU32);

impl<'a> Alone<'a> {
    fn with<H: Opaque>(users: &'a AtomicU32, process: &AtomicU32, name: &str) -> Result<Self, Failure> {
        let take = || users.compare_exchange(0, CHANGING, Ordering::Acquire, Ordering::Relaxed).is_ok();
        let is_taken = take() || forget_lost(users, process) && take();
        if is_taken { Ok(Self(users)) } else { Err(busy::<H>(name)) }
    }
}

/// Looks of threads that a process has left behind where it was forked never end: forgets those. Only the thread that forked goes on there, with
/// its own, if it is in a callback. An object that was being changed stays so, half-changed as it is. Returns whether there were any.
fn forget_lost(users: &AtomicU32, process: &AtomicU32) -> bool {
    let (here, counted_by) = (std::process::id(), process.load(Ordering::Relaxed));
    let lost = users.load(Ordering::Acquire);
    if counted_by == here || lost == CHANGING || is_nested() {
        return false;
    }
    let is_first = process.compare_exchange(counted_by, here, Ordering::AcqRel, Ordering::Relaxed).is_ok();
    if is_first {
        users.fetch_sub(lost, Ordering::Release);
    }
    is_first
}

impl Drop for Alone<'_> {
    fn drop(&mut self) {
        self.0.store(0, Ordering::Release);
    }
}

/// Runs the body of a call that changes an object. If it panics, the object is poisoned.
pub(crate) unsafe fn run_on<H: Opaque>(
    handle: *mut H,
    name: &str,
    body: impl FnOnce(&mut H::Object) -> Result<(), Failure>,
) -> covbeam_status {
    let status = run(|| {
        // SAFETY: the host's promise: a live handle.
        let boxed = unsafe { checked(handle.cast_const(), name) }?;
        // SAFETY: checked above; atomics may be looked at whoever uses the object.
        let (users, process) = unsafe { (&(*boxed).users, &(*boxed).process) };
        let _alone = Alone::with::<H>(users, process, name)?;
        // SAFETY: no other call uses the object.
        body(unsafe { &mut (*boxed).object })
    });
    if status == COVBEAM_PANICKED {
        // SAFETY: only the body panics, and it ran because the handle was live.
        unsafe { &(*handle.cast::<Boxed<H::Object>>()).poisoned }.store(true, Ordering::Relaxed);
    }
    status
}

/// Frees a handle; NULL is fine. One that is poisoned is freed too; the tag is wiped, so that a second free
/// or a later use is noticed as long as the memory is not used for something else.
pub(crate) unsafe fn free<H: Opaque>(handle: *mut H, name: &str) -> covbeam_status {
    if handle.is_null() {
        return COVBEAM_OK;
    }
    run(|| {
        // SAFETY: the host's promise: a live handle.
        let boxed = unsafe { of_kind(handle.cast_const(), name) }?;
        // SAFETY: checked above; atomics may be looked at whoever uses the object.
        let (users, process) = unsafe { (&(*boxed).users, &(*boxed).process) };
        core::mem::forget(Alone::with::<H>(users, process, name)?);
        // SAFETY: `handle_to` boxed it, and no other call uses it.
        unsafe {
            (*boxed).tag = 0;
            drop(Box::from_raw(boxed));
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam_map::handle::{covbeam_beam_map_clear, covbeam_beam_map_free};
    use crate::grid::handle::{
        Grid, covbeam_grid, covbeam_grid_clear, covbeam_grid_free, covbeam_grid_get_layout, covbeam_grid_new,
    };
    use crate::grid::look_up::covbeam_grid_resolve;
    use crate::grid::merge::covbeam_grid_merge;
    use crate::hostile::message;
    use crate::voxels::covbeam_grid_layout;
    use core::ptr;
    use std::process::Command;

    const LAYOUT: covbeam_grid_layout = covbeam_grid_layout { min: [0.0; 3], max: [1.0; 3], cells: [2; 3] };

    fn grid() -> *mut covbeam_grid {
        let mut grid = ptr::null_mut();
        // SAFETY: both point to locals.
        assert_eq!(unsafe { covbeam_grid_new(&LAYOUT, &mut grid) }, COVBEAM_OK);
        grid
    }

    #[test]
    fn a_panic_inside_a_call_poisons_its_object_and_nothing_else() {
        let (hit, other) = (grid(), grid());
        let mut layout = LAYOUT;
        // SAFETY: live handles, each used by this thread alone.
        unsafe {
            let status = run_on(hit, "grid", |_: &mut Grid| panic!("injected {}", 42));
            assert_eq!(status, COVBEAM_PANICKED);
            assert!(message().contains("injected 42") && message().contains("handle.rs"), "{}", message());
            assert_eq!(covbeam_grid_clear(hit), COVBEAM_POISONED);
            assert!(message().starts_with("grid: an earlier call on this covbeam_grid panicked"));
            assert_eq!(covbeam_grid_get_layout(hit, &mut layout), COVBEAM_POISONED);
            assert_eq!(covbeam_grid_merge(other, &hit.cast_const(), 1), COVBEAM_POISONED);
            assert_eq!(covbeam_grid_resolve(other), COVBEAM_OK);
            assert_eq!([free(hit, "grid"), free(other, "grid")], [COVBEAM_OK; 2]);
        }
    }

    #[test]
    fn a_panic_in_a_call_that_only_reads_poisons_nothing() {
        let grid = grid();
        // SAFETY: a live handle, used by this thread alone.
        unsafe {
            let status = run(|| {
                let _grid = shared(grid.cast_const(), "grid")?;
                panic!("injected")
            });
            assert_eq!(status, COVBEAM_PANICKED);
            assert_eq!([covbeam_grid_clear(grid), free(grid, "grid")], [COVBEAM_OK; 2]);
        }
    }

    /// Run by `a_panic_prints_nothing_inside_a_call_and_all_outside` in a process of its own.
    #[test]
    #[ignore = "the other process of a test"]
    fn panics_inside_and_outside() {
        assert_eq!(run(|| panic!("panic inside")), COVBEAM_PANICKED);
        assert!(std::panic::catch_unwind(|| panic!("panic outside")).is_err());
    }

    #[test]
    fn a_panic_prints_nothing_inside_a_call_and_all_outside() {
        let mut process = Command::new(std::env::current_exe().unwrap());
        process.args(["--exact", "handle::tests::panics_inside_and_outside", "--ignored", "--nocapture"]);
        let output = process.output().unwrap();
        let printed =
            String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && printed.contains("1 passed"), "{printed}");
        assert!(!printed.contains("panic inside") && printed.contains("panic outside"), "{printed}");
    }

    #[cfg(unix)]
    #[test]
    fn what_other_threads_looked_at_where_a_process_was_forked_is_free_in_the_child() {
        unsafe extern "C" {
            fn fork() -> i32;
            fn waitpid(child: i32, status: *mut i32, options: i32) -> i32;
            fn _exit(code: i32) -> !;
        }
        let grid = grid();
        let address = grid as usize;
        let (looks, looked) = std::sync::mpsc::channel();
        let (end, ended) = std::sync::mpsc::channel::<()>();
        let other = std::thread::spawn(move || {
            let handle = address as *const covbeam_grid;
            run(|| {
                // SAFETY: a live handle until this thread has ended.
                let _look = unsafe { shared(handle, "grid") }?;
                looks.send(()).expect("the test listens");
                ended.recv().expect("the test says so");
                Ok(())
            })
        });
        looked.recv().expect("a look");
        // SAFETY: a live handle; the child does nothing but two calls, and ends.
        let child = unsafe {
            assert_eq!(covbeam_grid_clear(grid), COVBEAM_BUSY);
            match fork() {
                0 => {
                    let changed = covbeam_grid_clear(grid) == COVBEAM_OK;
                    _exit(if changed && covbeam_grid_free(grid) == COVBEAM_OK { 0 } else { 1 })
                }
                child => child,
            }
        };
        let mut status = -1;
        // SAFETY: `status` is a local.
        assert_eq!(unsafe { waitpid(child, &mut status, 0) }, child);
        assert_eq!(status, 0);
        // In the parent it is as it was.
        // SAFETY: live handles, and the other thread ends before the last call.
        unsafe {
            assert_eq!(covbeam_grid_clear(grid), COVBEAM_BUSY);
            end.send(()).expect("it waits");
            assert_eq!(other.join().expect("no panic"), COVBEAM_OK);
            assert_eq!([covbeam_grid_clear(grid), free(grid, "grid")], [COVBEAM_OK; 2]);
        }
    }

    #[test]
    fn handles_of_another_kind_and_freed_ones_are_refused() {
        let grid = grid();
        // SAFETY: a live handle of another kind; the call looks at its tag only.
        let status = unsafe { covbeam_beam_map_clear(grid.cast()) };
        assert_eq!(status, COVBEAM_INVALID_HANDLE);
        assert_eq!(message(), "map: not a covbeam_beam_map, or freed");
        // SAFETY: a free of the wrong kind is refused by the tag, too; then the right one.
        unsafe {
            assert_eq!(covbeam_beam_map_free(grid.cast()), COVBEAM_INVALID_HANDLE);
            assert_eq!(covbeam_grid_clear(grid), COVBEAM_OK);
            assert_eq!([covbeam_grid_free(grid), covbeam_grid_free(ptr::null_mut())], [COVBEAM_OK; 2]);
        }
    }
}
