//! Tasks on all threads, begun in their order.

use crate::failure::{Failure, Result};
use rayon::ThreadPool;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Runs tasks 0 to `count` - 1, each by one of `workers`, until one fails or `cancelled` becomes true. Of several that
/// fail the first counts.
pub fn run(
    pool: &ThreadPool,
    workers: usize,
    count: usize,
    cancelled: &AtomicBool,
    task: impl Fn(usize, usize) -> Result<()> + Sync,
) -> Result<()> {
    let next = AtomicUsize::new(0);
    let stop = AtomicBool::new(false);
    let failed: Mutex<Option<(usize, Failure)>> = Mutex::new(None);
    let work = |worker: usize| {
        while !stop.load(Ordering::Relaxed) && !cancelled.load(Ordering::Relaxed) {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count {
                return;
            }
            if let Err(failure) = task(worker, index) {
                stop.store(true, Ordering::Relaxed);
                let mut failed = failed.lock().expect("nothing panics while it is held");
                if failed.as_ref().is_none_or(|(earlier, _)| index < *earlier) {
                    *failed = Some((index, failure));
                }
            }
        }
    };
    pool.scope(|scope| {
        let work = &work;
        (0..workers).for_each(|worker| scope.spawn(move |_| work(worker)));
    });
    if cancelled.load(Ordering::Relaxed) {
        return Err(Failure::Cancelled);
    }
    failed.into_inner().expect("nothing panics while it is held").map_or(Ok(()), |(_, failure)| Err(failure))
}
