//! `projector_calibrate solve --board`: from the board's poses to the projector's file and the camera's.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use rcs_calibration::board::{solve_boards, BoardRefusal, BoardSolution, Chessboard};
use rcs_calibration::{SolveOptions, Verdict};
use rcs_files::calibration_report;
use rcs_files::projector::{write_camera, ProjectorFile};

use super::poses::BoardPoses;
use crate::placing::PlacingArguments;
use crate::Failure;

/// Name of a camera without a frame, in its file.
const CAMERA_NAME: &str = "camera";

/// The files to write.
pub(crate) struct BoardOutputs<'a> {
    /// The projector's file.
    pub(crate) projector: &'a Path,
    /// The camera's file.
    pub(crate) camera: Option<&'a Path>,
    /// A folder for the report.
    pub(crate) report: Option<&'a Path>,
}

/// Solves, writes the report and, unless the verdict is "again", both files.
pub(crate) fn solve_and_write(
    folders: &[PathBuf],
    board: Chessboard,
    ignores_camera_info: bool,
    options: SolveOptions,
    placing: &PlacingArguments,
    outputs: &BoardOutputs<'_>,
) -> Result<(), Failure> {
    let poses = BoardPoses::read(folders, board)?;
    let place = placing.camera_pose(poses.camera_frame.as_deref(), &poses.robot, None)?;
    let solution = solved(&poses, options, ignores_camera_info).map_err(Failure::refused)?;
    if let Some(folder) = outputs.report {
        calibration_report::write_with_boards(folder, &solution).map_err(Failure::refused)?;
    }
    let report = &solution.report;
    if report.verdict == Verdict::Again {
        return Err(Failure::Refused(anyhow!("not to be used, scan again: {}", report.reasons.join("; "))));
    }
    let pose = report.solution.poses.first().ok_or_else(|| Failure::Refused(anyhow!("no pose was found")))?;
    let parent_from_projector = place.parent_from_camera * pose.projector_from_camera.inverse();
    ProjectorFile::calibrated(&report.solution.lens, &place.parent, &parent_from_projector)
        .write(outputs.projector)
        .map_err(Failure::refused)?;
    if let Some(path) = outputs.camera {
        let name = poses.camera_frame.as_deref().unwrap_or(CAMERA_NAME);
        write_camera(path, &solution.camera, name).map_err(Failure::refused)?;
    }
    eprintln!("{}", summary(&solution));
    report.reasons.iter().for_each(|reason| eprintln!("  {reason}"));
    place.tell_written(outputs.projector);
    if let Some(path) = outputs.camera {
        eprintln!("written: {}", path.display());
    }
    Ok(())
}

/// Solves for the poses so far.
pub(super) fn solved(
    poses: &BoardPoses,
    projector: SolveOptions,
    ignores_camera_info: bool,
) -> Result<BoardSolution, BoardRefusal> {
    solve_boards(&poses.views, &poses.options(projector, ignores_camera_info))
}

/// Verdict and errors in a line.
pub(super) fn summary(solution: &BoardSolution) -> String {
    let report = &solution.report;
    let left_out = solution.left_out_px.map_or(String::new(), |px| format!(", {px:.2} px at poses that are left out"));
    format!(
        "verdict: {}. RMS error {:.2} px{left_out}; {:.2} px in the camera's image; {} poses, {} of {} corners are inliers",
        report.verdict.name(),
        report.solution.rms_px,
        solution.camera_rms_px,
        solution.poses.len(),
        report.solution.inliers,
        report.points,
    )
}
