//! The end of a session's thread.

use super::tasks::locked;
use rayon::ThreadPool;
use std::sync::{Arc, Condvar, Mutex, PoisonError};

/// A session's work on its threads. Where it calls functions of a host, whoever drops this waits until it has ended: what was stopped goes on for a
/// moment, and the host is free to go once its sessions are.
pub(super) struct Served {
    pool: ThreadPool,
    stage: Arc<(Mutex<Stage>, Condvar)>,
    is_hosted: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    Waiting,
    Begun,
    Ended,
}

impl Served {
    pub(super) fn start(pool: ThreadPool, is_hosted: bool, work: impl FnOnce() + Send + 'static) -> Self {
        let stage = Arc::new((Mutex::new(Stage::Waiting), Condvar::new()));
        let ending = Ending(Arc::clone(&stage));
        pool.spawn(move || {
            if ending.begins() {
                work();
            }
        });
        Self { pool, stage, is_hosted }
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        // One of its own threads, in a function of the host's, would wait for itself.
        if !self.is_hosted || self.pool.current_thread_index().is_some() {
            return;
        }
        let (stage, ended) = &*self.stage;
        let mut stage = locked(stage);
        // A host may have started none of the threads that it says it has.
        if *stage == Stage::Waiting {
            *stage = Stage::Ended;
        }
        let waited = ended.wait_while(stage, |stage| *stage != Stage::Ended);
        drop(waited.unwrap_or_else(PoisonError::into_inner));
    }
}

/// Says that the work has ended when it is dropped.
struct Ending(Arc<(Mutex<Stage>, Condvar)>);

impl Ending {
    /// Whether the work may begin: it is still wanted.
    fn begins(&self) -> bool {
        let mut stage = locked(&self.0.0);
        let is_wanted = *stage == Stage::Waiting;
        if is_wanted {
            *stage = Stage::Begun;
        }
        is_wanted
    }
}

impl Drop for Ending {
    fn drop(&mut self) {
        *locked(&self.0.0) = Stage::Ended;
        self.0.1.notify_all();
    }
}
