//! What is wrong with a file of correspondences: that it cannot be read, or that what it says is refused.

use std::path::PathBuf;

/// Why correspondences cannot be used or written.
#[derive(Debug, thiserror::Error)]
pub enum PointsError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file is longer than any that can be read.
    #[error("{}: longer than {} GiB", path.display(), most_bytes >> 30)]
    TooLong {
        /// The file.
        path: PathBuf,
        /// The most bytes.
        most_bytes: u64,
    },
    /// There are more points than can be read.
    #[error("{}: with this file there are more than {most} points", path.display())]
    TooMany {
        /// The file that has the last of them.
        path: PathBuf,
        /// The most points.
        most: usize,
    },
    /// The file has no header.
    #[error("{}: it is empty; a header is needed: u_px,v_px,x_m,y_m,z_m", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The header or a row is not what it should be.
    #[error("{}:{line}: {problem}", path.display())]
    Row {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong there.
        problem: RowProblem,
    },
    /// The numbers of the scans become too large when they are told apart from those of the files before.
    #[error("{}: the numbers of its scans are too large to follow those of the files before", path.display())]
    ScanNumbers {
        /// The file.
        path: PathBuf,
    },
    /// The file cannot be written.
    #[error("{}: cannot write: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
}

/// What is wrong in a line.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RowProblem {
    /// A column that is needed is not in the header.
    #[error("the header has no column {0}")]
    MissingColumn(&'static str),
    /// A column is twice in the header.
    #[error("the header has the column {0} twice")]
    RepeatedColumn(String),
    /// The row has another number of fields than the header.
    #[error("{fields} fields, but the header has {columns}")]
    Fields {
        /// How many the row has.
        fields: usize,
        /// How many the header has.
        columns: usize,
    },
    /// A field is not a number.
    #[error("{column}: '{field}' is not a number")]
    NotANumber {
        /// The column.
        column: &'static str,
        /// The field, shortened if it is long.
        field: String,
    },
    /// A field is not the number of a scan.
    #[error("scan: '{0}' is not a whole number from 0 to 4294967295")]
    NotAScan(String),
    /// A number is not finite.
    #[error("{column} is {field}")]
    NotFinite {
        /// The column.
        column: &'static str,
        /// The field.
        field: String,
    },
    /// A number is finite but cannot be right.
    #[error("{column} is {field}; {needed}")]
    OutOfRange {
        /// The column.
        column: &'static str,
        /// The field.
        field: String,
        /// What it should be.
        needed: &'static str,
    },
}

impl RowProblem {
    /// Whether the line can be read and what it says is refused.
    pub fn is_refused(&self) -> bool {
        matches!(self, Self::NotFinite { .. } | Self::OutOfRange { .. })
    }
}

impl PointsError {
    /// Whether the file can be read and what it says is refused: a program exits with 1 then, and with 2 otherwise.
    pub fn is_refused(&self) -> bool {
        matches!(self, Self::Row { problem, .. } if problem.is_refused())
    }
}
