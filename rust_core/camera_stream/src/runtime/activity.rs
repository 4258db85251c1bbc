//! The present step of the scene's thread, for the control thread and the [watchdog](super::watchdog).

use std::fmt;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use rcs_process::lock;

use crate::runtime::watchdog::Worker;

/// A step of the scene's thread.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum SceneStep {
    /// Takes a message of a topic, by its whole name.
    Message(std::sync::Arc<str>),
    /// Takes transforms, parameters and other events.
    Event,
    Config,
    Displays,
    Frame(String),
    Statuses,
}

impl fmt::Display for SceneStep {
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

/// The work of a busy thread.
#[derive(Clone, Debug)]
pub(crate) struct Busy {
    /// The last wait for events.
    pub(crate) since: Instant,
    pub(crate) step: SceneStep,
    /// The beginning of that step.
    step_since: Instant,
}

/// The activity of the scene's thread, which records it itself.
#[derive(Debug, Default)]
pub(crate) struct Activity {
    busy: Mutex<Option<Busy>>,
}

impl Activity {
    pub(crate) fn begin(&self, step: SceneStep) {
        let now = Instant::now();
        let mut busy = lock(&self.busy);
        let since = busy.as_ref().map_or(now, |busy| busy.since);
        *busy = Some(Busy { since, step, step_since: now });
    }

    /// Records that the thread waits for events.
    pub(crate) fn wait_for_work(&self) {
        *lock(&self.busy) = None;
    }

    /// The thread's work, if it has been busy for at least this long.
    pub(crate) fn busy_for(&self, duration: Duration) -> Option<Busy> {
        lock(&self.busy).clone().filter(|busy| busy.since.elapsed() >= duration)
    }
}

impl Worker for Activity {
    fn step(&self) -> Option<(String, Instant)> {
        lock(&self.busy).as_ref().map(|busy| (busy.step.to_string(), busy.step_since))
    }

    fn consequence(&self) -> Option<&'static str> {
        Some("the last pictures are repeated")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_busy_until_it_waits_for_work() {
        let activity = Activity::default();
        assert!(activity.busy_for(Duration::ZERO).is_none());
        activity.begin(SceneStep::Displays);
        let first = activity.busy_for(Duration::ZERO).unwrap();
        activity.begin(SceneStep::Frame("eye".to_owned()));
        let second = activity.busy_for(Duration::ZERO).unwrap();
        assert_eq!((second.since, second.step.to_string()), (first.since, "drawing camera eye".to_owned()));
        assert!(second.step_since >= first.step_since);
        assert!(activity.busy_for(Duration::from_secs(60)).is_none());
        activity.wait_for_work();
        assert!(activity.busy_for(Duration::ZERO).is_none());
    }
}
