//! Errors of files that are no readable `.rviz` files.

use std::fmt::Display;
use std::io;
use std::path::Path;

/// Largest file that is read, in bytes: a hundred times the size of usual configs.
pub const MAX_FILE_BYTES: u64 = 8 << 20;

/// A file that is no readable `.rviz` file. Problems inside of one are [`Finding`](crate::Finding)s.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {problem}")]
pub struct ConfigError {
    /// The file's name as it was given, with the line and column of invalid text.
    pub place: String,
    /// The fault.
    pub problem: String,
}

impl ConfigError {
    pub(crate) fn new(place: impl Display, problem: impl Display) -> Self {
        Self { place: place.to_string(), problem: problem.to_string() }
    }

    /// A file that cannot be read, for the system's reason.
    pub fn unreadable(file: &Path, error: &io::Error) -> Self {
        Self::new(file.display(), format_args!("cannot be read: {error}"))
    }
}
