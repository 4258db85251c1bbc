//! Notices that a file was written again.
//!
//! The file's metadata are looked at a few times a second. That also sees a file that an editor put in the other's place,
//! one behind a symbolic link and one on a network share, which notifications of the kernel do not tell about. A change
//! counts once the file is the same in two looks, so that nobody reads one that is being written; a file that is not
//! there for a moment is waited for.

use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use std::time::Duration;

/// How often the file is looked at.
const LOOK_PERIOD: Duration = Duration::from_millis(200);

/// Tells one state of a file from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Fingerprint {
    device: u64,
    inode: u64,
    len: u64,
    modified: (i64, i64),
    changed: (i64, i64),
}

impl Fingerprint {
    /// None while there is no such file.
    fn of(file: &Path) -> Option<Self> {
        let data = std::fs::metadata(file).ok()?;
        Some(Self {
            device: data.dev(),
            inode: data.ino(),
            len: data.len(),
            modified: (data.mtime(), data.mtime_nsec()),
            changed: (data.ctime(), data.ctime_nsec()),
        })
    }
}

/// What was seen of the file.
#[derive(Debug, Default)]
struct Looks {
    last: Option<Fingerprint>,
    told: Option<Fingerprint>,
}

impl Looks {
    /// Whether a change is complete.
    fn look(&mut self, now: Option<Fingerprint>) -> bool {
        let settled = now.is_some() && now == self.last && now != self.told;
        self.last = now;
        if settled {
            self.told = now;
        }
        settled
    }
}

/// Looks at a file until it is dropped.
pub(super) struct FileWatch {
    changed: Arc<AtomicBool>,
    ended: Arc<AtomicBool>,
}

impl FileWatch {
    /// Begins to look. The state at the beginning counts as a change, for it may be newer than what was read before.
    /// `wake` is called for each change, on a thread of its own.
    ///
    /// # Errors
    /// The system's, when it has no thread left.
    pub(super) fn start(file: PathBuf, wake: impl Fn() + Send + 'static) -> io::Result<Self> {
        let (changed, ended) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        let (change, end) = (Arc::clone(&changed), Arc::clone(&ended));
        let watching = move || {
            let mut looks = Looks::default();
            while !end.load(Ordering::Acquire) {
                if looks.look(Fingerprint::of(&file)) {
                    change.store(true, Ordering::Release);
                    wake();
                }
                std::thread::sleep(LOOK_PERIOD);
            }
        };
        std::thread::Builder::new().name("config-watch".to_owned()).spawn(watching)?;
        Ok(Self { changed, ended })
    }

    /// Whether the file changed since this was asked the last time.
    pub(super) fn take_change(&self) -> bool {
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
        let mut looks = Looks::default();
        assert!(!looks.look(now()) && !looks.look(now()), "there is no file");
        write("first");
        assert_eq!([looks.look(now()), looks.look(now()), looks.look(now())], [false, true, false]);
        write("being wr");
        assert!(!looks.look(now()));
        write("being written");
        assert!(!looks.look(now()));
        assert!(looks.look(now()));
    }

    #[test]
    fn a_file_put_in_the_others_place_and_one_behind_a_link_are_seen() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("a"), "same").unwrap();
        std::os::unix::fs::symlink(at("a"), at("link")).unwrap();
        let mut looks = Looks::default();
        looks.look(Fingerprint::of(&at("link")));
        assert!(looks.look(Fingerprint::of(&at("link"))));
        std::fs::remove_file(at("a")).unwrap();
        assert!(!looks.look(Fingerprint::of(&at("link"))), "gone for a moment");
        std::fs::write(at("b"), "same").unwrap();
        std::fs::rename(at("b"), at("a")).unwrap();
        assert!(!looks.look(Fingerprint::of(&at("link"))));
        assert!(looks.look(Fingerprint::of(&at("link"))));
    }

    #[test]
    fn the_first_state_and_each_later_one_are_told_once() {
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
