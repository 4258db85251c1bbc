//! Locks and bounded waits, of threads that have nothing to do and for threads that were asked to end.
//!
//! Whoever has something for a thread wakes it. Should that ever be missed, the thread finds it after [`IDLE_PERIOD`]
//! all the same: a minute late, and not never.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// For how long a thread that has nothing to do waits before it looks again by itself.
pub const IDLE_PERIOD: Duration = Duration::from_secs(60);

/// How often the end of a thread is looked for.
const END_PERIOD: Duration = Duration::from_millis(2);

/// Locks a mutex whose value is valid even after another thread panicked.
pub fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Waits until `changed` is notified, at most for `timeout`; also after another thread panicked.
pub fn wait_timeout<'a, T>(changed: &Condvar, guard: MutexGuard<'a, T>, timeout: Duration) -> MutexGuard<'a, T> {
    changed.wait_timeout(guard, timeout).unwrap_or_else(PoisonError::into_inner).0
}

/// Waits while what the lock guards is idle; it is woken through `changed`, and looks by itself after [`IDLE_PERIOD`].
pub fn wait_while<'a, T>(
    changed: &Condvar,
    guard: MutexGuard<'a, T>,
    is_idle: impl FnMut(&mut T) -> bool,
) -> MutexGuard<'a, T> {
    look_every(IDLE_PERIOD, changed, guard, is_idle)
}

fn look_every<'a, T>(
    period: Duration,
    changed: &Condvar,
    mut guard: MutexGuard<'a, T>,
    mut is_idle: impl FnMut(&mut T) -> bool,
) -> MutexGuard<'a, T> {
    while is_idle(&mut guard) {
        guard = wait_timeout(changed, guard, period);
    }
    guard
}

/// What a thread that was asked to end returns, if it ends within `patience`. One that does not is left behind.
pub fn join_within<T>(thread: JoinHandle<T>, patience: Duration) -> Option<thread::Result<T>> {
    let asked = Instant::now();
    while !thread.is_finished() {
        if asked.elapsed() >= patience {
            return None;
        }
        thread::sleep(END_PERIOD);
    }
    Some(thread.join())
}

#[cfg(test)]
mod tests {
    use std::sync::{mpsc, Arc, Mutex};

    use super::*;

    #[test]
    fn what_nobody_was_woken_for_is_seen_after_a_while() {
        let shared = Arc::new((Mutex::new(false), Condvar::new()));
        let waiting = Arc::clone(&shared);
        let thread = thread::spawn(move || {
            let (is_there, changed) = &*waiting;
            let seen = *look_every(Duration::from_millis(5), changed, is_there.lock().unwrap(), |is_there| !*is_there);
            seen
        });
        thread::sleep(Duration::from_millis(20));
        assert!(!thread.is_finished(), "it does not wait");
        *shared.0.lock().unwrap() = true;
        assert!(join_within(thread, Duration::from_secs(20)).unwrap().unwrap());
    }

    #[test]
    fn a_thread_that_hangs_is_not_waited_for() {
        let (release, released) = mpsc::channel::<()>();
        let hanging = thread::spawn(move || released.recv().is_ok());
        assert!(join_within(hanging, Duration::from_millis(30)).is_none());
        drop(release);
        assert_eq!(join_within(thread::spawn(|| 1), Duration::from_secs(20)).unwrap().unwrap(), 1);
    }
}
