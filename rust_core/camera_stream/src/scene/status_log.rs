//! Logs the changes of the statuses that rviz would show in its display tree.
//!
//! Each change is logged once. Frames are often a little late and publishers start in any order, so a missing one is
//! logged only after a while; an invalid message is logged at once, because the next may be valid. A status that
//! changes back and forth is logged every ten seconds at most.

use std::collections::HashMap;

use rcs_displays::{Level, StatusCause, Statuses};
use rcs_logging::{log_status, without_numbers};
use rcs_transforms::Time;

use crate::scene::status_tree::{EntryKind, StatusEntry, FIXED_FRAME, PUBLISHER};
use crate::scene::visibility::VISIBILITY;

/// Time without a frame before that is logged.
const FRAME_PATIENCE_SECS: f64 = 2.0;
/// Time without a message before that is logged.
const TOPIC_PATIENCE_SECS: f64 = 5.0;
/// Time for which a status is ok before that is logged.
const OK_PATIENCE_SECS: f64 = 2.0;
/// Time until another problem of a status is logged.
const SILENCE_SECS: f64 = 10.0;
const CHECK_PERIOD_SECS: f64 = 0.5;
/// Most statuses that are tracked: they can name any number of markers.
const MOST_STATUSES: usize = 500;

/// Text of a status that is not a problem any more.
const OK_AGAIN: &str = "ok again";

/// Logs statuses as they change.
#[derive(Debug, Default)]
pub(crate) struct StatusLog {
    /// By the display and the status's name.
    histories: HashMap<(String, String), StatusHistory>,
    last_check: Option<Time>,
}

/// The history of one status.
#[derive(Debug)]
struct StatusHistory {
    /// `true` while it is a problem; `since` is the last change of that.
    is_bad: bool,
    since: Time,
    /// The problem that was logged last, unless its end was logged, too.
    logged: Option<String>,
    /// Time of the last logged problem.
    logged_at: Option<Time>,
}

/// The key under which statuses are limited together in the log: the display and the problem without its numbers. The
/// name of a marker (`namespace/id`) is left out, because a publisher can make up any number of them.
fn cause_of(display: &str, status_name: &str, text: &str) -> String {
    let is_number = |id: &str| !id.is_empty() && id.bytes().all(|digit| digit.is_ascii_digit());
    let is_marker = |(_, id): (&str, &str)| is_number(id.strip_prefix('-').unwrap_or(id));
    let name = if status_name.rsplit_once('/').is_some_and(is_marker) { "" } else { status_name };
    format!("{display}\n{name}\n{}", without_numbers(text))
}

fn patience_secs(status_name: &str, level: Level, cause: StatusCause) -> f64 {
    match status_name {
        Statuses::TRANSFORM | FIXED_FRAME => FRAME_PATIENCE_SECS,
        // An error of a topic is a wrong message or a wrong name.
        Statuses::TOPIC if level == Level::Warn => TOPIC_PATIENCE_SECS,
        PUBLISHER => TOPIC_PATIENCE_SECS,
        // Markers, robots' links and frames have statuses of their own names.
        _ if cause == StatusCause::Frame => FRAME_PATIENCE_SECS,
        _ => 0.0,
    }
}

/// `true` if a status is logged here: the node logs its cameras' problems itself, an unknown class was logged when the
/// config was read, a silent topic needs no line about its missing publisher as well, and displays move in and out of
/// view all the time.
fn is_logged(entry: &StatusEntry<'_>, status_name: &str, level: Level) -> bool {
    match (status_name, entry.kind) {
        (PUBLISHER, _) => level == Level::Error,
        (Statuses::CLASS | VISIBILITY, _) | (_, EntryKind::Camera) => false,
        (_, EntryKind::Global | EntryKind::Display) => true,
    }
}

impl StatusLog {
    /// `true` if the statuses are to be checked again.
    pub(crate) fn is_due(&self, now: Time) -> bool {
        self.last_check.is_none_or(|last| last > now || now.secs_since(last) >= CHECK_PERIOD_SECS)
    }

    /// Logs changes. `now` is of any clock that advances.
    pub(crate) fn check(&mut self, entries: &[StatusEntry<'_>], now: Time) {
        self.last_check = Some(now);
        self.log_changes(entries, now, false);
    }

    /// Logs all present problems, also those that might have resolved themselves later.
    pub(crate) fn conclude(&mut self, entries: &[StatusEntry<'_>], now: Time) {
        self.log_changes(entries, now, true);
    }

    fn log_changes(&mut self, entries: &[StatusEntry<'_>], now: Time, is_end: bool) {
        let mut old: HashMap<(String, String), StatusHistory> = std::mem::take(&mut self.histories);
        for entry in entries {
            for (name, status) in entry.statuses.iter().filter(|(name, status)| is_logged(entry, name, status.level)) {
                let display = match entry.kind {
                    EntryKind::Global => entry.path.clone(),
                    EntryKind::Display => format!("display {}", entry.path),
                    EntryKind::Camera => format!("camera {}", entry.path),
                };
                let key = (display, name.to_owned());
                let mut history = match (old.remove(&key), status.level) {
                    (Some(history), _) => history,
                    (None, Level::Ok) => continue,
                    (None, _) if self.histories.len() >= MOST_STATUSES => continue,
                    (None, _) => StatusHistory::new(now),
                };
                let (display, text) = (&key.0, status.one_line());
                let patience_secs = patience_secs(name, status.level, status.cause);
                if history.update(patience_secs, status.level, &text, now, is_end) {
                    let (level, text) = match status.level {
                        Level::Error if patience_secs == 0.0 => (log::Level::Error, text),
                        Level::Ok => (log::Level::Info, format!("{OK_AGAIN}: {text}")),
                        Level::Error | Level::Warn => (log::Level::Warn, text),
                    };
                    log_status(level, &cause_of(display, name, &text), &format!("{display}: {name}: {text}"));
                }
                self.histories.insert(key, history);
            }
        }
        // A problem whose status was removed is over.
        for (key, mut history) in old {
            if history.update(0.0, Level::Ok, "", now, is_end) {
                let (display, name) = &key;
                let cause = cause_of(display, name, OK_AGAIN);
                log_status(log::Level::Info, &cause, &format!("{display}: {name}: {OK_AGAIN}"));
            }
            self.histories.insert(key, history);
        }
        self.histories.retain(|_, history| !history.is_over(now));
    }
}

impl StatusHistory {
    fn new(now: Time) -> Self {
        Self { is_bad: false, since: now, logged: None, logged_at: None }
    }

    /// Records the present status. Returns `true` if it is to be logged.
    fn update(&mut self, patience_secs: f64, level: Level, text: &str, now: Time, is_end: bool) -> bool {
        let is_bad = level > Level::Ok;
        if is_bad != self.is_bad || self.since > now {
            (self.is_bad, self.since) = (is_bad, now);
        }
        let lasted_secs = now.secs_since(self.since);
        if !is_bad {
            return self.logged.is_some()
                && (is_end || lasted_secs >= OK_PATIENCE_SECS)
                && self.logged.take().is_some();
        }
        // Numbers are times and positions.
        let problem = without_numbers(text);
        if self.logged.as_ref() == Some(&problem) || (!is_end && lasted_secs < patience_secs) {
            return false;
        }
        if self.is_silent(now) && !is_end {
            return false;
        }
        (self.logged, self.logged_at) = (Some(problem), Some(now));
        true
    }

    /// `true` so soon after a logged problem that another one has to wait.
    fn is_silent(&self, now: Time) -> bool {
        self.logged_at.is_some_and(|logged_at| (0.0..SILENCE_SECS).contains(&now.secs_since(logged_at)))
    }

    fn is_over(&self, now: Time) -> bool {
        !self.is_bad && self.logged.is_none() && !self.is_silent(now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(secs: f64) -> Time {
        Time::from_secs_f64(secs)
    }

    /// The times and texts of the log lines of a status that is checked twice a second.
    fn logged(name: &str, secs: f64, status: impl Fn(f64) -> (Level, &'static str)) -> Vec<(f64, &'static str)> {
        let mut history = StatusHistory::new(at(100.0));
        let mut logged = Vec::new();
        for check in 0..(secs * 2.0) as u32 {
            let secs = f64::from(check) / 2.0;
            let (level, text) = status(secs);
            let patience_secs = patience_secs(name, level, StatusCause::Other);
            if history.update(patience_secs, level, text, at(100.0 + secs), false) {
                logged.push((secs, text));
            }
        }
        logged
    }

    #[test]
    fn a_problem_is_logged_once_and_so_is_its_end() {
        let frames = |secs| if secs < 5.0 { (Level::Error, "lost 1") } else { (Level::Ok, "found") };
        assert_eq!(logged("Transform", 30.0, frames), [(2.0, "lost 1"), (7.0, "found")]);
        assert_eq!(logged("Message", 30.0, frames), [(0.0, "lost 1"), (7.0, "found")]);
        let late = |secs| if secs < 1.5 { (Level::Error, "lost") } else { (Level::Ok, "found") };
        assert_eq!(logged("Transform", 30.0, late), []);
        let numbers = |secs| (Level::Error, if secs < 5.0 { "at 17 s" } else { "at 18 s" });
        assert_eq!(logged("Transform", 30.0, numbers), [(2.0, "at 17 s")]);
        let other = |secs| (Level::Error, if secs < 5.0 { "arm" } else { "leg" });
        assert_eq!(logged("Transform", 30.0, other), [(2.0, "arm"), (12.0, "leg")]);
    }

    #[test]
    fn markers_with_the_same_problem_are_one_cause() {
        let cause = |display, name| cause_of(display, name, "For frame [lost_7]: Frame [lost_7] does not exist");
        let first = cause("display markers 1", "arm/0");
        assert_eq!(cause("display markers 1", "leg/b/-12"), first);
        assert_eq!(cause_of("display markers 1", "/3", "For frame [lost_9]: Frame [lost_9] does not exist"), first);
        for (display, name) in [
            ("display markers 2", "arm/0"),
            ("display markers 1", "Transform"),
            ("display markers 1", "arm/link"),
            ("display markers 1", "link_1"),
        ] {
            assert_ne!(cause(display, name), first, "{display}: {name}");
        }
        assert_ne!(cause("display robot", "link_1"), cause("display robot", "link_2"));
        assert_ne!(cause_of("display markers 1", "arm/0", "Invalid color"), first);
    }

    #[test]
    fn a_status_that_changes_back_and_forth_is_logged_every_ten_seconds_at_most() {
        let flutter = |secs: f64| if secs % 6.0 < 3.0 { (Level::Error, "bad") } else { (Level::Ok, "good") };
        let expected = [(0.0, "bad"), (5.0, "good"), (12.0, "bad"), (17.0, "good"), (24.0, "bad"), (29.0, "good")];
        assert_eq!(logged("Message", 30.0, flutter), expected);
        let alternating = |secs: f64| (Level::Error, if secs % 1.0 < 0.5 { "a" } else { "b" });
        assert_eq!(logged("Transform", 30.0, alternating), [(2.0, "a"), (12.5, "b"), (23.0, "a")]);
    }
}
