//! The board's poses: corners in capture folders, of cameras with CameraInfo and without.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use rcs_calibration::board::{find_chessboard, lit_corners, BoardRefusal, BoardSolveOptions, BoardView, Chessboard};
use rcs_calibration::patterns::Pattern;
use rcs_calibration::{Decoded, Lens, SolveOptions};
use rcs_files::capture::{Capture, CapturedRobot, CAPTURE_FILE};
use rcs_files::image_folder::subfolders;

use crate::decode::{self, decode_capture};
use crate::Failure;

/// Poses of one board before one camera.
pub(super) struct BoardPoses {
    board: Chessboard,
    pub(super) views: Vec<BoardView>,
    /// The camera's lens, if it has a CameraInfo; its size otherwise.
    camera: Option<(Lens, bool)>,
    /// The camera's optical frame, if a capture names it.
    pub(super) camera_frame: Option<String>,
    /// The robot in the first pose.
    pub(super) robot: CapturedRobot,
}

impl BoardPoses {
    pub(super) fn new(board: Chessboard) -> Self {
        Self { board, views: Vec::new(), camera: None, camera_frame: None, robot: CapturedRobot::default() }
    }

    /// Reads capture folders, or folders of them.
    pub(super) fn read(paths: &[PathBuf], board: Chessboard) -> Result<Self, Failure> {
        let mut poses = Self::new(board);
        for folder in folders(paths)? {
            let capture = decode::read(&folder)?;
            let decoded = decode_capture(&folder, &capture)?;
            let name =
                folder.file_name().map_or_else(|| folder.display().to_string(), |name| name.display().to_string());
            let fault = |error: anyhow::Error| Failure::Refused(error.context(folder.display().to_string()));
            poses.check_camera(&capture).map_err(fault)?;
            poses.add(name, &capture, &decoded).map_err(|refusal| fault(refusal.into()))?;
        }
        Ok(poses)
    }

    /// Adds a pose.
    ///
    /// # Errors
    /// [`BoardRefusal::NoBoard`]: the board is not seen.
    pub(super) fn add(&mut self, name: String, capture: &Capture, decoded: &Decoded) -> Result<(), BoardRefusal> {
        let white = capture.images.iter().find(|image| image.pattern == Pattern::White);
        let grey = white.map_or(&[][..], |white| &white.grey);
        let corners = find_chessboard(grey, capture.image_size_px(), &self.board)?;
        self.views.push(BoardView { name, corners: lit_corners(&corners, decoded) });
        if self.camera.is_none() {
            self.camera = Some((capture.camera, capture.is_camera_calibrated));
            self.robot.clone_from(&capture.robot);
        }
        if self.camera_frame.is_none() && !capture.camera_frame_id.is_empty() {
            self.camera_frame = Some(capture.camera_frame_id.clone());
        }
        Ok(())
    }

    /// Refuses a capture of another camera.
    fn check_camera(&self, capture: &Capture) -> anyhow::Result<()> {
        match &self.camera {
            Some((lens, is_calibrated))
                if lens.size_px != capture.camera.size_px
                    || (*is_calibrated && capture.is_camera_calibrated && *lens != capture.camera) =>
            {
                Err(anyhow!(
                    "its CameraInfo is another one than that of {}: give poses of one camera",
                    self.views[0].name
                ))
            }
            _ => Ok(()),
        }
    }

    /// Options of a solution.
    pub(super) fn options(&self, projector: SolveOptions, ignores_camera_info: bool) -> BoardSolveOptions {
        let (lens, is_calibrated) = self.camera.unwrap_or((Lens::pinhole([1, 1], [1.0; 2], [0.0; 2]), false));
        let camera = (is_calibrated && !ignores_camera_info).then_some(lens);
        BoardSolveOptions { board: self.board, camera_px: lens.size_px, camera, projector }
    }
}

/// Capture folders, and those in folders of them by their names.
fn folders(paths: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let is_capture = |path: &Path| path.join(CAPTURE_FILE).is_file();
    let mut folders = Vec::new();
    for path in paths {
        if is_capture(path) {
            folders.push(path.clone());
            continue;
        }
        let inner = subfolders(path).map_err(Failure::unreadable)?;
        let before = folders.len();
        folders.extend(inner.into_iter().filter(|folder| is_capture(folder)));
        if folders.len() == before {
            return Err(Failure::Unreadable(anyhow!(
                "{}: no {CAPTURE_FILE} in it or in a folder in it; scan --pictures makes captures of pictures",
                path.display()
            )));
        }
    }
    Ok(folders)
}
