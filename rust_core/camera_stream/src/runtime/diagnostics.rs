//! Reports the status of each display and camera: changes in the log, all statuses on `/diagnostics` once a second.
//!
//! The rate is by the computer's clock, so that a paused simulation is reported, too; the stamps are ROS time.

use std::cmp::Reverse;
use std::time::{Duration, Instant};

use rcs_camera::figure;
use rcs_displays::Level;
use rcs_messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use rcs_node_support::node_status::diagnostic_status;
use rcs_ros::{Publisher, RosNode};
use rcs_transforms::Time;

use crate::scene::status_log::StatusLog;
use crate::scene::status_tree::{self, EntryKind, StatusEntry};
use crate::scene::visibility::VISIBILITY;

/// Period of `/diagnostics`.
const PERIOD: Duration = Duration::from_secs(1);
/// Most statuses of a display: first problems, then the visibility.
const MOST_VALUES: usize = 100;

/// Reports statuses to the log and on `/diagnostics`.
pub(crate) struct Diagnostics {
    log: StatusLog,
    publisher: Option<Publisher<DiagnosticArray>>,
    started: Instant,
    published: Option<Instant>,
    last_error: Option<String>,
    /// The statuses that were published last.
    last_status: Vec<DiagnosticStatus>,
}

impl Diagnostics {
    /// Opens the topic.
    pub(crate) fn start(ros: &RosNode) -> Self {
        let publisher = ros.diagnostics_publisher().map_err(|error| log::error!("{error}")).ok();
        let (log, started, last_status) = (StatusLog::default(), Instant::now(), Vec::new());
        Self { log, publisher, started, published: None, last_error: None, last_status }
    }

    /// Time until the statuses are published again.
    pub(crate) fn until_due(&self, now: Instant) -> Duration {
        self.published.map_or(Duration::ZERO, |last| PERIOD.saturating_sub(now.saturating_duration_since(last)))
    }

    /// `true` if the statuses are to be reported, in the log or on the topic.
    pub(crate) fn is_due(&self) -> bool {
        self.log.is_due(self.log_time()) || self.until_due(Instant::now()).is_zero()
    }

    fn log_time(&self) -> Time {
        Time::from_secs_f64(self.started.elapsed().as_secs_f64())
    }

    /// Reports statuses as far as that is due, with those of the ROS graph.
    pub(crate) fn report(&mut self, ros: &RosNode, entries: &mut [StatusEntry<'_>]) {
        status_tree::add_ros_graph(entries, ros);
        let log_time = self.log_time();
        if self.log.is_due(log_time) {
            self.log.check(entries, log_time);
        }
        if self.begin_publishing() {
            self.last_status = entries.iter().map(|entry| status_of(ros.name(), entry)).collect();
            self.publish(self.last_status.clone());
        }
    }

    /// Publishes the last statuses again if that is due, with a warning about the busy scene's thread.
    pub(crate) fn report_busy(&mut self, ros: &RosNode, text: &str) {
        if !self.begin_publishing() {
            return;
        }
        let busy = diagnostic_status(ros.name(), "Scene", (Level::Warn, text), []);
        let status = std::iter::once(busy).chain(self.last_status.iter().cloned()).collect();
        self.publish(status);
    }

    /// Returns `true` if the topic is due, which counts as published then.
    fn begin_publishing(&mut self) -> bool {
        let now = Instant::now();
        let is_due = self.until_due(now).is_zero();
        if is_due {
            // Timed from when it was due, so that delays do not add up.
            let regular = self.published.and_then(|last| last.checked_add(PERIOD));
            self.published = regular.filter(|due| now.saturating_duration_since(*due) < PERIOD).or(Some(now));
        }
        is_due
    }

    fn publish(&mut self, status: Vec<DiagnosticStatus>) {
        let Some(publisher) = &self.publisher else { return };
        self.last_error = match publisher
            .send(DiagnosticArray { status, ..DiagnosticArray::default() })
            .map_err(|error| error.to_string())
        {
            Ok(()) => None,
            Err(error) => {
                if self.last_error.as_ref() != Some(&error) {
                    log::error!("{error}");
                }
                Some(error)
            }
        };
    }
}

/// Converts an entry: the worst status is the message, the values are the entry's and all statuses.
fn status_of(node: &str, entry: &StatusEntry<'_>) -> DiagnosticStatus {
    let message = match entry.statuses.worst() {
        Some((name, status)) if status.level > Level::Ok => format!("{name}: {}", status.text),
        _ => "OK".to_owned(),
    };
    let mut values = Vec::new();
    if !entry.class.is_empty() {
        values.push(("class", entry.class.clone()));
    }
    if !entry.topic.is_empty() {
        let key = if entry.kind == EntryKind::Camera { "image topic" } else { "topic" };
        values.push((key, entry.topic.clone()));
    }
    if let Some(received) = entry.received {
        let age_ms = figure(entry.age_ms.map(|age_ms| format!("{age_ms:.0}")));
        values.extend([("messages received", received.to_string()), ("age of the data shown ms", age_ms)]);
    }
    values.extend(entry.values.iter().cloned());
    let mut statuses: Vec<_> = entry.statuses.iter().collect();
    statuses.sort_by_key(|(name, status)| (Reverse(status.level), *name != VISIBILITY));
    let listed = statuses.iter().take(MOST_VALUES).map(|(name, status)| match status.level {
        Level::Ok => (*name, status.text.clone()),
        level => (*name, format!("{level:?}: {}", status.text)),
    });
    values.extend(listed);
    if statuses.len() > MOST_VALUES {
        values.push(("further statuses", (statuses.len() - MOST_VALUES).to_string()));
    }
    diagnostic_status(node, &entry.path, (entry.level(), &message), values)
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use rcs_displays::Statuses;

    use super::*;

    #[test]
    fn the_headline_is_the_worst_and_many_statuses_are_cut_short() {
        let mut statuses = Statuses::default();
        for marker in 0..300 {
            statuses.set(Level::Ok, &format!("n/{marker}"), "Marker OK");
        }
        let mut entry = StatusEntry {
            path: "robot / markers".to_owned(),
            class: "rviz/Marker".to_owned(),
            topic: "/m".to_owned(),
            received: Some(7),
            statuses: Cow::Owned(statuses),
            ..StatusEntry::default()
        };
        let ok = status_of("cam", &entry);
        assert_eq!((ok.level, ok.name.as_str(), ok.message.as_str()), (0, "cam: robot / markers", "OK"));
        entry.statuses.to_mut().set(Level::Warn, "z", "odd");
        entry.statuses.to_mut().set(Level::Error, "zz", "broken");
        entry.statuses.to_mut().set(Level::Ok, VISIBILITY, "hidden in camera X");
        let bad = status_of("cam", &entry);
        assert_eq!((bad.level, bad.message.as_str()), (2, "zz: broken"));
        let values: Vec<(&str, &str)> = bad.values.iter().map(|v| (v.key.as_str(), v.value.as_str())).collect();
        let head = [
            ("class", "rviz/Marker"),
            ("topic", "/m"),
            ("messages received", "7"),
            ("age of the data shown ms", "-"),
            ("zz", "Error: broken"),
            ("z", "Warn: odd"),
            (VISIBILITY, "hidden in camera X"),
        ];
        assert_eq!(values[..head.len()], head);
        assert_eq!((values.len(), values[values.len() - 1]), (4 + MOST_VALUES + 1, ("further statuses", "203")));
    }
}
