//! The library's own memory: where there is none, a call ends in COVBEAM_OUT_OF_MEMORY.

use crate::status::{Failure, covbeam_status::*, fail};
use core::ops::Deref;
use core::ptr::NonNull;
use std::alloc::{Layout, alloc};
use std::sync::atomic::{AtomicUsize, Ordering, fence};

/// The failure of a call that could not have so much memory.
pub(crate) fn out_of_memory(bytes: usize) -> Failure {
    fail(COVBEAM_OUT_OF_MEMORY, format_args!("no memory: {bytes} bytes were wanted"))
}

/// An empty vector with room for `count` elements.
pub(crate) fn reserved<T>(count: usize) -> Result<Vec<T>, Failure> {
    let mut vector = Vec::new();
    reserve(&mut vector, count)?;
    Ok(vector)
}

/// Room for exactly `more` elements behind those of a vector.
pub(crate) fn reserve<T>(vector: &mut Vec<T>, more: usize) -> Result<(), Failure> {
    vector.try_reserve_exact(more).map_err(|_| no_room(vector, more))
}

/// Room for `more` elements, and where that is not there yet for so many that asking again and again costs little.
pub(crate) fn grow<T>(vector: &mut Vec<T>, more: usize) -> Result<(), Failure> {
    vector.try_reserve(more).map_err(|_| no_room(vector, more))
}

#[cold]
fn no_room<T>(vector: &[T], more: usize) -> Failure {
    out_of_memory(vector.len().saturating_add(more).saturating_mul(size_of::<T>()))
}

/// `Box::new`, which cannot fail.
pub(crate) fn boxed<T>(value: T) -> Result<Box<T>, Failure> {
    const { assert!(size_of::<T>() > 0) };
    let layout = Layout::new::<T>();
    // SAFETY: the size is not 0.
    let Some(memory) = NonNull::new(unsafe { alloc(layout) }.cast::<T>()) else {
        return Err(out_of_memory(layout.size()));
    };
    // SAFETY: memory of the global allocator with the layout of a `T`, which is written before the box is made.
    unsafe {
        memory.write(value);
        Ok(Box::from_raw(memory.as_ptr()))
    }
}

/// One of several owners of a value: an `Arc` that can be made fallibly.
pub(crate) struct Owner<T>(NonNull<Owned<T>>);

struct Owned<T> {
    owners: AtomicUsize,
    value: T,
}

// SAFETY: as of `Arc`: owners on several threads share the value, and any of them may drop it.
unsafe impl<T: Send + Sync> Send for Owner<T> {}
// SAFETY: as above.
unsafe impl<T: Send + Sync> Sync for Owner<T> {}

impl<T> Owner<T> {
    pub(crate) fn new(value: T) -> Result<Self, Failure> {
        let owned = boxed(Owned { owners: AtomicUsize::new(1), value })?;
        Ok(Self(NonNull::from(Box::leak(owned))))
    }
}

impl<T> Deref for Owner<T> {
    type Target = T;

    fn deref(&self) -> &T {
        // SAFETY: alive as long as it has an owner.
        &unsafe { self.0.as_ref() }.value
    }
}

impl<T> Clone for Owner<T> {
    fn clone(&self) -> Self {
        // SAFETY: as for `deref`. Each owner takes memory of its own: fewer than a usize can count.
        unsafe { self.0.as_ref() }.owners.fetch_add(1, Ordering::Relaxed);
        Self(self.0)
    }
}

impl<T> Drop for Owner<T> {
    fn drop(&mut self) {
        // SAFETY: as for `deref`.
        if unsafe { self.0.as_ref() }.owners.fetch_sub(1, Ordering::Release) == 1 {
            // What other owners did with the value comes before its end.
            fence(Ordering::Acquire);
            // SAFETY: `new` boxed it, and this was the last owner.
            drop(unsafe { Box::from_raw(self.0.as_ptr()) });
        }
    }
}
