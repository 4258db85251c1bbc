//! A capture folder: what a camera saw while a projector showed its patterns, and what is needed to decode it again.
//!
//! `capture.yaml` names everything else, relative to the folder:
//!
//! ```yaml
//! projector: {width: 1280, height: 800}
//! patterns:
//!   - {file: c000.png, kind: white}
//!   - {file: c001.png, kind: black}
//!   - {file: c002.png, kind: gray_code, axis: x, bits: 11, bit: 0, step: 1, offset: 0, inverted: false}
//! camera_info: camera_info.yaml    # a CameraInfo, see `projector`; its size is that of all pictures
//! depth: depth.png                 # optional: 16 bit, registered to the pictures; 0 is no depth
//! depth_scale_m: 0.0001            # metres of the depth 1; this is what is taken if the key is missing
//! ```
//!
//! Pictures are PNGs of 8 bits, grey or in colours. Of colours, the luma of ITU-R BT.601 counts (0.299 red, 0.587
//! green, 0.114 blue), as with OpenCV and so with cv_bridge. [`rcs_calibration::patterns::Stripes`]
//! defines the stripes. Names may lead into folders of the folder, never out of it, by links neither.
//!
//! [`PatternList`] is the same list without a camera, as `patterns.yaml` beside the pictures to be shown.

mod error;
mod file_name;
mod pattern_entry;
mod pattern_list;
mod pictures;
mod write;

use std::io::Read as _;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use rcs_calibration::patterns::Pattern;
use rcs_calibration::Lens;
use serde::Deserialize;

pub use error::CaptureError;
use file_name::FileName;
use pattern_entry::{Patterns, ProjectorSize};
pub use pattern_list::{parse_patterns, read_patterns, write_patterns, PatternList};
use pictures::{read_depth, read_grey};

use crate::projector::checked_numbers::PositiveNumber;
use crate::projector::ProjectorFile;
use crate::yaml_text::one_line;

/// The file that names all others.
pub const CAPTURE_FILE: &str = "capture.yaml";
/// The list of patterns to be shown.
pub const PATTERNS_FILE: &str = "patterns.yaml";
/// The widest and highest picture, pixels, of a camera or a projector.
pub const MOST_PIXELS: u32 = 16_384;
/// The most patterns of a capture.
pub const MOST_PATTERNS: usize = 1000;
/// The most bytes of all pictures together, as grey.
pub const MOST_BYTES: u64 = 8 << 30;
/// Metres of the depth 1: in 16 bits, 6.5 m fit.
pub const DEPTH_SCALE_M: f64 = 0.0001;
/// The most bytes of a YAML file.
const MOST_YAML_BYTES: u64 = 4 << 20;

/// A picture that the camera took while a pattern was shown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PatternPicture {
    /// What was shown.
    pub pattern: Pattern,
    /// Brightness of each pixel, row by row from the top.
    pub grey: Vec<u8>,
}

/// The contents of a capture folder.
#[derive(Debug, Clone, PartialEq)]
pub struct Capture {
    /// Width and height of the projector's picture, pixels.
    pub projector_size_px: [u32; 2],
    /// The camera's lens; its size is that of all pictures.
    pub camera: Lens,
    /// The camera's optical frame; may be empty.
    pub camera_frame_id: String,
    /// What the camera saw, in the order in which it was shown.
    pub pictures: Vec<PatternPicture>,
    /// Depth along the view of each of the camera's pixels, metres, row by row; what is not a positive number is no
    /// depth.
    pub depth_m: Option<Vec<f32>>,
    /// Keys that have no meaning, such as a misspelt one; each is a phrase that names the file.
    pub warnings: Vec<String>,
}

#[derive(Deserialize)]
struct RawCapture {
    projector: ProjectorSize,
    patterns: Patterns,
    camera_info: FileName,
    depth: Option<FileName>,
    depth_scale_m: Option<PositiveNumber>,
}

impl Capture {
    /// Width and height of the camera's pictures, pixels.
    pub fn image_size_px(&self) -> [u32; 2] {
        self.camera.size_px
    }

    /// Reads a folder.
    ///
    /// # Errors
    /// [`CaptureError`] with the file and, where there is one, key and line: a file that is missing or of another size
    /// or depth than it should be, keys that are missing, given twice or out of their range, names that leave the
    /// folder.
    pub fn read(folder: &Path) -> Result<Self, CaptureError> {
        let path = folder.join(CAPTURE_FILE);
        let (raw, mut warnings): (RawCapture, _) = read_yaml(&path)?;
        let camera_path = raw.camera_info.to_read(folder)?;
        let (camera, camera_frame_id, camera_warnings) = read_camera(&camera_path)?;
        warnings.extend(camera_warnings);
        let Patterns(entries) = raw.patterns;
        check_amount(&path, camera.size_px, entries.len())?;

        let size_px = camera.size_px;
        let pictures = entries.into_par_iter().map(|entry| {
            let grey = read_grey(&entry.file.to_read(folder)?, size_px)?;
            Ok(PatternPicture { pattern: entry.pattern, grey })
        });
        let pictures: Vec<Result<PatternPicture, CaptureError>> = pictures.collect();
        // Of several errors the first file's is told, whichever thread was faster.
        let pictures = pictures.into_iter().collect::<Result<Vec<_>, _>>()?;
        let scale_m = raw.depth_scale_m.map_or(DEPTH_SCALE_M, |PositiveNumber(scale)| scale);
        let depth_m = raw.depth.map(|file| read_depth(&file.to_read(folder)?, size_px, scale_m)).transpose()?;
        Ok(Self { projector_size_px: raw.projector.size_px(), camera, camera_frame_id, pictures, depth_m, warnings })
    }
}

/// The camera's lens, its frame, and what is odd about its file.
fn read_camera(path: &Path) -> Result<(Lens, String, Vec<String>), CaptureError> {
    check_is_file(path)?;
    let file = ProjectorFile::read(path)?;
    let lens = file.camera_lens().map_err(|problem| CaptureError::Lens { path: path.to_owned(), problem })?;
    let warnings = file.warnings().into_iter().map(|warning| format!("{}: {warning}", path.display())).collect();
    Ok((lens, file.camera_info.header.frame_id, warnings))
}

/// An error for pictures that would not fit into memory.
fn check_amount(path: &Path, size_px: [u32; 2], patterns: usize) -> Result<(), CaptureError> {
    let [width, height] = size_px.map(u64::from);
    if size_px.iter().any(|size| *size > MOST_PIXELS) {
        return Err(CaptureError::TooLarge { path: path.to_owned(), size_px, most_px: MOST_PIXELS });
    }
    if width * height * patterns as u64 > MOST_BYTES {
        return Err(CaptureError::TooMuch { path: path.to_owned(), patterns, size_px, most_bytes: MOST_BYTES });
    }
    Ok(())
}

/// Reads a YAML file and the phrases about its keys without a meaning.
fn read_yaml<T: for<'de> Deserialize<'de>>(path: &Path) -> Result<(T, Vec<String>), CaptureError> {
    check_is_file(path)?;
    let read_error = |source| CaptureError::Read { path: path.to_owned(), source };
    let mut text = String::new();
    let file = std::fs::File::open(path).map_err(read_error)?;
    file.take(MOST_YAML_BYTES + 1).read_to_string(&mut text).map_err(read_error)?;
    if text.len() as u64 > MOST_YAML_BYTES {
        return Err(CaptureError::LongYaml { path: path.to_owned(), most_bytes: MOST_YAML_BYTES });
    }
    parse_yaml(path, &text)
}

/// Reads YAML; `path` only names it in errors and warnings.
fn parse_yaml<T: for<'de> Deserialize<'de>>(path: &Path, text: &str) -> Result<(T, Vec<String>), CaptureError> {
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

/// An error for what is missing or no file: opening a pipe would wait for its writer.
fn check_is_file(path: &Path) -> Result<(), CaptureError> {
    let metadata = std::fs::metadata(path).map_err(|source| CaptureError::Read { path: path.to_owned(), source })?;
    if metadata.is_file() {
        Ok(())
    } else {
        Err(CaptureError::NotAFile { path: PathBuf::from(path) })
    }
}

#[cfg(test)]
mod tests;
