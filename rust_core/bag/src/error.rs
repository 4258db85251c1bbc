//! Errors of reading bags.

use std::io;
use std::path::PathBuf;

/// Why a bag, or a part of it, cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum BagError {
    /// The file cannot be opened or read.
    #[error("{path}: {source}")]
    File {
        /// The bag.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// Not a bag, by its first bytes.
    #[error("{path}: neither a ROS bag of version 2.0 nor an MCAP file")]
    NotABag {
        /// The file.
        path: PathBuf,
    },
    /// The recorder was killed before it wrote the index, or the file is cut off.
    #[error("{path}: no index, the bag was not closed or is cut off: run `{remedy}` on it")]
    NoIndex {
        /// The bag.
        path: PathBuf,
        /// The command that writes an index.
        remedy: &'static str,
    },
    /// The chunks are encrypted.
    #[error("{path}: encrypted by {encryptor}: run `rosbag decrypt` on it")]
    Encrypted {
        /// The bag.
        path: PathBuf,
        /// The plugin that encrypted it.
        encryptor: String,
    },
    /// No topic holds messages of ROS 1.
    #[error("{path}: all messages are encoded as {encoding}, but only those of ROS 1 (ros1) are read")]
    NotRos1 {
        /// The file.
        path: PathBuf,
        /// The encoding, such as `cdr` for ROS 2.
        encoding: String,
    },
    /// A part is damaged.
    #[error("{path}: damaged at byte {at}: {reason}")]
    Damaged {
        /// The bag.
        path: PathBuf,
        /// Offset in the file.
        at: u64,
        /// The problem there.
        reason: String,
    },
}
