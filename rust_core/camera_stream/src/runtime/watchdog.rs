//! Names what hangs.
//!
//! What works for the pictures on a thread of its own (the scene, calls, compression, windows) tells since when it has
//! been busy with one step, and with which ([`Worker`]). One more thread looks at all of them each second, and logs a
//! step that takes longer than [`HANG_AFTER`]; again after each doubling.

use std::io;
use std::sync::mpsc::{sync_channel, RecvTimeoutError, SyncSender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::thread;
use std::time::{Duration, Instant};

/// How long a step may take before it is logged.
const HANG_AFTER: Duration = Duration::from_secs(5);
/// How often all workers are looked at.
const PERIOD: Duration = Duration::from_secs(1);

/// Something that may hang.
pub(crate) trait Worker: Send + Sync {
    /// What it is doing, and since when; `None` while it waits for work. Must not wait itself.
    fn step(&self) -> Option<(String, Instant)>;

    /// What that means meanwhile, if there is more to say than that it hangs.
    fn consequence(&self) -> Option<&'static str> {
        None
    }
}

/// A worker of one step.
#[derive(Debug)]
pub(crate) struct Task {
    name: String,
    since: Mutex<Option<Instant>>,
}

impl Task {
    /// A task of this name, as in `NAME has taken 5 s so far`, that is watched for as long as it lives.
    pub(crate) fn watched(name: impl Into<String>) -> Arc<Self> {
        let task = Arc::new(Self { name: name.into(), since: Mutex::default() });
        watch(&task);
        task
    }

    /// Work begins.
    pub(crate) fn begin(&self) {
        *lock(&self.since) = Some(Instant::now());
    }

    /// The task waits for work.
    pub(crate) fn wait_for_work(&self) {
        *lock(&self.since) = None;
    }
}

impl Worker for Task {
    fn step(&self) -> Option<(String, Instant)> {
        lock(&self.since).map(|since| (self.name.clone(), since))
    }
}

/// A worker, and how long a hang lasts that is logged next.
struct Watched {
    worker: Weak<dyn Worker>,
    next: Duration,
}

static WORKERS: Mutex<Vec<Watched>> = Mutex::new(Vec::new());

/// Has a worker watched for as long as it lives.
pub(crate) fn watch<W: Worker + 'static>(worker: &Arc<W>) {
    let worker: Weak<W> = Arc::downgrade(worker);
    lock(&WORKERS).push(Watched { worker, next: HANG_AFTER });
}

/// Watches all workers until it is dropped.
#[derive(Debug)]
pub(crate) struct Watchdog {
    _end: SyncSender<()>,
}

impl Watchdog {
    /// Starts the thread.
    ///
    /// # Errors
    /// The system's, where there is no thread left.
    pub(crate) fn start() -> io::Result<Self> {
        let (end, is_ended) = sync_channel(0);
        let watching = move || {
            while is_ended.recv_timeout(PERIOD) == Err(RecvTimeoutError::Timeout) {
                for line in hangs(&mut lock(&WORKERS), Instant::now()) {
                    log::error!("{line}");
                }
            }
        };
        thread::Builder::new().name("watchdog".to_owned()).spawn(watching)?;
        Ok(Self { _end: end })
    }
}

/// What is to be logged now.
fn hangs(workers: &mut Vec<Watched>, now: Instant) -> Vec<String> {
    let mut lines = Vec::new();
    workers.retain_mut(|watched| {
        let Some(worker) = watched.worker.upgrade() else { return false };
        let step = worker.step().map(|(step, since)| (step, now.saturating_duration_since(since)));
        match step {
            Some((step, lasts)) if lasts >= watched.next => {
                let consequence = worker.consequence().map(|text| format!("; {text}")).unwrap_or_default();
                lines.push(format!("{step} has taken {:.0} s so far{consequence}", lasts.as_secs_f64()));
                watched.next = lasts.saturating_mul(2);
            }
            Some((_, lasts)) if lasts >= HANG_AFTER => {}
            _ => watched.next = HANG_AFTER,
        }
        true
    });
    lines
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_that_hangs_is_named_and_again_after_each_doubling() {
        let task = Arc::new(Task { name: "drawing".to_owned(), since: Mutex::default() });
        let worker: Weak<Task> = Arc::downgrade(&task);
        let mut workers = vec![Watched { worker, next: HANG_AFTER }];
        let begun = Instant::now();
        let mut after = |seconds: u64| hangs(&mut workers, begun + Duration::from_secs(seconds));
        assert!(after(100).is_empty(), "it waits for work");
        *lock(&task.since) = Some(begun);
        assert!(after(4).is_empty());
        assert_eq!(after(5), ["drawing has taken 5 s so far"]);
        assert!(after(6).is_empty() && after(9).is_empty());
        assert_eq!(after(10), ["drawing has taken 10 s so far"]);
        assert!(after(19).is_empty());
        assert_eq!(after(21), ["drawing has taken 21 s so far"]);
        task.wait_for_work();
        assert!(after(50).is_empty());
        // Another hang is logged as the first one was.
        *lock(&task.since) = Some(begun + Duration::from_secs(60));
        assert!(after(64).is_empty());
        assert_eq!(after(66), ["drawing has taken 6 s so far"]);
        drop(task);
        assert!(after(1000).is_empty() && workers.is_empty());
    }
}
