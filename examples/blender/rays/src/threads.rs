//! The threads that calls use.

use crate::failure::{Result, invalid};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::{Arc, Mutex, PoisonError};

/// More than any machine has; each costs memory.
const MOST: usize = 1024;

/// Made by the first call that needs it.
static POOL: Mutex<Option<Arc<ThreadPool>>> = Mutex::new(None);

/// The threads of calls that wait for their end. They last until the last reference is gone.
pub fn pool() -> Result<Arc<ThreadPool>> {
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    match &*pool {
        Some(pool) => Ok(pool.clone()),
        None => Ok(pool.insert(make(0)?).clone()),
    }
}

/// Sets how many threads the calls from now on use; 0 = one a core.
pub fn set(count: usize) -> Result<()> {
    if count > MOST {
        return Err(invalid!("count: {count} threads; give 0 for one a core, or at most {MOST}"));
    }
    let made = make(count)?;
    *POOL.lock().unwrap_or_else(PoisonError::into_inner) = Some(made);
    Ok(())
}

/// As many others.
pub fn others() -> Result<Arc<ThreadPool>> {
    make(pool()?.current_num_threads())
}

fn make(count: usize) -> Result<Arc<ThreadPool>> {
    let name = |index| format!("covbeam rays {index}");
    let pool = ThreadPoolBuilder::new().num_threads(count).thread_name(name).build();
    pool.map(Arc::new).map_err(|error| invalid!("count: {count} threads cannot be started: {error}"))
}
