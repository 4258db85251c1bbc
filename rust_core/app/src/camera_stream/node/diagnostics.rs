//! How the displays and cameras do, said by the node: changes in the log, all of it on `/diagnostics` once a second.
//!
//! The pace is the computer's clock, so that a simulation that stands still is heard of too; the stamps are ROS's.

use std::time::{Duration, Instant};

use rcs_displays::Level;
use rcs_messages::diagnostic_msgs::{DiagnosticStatus, KeyValue};
use rcs_ros::diagnostics_topic::DiagnosticsPublisher;
use rcs_ros::RosNode;
use rcs_transforms::Time;

use crate::camera_stream::report::{self, Kind, Subject};
use crate::camera_stream::status_log::StatusLog;

/// How often `/diagnostics` is published.
const PERIOD: Duration = Duration::from_secs(1);
/// A monitor shows that many lines of a display at most; what is wrong comes first.
const MOST_VALUES: usize = 100;
/// What the diagnosed thing is.
const HARDWARE_ID: &str = "rviz_camera_stream";

/// What tells how the node does.
pub(super) struct Diagnostics {
    log: StatusLog,
    publisher: Option<DiagnosticsPublisher>,
    started: Instant,
    published: Option<Instant>,
    fault: Option<String>,
}

impl Diagnostics {
    /// Opens the topic.
    pub(super) fn start() -> Self {
        let publisher = DiagnosticsPublisher::new().map_err(|error| log::error!("{error}")).ok();
        Self { log: StatusLog::default(), publisher, started: Instant::now(), published: None, fault: None }
    }

    /// How long until they are published again.
    pub(super) fn until_due(&self, now: Instant) -> Duration {
        self.published.map_or(Duration::ZERO, |last| PERIOD.saturating_sub(now.saturating_duration_since(last)))
    }

    /// Says what is due. `subjects` is called for what is told of.
    pub(super) fn tell<'s>(&mut self, ros: &RosNode, subjects: impl FnOnce() -> Vec<Subject<'s>>) {
        let now = Instant::now();
        let log_time = Time::from_secs_f64(now.saturating_duration_since(self.started).as_secs_f64());
        let (is_log_due, is_topic_due) = (self.log.is_due(log_time), self.until_due(now).is_zero());
        if !is_log_due && !is_topic_due {
            return;
        }
        let mut subjects = subjects();
        report::add_surroundings(&mut subjects, ros);
        if is_log_due {
            self.log.look(&subjects, log_time);
        }
        if is_topic_due {
            // From when it was due, so that the rate is not what is left of it.
            let regular = self.published.and_then(|last| last.checked_add(PERIOD));
            self.published = regular.filter(|due| now.saturating_duration_since(*due) < PERIOD).or(Some(now));
            self.publish(ros, &subjects);
        }
    }

    fn publish(&mut self, ros: &RosNode, subjects: &[Subject<'_>]) {
        let Some(publisher) = &mut self.publisher else { return };
        let node = ros.name().trim_start_matches('/');
        let status = subjects.iter().map(|subject| diagnostic_status(node, subject)).collect();
        self.fault = match publisher.publish(status, ros.now()).map_err(|error| error.to_string()) {
            Ok(()) => None,
            Err(error) => {
                if self.fault.as_ref() != Some(&error) {
                    log::error!("{error}");
                }
                Some(error)
            }
        };
    }
}

fn level(level: Level) -> i8 {
    match level {
        Level::Ok => DiagnosticStatus::OK,
        Level::Warn => DiagnosticStatus::WARN,
        Level::Error => DiagnosticStatus::ERROR,
    }
}

/// A subject as monitors show it: the worst status in the headline, and all of them with what else is known below it.
fn diagnostic_status(node: &str, subject: &Subject<'_>) -> DiagnosticStatus {
    let message = match subject.statuses.worst() {
        Some((name, status)) if status.level > Level::Ok => format!("{name}: {}", status.text),
        _ => "OK".to_owned(),
    };
    let value = |key: &str, value: String| KeyValue { key: key.to_owned(), value };
    let mut values = Vec::new();
    if !subject.class.is_empty() {
        values.push(value("class", subject.class.clone()));
    }
    if !subject.topic.is_empty() {
        let key = if subject.kind == Kind::Camera { "image topic" } else { "topic" };
        values.push(value(key, subject.topic.clone()));
    }
    values.extend(subject.values.iter().map(|(key, text)| value(key, text.clone())));
    let mut statuses: Vec<_> = subject.statuses.iter().collect();
    statuses.sort_by_key(|(_, status)| std::cmp::Reverse(status.level));
    let told = statuses.iter().take(MOST_VALUES).map(|(name, status)| match status.level {
        Level::Ok => value(name, status.text.clone()),
        level => value(name, format!("{level:?}: {}", status.text)),
    });
    values.extend(told);
    if statuses.len() > MOST_VALUES {
        values.push(value("further statuses", (statuses.len() - MOST_VALUES).to_string()));
    }
    DiagnosticStatus {
        level: level(subject.level()),
        name: format!("{node}: {}", subject.path),
        message,
        hardware_id: HARDWARE_ID.to_owned(),
        values,
    }
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
        let mut subject = Subject {
            kind: Kind::Display,
            path: "robot / markers".to_owned(),
            class: "rviz/Marker".to_owned(),
            topic: "/m".to_owned(),
            listens: Vec::new(),
            has_heard: true,
            statuses: Cow::Owned(statuses),
            values: vec![("messages received", "7".to_owned())],
        };
        let well = diagnostic_status("cam", &subject);
        assert_eq!((well.level, well.name.as_str(), well.message.as_str()), (0, "cam: robot / markers", "OK"));
        subject.statuses.to_mut().set(Level::Warn, "z", "odd");
        subject.statuses.to_mut().set(Level::Error, "zz", "broken");
        let ill = diagnostic_status("cam", &subject);
        assert_eq!((ill.level, ill.message.as_str()), (2, "zz: broken"));
        let values: Vec<(&str, &str)> = ill.values.iter().map(|v| (v.key.as_str(), v.value.as_str())).collect();
        let head = [
            ("class", "rviz/Marker"),
            ("topic", "/m"),
            ("messages received", "7"),
            ("zz", "Error: broken"),
            ("z", "Warn: odd"),
        ];
        assert_eq!(values[..5], head);
        assert_eq!((values.len(), values[values.len() - 1]), (3 + MOST_VALUES + 1, ("further statuses", "202")));
    }
}
