//! `projector_calibrate refine`: the pose alone, for a projector that was bumped.

use std::path::PathBuf;

use clap::Args;
use rcs_calibration::{solve, SolveOptions};
use rcs_files::projector::ProjectorFile;

use super::placing::PlacingArguments;
use super::{input, solve as solving, Failure};

/// Solves for the pose alone, for a projector that was bumped; a flat wall is enough
///
/// Takes points or capture folders as solve does, and the projector's file, whose lens is kept as it is. Without a
/// scan, six or more points measured by hand do: steer the crosshair of `show --test crosshair` onto things, and write
/// its pixel and the thing's place in the camera's optical frame into a file of points.
#[derive(Debug, Args)]
#[command(after_help = "\
Exit codes: 0 written; 1 refused, nothing written; 2 invalid arguments or unreadable files

Example: projector_calibrate refine capture --projector projector.yaml -o projector.yaml")]
pub(super) struct RefineArguments {
    /// Files of points, or capture folders
    #[arg(value_name = "FILE", required = true)]
    points: Vec<PathBuf>,
    /// The projector's file with its lens
    #[arg(long, value_name = "FILE")]
    projector: PathBuf,
    /// The projector's file to write; may be the same
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// A folder for report.yaml and report.html
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    #[command(flatten)]
    placing: PlacingArguments,
}

/// Runs the command.
pub(super) fn run(arguments: &RefineArguments) -> Result<(), Failure> {
    let lens = super::read_lens(&arguments.projector)?;
    let input = input::read(&arguments.points)?;
    let options = SolveOptions { known_lens: Some(lens), ..SolveOptions::new(lens.size_px) };
    let solution = solve(&input.samples, &options).map_err(Failure::refused)?;
    let pose = solving::first_pose(&solution)?;
    let report = solving::judge(&input.samples, solution, arguments.report.as_deref())?;
    let placed = arguments.placing.place(&pose.projector_from_camera, input.camera_frame.as_deref())?;
    ProjectorFile::calibrated(&lens, &placed.parent, &placed.parent_from_projector)
        .write(&arguments.output)
        .map_err(Failure::refused)?;
    solving::summarise(&report);
    eprintln!("written: {}", arguments.output.display());
    Ok(())
}
