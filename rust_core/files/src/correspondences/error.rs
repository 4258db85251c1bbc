//! Errors of correspondence files.

use std::path::PathBuf;

/// Failure to read, use or write correspondences.
#[derive(Debug, thiserror::Error)]
pub enum PointsError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// File.
        path: PathBuf,
        /// System error.
        source: std::io::Error,
    },
    /// There are too many points.
    #[error("{}: with this file there are more than {most} points", path.display())]
    TooMany {
        /// File with the last of them.
        path: PathBuf,
        /// Maximum number of points.
        most: usize,
    },
    /// The file has no header.
    #[error("{0}: it is empty; a header is needed: u_px,v_px,x_m,y_m,z_m")]
    Empty(PathBuf),
    /// The header or a row is invalid.
    #[error("{}:{line}: {problem}", path.display())]
    Row {
        /// File.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Problem.
        problem: RowProblem,
    },
    /// The scan numbers overflow when they are shifted past those of the files before.
    #[error("{0}: the numbers of its scans are too large to follow those of the files before")]
    ScanNumbers(PathBuf),
    /// The file cannot be written.
    #[error("{}: cannot write: {source}", path.display())]
    Write {
        /// File.
        path: PathBuf,
        /// System error.
        source: std::io::Error,
    },
}

/// Problem of a line.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RowProblem {
    /// The header lacks a required column.
    #[error("the header has no column {0}")]
    MissingColumn(&'static str),
    /// The header repeats a column.
    #[error("the header has the column {0} twice")]
    RepeatedColumn(String),
    /// The row and the header differ in their number of fields.
    #[error("{fields} fields, but the header has {columns}")]
    Fields {
        /// Fields of the row.
        fields: usize,
        /// Columns of the header.
        columns: usize,
    },
    /// A field is not a number.
    #[error("{column}: '{field}' is not a number")]
    NotANumber {
        /// Column.
        column: &'static str,
        /// Field, shortened if it is long.
        field: String,
    },
    /// A field is not a scan number.
    #[error("scan: '{0}' is not a whole number from 0 to 4294967295")]
    NotAScan(String),
    /// A number is not finite.
    #[error("{column} is {field}")]
    NotFinite {
        /// Column.
        column: &'static str,
        /// Field.
        field: String,
    },
    /// A number is out of range.
    #[error("{column} is {field}; {needed}")]
    OutOfRange {
        /// Column.
        column: &'static str,
        /// Field.
        field: String,
        /// Requirement.
        needed: &'static str,
    },
}

impl RowProblem {
    /// `true` if the line is readable but its values are refused.
    pub fn is_refused(&self) -> bool {
        matches!(self, Self::NotFinite { .. } | Self::OutOfRange { .. })
    }
}

impl PointsError {
    /// `true` if the file is readable but its values are refused: exit status 1, otherwise 2.
    pub fn is_refused(&self) -> bool {
        matches!(self, Self::Row { problem, .. } if problem.is_refused())
    }
}
