//! Errors of reading bags.

use std::fmt::Display;
use std::path::{Path, PathBuf};

/// A bag, or a part of it, that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {problem}")]
pub struct BagError {
    /// The bag.
    pub path: PathBuf,
    /// The fault, with the offset of a damaged part and the command that mends the file where there is one.
    pub problem: String,
}

impl BagError {
    pub(crate) fn new(path: &Path, problem: impl Display) -> Self {
        Self { path: path.to_owned(), problem: problem.to_string() }
    }

    /// Not a bag, by its first bytes.
    pub(crate) fn no_bag(path: &Path) -> Self {
        Self::new(path, "neither a ROS bag of version 2.0 nor an MCAP file")
    }

    /// The recorder was killed before it wrote the index, or the file is cut off.
    pub(crate) fn no_index(path: &Path, remedy: &str) -> Self {
        Self::new(path, format_args!("no index, the bag was not closed or is cut off: run `{remedy}` on it"))
    }
}
