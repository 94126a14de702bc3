//! The threads that work is done on.

use crate::work::failure::{Result, invalid};
use rayon::{ThreadPool, ThreadPoolBuilder};

/// More than any machine has; each costs memory.
pub const MOST: u32 = 1024;

/// So many threads; 0 = one a core.
pub fn pool(count: u32) -> Result<ThreadPool> {
    let name = |index| format!("covbeam {index}");
    let pool = ThreadPoolBuilder::new().num_threads(count as usize).thread_name(name).build();
    pool.map_err(|error| invalid!("threads: {count} cannot be started: {error}"))
}
