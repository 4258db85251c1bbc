//! Calibration report as two files: `report.yaml` for programs, and `report.html` for people, one page with plots that
//! needs neither network nor scripts.

mod boards;
mod page;
mod plots;
mod scale;
mod svg;
mod yaml;

use std::io::Write as _;
use std::path::Path;

use rcs_calibration::board::BoardSolution;
use rcs_calibration::{Report, Sample};

use crate::atomic_file::write_atomically;
use crate::FileError;

/// File for programs.
pub const YAML_FILE: &str = "report.yaml";
/// File for people.
pub const PAGE_FILE: &str = "report.html";

/// Writes `report.yaml` and `report.html` into a folder, which is created if only its parent exists. Both are written
/// atomically, the one for programs last. `samples` are those of the report's solution.
///
/// # Errors
/// [`FileError`] with the file.
pub fn write(folder: &Path, report: &Report, samples: &[Sample]) -> Result<(), FileError> {
    write_files(folder, &page::page(report, samples, ""), &yaml::yaml(report))
}

/// [`write`] for a calibration with a board: the camera's lens and the board's poses, too.
///
/// # Errors
/// [`FileError`] with the file.
pub fn write_with_boards(folder: &Path, solution: &BoardSolution) -> Result<(), FileError> {
    let BoardSolution { report, samples, .. } = solution;
    let text = yaml::yaml(report) + &boards::yaml(solution);
    write_files(folder, &page::page(report, samples, &boards::tables(solution)), &text)
}

fn write_files(folder: &Path, page: &str, yaml: &str) -> Result<(), FileError> {
    match std::fs::create_dir(folder) {
        Err(source) if source.kind() != std::io::ErrorKind::AlreadyExists => {
            return Err(FileError::writing(folder, source));
        }
        _ => {}
    }
    for (name, text) in [(PAGE_FILE, page), (YAML_FILE, yaml)] {
        let path = folder.join(name);
        let io_error = |source| FileError::writing(&path, source);
        write_atomically(&path, |file| file.write_all(text.as_bytes()).map_err(io_error), io_error)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
