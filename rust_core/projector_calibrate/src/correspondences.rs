//! Correspondences as the commands take them: files of points, or capture folders that are decoded on the way.

use std::path::{Path, PathBuf};

use rcs_calibration::Sample;
use rcs_files::capture::{CapturedRobot, CAPTURE_FILE};
use rcs_files::correspondences;

use super::{decode, Failure};

/// Points of all scans with the projector's pixels that light them.
pub(super) struct Correspondences {
    /// The points; each scan has a number of its own.
    pub(super) samples: Vec<Sample>,
    /// The camera's optical frame, if a capture folder names it.
    pub(super) camera_frame: Option<String>,
    /// The robot during the first scan; empty if that is of a file of points.
    pub(super) robot: CapturedRobot,
}

impl Correspondences {
    /// Reads files of points and capture folders; each folder is a scan.
    pub(super) fn read(paths: &[PathBuf]) -> Result<Self, Failure> {
        let (folders, files): (Vec<&PathBuf>, Vec<&PathBuf>) = paths.iter().partition(|path| is_folder(path));
        let points = correspondences::Correspondences::read(&files).map_err(|error| {
            if error.is_refused() {
                Failure::refused(error)
            } else {
                Failure::unreadable(error)
            }
        })?;
        points.warnings.iter().for_each(|warning| log::warn!("{warning}"));
        let mut all = Self { samples: points.samples, camera_frame: None, robot: CapturedRobot::default() };
        let first = points.scans.last().map_or(0, |last| last.number + 1);
        for (scan, folder) in (first..).zip(folders) {
            let capture = decode::read(folder)?;
            let decoded = decode::decode_capture(folder, &capture)?;
            let samples = decode::points_of(folder, &capture, &decoded)?;
            if scan == 0 {
                all.robot = capture.robot;
            }
            all.samples.extend(samples.into_iter().map(|sample| Sample { scan, ..sample }));
            if all.camera_frame.is_none() && !capture.camera_frame_id.is_empty() {
                all.camera_frame = Some(capture.camera_frame_id);
            }
        }
        Ok(all)
    }
}

fn is_folder(path: &Path) -> bool {
    path.is_dir() || path.file_name().is_some_and(|name| name == CAPTURE_FILE)
}
