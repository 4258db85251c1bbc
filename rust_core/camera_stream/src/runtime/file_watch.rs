//! Detects that a file was rewritten.
//!
//! The file's metadata is polled a few times a second. That also covers a file that an editor replaces, one behind a
//! symbolic link and one on a network share, of which the kernel sends no notification. A change counts once two
//! consecutive polls agree, so that a file is not read while it is being written; a file that is missing for a moment
//! is waited for. So is anything but a regular file: what a pipe had (`-d <(…)`) is gone once it was read.

use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use std::time::Duration;

const POLL_PERIOD: Duration = Duration::from_millis(200);

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

pub(crate) struct FileWatch {
    changed: Arc<AtomicBool>,
    ended: Arc<AtomicBool>,
}

impl FileWatch {
    /// Starts watching. The first state counts as a change, as it may be newer than what was read before. `wake` is
    /// called for each change, on a separate thread.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub(crate) fn start(file: PathBuf, wake: impl Fn() + Send + 'static) -> io::Result<Self> {
        let (changed, ended) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        let (change, end) = (Arc::clone(&changed), Arc::clone(&ended));
        let watching = move || {
            let mut detector = ChangeDetector::default();
            while !end.load(Ordering::Acquire) {
                if detector.poll(Fingerprint::of(&file)) {
                    change.store(true, Ordering::Release);
                    wake();
                }
                std::thread::sleep(POLL_PERIOD);
            }
        };
        std::thread::Builder::new().name("config-watch".to_owned()).spawn(watching)?;
        Ok(Self { changed, ended })
    }

    pub(crate) fn take_change(&self) -> bool {
        self.changed.swap(false, Ordering::AcqRel)
    }
}

impl Drop for FileWatch {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn the_first_state_and_each_later_one_are_reported_once() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("scene.rviz");
        std::fs::write(&file, "first").unwrap();
        let (sender, woken) = std::sync::mpsc::channel();
        let watch = FileWatch::start(file.clone(), move || sender.send(()).unwrap()).unwrap();
        for text in ["second", "third one"] {
            woken.recv_timeout(Duration::from_secs(20)).unwrap();
            assert!(watch.take_change() && !watch.take_change());
            std::fs::write(&file, text).unwrap();
        }
        woken.recv_timeout(Duration::from_secs(20)).unwrap();
    }
}
