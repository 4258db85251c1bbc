//! The error of a file.

use std::fmt::Display;
use std::path::{Path, PathBuf};

/// A file that cannot be read, used or written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {problem}")]
pub struct FileError {
    /// File or folder.
    pub path: PathBuf,
    /// The fault, with the line, offset or key where there is one.
    pub problem: String,
}

impl FileError {
    pub(crate) fn new(path: &Path, problem: impl Display) -> Self {
        Self { path: path.to_owned(), problem: problem.to_string() }
    }

    pub(crate) fn writing(path: &Path, problem: impl Display) -> Self {
        Self::new(path, format_args!("cannot write: {problem}"))
    }
}
