//! Errors of files that are no readable `.rviz` files.

/// Largest file that is read, in bytes: a hundred times the size of usual configs.
pub const MAX_FILE_BYTES: u64 = 8 << 20;

/// A file that is no readable `.rviz` file. Problems inside of one are [`Finding`](crate::Finding)s.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The file is missing, a directory, or not permitted to be read.
    #[error("{file}: cannot be read: {error}")]
    Unreadable {
        /// The file's path as it was given.
        file: String,
        /// The operating system's reason.
        #[source]
        error: std::io::Error,
    },
    /// The file is larger than [`MAX_FILE_BYTES`].
    #[error("{file}: larger than {} MB, so this is not a .rviz file", MAX_FILE_BYTES >> 20)]
    TooLarge {
        /// The file's path as it was given.
        file: String,
    },
    /// The file's bytes are not UTF-8 text.
    #[error("{file}:{line}: not UTF-8 text")]
    NotUtf8 {
        /// The file's path as it was given.
        file: String,
        /// The line of the first offending byte, from 1.
        line: usize,
    },
    /// The text is not YAML, or YAML that nests or repeats itself beyond any use.
    #[error("{file}:{line}:{column}: not YAML: {reason}")]
    NotYaml {
        /// The file's name.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The parser's message.
        reason: String,
    },
    /// The file was written by ROS 2's rviz, whose classes have other names.
    #[error("{file}: this is a ROS 2 config ({class}); save the scene with ROS 1's rviz, or name ROS 1's classes, such as rviz/Grid")]
    Ros2 {
        /// The file's name.
        file: String,
        /// A class of ROS 2's rviz in the file.
        class: String,
    },
    /// The YAML has no map `Visualization Manager`, so it is not a `.rviz` file.
    #[error("{file}: no \"Visualization Manager\" section, so this is not a .rviz file")]
    NoVisualizationManager {
        /// The file's name.
        file: String,
    },
}
