//! The threads that work is done on: native ones, or those that a caller starts.

use crate::work::failure::{Result, invalid};
use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuilder};
use std::fmt;
use std::io::Error;
use std::sync::Arc;

/// More than any machine has; each costs memory.
pub const MOST: u32 = 1024;

/// What one thread does, from its start to its end.
#[derive(Debug)]
pub struct Worker(ThreadBuilder);

impl Worker {
    /// Works until nobody needs it any more; blocks meanwhile.
    pub fn run(self) {
        self.0.run();
    }
}

/// Starts threads of the caller's, for hosts whose threads are named, pinned or counted.
#[derive(Clone)]
pub struct Spawn(Arc<Start>);

type Start = dyn Fn(Worker) -> bool + Send + Sync;

impl Spawn {
    /// - `start`: called once for each thread; starts it, lets it [`run`](Worker::run) the worker, and returns at once. False: it has started none,
    ///   and the session is refused.
    pub fn new(start: impl Fn(Worker) -> bool + Send + Sync + 'static) -> Self {
        Self(Arc::new(start))
    }
}

impl fmt::Debug for Spawn {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("Spawn")
    }
}

/// So many threads; 0 = one a core.
pub fn pool(count: u32, spawn: Option<&Spawn>) -> Result<ThreadPool> {
    let name = |index| format!("covbeam {index}");
    let builder = ThreadPoolBuilder::new().num_threads(count as usize).thread_name(name);
    let pool = match spawn {
        None => builder.build(),
        Some(Spawn(start)) => {
            let refused = || Error::other("the caller's spawn has started no thread");
            builder.spawn_handler(|worker| start(Worker(worker)).then_some(()).ok_or_else(refused)).build()
        }
    };
    pool.map_err(|error| invalid!("threads: {count} cannot be started: {error}"))
}
