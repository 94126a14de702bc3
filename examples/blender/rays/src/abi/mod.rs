//! The C interface, and the one place with unsafe code.
//!
//! What the only caller, the Python module, promises: a pointer shows the array or struct that the function says,
//! readable (or writable, if it is not const) during the call;
//! outputs overlap nothing else; handles come from here and are not used after they are freed. Everything else is
//! checked: NULL, alignment, counts, and every number. Any thread may call, several at once.
//!
//! All return 0 or the number of a [`Failure`], whose message `covbeam_rays_last_error` gives; a call that fails has
//! changed nothing but its outputs. No panic leaves.
#![allow(unsafe_code)]

mod description;
mod geometry;
mod memory;
mod session;

pub use description::*;
pub use geometry::*;
pub use session::*;

use crate::failure::{Failure, Result};
use core::ffi::c_char;
use std::cell::RefCell;
use std::ffi::{CStr, CString};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Rises when anything here changes.
const ABI: u32 = 5;

thread_local! {
    static LAST: RefCell<Option<CString>> = const { RefCell::new(None) };
}

/// Runs the body of a call.
fn run(body: impl FnOnce() -> Result<()>) -> i32 {
    let result = catch_unwind(AssertUnwindSafe(body));
    let failure = match result {
        Ok(Ok(())) => return 0,
        Ok(Err(failure)) => failure,
        Err(payload) => Failure::from_panic(&*payload),
    };
    let message = failure.to_string().replace('\0', "");
    LAST.set(CString::new(message).ok());
    failure.status()
}

/// The ABI that this library has.
#[unsafe(no_mangle)]
pub extern "C" fn covbeam_rays_abi_version() -> u32 {
    ABI
}

/// The version of the library, as text.
#[unsafe(no_mangle)]
pub extern "C" fn covbeam_rays_version() -> *const c_char {
    const VERSION: &CStr =
        match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
            Ok(version) => version,
            Err(_) => c"",
        };
    VERSION.as_ptr()
}

/// The message of the thread's latest call that failed, until its next one that fails.
#[unsafe(no_mangle)]
pub extern "C" fn covbeam_rays_last_error() -> *const c_char {
    LAST.with_borrow(|last| last.as_deref().unwrap_or(c"").as_ptr())
}
