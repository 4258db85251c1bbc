//! Calibration report as two files: `report.yaml` for programs, and `report.html` for people, one page with plots that
//! needs neither network nor scripts.

mod page;
mod plots;
mod scale;
mod svg;
mod yaml;

use std::io::Write as _;
use std::path::{Path, PathBuf};

use rcs_calibration::{Report, Sample};

use crate::atomic_file::write_atomically;

/// File for programs.
pub const YAML_FILE: &str = "report.yaml";
/// File for people.
pub const PAGE_FILE: &str = "report.html";

/// Failure to write a report.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot write: {source}", path.display())]
pub struct ReportError {
    /// File or folder.
    pub path: PathBuf,
    /// System error.
    pub source: std::io::Error,
}

/// Writes `report.yaml` and `report.html` into a folder, which is created if only its parent exists. Both are written
/// atomically, the one for programs last. `samples` are those of the report's solution.
///
/// # Errors
/// [`ReportError`] with the file.
pub fn write(folder: &Path, report: &Report, samples: &[Sample]) -> Result<(), ReportError> {
    match std::fs::create_dir(folder) {
        Err(source) if source.kind() != std::io::ErrorKind::AlreadyExists => {
            return Err(ReportError { path: folder.to_owned(), source });
        }
        _ => {}
    }
    for (name, text) in [(PAGE_FILE, page::page(report, samples)), (YAML_FILE, yaml::yaml(report))] {
        let path = folder.join(name);
        let io_error = |source| ReportError { path: path.clone(), source };
        write_atomically(&path, |file| file.write_all(text.as_bytes()).map_err(io_error), io_error)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
