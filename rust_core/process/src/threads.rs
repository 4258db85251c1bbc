//! Locks, bounded waits of idle threads and for threads that were asked to end, and the names of the worker threads.
//!
//! Should a wake-up ever be missed, the thread finds its work after [`IDLE_PERIOD`]: a minute late, and not never.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Longest wait of an idle thread before it polls by itself.
pub const IDLE_PERIOD: Duration = Duration::from_secs(60);

/// Polling period while a thread is to end.
const END_PERIOD: Duration = Duration::from_millis(2);

/// Locks a mutex whose value is valid even after another thread panicked.
pub fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Waits until `changed` is notified, at most for `timeout`; also after another thread panicked.
pub fn wait_timeout<'a, T>(changed: &Condvar, guard: MutexGuard<'a, T>, timeout: Duration) -> MutexGuard<'a, T> {
    changed.wait_timeout(guard, timeout).unwrap_or_else(PoisonError::into_inner).0
}

/// Waits while the guarded value is idle: until a wake-up through `changed`, or for [`IDLE_PERIOD`], and again.
pub fn wait_while<'a, T>(
    changed: &Condvar,
    guard: MutexGuard<'a, T>,
    is_idle: impl FnMut(&mut T) -> bool,
) -> MutexGuard<'a, T> {
    poll_every(IDLE_PERIOD, changed, guard, is_idle)
}

fn poll_every<'a, T>(
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

/// Joins a thread that was asked to end, if it ends within `patience`; else it is left behind.
#[expect(clippy::disallowed_methods, reason = "the thread has ended")]
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

/// Starts rayon's worker threads with the names `draw-0`, `draw-1`, …, for `top -H` and debuggers. To be called before
/// there is parallel work, later it changes nothing.
pub fn name_threads() {
    // Fails if they run already.
    let _ = rayon::ThreadPoolBuilder::new().thread_name(|index| format!("draw-{index}")).build_global();
}

#[cfg(test)]
mod tests {
    use std::sync::{mpsc, Arc, Mutex};

    use super::*;

    #[test]
    fn a_missed_wake_up_is_found_after_the_period() {
        let shared = Arc::new((Mutex::new(false), Condvar::new()));
        let waiting = Arc::clone(&shared);
        let thread = thread::spawn(move || {
            let (is_there, changed) = &*waiting;
            let seen = *poll_every(Duration::from_millis(5), changed, is_there.lock().unwrap(), |is_there| !*is_there);
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
