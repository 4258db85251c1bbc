//! Reading a capture folder.

use std::path::Path;

use rayon::prelude::*;
use rcs_calibration::patterns::Pattern;
use rcs_calibration::Lens;
use serde::Deserialize;

use super::error::CaptureError;
use super::file_name::FileName;
use super::images::{read_depth, read_grey};
use super::limits::check_amount;
use super::pattern_entry::{Patterns, ProjectorSize};
use super::robot::{CapturedRobot, FrameChain};
use super::yaml_file::{read_text, read_yaml};
use crate::projector::checked_numbers::PositiveNumber;
use crate::projector::ProjectorFile;

/// The file that names all others.
pub const CAPTURE_FILE: &str = "capture.yaml";
/// Metres of the depth 1: in 16 bits, 6.5 m fit.
pub const DEPTH_SCALE_M: f64 = 0.0001;

/// Largest robot description.
const MOST_URDF_BYTES: u64 = 64 << 20;

/// The camera's image of a pattern.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PatternImage {
    /// Pattern.
    pub pattern: Pattern,
    /// Brightness of each pixel, row by row from the top.
    pub grey: Vec<u8>,
}

/// Contents of a capture folder.
#[derive(Debug, Clone, PartialEq)]
pub struct Capture {
    /// Width and height of the projector's image, pixels.
    pub projector_size_px: [u32; 2],
    /// Lens of the camera, with the size of all images.
    pub camera: Lens,
    /// `false` if the camera has no CameraInfo: of [`Self::camera`] only the size is right.
    pub is_camera_calibrated: bool,
    /// Optical frame of the camera; may be empty.
    pub camera_frame_id: String,
    /// Images in the order of the patterns.
    pub images: Vec<PatternImage>,
    /// Depth (z) of each of the camera's pixels, metres, row by row; only positive numbers are depths.
    pub depth_m: Option<Vec<f32>>,
    /// The robot that carried the camera; empty in captures of cameras without TF, and of other tools.
    pub robot: CapturedRobot,
    /// Unknown keys, such as misspelt ones, as phrases that name the file.
    pub warnings: Vec<String>,
}

#[derive(Deserialize)]
pub(super) struct RawCapture {
    projector: ProjectorSize,
    pub(super) patterns: Patterns,
    pub(super) camera_info: FileName,
    #[serde(default = "yes")]
    camera_calibrated: bool,
    pub(super) depth: Option<FileName>,
    depth_scale_m: Option<PositiveNumber>,
    #[serde(default)]
    frames: FrameChain,
    pub(super) robot_description: Option<FileName>,
}

/// Default of a key.
fn yes() -> bool {
    true
}

impl Capture {
    /// Width and height of the camera's images, pixels.
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
        let images = entries.into_par_iter().map(|entry| {
            let grey = read_grey(&entry.file.to_read(folder)?, size_px)?;
            Ok(PatternImage { pattern: entry.pattern, grey })
        });
        let images: Vec<Result<PatternImage, CaptureError>> = images.collect();
        // The error of the first file, whichever thread was faster.
        let images = images.into_iter().collect::<Result<Vec<_>, _>>()?;
        let scale_m = raw.depth_scale_m.map_or(DEPTH_SCALE_M, |PositiveNumber(scale)| scale);
        let depth_m = raw.depth.map(|file| read_depth(&file.to_read(folder)?, size_px, scale_m)).transpose()?;
        let description = raw.robot_description.map(|file| read_text(&file.to_read(folder)?, MOST_URDF_BYTES));
        let FrameChain(frames) = raw.frames;
        Ok(Self {
            projector_size_px: raw.projector.size_px(),
            camera,
            is_camera_calibrated: raw.camera_calibrated,
            camera_frame_id,
            images,
            depth_m,
            robot: CapturedRobot { description: description.transpose()?, frames },
            warnings,
        })
    }
}

/// Reads the camera's lens, frame, and warnings.
fn read_camera(path: &Path) -> Result<(Lens, String, Vec<String>), CaptureError> {
    let file = ProjectorFile::read(path)?;
    let lens = file.camera_lens().map_err(|problem| CaptureError::Lens { path: path.to_owned(), problem })?;
    let warnings = file.warnings().into_iter().map(|warning| format!("{}: {warning}", path.display())).collect();
    Ok((lens, file.camera_info.header.frame_id, warnings))
}
