//! Errors of single keys of a projector's file.

use std::path::Path;

use crate::yaml_text::one_line;
use crate::FileError;

/// An invalid key and the reason.
pub(super) type KeyError = (&'static str, String);

/// The error of a file with an invalid key.
pub(super) fn key_error(path: &Path, (key, reason): KeyError) -> FileError {
    FileError::new(path, format_args!("{key}: {}", one_line(&reason)))
}
