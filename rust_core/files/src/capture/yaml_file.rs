//! Reading the YAML files of a capture.

use std::path::Path;

use serde::Deserialize;

use super::error::CaptureError;
use crate::yaml_text::one_line;

/// Largest YAML file.
const MOST_YAML_BYTES: u64 = 4 << 20;

/// Reads a YAML file, with warnings of unknown keys.
pub(super) fn read_yaml<T: for<'de> Deserialize<'de>>(path: &Path) -> Result<(T, Vec<String>), CaptureError> {
    parse_yaml(path, &read_text(path, MOST_YAML_BYTES)?)
}

/// Reads a text file of a limited size.
pub(super) fn read_text(path: &Path, most_bytes: u64) -> Result<String, CaptureError> {
    rcs_user_files::read_text(path, most_bytes).map_err(|source| CaptureError::Read { path: path.to_owned(), source })
}

/// Parses YAML; `path` is for errors and warnings.
pub(super) fn parse_yaml<T: for<'de> Deserialize<'de>>(
    path: &Path,
    text: &str,
) -> Result<(T, Vec<String>), CaptureError> {
    let mut warnings = Vec::new();
    let ignored = |key: serde_ignored::Path<'_>| {
        let key = one_line(&key.to_string());
        warnings.push(format!("{}: key '{key}' is not known and is ignored", path.display()));
    };
    let document = serde_yaml_ng::Deserializer::from_str(text.trim_start_matches('\u{feff}'));
    let contents = serde_ignored::deserialize(document, ignored)
        .map_err(|source| CaptureError::Yaml { path: path.to_owned(), source })?;
    Ok((contents, warnings))
}
