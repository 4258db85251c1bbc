//! The last lines of the log, for those who show them.

use std::collections::VecDeque;
use std::sync::{Mutex, OnceLock};
use std::time::SystemTime;

use log::Level;
use rcs_process::lock;

/// Most lines that are kept.
const MOST_LINES: usize = 200;
/// Most characters of a line that is kept.
const MOST_CHARS: usize = 2000;

/// A line of the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecentLine {
    /// Counts up from 1.
    pub id: u64,
    /// When it was logged.
    pub time: SystemTime,
    /// Its severity.
    pub level: Level,
    /// Its text, without control characters.
    pub text: String,
}

/// The last lines.
pub(crate) struct RecentLines {
    lines: Mutex<VecDeque<RecentLine>>,
    on_new: OnceLock<Box<dyn Fn() + Send + Sync>>,
}

impl RecentLines {
    pub(crate) const fn new() -> Self {
        Self { lines: Mutex::new(VecDeque::new()), on_new: OnceLock::new() }
    }

    /// Adds a line. Debug messages are left out.
    pub(crate) fn push(&self, level: Level, text: &str) {
        if level > Level::Info {
            return;
        }
        let mut lines = lock(&self.lines);
        let id = lines.back().map_or(1, |last| last.id + 1);
        if lines.len() >= MOST_LINES {
            lines.pop_front();
        }
        let text = text.chars().take(MOST_CHARS).collect();
        lines.push_back(RecentLine { id, time: SystemTime::now(), level, text });
        drop(lines);
        if let Some(on_new) = self.on_new.get() {
            on_new();
        }
    }

    /// The lines after the one with this number, oldest first.
    pub(crate) fn after(&self, id: u64) -> Vec<RecentLine> {
        lock(&self.lines).iter().filter(|line| line.id > id).cloned().collect()
    }

    /// Has `on_new` called after each new line. The first call counts.
    pub(crate) fn watch(&self, on_new: impl Fn() + Send + Sync + 'static) {
        // Fails if somebody watches already.
        let _ = self.on_new.set(Box::new(on_new));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::Arc;

    use super::*;

    #[test]
    fn the_last_lines_are_kept_and_new_ones_are_announced() {
        let recent = RecentLines::new();
        let calls = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&calls);
        recent.push(Level::Info, "before");
        recent.watch(move || {
            counted.fetch_add(1, Ordering::Relaxed);
        });
        recent.push(Level::Debug, "left out");
        (1..=250).for_each(|number| recent.push(Level::Warn, &format!("line {number}")));
        let lines = recent.after(0);
        assert_eq!((lines.len(), lines[0].id, &*lines[0].text), (MOST_LINES, 52, "line 51"));
        assert_eq!(calls.load(Ordering::Relaxed), 250);
        let last = recent.after(250);
        assert_eq!((last.len(), last[0].level, &*last[0].text), (1, Level::Warn, "line 250"));
        recent.push(Level::Error, &"ä".repeat(2 * MOST_CHARS));
        assert_eq!(recent.after(251)[0].text.chars().count(), MOST_CHARS);
    }
}
