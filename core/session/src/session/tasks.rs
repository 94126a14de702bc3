//! Tasks of a session, and what its thread and its callers both see.

use super::info::Info;
use crate::film::Picture;
use crate::film::passes::Passes;
use crate::render::{End, Goal};
use crate::work::failure::Failure;
use crate::work::job::Job;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What the session's thread and its callers both see.
#[derive(Default)]
pub(super) struct Shared {
    pub(super) info: Mutex<Info>,
    pub(super) passes: Mutex<Passes>,
    /// The picture of all passes done, once it has been made.
    pub(super) picture: Mutex<Option<Arc<Picture>>>,
}

/// What a session can be told to do.
pub(super) enum Task {
    /// To get ready, which it does unasked.
    Prepare,
    /// The next pass.
    Pass,
    /// Passes until a goal is reached.
    Until(Goal),
    /// A picture of the passes done.
    Picture,
    /// Their sums, as bytes.
    Save,
    /// Sums of other passes.
    Merge(Vec<u8>),
    /// To begin anew.
    Restart { photons: u32, plain: bool },
}

/// What comes of it.
pub(super) enum Done {
    Nothing,
    Reached(End),
    Picture(Arc<Picture>),
    Sums(Vec<u8>),
}

pub(super) struct Order {
    pub(super) task: Task,
    pub(super) job: Arc<Job<Done>>,
}

impl Drop for Order {
    fn drop(&mut self) {
        // Nothing happens if it was carried out.
        let message = "session: it was stopped before it was ready, or has failed; make a new one";
        self.job.end(Err(Failure::Order(message.into())));
    }
}

/// What a mutex guards, whatever became of who had it before.
pub(super) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
