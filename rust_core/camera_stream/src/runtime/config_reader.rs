//! Reads the config again when its file changes or somebody asks, on a thread of its own: a file on a network share may
//! be missing for minutes.
//!
//! The file's metadata is polled a few times a second. That also covers a file that an editor replaces, one behind a
//! symbolic link and one on a network share, of which the kernel sends no notification. A change counts once two
//! consecutive polls agree, so that a file is not read while it is being written; a file that is missing for a moment
//! is waited for. So is anything but a regular file: what a pipe had (`-d <(…)`) is gone once it was read.

use std::io;
use std::os::unix::fs::MetadataExt;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{sync_channel, Receiver, RecvTimeoutError, SyncSender};
use std::thread;
use std::time::Duration;

use rcs_rviz_config::{parse_bytes, Config, ConfigError, MAX_FILE_BYTES};

use crate::runtime::watchdog::Task;

const POLL_PERIOD: Duration = Duration::from_millis(200);

type ReadResult = Result<Config, ConfigError>;

/// Distinguishes states of a file by its metadata.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Fingerprint {
    device: u64,
    inode: u64,
    len: u64,
    modified: (i64, i64),
    changed: (i64, i64),
}

impl Fingerprint {
    /// `None` while there is no such regular file.
    fn of(file: &Path) -> Option<Self> {
        let data = std::fs::metadata(file).ok().filter(std::fs::Metadata::is_file)?;
        Some(Self {
            device: data.dev(),
            inode: data.ino(),
            len: data.len(),
            modified: (data.mtime(), data.mtime_nsec()),
            changed: (data.ctime(), data.ctime_nsec()),
        })
    }
}

/// Finds completed changes in a sequence of polls.
#[derive(Debug, Default)]
struct ChangeDetector {
    last: Option<Fingerprint>,
    reported: Option<Fingerprint>,
}

impl ChangeDetector {
    /// Returns `true` if a change is complete.
    fn poll(&mut self, now: Option<Fingerprint>) -> bool {
        let settled = now.is_some() && now == self.last && now != self.reported;
        self.last = now;
        if settled {
            self.reported = now;
        }
        settled
    }
}

/// Reads the config until it is dropped.
pub(crate) struct ConfigReader {
    requests: SyncSender<()>,
    results: Receiver<ConfigRead>,
}

/// A config that was read.
pub(crate) struct ConfigRead {
    pub(crate) config: ReadResult,
    /// `true` if it was read because the file has changed.
    pub(crate) has_changed: bool,
}

/// Reads the config in a regular file: a pipe, which is allowed at the node's start, would block.
fn load(file: &Path) -> ReadResult {
    match rcs_user_files::read(file, MAX_FILE_BYTES) {
        Ok(bytes) => parse_bytes(&bytes, &file.display().to_string()),
        Err(error) => Err(ConfigError::unreadable(file, &error)),
    }
}

impl ConfigReader {
    /// Starts the thread, which watches the file if `is_watched`. Its first state counts as a change, as it may be
    /// newer than what was read before. `wake` is called on the thread after there is a result.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub(crate) fn start(file: PathBuf, is_watched: bool, wake: impl Fn() + Send + 'static) -> io::Result<Self> {
        let watched = is_watched.then(|| file.clone());
        Self::start_with(watched, move || load(&file), wake)
    }

    fn start_with(
        watched: Option<PathBuf>,
        read: impl Fn() -> ReadResult + Send + 'static,
        wake: impl Fn() + Send + 'static,
    ) -> io::Result<Self> {
        let (requests, requested) = sync_channel(1);
        let (sender, results) = sync_channel(1);
        let reading = move || {
            // A panic was logged.
            let read = || catch_unwind(AssertUnwindSafe(&read)).ok();
            let mut detector = ChangeDetector::default();
            let task = Task::watched("reading the config");
            loop {
                let is_requested = match requested.recv_timeout(POLL_PERIOD) {
                    Err(RecvTimeoutError::Disconnected) => return,
                    request => request.is_ok(),
                };
                task.begin();
                let has_changed = watched.as_ref().is_some_and(|file| detector.poll(Fingerprint::of(file)));
                let mut result = (is_requested || has_changed).then(read).flatten();
                while requested.try_recv().is_ok() {
                    // Requested again meanwhile, so the result may be too old.
                    result = read();
                }
                task.wait_for_work();
                if let Some(config) = result {
                    // Fails at the node's end.
                    let _ = sender.send(ConfigRead { config, has_changed });
                    wake();
                }
            }
        };
        thread::Builder::new().name("config-read".to_owned()).spawn(reading)?;
        Ok(Self { requests, results })
    }

    /// Has the config read as it is now.
    pub(crate) fn request(&self) {
        // An earlier result may be too old.
        drop(self.results.try_recv());
        // Fails if that is requested already.
        let _ = self.requests.try_send(());
    }

    /// The config that was read since the last call. Never waits.
    pub(crate) fn take(&self) -> Option<ConfigRead> {
        self.results.try_recv().ok()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::mpsc::channel;
    use std::sync::Arc;
    use std::time::Instant;

    use super::*;

    fn config(frame: &str) -> String {
        format!("Visualization Manager: {{Global Options: {{Fixed Frame: {frame}}}}}")
    }

    fn frame_of(read: ConfigRead) -> String {
        read.config.unwrap().global.fixed_frame
    }

    #[test]
    fn a_change_counts_once_it_is_complete() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("scene.rviz");
        let now = || Fingerprint::of(&file);
        let write = |text: &str| std::fs::write(&file, text).unwrap();
        let mut detector = ChangeDetector::default();
        assert!(!detector.poll(now()) && !detector.poll(now()), "there is no file");
        write("first");
        assert_eq!([detector.poll(now()), detector.poll(now()), detector.poll(now())], [false, true, false]);
        write("being wr");
        assert!(!detector.poll(now()));
        write("being written");
        assert!(!detector.poll(now()));
        assert!(detector.poll(now()));
    }

    #[test]
    fn a_replaced_file_and_one_behind_a_link_are_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("a"), "same").unwrap();
        std::os::unix::fs::symlink(at("a"), at("link")).unwrap();
        let mut detector = ChangeDetector::default();
        detector.poll(Fingerprint::of(&at("link")));
        assert!(detector.poll(Fingerprint::of(&at("link"))));
        std::fs::remove_file(at("a")).unwrap();
        assert!(!detector.poll(Fingerprint::of(&at("link"))), "missing for a moment");
        std::fs::write(at("b"), "same").unwrap();
        std::fs::rename(at("b"), at("a")).unwrap();
        assert!(!detector.poll(Fingerprint::of(&at("link"))));
        assert!(detector.poll(Fingerprint::of(&at("link"))));
    }

    #[test]
    fn a_pipe_has_no_changes() {
        let (_writer, reader) = std::os::unix::net::UnixStream::pair().unwrap();
        let file = format!("/proc/self/fd/{}", std::os::fd::AsRawFd::as_raw_fd(&reader));
        let mut detector = ChangeDetector::default();
        assert!(!detector.poll(Fingerprint::of(Path::new(&file))) && !detector.poll(Fingerprint::of(Path::new(&file))));
    }

    #[test]
    fn the_first_state_and_each_later_one_are_read_once() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("scene.rviz");
        std::fs::write(&file, config("first")).unwrap();
        let (sender, woken) = channel();
        let reader = ConfigReader::start(file.clone(), true, move || sender.send(()).unwrap()).unwrap();
        for (frame, next) in [("first", "second"), ("second", "third one"), ("third one", "")] {
            woken.recv_timeout(Duration::from_secs(20)).unwrap();
            let read = reader.take().unwrap();
            assert!(read.has_changed && reader.take().is_none());
            assert_eq!(frame_of(read), frame);
            std::fs::write(&file, config(next)).unwrap();
        }
    }

    #[test]
    fn a_file_that_hangs_is_not_waited_for_and_then_read_as_it_is_by_then() {
        let (release, released) = channel::<&str>();
        let (sender, is_begun) = channel();
        let read = move || {
            sender.send(()).unwrap();
            rcs_rviz_config::parse(&config(released.recv().unwrap()), "test")
        };
        let (sender, is_woken) = channel();
        let reader = ConfigReader::start_with(None, read, move || sender.send(()).unwrap()).unwrap();
        reader.request();
        is_begun.recv_timeout(Duration::from_secs(20)).unwrap();
        reader.request();
        reader.request();
        assert!(reader.take().is_none());
        release.send("old").unwrap();
        is_begun.recv_timeout(Duration::from_secs(20)).unwrap();
        release.send("new").unwrap();
        is_woken.recv_timeout(Duration::from_secs(20)).unwrap();
        assert_eq!(reader.take().map(frame_of).as_deref(), Some("new"), "and not the old one");
    }

    #[test]
    fn after_a_panic_the_file_is_read_again() {
        let reads = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&reads);
        let read = move || {
            assert!(counted.fetch_add(1, Ordering::Relaxed) > 0, "a test's panic");
            rcs_rviz_config::parse(&config("map"), "test")
        };
        let reader = ConfigReader::start_with(None, read, || {}).unwrap();
        let begun = Instant::now();
        reader.request();
        while reads.load(Ordering::Relaxed) == 0 {
            assert!(begun.elapsed() < Duration::from_secs(20));
            thread::sleep(Duration::from_millis(5));
        }
        reader.request();
        assert_eq!(reader.results.recv_timeout(Duration::from_secs(20)).map(frame_of).as_deref(), Ok("map"));
    }
}
