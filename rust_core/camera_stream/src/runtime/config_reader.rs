//! Reads the config again, on a thread of its own: a file on a network share may not be there for minutes.

use std::path::Path;
use std::sync::mpsc::{sync_channel, Receiver, TryRecvError};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use rcs_resources::read_regular_file;
use rcs_rviz_config::{parse_bytes, Config, ConfigError, MAX_FILE_BYTES};

/// How long reading may take before that is logged; again after each doubling.
const SLOW_AFTER: Duration = Duration::from_secs(5);

type ReadResult = Result<Config, ConfigError>;

/// Reads a file at a time, and again if that was asked for meanwhile.
pub(crate) struct ConfigReader {
    read: Arc<dyn Fn() -> ReadResult + Send + Sync>,
    wake: Arc<dyn Fn() + Send + Sync>,
    reading: Option<Reading>,
    /// Asked for since this reading began, so that what comes of it may be too old.
    is_asked_again: bool,
}

struct Reading {
    result: Receiver<ReadResult>,
    begun: Instant,
    /// How long it lasts when that is logged next.
    next_report: Duration,
}

/// The config in a regular file. At the node's start a pipe may do; later it would be waited for.
pub(crate) fn load(file: &Path) -> ReadResult {
    let source = file.display().to_string();
    match read_regular_file(file, MAX_FILE_BYTES) {
        Ok(bytes) => parse_bytes(&bytes, &source),
        Err(error) => Err(ConfigError::Unreadable { file: source, error }),
    }
}

impl ConfigReader {
    /// `read` and `wake`, which says that there is a result, are called on other threads.
    pub(crate) fn new(
        read: impl Fn() -> ReadResult + Send + Sync + 'static,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        Self { read: Arc::new(read), wake: Arc::new(wake), reading: None, is_asked_again: false }
    }

    /// Has the config read as it is now.
    pub(crate) fn request(&mut self) {
        if self.reading.is_some() {
            self.is_asked_again = true;
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
            Ok(_) => self.reading = Some(Reading { result, begun: Instant::now(), next_report: SLOW_AFTER }),
            Err(error) => log::error!("no thread to read the config on: {error}"),
        }
    }

    /// What was read since it was last asked for. Never waits.
    pub(crate) fn take(&mut self) -> Option<ReadResult> {
        let result = match self.reading.as_ref()?.result.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => return None,
            // It panicked, which is logged where panics are.
            Err(TryRecvError::Disconnected) => None,
        };
        self.reading = None;
        if std::mem::take(&mut self.is_asked_again) {
            self.request();
            return None;
        }
        result
    }

    /// For how long it has been reading, when that is to be logged.
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
