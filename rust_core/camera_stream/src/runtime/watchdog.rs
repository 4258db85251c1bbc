//! Logs threads that hang.
//!
//! Each thread that frames depend on (the scene, calls, compression, windows) is a [`Worker`] with a present step. One
//! more thread polls all of them each second, and logs a step that takes longer than [`HANG_AFTER`]; again after each
//! doubling.

use std::io;
use std::sync::mpsc::{sync_channel, RecvTimeoutError, SyncSender};
use std::sync::{Arc, Mutex, Weak};
use std::thread;
use std::time::{Duration, Instant};

use rcs_process::lock;

/// Duration from which a step is logged.
const HANG_AFTER: Duration = Duration::from_secs(5);
const PERIOD: Duration = Duration::from_secs(1);

pub(crate) trait Worker: Send + Sync {
    /// The present step and its beginning; `None` while it waits for work. Must not wait itself.
    fn step(&self) -> Option<(String, Instant)>;

    /// The consequence of a hang, if there is one to be logged.
    fn consequence(&self) -> Option<&'static str> {
        None
    }
}

/// A worker with one step.
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

    pub(crate) fn begin(&self) {
        *lock(&self.since) = Some(Instant::now());
    }

    /// Ends the step: the task waits for work.
    pub(crate) fn wait_for_work(&self) {
        *lock(&self.since) = None;
    }
}

impl Worker for Task {
    fn step(&self) -> Option<(String, Instant)> {
        lock(&self.since).map(|since| (self.name.clone(), since))
    }
}

/// A worker, and the duration of a hang that is logged next.
struct WatchedWorker {
    worker: Weak<dyn Worker>,
    next: Duration,
}

static WORKERS: Mutex<Vec<WatchedWorker>> = Mutex::new(Vec::new());

/// Has a worker watched for as long as it lives.
pub(crate) fn watch<W: Worker + 'static>(worker: &Arc<W>) {
    let worker: Weak<W> = Arc::downgrade(worker);
    lock(&WORKERS).push(WatchedWorker { worker, next: HANG_AFTER });
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
    /// The thread cannot be started.
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

/// The lines that are to be logged now.
fn hangs(workers: &mut Vec<WatchedWorker>, now: Instant) -> Vec<String> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_that_hangs_is_named_and_again_after_each_doubling() {
        let task = Arc::new(Task { name: "drawing".to_owned(), since: Mutex::default() });
        let worker: Weak<Task> = Arc::downgrade(&task);
        let mut workers = vec![WatchedWorker { worker, next: HANG_AFTER }];
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
