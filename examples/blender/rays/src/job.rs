//! Work on native threads that the caller waits for a little at a time.

use crate::failure::{Failure, Result};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Work that goes on until it is done or, some time after it was told so, stops.
#[derive(Debug)]
pub struct Job<T> {
    cancelled: AtomicBool,
    ended: Condvar,
    state: Mutex<State<T>>,
}

#[derive(Debug)]
enum State<T> {
    Running,
    /// It is too late to stop it: what it does now is seen by others.
    Closing,
    Ended(Result<T>),
    Taken,
}

impl<T> Default for Job<T> {
    /// Work that has not begun yet.
    fn default() -> Self {
        Self { cancelled: AtomicBool::new(false), ended: Condvar::new(), state: Mutex::new(State::Running) }
    }
}

impl<T> Job<T> {
    /// Does the work, on the thread that calls; whoever waits gets what comes of it. False: it has panicked.
    pub fn run(&self, work: impl FnOnce() -> Result<T>) -> bool {
        let result = catch_unwind(AssertUnwindSafe(work));
        let is_sound = result.is_ok();
        self.end(result.unwrap_or_else(|payload| Err(Failure::from_panic(&*payload))));
        is_sound
    }

    /// The work has ended, if it has not before.
    pub fn end(&self, result: Result<T>) {
        let mut state = self.locked();
        if state.goes_on() {
            *state = State::Ended(result);
            self.ended.notify_all();
        }
    }

    /// Waits until the work has ended, at most this long. None = it goes on. The result is given once.
    pub fn wait(&self, longest: Duration) -> Option<Result<T>> {
        let waited = self.ended.wait_timeout_while(self.locked(), longest, |state| state.goes_on());
        let (mut state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        if state.goes_on() {
            return None;
        }
        match std::mem::replace(&mut *state, State::Taken) {
            State::Ended(result) => Some(result),
            _ => Some(Err(Failure::Order("the work has ended before; start it again".into()))),
        }
    }

    /// Tells the work to stop, and returns at once: nobody will see what it still does. Where it is too late for that, waits for its end.
    pub fn cancel(&self) {
        let state = self.locked();
        self.cancelled.store(true, Ordering::Relaxed);
        let closing = |state: &mut State<T>| matches!(state, State::Closing);
        drop(self.ended.wait_while(state, closing));
    }

    /// Whether the work is to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Err if the work is to stop.
    pub fn go_on(&self) -> Result<()> {
        if self.is_cancelled() { Err(Failure::Cancelled) } else { Ok(()) }
    }

    /// Err if the work is to stop; from now on it cannot be stopped.
    pub fn close(&self) -> Result<()> {
        let mut state = self.locked();
        self.go_on()?;
        *state = State::Closing;
        Ok(())
    }

    fn locked(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T> State<T> {
    fn goes_on(&self) -> bool {
        matches!(self, Self::Running | Self::Closing)
    }
}
