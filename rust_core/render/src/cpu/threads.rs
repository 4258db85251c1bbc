//! Work on several threads.

use std::sync::{Mutex, PoisonError};

/// Hands the items to the workers, each to the first that is free.
pub(super) fn in_parallel<W: Send, T: Send>(
    workers: &mut [W],
    items: impl Iterator<Item = T> + Send,
    work: impl Fn(&mut W, T) + Sync,
) {
    let items = Mutex::new(items);
    let next = || items.lock().unwrap_or_else(PoisonError::into_inner).next();
    let run = |worker: &mut W| {
        while let Some(item) = next() {
            work(worker, item);
        }
    };
    match workers {
        [worker] => run(worker),
        workers => rayon::scope(|scope| {
            for worker in workers {
                scope.spawn(|_| run(worker));
            }
        }),
    }
}
