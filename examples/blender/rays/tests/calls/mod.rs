//! How calls of the C interface end.

use core::ffi::CStr;
use covbeam_rays::abi::covbeam_rays_last_error;

/// Of the thread's latest call that failed.
pub(crate) fn message() -> String {
    unsafe { CStr::from_ptr(covbeam_rays_last_error()) }.to_str().expect("UTF-8").to_owned()
}

/// A call must end with this status, and a message that has all these parts.
#[track_caller]
pub(crate) fn refused(status: i32, wanted: i32, parts: &[&str]) {
    let message = message();
    assert_eq!(status, wanted, "{message}");
    assert!(parts.iter().all(|part| message.contains(part)), "{message} lacks one of {parts:?}");
}
