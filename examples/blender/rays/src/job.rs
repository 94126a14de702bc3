//! Work on native threads that the caller waits for a little at a time.

use crate::failure::{Failure, Result};
use crate::threads;
use rayon::ThreadPool;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
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
    Ended(Result<T>),
    Taken,
}

impl<T: Send + 'static> Job<T> {
    /// Starts work on threads of its own, so that it is in nobody's way for as long as it takes to stop. It is given
    /// these and the job, to ask whether it is cancelled.
    pub fn start(work: impl FnOnce(&ThreadPool, &Job<T>) -> Result<T> + Send + 'static) -> Result<Arc<Self>> {
        let pool = threads::others()?;
        let job = Arc::new(Self {
            cancelled: AtomicBool::new(false),
            ended: Condvar::new(),
            state: Mutex::new(State::Running),
        });
        let (running, own) = (job.clone(), pool.clone());
        pool.spawn(move || {
            let result = catch_unwind(AssertUnwindSafe(|| work(&own, &running)));
            let result = result.unwrap_or_else(|payload| Err(Failure::from_panic(&*payload)));
            *running.locked() = State::Ended(result);
            running.ended.notify_all();
        });
        Ok(job)
    }

    /// Waits until the work has ended, at most this long. None = it goes on. The result is given once.
    pub fn wait(&self, longest: Duration) -> Option<Result<T>> {
        let running = |state: &mut State<T>| matches!(state, State::Running);
        let waited = self.ended.wait_timeout_while(self.locked(), longest, running);
        let (mut state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        if running(&mut state) {
            return None;
        }
        match std::mem::replace(&mut *state, State::Taken) {
            State::Ended(result) => Some(result),
            _ => Some(Err(Failure::Order("the work has ended before; start it again".into()))),
        }
    }

    /// Tells the work to stop, and returns at once.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Tells the work to stop, and waits until it has.
    pub fn stop(&self) {
        self.cancel();
        let running = |state: &mut State<T>| matches!(state, State::Running);
        drop(self.ended.wait_while(self.locked(), running));
    }

    /// Becomes true when the work is to stop.
    pub fn cancelled(&self) -> &AtomicBool {
        &self.cancelled
    }

    /// Err if the work is to stop.
    pub fn go_on(&self) -> Result<()> {
        if self.cancelled.load(Ordering::Relaxed) { Err(Failure::Cancelled) } else { Ok(()) }
    }

    fn locked(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
