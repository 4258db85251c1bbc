//! `patterns.yaml`: patterns to be shown, with their images beside it.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use rcs_calibration::patterns::Pattern;
use rcs_scene::{Encoding, Image};
use serde::Deserialize;

use super::error::CaptureError;
use super::pattern_entry::{check_writable, entry_line, projector_line, Patterns, ProjectorSize};
use super::yaml_file::{parse_yaml, read_yaml};
use crate::atomic_file::write_atomically;
use crate::image_file;

/// The list of patterns to be shown.
pub const PATTERNS_FILE: &str = "patterns.yaml";

/// Patterns for a projector to show.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PatternList {
    /// Width and height of the projector's image, pixels.
    pub projector_size_px: [u32; 2],
    /// Patterns with the files of their images.
    pub patterns: Vec<(PathBuf, Pattern)>,
    /// Unknown keys, such as misspelt ones, as phrases that name the file.
    pub warnings: Vec<String>,
}

#[derive(Deserialize)]
struct RawList {
    projector: ProjectorSize,
    patterns: Patterns,
}

/// Reads a list of patterns without opening the images.
///
/// # Errors
/// [`CaptureError`] with the file, key and line.
pub fn read_patterns(path: &Path) -> Result<PatternList, CaptureError> {
    Ok(PatternList::from_raw(path, read_yaml(path)?))
}

/// Parses the text of a list of patterns; `path` is for errors, and its folder contains the images.
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

/// Writes the images `p000.png` and so on of these patterns, and then their list, [`PATTERNS_FILE`]. The folder is
/// created if its parent exists.
///
/// # Errors
/// An invalid pattern, or a file that cannot be written.
pub fn write_patterns(folder: &Path, size_px: [u32; 2], patterns: &[Pattern]) -> Result<(), CaptureError> {
    check_writable(size_px, patterns.iter())
        .map_err(|reason| CaptureError::Unwritable { path: folder.to_owned(), reason })?;
    make_folder(folder)?;
    let name = |index: usize| format!("p{index:03}.png");
    let names = (0..patterns.len()).map(name).chain([PATTERNS_FILE.to_owned()]);
    names.map(|name| folder.join(name)).try_for_each(|path| remove_link(&path))?;
    let [width_px, height_px] = size_px;
    patterns.par_iter().enumerate().try_for_each(|(index, pattern)| {
        let image = Image { width_px, height_px, encoding: Encoding::Mono8, data: pattern.image(size_px) };
        image_file::write(&folder.join(name(index)), &image)
    })?;
    let entries = patterns.iter().enumerate().map(|(index, pattern)| entry_line(&name(index), pattern));
    let text = projector_line(size_px) + "patterns:\n" + &entries.collect::<String>();
    write_text(&folder.join(PATTERNS_FILE), &text)
}

/// Removes a link, so that a file of its name is written into the folder and not to the link's target.
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

/// Creates a folder unless it exists.
pub(super) fn make_folder(folder: &Path) -> Result<(), CaptureError> {
    match std::fs::create_dir(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => {
            Err(CaptureError::Write { path: folder.to_owned(), source: error })
        }
        _ => Ok(()),
    }
}
