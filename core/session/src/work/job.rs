//! Work on native threads that the caller waits for a little at a time.

use crate::work::GoOn;
use crate::work::failure::{Failure, Result};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Between two questions whether to go on.
const INTERVAL: Duration = Duration::from_millis(40);

/// Work that goes on until it is done or, some time after it was told so, stops.
#[derive(Debug)]
pub(crate) struct Job<T> {
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
    pub(crate) fn run(&self, work: impl FnOnce() -> Result<T>) -> bool {
        let result = catch_unwind(AssertUnwindSafe(work));
        let is_sound = result.is_ok();
        self.end(result.unwrap_or_else(|payload| Err(Failure::from_panic(&*payload))));
        is_sound
    }

    /// The work has ended, if it has not before.
    pub(crate) fn end(&self, result: Result<T>) {
        let mut state = self.locked();
        if state.goes_on() {
            *state = State::Ended(result);
            self.ended.notify_all();
        }
    }

    /// Waits until the work has ended, at most this long. None = it goes on. The result is given once.
    pub(crate) fn wait(&self, longest: Duration) -> Option<Result<T>> {
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

    /// What comes of it, at the end, while this thread asks whether to go on. If it is to stop, [`Failure::Cancelled`], at once, and nobody will see
    /// what it still does; or, if what it has done is kept, its result once it has stopped.
    pub(crate) fn result(&self, go_on: GoOn, keeps_work: bool) -> Result<T> {
        loop {
            if let Some(result) = self.wait(INTERVAL) {
                return result;
            }
            if !go_on() {
                // What is nearly done is done when this returns.
                self.cancel();
                let longest = if keeps_work { Duration::MAX } else { Duration::ZERO };
                return self.wait(longest).unwrap_or(Err(Failure::Cancelled));
            }
        }
    }

    /// Tells the work to stop, and returns at once: nobody will see what it still does. Where it is too late for that, waits for its end.
    pub(crate) fn cancel(&self) {
        let state = self.locked();
        self.cancelled.store(true, Ordering::Relaxed);
        let closing = |state: &mut State<T>| matches!(state, State::Closing);
        drop(self.ended.wait_while(state, closing));
    }

    /// Whether the work is to stop.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Err if the work is to stop.
    pub(crate) fn go_on(&self) -> Result<()> {
        if self.is_cancelled() { Err(Failure::Cancelled) } else { Ok(()) }
    }

    /// Err if the work is to stop; from now on it cannot be stopped.
    pub(crate) fn close(&self) -> Result<()> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Barrier};
    use std::thread::{self, sleep};
    use std::time::Instant;

    /// What a caller does not notice.
    const QUICK: Duration = Duration::from_millis(50);

    /// A job on a thread of its own that has begun, and the thread.
    fn begun(
        work: impl FnOnce(&Job<u32>) -> Result<u32> + Send + 'static,
    ) -> (Arc<Job<u32>>, thread::JoinHandle<bool>) {
        let (job, started) = (Arc::<Job<u32>>::default(), Arc::new(Barrier::new(2)));
        let (running, ready) = (Arc::clone(&job), Arc::clone(&started));
        let thread = thread::spawn(move || {
            running.run(|| {
                ready.wait();
                work(&running)
            })
        });
        started.wait();
        (job, thread)
    }

    #[test]
    fn a_job_that_panics_fails() {
        let job = Job::<()>::default();
        assert!(!job.run(|| panic!("a broken job")));
        let failure = job.wait(Duration::ZERO).expect("ended").expect_err("fails");
        assert_eq!(failure, Failure::Panicked("a defect of covbeam: a broken job".into()));
        assert!(matches!(job.wait(Duration::ZERO), Some(Err(Failure::Order(_)))), "its result is given once");
        assert!(matches!(job.result(&mut || true, false), Err(Failure::Order(_))));
    }

    #[test]
    fn a_job_that_is_cancelled_is_not_waited_for_unless_it_is_closing() {
        for is_closing in [false, true] {
            let closed = Arc::new(Barrier::new(2));
            let closing = Arc::clone(&closed);
            let (job, thread) = begun(move |job| {
                if is_closing {
                    job.close()?;
                }
                closing.wait();
                sleep(2 * QUICK);
                if is_closing { Ok(1) } else { job.close().map(|()| 1) }
            });
            closed.wait();
            assert_eq!(job.wait(Duration::from_millis(1)), None);
            let start = Instant::now();
            job.cancel();
            assert_eq!(start.elapsed() < QUICK, !is_closing, "{:?}", start.elapsed());
            assert!(thread.join().expect("no panic"));
            // What was closed in time counts; what was not has done nothing.
            let expected = if is_closing { Ok(1) } else { Err(Failure::Cancelled) };
            assert_eq!(job.wait(Duration::ZERO), Some(expected));
        }
    }

    #[test]
    fn whoever_waits_for_a_result_is_asked_all_the_time_on_the_same_thread() {
        let (job, thread) = begun(|_| {
            sleep(Duration::from_millis(300));
            Ok(7)
        });
        let (here, mut asked) = (thread::current().id(), 0);
        let go_on = &mut || {
            assert_eq!(thread::current().id(), here);
            asked += 1;
            true
        };
        assert_eq!(job.result(go_on, false), Ok(7));
        // Every 40 ms is seven times; a busy machine may be late, but not by half.
        assert!((4..=8).contains(&asked), "{asked} times");
        assert!(thread.join().expect("no panic"));
    }

    #[test]
    fn a_result_that_is_there_is_given_without_a_question() {
        let job = Job::default();
        job.end(Ok(1));
        // The first end counts.
        job.end(Ok(2));
        assert!(job.run(|| Ok(3)));
        assert_eq!(job.result(&mut || panic!("asked"), false), Ok(1));
    }

    #[test]
    fn a_no_ends_the_wait_at_once_and_the_work_when_it_looks() {
        let (job, thread) = begun(|job| {
            while job.go_on().is_ok() {
                sleep(Duration::from_millis(1));
            }
            sleep(2 * QUICK);
            Ok(1)
        });
        let (mut refused, mut asked) = (Instant::now(), 0);
        let result = job.result(
            &mut || {
                asked += 1;
                refused = Instant::now();
                asked < 3
            },
            false,
        );
        assert!(refused.elapsed() < QUICK, "{:?}", refused.elapsed());
        assert_eq!((result, asked), (Err(Failure::Cancelled), 3));
        assert!(job.is_cancelled() && thread.join().expect("no panic"));
    }

    #[test]
    fn a_no_is_too_late_for_what_is_closing() {
        let (job, thread) = begun(|job| {
            job.close()?;
            sleep(3 * QUICK);
            Ok(5)
        });
        assert_eq!(job.result(&mut || false, false), Ok(5));
        assert!(thread.join().expect("no panic"));
    }

    #[test]
    fn work_that_is_kept_is_waited_for_once_it_was_told_to_stop() {
        let (job, thread) = begun(|job| {
            let mut done = 0;
            while job.go_on().is_ok() {
                done = 9;
                sleep(Duration::from_millis(1));
            }
            sleep(QUICK);
            Ok(done)
        });
        assert_eq!(job.result(&mut || false, true), Ok(9));
        assert!(thread.join().expect("no panic"));
    }
}
