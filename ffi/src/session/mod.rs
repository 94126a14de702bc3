//! Sessions: covbeam's whole method behind the C ABI, for hosts that describe their scenes. Made into `covbeam_session.h`.

mod description;
mod fields;
mod geometry;
mod host;
mod identity;
mod picture;
mod render;
mod scene;
mod settings;
#[cfg(test)]
mod tests;

use crate::status::{Failure, covbeam_poll, covbeam_status::*, fail, go_on};
use ::covbeam_session::work::GoOn;
use ::covbeam_session::work::failure;
use core::ffi::c_void;

/// The status and the message of a failure.
fn refused(failure: failure::Failure) -> Failure {
    let status = match &failure {
        failure::Failure::Invalid(_) => COVBEAM_INVALID_VALUE,
        failure::Failure::Order(_) => COVBEAM_WRONG_ORDER,
        failure::Failure::Busy(_) => COVBEAM_BUSY,
        failure::Failure::Data(_) => COVBEAM_BAD_DATA,
        failure::Failure::Cancelled => COVBEAM_CANCELLED,
        failure::Failure::Memory(_) => COVBEAM_OUT_OF_MEMORY,
        failure::Failure::Panicked(_) => COVBEAM_PANICKED,
    };
    match failure {
        failure::Failure::Cancelled => fail(status, format_args!("poll: asked to stop")),
        failure => fail(status, format_args!("{failure}")),
    }
}

/// Calls what asks the host's poll whether to go on.
fn polled<T>(
    poll: covbeam_poll,
    user: *mut c_void,
    call: impl FnOnce(GoOn) -> failure::Result<T>,
) -> Result<T, Failure> {
    call(&mut go_on(poll, user)).map_err(refused)
}
