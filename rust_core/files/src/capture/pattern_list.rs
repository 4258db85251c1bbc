//! A list of patterns to be shown, `patterns.yaml`, with their pictures beside it.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use rcs_calibration::patterns::Pattern;
use rcs_scene::{Encoding, Picture};
use serde::Deserialize;

use super::pattern_entry::{check_writable, entry_line, projector_line, Patterns, ProjectorSize};
use super::{parse_yaml, read_yaml, CaptureError, PATTERNS_FILE};
use crate::atomic_file::write_atomically;
use crate::picture_file;

/// What a projector is to show.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PatternList {
    /// Width and height of the projector's picture, pixels.
    pub projector_size_px: [u32; 2],
    /// Each pattern with the file of its picture.
    pub patterns: Vec<(PathBuf, Pattern)>,
    /// Keys that have no meaning, such as a misspelt one; each is a phrase that names the file.
    pub warnings: Vec<String>,
}

#[derive(Deserialize)]
struct RawList {
    projector: ProjectorSize,
    patterns: Patterns,
}

/// Reads a list of patterns. The pictures are not opened: the patterns say what they show.
///
/// # Errors
/// [`CaptureError`] with the file, key and line.
pub fn read_patterns(path: &Path) -> Result<PatternList, CaptureError> {
    Ok(PatternList::from_raw(path, read_yaml(path)?))
}

/// Reads the text of a list of patterns; `path` only names it in errors, and its folder is that of the pictures.
///
/// # Errors
/// As [`read_patterns`].
pub fn parse_patterns(path: &Path, text: &str) -> Result<PatternList, CaptureError> {
    Ok(PatternList::from_raw(path, parse_yaml(path, text)?))
}

impl PatternList {
    fn from_raw(path: &Path, (raw, warnings): (RawList, Vec<String>)) -> Self {
        let folder = path.parent().unwrap_or(Path::new(""));
        let Patterns(entries) = raw.patterns;
        let patterns = entries.into_iter().map(|entry| (entry.file.in_folder(folder), entry.pattern)).collect();
        Self { projector_size_px: raw.projector.size_px(), patterns, warnings }
    }
}

/// Writes the pictures `p000.png` and so on of these patterns, and last their list, [`PATTERNS_FILE`]. The folder is
/// made if it does not exist; its parent must.
///
/// # Errors
/// [`CaptureError`]: a pattern that is none, or a file that cannot be written.
pub fn write_patterns(folder: &Path, size_px: [u32; 2], patterns: &[Pattern]) -> Result<(), CaptureError> {
    check_writable(size_px, patterns.iter())
        .map_err(|reason| CaptureError::Unwritable { path: folder.to_owned(), reason })?;
    make_folder(folder)?;
    let name = |index: usize| format!("p{index:03}.png");
    let names = (0..patterns.len()).map(name).chain([PATTERNS_FILE.to_owned()]);
    names.map(|name| folder.join(name)).try_for_each(|path| remove_link(&path))?;
    let [width_px, height_px] = size_px;
    patterns.par_iter().enumerate().try_for_each(|(index, pattern)| {
        let picture = Picture { width_px, height_px, encoding: Encoding::Mono8, data: pattern.picture(size_px) };
        picture_file::write(&folder.join(name(index)), &picture)
    })?;
    let entries = patterns.iter().enumerate().map(|(index, pattern)| entry_line(&name(index), pattern));
    let text = projector_line(size_px) + "patterns:\n" + &entries.collect::<String>();
    write_text(&folder.join(PATTERNS_FILE), &text)
}

/// Removes a link, so that a file of its name is written into the folder and not to where the link leads.
pub(super) fn remove_link(path: &Path) -> Result<(), CaptureError> {
    let removed = match std::fs::symlink_metadata(path) {
        Ok(metadata) if metadata.is_symlink() => std::fs::remove_file(path),
        _ => Ok(()),
    };
    removed.map_err(|source| CaptureError::Write { path: path.to_owned(), source })
}

/// Writes a text whole or not at all.
pub(super) fn write_text(path: &Path, text: &str) -> Result<(), CaptureError> {
    let io_error = |source| CaptureError::Write { path: path.to_owned(), source };
    write_atomically(path, |file| file.write_all(text.as_bytes()).map_err(io_error), io_error)
}

/// Makes a folder unless it is there.
pub(super) fn make_folder(folder: &Path) -> Result<(), CaptureError> {
    match std::fs::create_dir(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => {
            Err(CaptureError::Write { path: folder.to_owned(), source: error })
        }
        _ => Ok(()),
    }
}
