//! `projector_calibrate scan --board`: the board's poses, live with a guide in words, or from folders of images. Each
//! pose becomes a capture folder.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use rcs_calibration::board::{advice, board_pose, BoardAdvice, BoardCorner, Chessboard, LEAST_POSES};
use rcs_calibration::patterns::Pattern;
use rcs_calibration::{Lens, SolveOptions, Verdict};
use rcs_files::image_file::{is_image, read_grey};
use rcs_scan::recorded::{in_order, of_images};
use rcs_scan::{ScanCamera, ScanEvent, ScanFailure, ScanOptions, ScanResult, ScanSession};

use super::poses::{subfolders, BoardPoses};
use super::solve::{solved, summary};
use crate::live::{LiveSession, Progress};
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

/// Images of a camera in folders, one for each pose.
pub(crate) struct ImageFolders<'a> {
    /// The folder of the folders.
    pub(crate) folder: &'a Path,
    /// The patterns in their order.
    pub(crate) patterns: Vec<Pattern>,
    /// The camera's lens, if it is known.
    pub(crate) camera: Option<Lens>,
}

/// Progress of a board scan: the poses so far, and their verdict.
struct Guide {
    scan: BoardScan,
    poses: BoardPoses,
    last: Option<Vec<BoardCorner>>,
    verdict: Option<Verdict>,
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
        guide.finish()
    }

    /// Takes the images in folders.
    pub(crate) fn of_folders(self, folders: &ImageFolders<'_>) -> Result<(), Failure> {
        let (folder, projector_px) = (folders.folder, self.projector_px);
        let mut guide = Guide::new(self)?;
        for pose in subfolders(folder)? {
            let (size_px, greys) = read_images(&pose)?;
            if greys.is_empty() {
                continue;
            }
            let [middle_x, middle_y] = size_px.map(|side| 0.5 * (f64::from(side) - 1.0));
            let unknown = || Lens::pinhole(size_px, [f64::from(size_px[0]); 2], [middle_x, middle_y]);
            let lens = folders.camera.unwrap_or_else(unknown);
            let mut observe = |event: ScanEvent<'_>| {
                if let ScanEvent::Warning(warning) = event {
                    log::warn!("{}: {warning}", pose.display());
                }
            };
            let scanned = in_order(greys, &folders.patterns)
                .and_then(|images| of_images(images, lens, projector_px, &mut observe));
            match scanned {
                Ok(mut scanned) => {
                    scanned.capture.is_camera_calibrated = folders.camera.is_some();
                    guide.add(scanned)?;
                }
                // The patterns that were shown may be in a folder beside the poses.
                Err(failure) if failure.is_refusal() => {
                    log::warn!("{}: this pose is not used: {failure}", pose.display());
                }
                Err(failure) => return Err(Failure::Unreadable(anyhow!("{}: {failure}", pose.display()))),
            }
        }
        if guide.poses.views.is_empty() {
            return Err(Failure::Unreadable(anyhow!("{}: no folders of pictures with the board", folder.display())));
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
        let old = subfolders(&scan.output)?;
        if !old.is_empty() {
            let path = scan.output.display();
            return Err(Failure::Unreadable(anyhow!("{path}: there are folders in it already; give a new one")));
        }
        Ok(Self { poses: BoardPoses::new(scan.board), scan, last: None, verdict: None })
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
        let scanned = scan.scan()?;
        // Half a pose would be solved with as if it were whole.
        if scanned.is_complete {
            Ok(scanned)
        } else {
            Err(ScanFailure::Interrupted)
        }
    }

    /// Writes a pose and judges all of them.
    fn add(&mut self, scanned: ScanResult) -> Result<(), Failure> {
        let name = format!("pose{:02}", self.poses.views.len() + 1);
        let ScanResult { capture, decoded, .. } = scanned;
        if let Err(refusal) = self.poses.add(name.clone(), &capture, &decoded) {
            log::warn!("{name}: this pose is not used: {refusal}");
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

    fn finish(self) -> Result<(), Failure> {
        let (count, output) = (self.poses.views.len(), self.scan.output.display());
        if count < LEAST_POSES {
            return Err(Failure::Refused(anyhow!("{count} poses are too few: scan at least {LEAST_POSES}")));
        }
        eprintln!("written: {count} poses in {output}; next: projector_calibrate solve {output} --board …");
        Ok(())
    }
}

/// The images in a folder by their names, all of one size.
fn read_images(folder: &Path) -> Result<([u32; 2], Vec<Vec<u8>>), Failure> {
    let unreadable = |error: std::io::Error| Failure::Unreadable(anyhow!("{}: {error}", folder.display()));
    let entries = std::fs::read_dir(folder).map_err(unreadable)?.collect::<Result<Vec<_>, _>>().map_err(unreadable)?;
    let mut paths: Vec<PathBuf> = entries.iter().map(std::fs::DirEntry::path).filter(|path| is_image(path)).collect();
    // 2 comes before 10, whether zeros lead or not.
    paths.sort_by_key(|path| number_in(path));
    let (mut size_px, mut greys) = ([0; 2], Vec::new());
    for path in paths {
        let (size, grey) = read_grey(&path).map_err(Failure::unreadable)?;
        if greys.is_empty() {
            size_px = size;
        } else if size != size_px {
            let text = anyhow!(
                "{}: {}x{} pixels, others have {}x{}",
                path.display(),
                size[0],
                size[1],
                size_px[0],
                size_px[1]
            );
            return Err(Failure::Unreadable(text));
        }
        greys.push(grey);
    }
    Ok((size_px, greys))
}

/// The last number in a file's name, and its name.
fn number_in(path: &Path) -> (u64, String) {
    let name = path.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let digits: String =
        name.chars().rev().skip_while(|c| !c.is_ascii_digit()).take_while(char::is_ascii_digit).collect();
    (digits.chars().rev().collect::<String>().parse().unwrap_or(0), name)
}
