//! What the scene's thread is doing, for those who wait for it and for the [watchdog](crate::runtime::watchdog).

use std::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::runtime::watchdog::Worker;

/// A step of the scene's thread.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Takes a message of a topic, by its whole name.
    Message(std::sync::Arc<str>),
    /// Takes transforms, parameters and what else arrives.
    Event,
    /// Applies another config.
    Config,
    /// Brings the displays up to date.
    Displays,
    /// Draws a picture of the camera of this name.
    Frame(String),
    /// Collects and reports statuses.
    Statuses,
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Message(topic) => write!(f, "taking a message of {topic}"),
            Self::Event => f.write_str("taking transforms"),
            Self::Config => f.write_str("applying the config"),
            Self::Displays => f.write_str("updating the displays"),
            Self::Frame(camera) => write!(f, "drawing camera {camera}"),
            Self::Statuses => f.write_str("collecting the statuses"),
        }
    }
}

/// Since when the thread has been busy, and with what.
#[derive(Clone, Debug)]
pub(crate) struct Busy {
    /// Since when it has not waited for events.
    pub(crate) since: Instant,
    /// What it is doing.
    pub(crate) step: Step,
    /// Since when it has been doing that.
    step_since: Instant,
}

/// What the scene's thread is doing. It notes that itself; others read it.
#[derive(Debug, Default)]
pub(crate) struct Activity {
    busy: Mutex<Option<Busy>>,
}

impl Activity {
    fn lock(&self) -> MutexGuard<'_, Option<Busy>> {
        self.busy.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The thread begins a step.
    pub(crate) fn begin(&self, step: Step) {
        let now = Instant::now();
        let mut busy = self.lock();
        let since = busy.as_ref().map_or(now, |busy| busy.since);
        *busy = Some(Busy { since, step, step_since: now });
    }

    /// The thread is about to wait for events.
    pub(crate) fn wait_for_work(&self) {
        *self.lock() = None;
    }

    /// What the thread is doing, if it has been busy for at least this long.
    pub(crate) fn busy_for(&self, duration: Duration) -> Option<Busy> {
        self.lock().clone().filter(|busy| busy.since.elapsed() >= duration)
    }
}

impl Worker for Activity {
    fn step(&self) -> Option<(String, Instant)> {
        self.lock().as_ref().map(|busy| (busy.step.to_string(), busy.step_since))
    }

    fn consequence(&self) -> Option<&'static str> {
        Some("the last pictures are repeated")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_has_been_busy_since_it_last_rested() {
        let activity = Activity::default();
        assert!(activity.busy_for(Duration::ZERO).is_none());
        activity.begin(Step::Displays);
        let first = activity.busy_for(Duration::ZERO).unwrap();
        activity.begin(Step::Frame("eye".to_owned()));
        let second = activity.busy_for(Duration::ZERO).unwrap();
        assert_eq!((second.since, second.step.to_string()), (first.since, "drawing camera eye".to_owned()));
        assert!(second.step_since >= first.step_since);
        assert!(activity.busy_for(Duration::from_secs(60)).is_none());
        activity.wait_for_work();
        assert!(activity.busy_for(Duration::ZERO).is_none());
    }
}
