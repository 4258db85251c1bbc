//! The statuses of a display, as rviz's tree shows them.

use std::collections::BTreeMap;
use std::ops::Bound;

/// Severity of a status; that of a display is the worst of its statuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Level {
    /// Working.
    #[default]
    Ok,
    /// Something is missing that may still come.
    Warn,
    /// Failed.
    Error,
}

/// Cause of a status, where consumers need it: a missing frame is often merely late.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum StatusCause {
    /// A frame that cannot be found, or not at the time in question.
    Frame,
    /// Anything else.
    #[default]
    Other,
}

/// Text of a status with its cause. Plain text has the cause [`StatusCause::Other`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StatusText {
    /// rviz's text where rviz has such a status, otherwise this project's.
    pub text: String,
    /// Its cause.
    pub cause: StatusCause,
}

impl StatusText {
    /// A text about a frame that cannot be found.
    pub(crate) fn about_frame(text: String) -> Self {
        Self { text, cause: StatusCause::Frame }
    }
}

impl From<String> for StatusText {
    fn from(text: String) -> Self {
        Self { text, cause: StatusCause::Other }
    }
}

impl From<&str> for StatusText {
    fn from(text: &str) -> Self {
        text.to_owned().into()
    }
}

/// One line of a display's statuses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Status {
    /// Its severity.
    pub level: Level,
    /// rviz's text where rviz has such a status, otherwise this project's.
    pub text: String,
    /// Its cause.
    pub cause: StatusCause,
}

impl Status {
    /// The text in one line.
    pub fn one_line(&self) -> String {
        self.text.replace(" \n", "; ").replace('\n', "; ")
    }
}

/// A display's statuses by name (`Topic`, `Transform`, `Message`, …).
///
/// ```
/// use rcs_displays::{Level, Statuses};
///
/// let mut statuses = Statuses::default();
/// statuses.set(Level::Ok, Statuses::TRANSFORM, "Transform OK");
/// statuses.set(Level::Warn, Statuses::TOPIC, "No messages received");
/// assert_eq!(statuses.level(), Level::Warn);
/// assert_eq!(statuses.worst().map(|(name, _)| name), Some("Topic"));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Statuses {
    by_name: BTreeMap<String, Status>,
}

impl Statuses {
    /// The name of the status that reports whether messages arrive.
    pub const TOPIC: &'static str = "Topic";
    /// The name of the status that reports whether frames are known.
    pub const TRANSFORM: &'static str = "Transform";
    /// The name of the status of a display whose class is not drawn.
    pub const CLASS: &'static str = "Class";
    /// The name of the status of a display that panicked.
    pub(crate) const FAULT: &'static str = "Fault";

    /// Sets a status.
    pub fn set(&mut self, level: Level, name: &str, text: impl Into<StatusText>) {
        let StatusText { text, cause } = text.into();
        let status = Status { level, text, cause };
        match self.by_name.get_mut(name) {
            Some(known) => *known = status,
            None => drop(self.by_name.insert(name.to_owned(), status)),
        }
    }

    /// Removes a status.
    pub fn remove(&mut self, name: &str) {
        self.by_name.remove(name);
    }

    /// `false` only if no status's name begins so.
    pub(crate) fn may_begin_with(&self, begin: &str) -> bool {
        let from = (Bound::Included(begin), Bound::Unbounded);
        self.by_name.range::<str, _>(from).next().is_some_and(|(name, _)| name.starts_with(begin))
    }

    /// Removes all statuses.
    pub fn clear(&mut self) {
        self.by_name.clear();
    }

    /// A status by its name.
    pub fn get(&self, name: &str) -> Option<&Status> {
        self.by_name.get(name)
    }

    /// All statuses by name, sorted.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Status)> {
        self.by_name.iter().map(|(name, status)| (name.as_str(), status))
    }

    /// The worst status with its name; of several the first by name.
    pub fn worst(&self) -> Option<(&str, &Status)> {
        self.iter().reduce(|worst, next| if next.1.level > worst.1.level { next } else { worst })
    }

    /// Severity of the worst status.
    pub fn level(&self) -> Level {
        self.by_name.values().map(|status| status.level).max().unwrap_or_default()
    }
}
