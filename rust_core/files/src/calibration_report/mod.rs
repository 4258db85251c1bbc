//! What a calibration says of itself, as two files: `report.yaml` for programs, and `report.html` for people, one page
//! with its plots, which needs neither network nor scripts.

mod page;
mod parameters;
mod plots;
mod scale;
mod svg;
mod yaml;

use std::io::Write as _;
use std::path::{Path, PathBuf};

use rcs_calibration::{Report, Sample, Verdict};

use crate::atomic_file::write_atomically;

/// The file for programs.
pub const YAML_FILE: &str = "report.yaml";
/// The file for people.
pub const PAGE_FILE: &str = "report.html";

/// Why a report cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot write: {source}", path.display())]
pub struct ReportError {
    /// The file or folder.
    pub path: PathBuf,
    /// The system's error.
    pub source: std::io::Error,
}

/// Writes `report.yaml` and `report.html` into a folder, which is made if it does not exist; its parent must. Each file
/// appears whole or not at all, the one for programs last. `samples` are those that the report's solution is of.
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

/// The word for a verdict in `report.yaml`.
const fn verdict_word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Good => "good",
        Verdict::Usable => "usable",
        Verdict::Again => "again",
    }
}

#[cfg(test)]
mod tests;
