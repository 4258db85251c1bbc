//! `projector_calibrate scan --board`: the board's poses, live with a guide in words, or from folders of images. Each
//! pose becomes a capture folder.

use std::fmt::Display;
use std::path::PathBuf;

use anyhow::anyhow;
use rcs_calibration::board::{advice, board_pose, BoardAdvice, BoardCorner, Chessboard, LEAST_POSES};
use rcs_calibration::{DecodeError, Lens, SolveOptions, Verdict};
use rcs_files::image_folder::{extensions, subfolders};
use rcs_scan::{ScanCamera, ScanEvent, ScanFailure, ScanOptions, ScanResult, ScanSession};

use super::poses::BoardPoses;
use super::solve::{solved, summary};
use crate::live::{LiveSession, Progress};
use crate::pictures::Pictures;
use crate::Failure;

/// Maximum number of poses: more improve nothing.
const MOST_POSES: usize = 20;
/// Minimum number of poses for the verdict good: fewer cannot be checked.
const ENOUGH_POSES: usize = 5;

/// A scan of a board.
#[derive(Debug, Clone)]
pub(crate) struct BoardScan {
    pub(crate) board: Chessboard,
    /// Width and height of the projector's image, pixels.
    pub(crate) projector_px: [u32; 2],
    /// The folder for the folders of all poses.
    pub(crate) output: PathBuf,
}

/// Progress of a board scan: the poses so far, and their verdict.
struct Guide {
    scan: BoardScan,
    poses: BoardPoses,
    last: Option<Vec<BoardCorner>>,
    verdict: Option<Verdict>,
    /// The last pose that is not used, with the reason.
    refused: Option<String>,
}

impl BoardScan {
    /// Scans live until the verdict is good or the session is to end.
    pub(crate) fn live(self, session: &mut LiveSession<'_>, step: u32, frames: usize) -> Result<(), Failure> {
        let end = session.end;
        let options =
            ScanOptions { projector_px: self.projector_px, step, frames, is_cancelled: &|| end.is_requested() };
        session.camera.follow_robot().map_err(Failure::unreadable)?;
        if !session.camera.is_calibrated() {
            log::info!("the camera has no CameraInfo: its lens is solved for, too");
        }
        let camera_px = session.camera.lens().size_px;
        let mut guide = Guide::new(self)?;
        while !guide.is_done() {
            let advice = guide.advice();
            let mut progress = Progress::new(advice.text(), None, camera_px, options.projector_px);
            let scanned = guide.scan_pose(session, &options, &mut |event| progress.show(&event));
            progress.finish();
            match scanned {
                Ok(mut scanned) => {
                    session.check_valid()?;
                    scanned.capture.robot = session.camera.robot();
                    scanned.capture.is_camera_calibrated = session.camera.is_calibrated();
                    guide.add(scanned)?;
                }
                Err(ScanFailure::Interrupted) => break,
                // Another pose may be better.
                Err(failure) if failure.is_refusal() => log::warn!("this pose is not used: {failure}"),
                Err(failure) => return Err(failure.into()),
            }
        }
        let finished = guide.finish();
        finished
            .map_err(|failure| if end.is_requested() { Failure::Interrupted(failure.into_error()) } else { failure })
    }

    /// Takes the images in folders, one for each pose.
    pub(crate) fn of_folders(self, pictures: &Pictures<'_>) -> Result<(), Failure> {
        let mut guide = Guide::new(self)?;
        let mut has_images = false;
        for pose in subfolders(pictures.folder).map_err(Failure::unreadable)? {
            let set = pictures.read(&pose)?;
            if set.greys.is_empty() {
                continue;
            }
            has_images = true;
            match pictures.scan(&pose, set) {
                Ok(scanned) => guide.add(scanned)?,
                // The patterns that were shown, or other images, may be in a folder beside the poses.
                Err(failure)
                    if failure.is_refusal() || matches!(failure, ScanFailure::Decode(DecodeError::Count(..))) =>
                {
                    guide.refuse(&pose.display(), &failure);
                }
                Err(failure) => return Err(Failure::Unreadable(anyhow!("{}: {failure}", pose.display()))),
            }
        }
        if !has_images {
            let (folder, extensions) = (pictures.folder.display(), extensions());
            let text = anyhow!("{folder}: no folder in it has pictures ({extensions}): give each pose a folder");
            return Err(Failure::Unreadable(text));
        }
        guide.finish()
    }
}

impl Guide {
    fn new(scan: BoardScan) -> Result<Self, Failure> {
        match std::fs::create_dir(&scan.output) {
            Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => {
                return Err(Failure::Refused(anyhow!("{}: cannot write: {error}", scan.output.display())));
            }
            _ => {}
        }
        let old = subfolders(&scan.output).map_err(Failure::unreadable)?;
        if !old.is_empty() {
            let path = scan.output.display();
            return Err(Failure::Unreadable(anyhow!("{path}: there are folders in it already; give a new one")));
        }
        Ok(Self { poses: BoardPoses::new(scan.board), scan, last: None, verdict: None, refused: None })
    }

    fn is_done(&self) -> bool {
        let count = self.poses.views.len();
        count >= MOST_POSES || (count >= ENOUGH_POSES && self.verdict == Some(Verdict::Good))
    }

    /// Advice for the next pose.
    fn advice(&self) -> BoardAdvice {
        let options = self.poses.options(SolveOptions::new(self.scan.projector_px), false);
        // Good enough to tell how a board is tilted.
        let guess = || {
            let [middle_x, middle_y] = options.camera_px.map(|side| 0.5 * (f64::from(side) - 1.0));
            Lens::pinhole(options.camera_px, [f64::from(options.camera_px[0]); 2], [middle_x, middle_y])
        };
        let lens = options.camera.unwrap_or_else(guess);
        let pose = |corners: &Vec<BoardCorner>| board_pose(corners, self.scan.board, &lens);
        advice(&self.poses.views.iter().filter_map(|view| pose(&view.corners)).collect::<Vec<_>>())
    }

    /// Waits for the board in a new pose, and scans it.
    fn scan_pose(
        &mut self,
        session: &mut LiveSession<'_>,
        options: &ScanOptions<'_>,
        observe: &mut dyn FnMut(ScanEvent<'_>),
    ) -> Result<ScanResult, ScanFailure> {
        log::info!("pose {}: {}", self.poses.views.len() + 1, self.advice());
        let mut scan = ScanSession::new(&mut *session.screen, &mut session.camera, options, observe);
        let corners = scan.wait_for_board(&self.scan.board, self.last.as_deref())?;
        self.last = Some(corners);
        let mut scanned = scan.scan()?;
        // Half a pose would be solved with as if it were whole.
        scanned.ended.take().map_or(Ok(scanned), Err)
    }

    /// Writes a pose and judges all of them.
    fn add(&mut self, scanned: ScanResult) -> Result<(), Failure> {
        let name = format!("pose{:02}", self.poses.views.len() + 1);
        let ScanResult { capture, decoded, .. } = scanned;
        if let Err(refusal) = self.poses.add(name.clone(), &capture, &decoded) {
            self.refuse(&name, &refusal);
            return Ok(());
        }
        capture.write(&self.scan.output.join(&name)).map_err(Failure::refused)?;
        log::info!("{name}: {} corners", self.poses.views.last().map_or(0, |view| view.corners.len()));
        if self.poses.views.len() >= LEAST_POSES {
            let solution = solved(&self.poses, SolveOptions::new(self.scan.projector_px), false);
            self.verdict = solution.as_ref().ok().map(|solution| solution.report.verdict);
            match solution {
                Ok(solution) => {
                    log::info!("{}", summary(&solution));
                    solution.report.reasons.iter().for_each(|reason| log::info!("  {reason}"));
                }
                Err(refusal) => log::warn!("{refusal}"),
            }
        }
        Ok(())
    }

    /// Notes a pose that is not used.
    fn refuse(&mut self, name: &dyn Display, reason: &dyn Display) {
        log::warn!("{name}: this pose is not used: {reason}");
        self.refused = Some(format!("{name}: {reason}"));
    }

    fn finish(self) -> Result<(), Failure> {
        let (count, output) = (self.poses.views.len(), self.scan.output.display());
        if count < LEAST_POSES {
            let refused = self.refused.map_or(String::new(), |last| format!("; the last that is not used: {last}"));
            return Err(Failure::Refused(anyhow!("{count} poses are too few: scan at least {LEAST_POSES}{refused}")));
        }
        let frame = if self.poses.camera_frame.is_none() { " --camera-frame FRAME" } else { "" };
        eprintln!("written: {count} poses in {output}; next: projector_calibrate solve {output} --board …{frame}");
        Ok(())
    }
}
