//! What a display would say of itself in rviz's tree.

use std::collections::BTreeMap;

/// How well a display does; the worst of its statuses counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Level {
    /// All is well.
    #[default]
    Ok,
    /// Something is missing, and may still come.
    Warn,
    /// Something is wrong.
    Error,
}

/// One line of a display's statuses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Status {
    /// How bad it is.
    pub level: Level,
    /// What is the matter, as rviz puts it.
    pub text: String,
}

/// A display's statuses by name (`Topic`, `Transform`, `Message`, …).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Statuses {
    by_name: BTreeMap<String, Status>,
}

impl Statuses {
    /// The status that tells whether messages come.
    pub const TOPIC: &'static str = "Topic";
    /// The status that tells about frames.
    pub const TRANSFORM: &'static str = "Transform";
    /// The status of a display whose class is not drawn.
    pub const CLASS: &'static str = "Class";

    /// Sets a status.
    pub fn set(&mut self, level: Level, name: &str, text: impl Into<String>) {
        self.by_name.insert(name.to_owned(), Status { level, text: text.into() });
    }

    /// Takes a status away.
    pub fn remove(&mut self, name: &str) {
        self.by_name.remove(name);
    }

    /// Takes all statuses away.
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

    /// The worst of them, with its name; of several equally bad ones the first by name. `None` without any.
    pub fn worst(&self) -> Option<(&str, &Status)> {
        self.iter().reduce(|worst, next| if next.1.level > worst.1.level { next } else { worst })
    }

    /// How bad the worst of them is.
    pub fn level(&self) -> Level {
        self.by_name.values().map(|status| status.level).max().unwrap_or_default()
    }
}
