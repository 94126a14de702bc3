//! The caller's memory and handles, checked before they are touched.

use crate::failure::{Result, invalid};
use core::ffi::c_void;

/// An array of `count` elements, none of which NULL may show.
///
/// # Safety
/// Readable while the result lives; any bits are a `T`.
pub(super) unsafe fn array<'a, T>(first: *const T, count: usize, name: &str) -> Result<&'a [T]> {
    if count == 0 {
        return Ok(&[]);
    }
    fits(first, count, name)?;
    // SAFETY: not NULL, aligned, of a size that memory can have; readable by the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts(first, count) })
}

/// [`array`] for one that is written.
///
/// # Safety
/// Writable while the result lives, and not used otherwise; any bits are a `T`.
pub(super) unsafe fn array_mut<'a, T>(first: *mut T, count: usize, name: &str) -> Result<&'a mut [T]> {
    if count == 0 {
        return Ok(&mut []);
    }
    fits(first, count, name)?;
    // SAFETY: as for `array`; exclusive by the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts_mut(first, count) })
}

pub(super) fn fits<T>(first: *const T, count: usize, name: &str) -> Result<()> {
    if first.is_null() {
        return Err(invalid!("{name}: NULL"));
    }
    if !first.is_aligned() {
        return Err(invalid!("{name}: not a multiple of {} bytes", align_of::<T>()));
    }
    let bytes = count.checked_mul(size_of::<T>()).filter(|bytes| *bytes <= isize::MAX as usize);
    match bytes.and_then(|bytes| first.addr().checked_add(bytes)) {
        Some(_) => Ok(()),
        None => Err(invalid!("{name}: {count} elements are more than memory has")),
    }
}

/// Writes one result.
///
/// # Safety
/// Writable.
pub(super) unsafe fn set<T>(out: *mut T, value: T, name: &str) -> Result<()> {
    fits(out, 1, name)?;
    // SAFETY: not NULL and aligned; writable by the caller's promise.
    unsafe { out.write(value) };
    Ok(())
}

/// What a handle points to.
#[repr(C)]
struct Handle<T> {
    tag: u64,
    object: T,
}

/// # Safety
/// `out` is writable.
pub(super) unsafe fn new_handle<T>(tag: u64, object: T, out: *mut *mut c_void) -> Result<()> {
    fits(out, 1, "out")?;
    let handle = Box::into_raw(Box::new(Handle { tag, object }));
    // SAFETY: by the caller's promise.
    unsafe { set(out, handle.cast(), "out") }
}

/// # Safety
/// NULL, or a live handle made by `new_handle`.
pub(super) unsafe fn object<'a, T>(handle: *const c_void, tag: u64, name: &str) -> Result<&'a T> {
    let handle: *const Handle<T> = handle.cast();
    fits(handle, 1, name)?;
    // SAFETY: not NULL and aligned; live by the caller's promise, and every kind begins with a tag.
    if unsafe { handle.cast::<u64>().read() } != tag {
        return Err(invalid!("{name}: another kind of handle, or freed"));
    }
    // SAFETY: the tag says that it is of this kind. Shared only: objects lock themselves.
    Ok(unsafe { &(*handle).object })
}

/// # Safety
/// NULL, or a live handle that nobody uses from now on.
pub(super) unsafe fn free<T>(handle: *mut c_void, tag: u64, name: &str) -> Result<()> {
    if handle.is_null() {
        return Ok(());
    }
    // SAFETY: by the caller's promise.
    unsafe { object::<T>(handle, tag, name) }?;
    let handle: *mut Handle<T> = handle.cast();
    // SAFETY: checked above, made from a box.
    let mut boxed = unsafe { Box::from_raw(handle) };
    boxed.tag = 0;
    Ok(())
}
