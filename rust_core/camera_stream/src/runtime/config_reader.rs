//! Reads the config again, on a thread of its own: a file on a network share may be missing for minutes.

use std::path::Path;
use std::sync::mpsc::{sync_channel, Receiver, TryRecvError};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use rcs_resources::read_regular_file;
use rcs_rviz_config::{parse_bytes, Config, ConfigError, MAX_FILE_BYTES};

/// Reading time that is logged; again after each doubling.
const SLOW_AFTER: Duration = Duration::from_secs(5);

type ReadResult = Result<Config, ConfigError>;

/// Reads the config, and once more if that was requested meanwhile.
pub(crate) struct ConfigReader {
    read: Arc<dyn Fn() -> ReadResult + Send + Sync>,
    wake: Arc<dyn Fn() + Send + Sync>,
    reading: Option<PendingRead>,
    /// Requested again since this read began, whose result may be too old.
    is_requested_again: bool,
}

struct PendingRead {
    result: Receiver<ReadResult>,
    begun: Instant,
    next_report: Duration,
}

/// Reads the config in a regular file: a pipe, which is allowed at the node's start, would block.
pub(crate) fn load(file: &Path) -> ReadResult {
    let source = file.display().to_string();
    match read_regular_file(file, MAX_FILE_BYTES) {
        Ok(bytes) => parse_bytes(&bytes, &source),
        Err(error) => Err(ConfigError::Unreadable { file: source, error }),
    }
}

impl ConfigReader {
    /// `read`, and `wake` after there is a result, are called on other threads.
    pub(crate) fn new(
        read: impl Fn() -> ReadResult + Send + Sync + 'static,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        Self { read: Arc::new(read), wake: Arc::new(wake), reading: None, is_requested_again: false }
    }

    /// Has the config read as it is now.
    pub(crate) fn request(&mut self) {
        if self.reading.is_some() {
            self.is_requested_again = true;
            return;
        }
        let (sender, result) = sync_channel(1);
        let (read, wake) = (Arc::clone(&self.read), Arc::clone(&self.wake));
        let reading = move || {
            // Fails at the node's end.
            let _ = sender.send(read());
            wake();
        };
        match thread::Builder::new().name("config-read".to_owned()).spawn(reading) {
            Ok(_) => self.reading = Some(PendingRead { result, begun: Instant::now(), next_report: SLOW_AFTER }),
            Err(error) => log::error!("cannot start the thread that reads the config: {error}"),
        }
    }

    /// The config that was read since the last call. Never waits.
    pub(crate) fn take(&mut self) -> Option<ReadResult> {
        let result = match self.reading.as_ref()?.result.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => return None,
            // It panicked, which was logged.
            Err(TryRecvError::Disconnected) => None,
        };
        self.reading = None;
        if std::mem::take(&mut self.is_requested_again) {
            self.request();
            return None;
        }
        result
    }

    /// The reading time so far, when it is to be logged.
    pub(crate) fn take_slow(&mut self) -> Option<Duration> {
        let reading = self.reading.as_mut()?;
        let lasts = reading.begun.elapsed();
        let is_due = lasts >= reading.next_report;
        if is_due {
            reading.next_report = lasts.saturating_mul(2);
        }
        is_due.then_some(lasts)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::mpsc::channel;
    use std::sync::{Mutex, PoisonError};

    use super::*;

    #[test]
    fn a_file_that_hangs_is_not_waited_for_and_then_read_as_it_is_by_then() {
        let (release, released) = channel::<&str>();
        let released = Mutex::new(released);
        let read = move || {
            let text = released.lock().unwrap_or_else(PoisonError::into_inner).recv().unwrap();
            rcs_rviz_config::parse(text, "test")
        };
        let (woken, is_woken) = channel();
        let mut reader = ConfigReader::new(read, move || woken.send(()).unwrap());
        reader.request();
        reader.request();
        assert!(reader.take().is_none() && reader.take_slow().is_none());
        if let Some(reading) = &mut reader.reading {
            reading.next_report = Duration::ZERO;
        }
        assert!(reader.take_slow().is_some(), "logged once it is slow");
        let mut frame = |frame: &'static str| {
            release.send(frame).unwrap();
            is_woken.recv_timeout(Duration::from_secs(20)).unwrap();
            reader.take().map(|config| config.unwrap().global.fixed_frame)
        };
        assert_eq!(frame("Visualization Manager: {Global Options: {Fixed Frame: old}}"), None);
        assert_eq!(frame("Visualization Manager: {Global Options: {Fixed Frame: new}}").as_deref(), Some("new"));
    }
    #[test]
    fn after_a_panic_the_file_is_read_again() {
        let is_first = AtomicBool::new(true);
        let read = move || {
            assert!(!is_first.swap(false, Ordering::Relaxed), "a test's panic");
            rcs_rviz_config::parse("Visualization Manager: {}", "test")
        };
        let mut reader = ConfigReader::new(read, || {});
        let begun = Instant::now();
        reader.request();
        while reader.reading.is_some() {
            assert!(begun.elapsed() < Duration::from_secs(20));
            assert!(reader.take().is_none());
            thread::sleep(Duration::from_millis(5));
        }
        reader.request();
        let config = loop {
            assert!(begun.elapsed() < Duration::from_secs(20));
            match reader.take() {
                Some(config) => break config,
                None => thread::sleep(Duration::from_millis(5)),
            }
        };
        assert!(config.is_ok());
    }
}
