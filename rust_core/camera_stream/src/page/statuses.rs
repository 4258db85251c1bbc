//! The statuses of the scene, kept for the pages.
//!
//! The scene's thread leaves them here once a second, and only while a page is open.

use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard};
use std::time::Instant;

use rcs_displays::{Level, Statuses};
use rcs_process::lock;
use rcs_web::Pages;
use serde_json::{json, Value};

use crate::doctor::advice_for;
use crate::scene::status_tree::{EntryKind, StatusEntry};

/// Most statuses of an entry that are shown: a display with markers has one for each.
const MOST_STATUSES: usize = 20;

/// The pages, and their contents.
pub(crate) struct PageStatuses {
    pages: Pages,
    statuses: Mutex<LastReport>,
}

/// The statuses of the last report.
#[derive(Default)]
pub(crate) struct LastReport {
    /// The global status and the displays.
    pub(crate) displays: Vec<Value>,
    /// The statuses of the cameras, by path.
    pub(crate) cameras: HashMap<String, Value>,
    /// Counters of messages and images, by path or camera.
    rates: HashMap<String, Rate>,
}

/// A counter at the last two reports.
struct Rate {
    at: Instant,
    count: u64,
    per_sec: Option<f64>,
}

impl PageStatuses {
    /// Without pages.
    pub(crate) fn new() -> Self {
        Self { pages: Pages::new(), statuses: Mutex::default() }
    }

    /// The pages that are open.
    pub(crate) fn pages(&self) -> &Pages {
        &self.pages
    }

    /// The statuses of the last report.
    pub(crate) fn statuses(&self) -> MutexGuard<'_, LastReport> {
        lock(&self.statuses)
    }

    /// Keeps a report's entries for the pages, and the number of images that each camera has published.
    pub(crate) fn note(&self, entries: &[StatusEntry<'_>], published: impl Iterator<Item = (String, u64)>) {
        let mut statuses = self.statuses();
        let mut rates = std::mem::take(&mut statuses.rates);
        let now = Instant::now();
        for (camera, count) in published {
            let rate = Rate::next(rates.remove(&camera), count, now);
            statuses.rates.insert(camera, rate);
        }
        (statuses.displays, statuses.cameras) = (Vec::new(), HashMap::new());
        for entry in entries {
            match entry.kind {
                EntryKind::Camera => {
                    let of_entry = statuses_of(&entry.statuses);
                    statuses.cameras.insert(entry.path.clone(), of_entry);
                }
                EntryKind::Global | EntryKind::Display => {
                    let count = entry.received;
                    let key = format!("display {}", entry.path);
                    let rate = count.map(|count| Rate::next(rates.remove(&key), count, now));
                    let per_sec = rate.as_ref().and_then(|rate| rate.per_sec);
                    statuses.displays.push(display(entry, per_sec));
                    if let Some(rate) = rate {
                        statuses.rates.insert(key, rate);
                    }
                }
            }
        }
        drop(statuses);
        self.pages.state_changed();
    }
}

impl LastReport {
    /// Images a second that a camera publishes.
    pub(crate) fn rate_hz(&self, camera: &str) -> Option<f64> {
        self.rates.get(camera)?.per_sec
    }
}

impl Rate {
    fn next(last: Option<Self>, count: u64, at: Instant) -> Self {
        let per_sec = last.and_then(|last| {
            let secs = at.saturating_duration_since(last.at).as_secs_f64();
            // A display that was made again counts from 0.
            (secs > 0.0).then(|| count.checked_sub(last.count).map(|count| count as f64 / secs)).flatten()
        });
        Self { at, count, per_sec }
    }
}

/// A display's or the global entry as the page shows it, still without its switches.
fn display(entry: &StatusEntry<'_>, rate_hz: Option<f64>) -> Value {
    json!({
        "path": entry.path,
        "class": entry.class,
        "topic": entry.topic,
        "level": level_name(entry.level()),
        "rate_hz": rate_hz,
        "age_ms": entry.age_ms.map(f64::round),
        "statuses": statuses_of(&entry.statuses),
        "advice": advice_for(entry),
        "switches": {},
    })
}

/// The statuses, the worst first.
fn statuses_of(statuses: &Statuses) -> Value {
    let mut list: Vec<_> = statuses.iter().collect();
    list.sort_by_key(|(_, status)| std::cmp::Reverse(status.level));
    let status = |(name, status): (&str, &rcs_displays::Status)| json!({"level": level_name(status.level), "name": name, "text": status.one_line()});
    list.into_iter().take(MOST_STATUSES).map(status).collect()
}

fn level_name(level: Level) -> &'static str {
    match level {
        Level::Ok => "ok",
        Level::Warn => "warn",
        Level::Error => "error",
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_rate_is_that_between_two_reports() {
        let start = Instant::now();
        let at = |secs| start + Duration::from_secs(secs);
        let first = Rate::next(None, 10, start);
        assert_eq!(first.per_sec, None);
        let second = Rate::next(Some(first), 40, at(2));
        assert_eq!(second.per_sec, Some(15.0));
        assert_eq!(Rate::next(Some(second), 5, at(3)).per_sec, None, "it began anew");
    }

    #[test]
    fn the_worst_statuses_come_first() {
        let mut statuses = Statuses::default();
        for (level, name) in [(Level::Ok, "a"), (Level::Error, "b"), (Level::Warn, "c")] {
            statuses.set(level, name, "text");
        }
        let list = statuses_of(&statuses);
        assert_eq!([&list[0]["name"], &list[1]["name"], &list[2]["level"]], ["b", "c", "ok"]);
    }
}
