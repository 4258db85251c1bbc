//! `projector_calibrate refine`: the pose alone, for a projector that was bumped.

use std::path::{Path, PathBuf};

use clap::Args;
use rcs_calibration::{solve, Lens, Sample, SolveOptions};
use rcs_files::correspondences::read_places;
use rcs_files::projector::ProjectorFile;

use super::input::Input;
use super::placing::{self, PlacingArguments};
use super::steer::steer;
use super::{input, solve as solving, Failure};
use crate::monitor_arguments::MonitorArguments;

/// Solves for the pose alone, for a projector that was bumped; a flat wall is enough
///
/// Takes points or capture folders as solve does, and the projector's file, whose lens is kept as it is. By hand: with
/// --things, the projector shows a crosshair that you steer with the keyboard onto six or more things, whose places in
/// the camera's optical frame the file has (read off the depth camera, such as with rviz's Publish Point).
#[derive(Debug, Args)]
#[command(after_help = "\
Exit codes: 0 written; 1 refused, nothing written; 2 invalid arguments or unreadable files

Example: projector_calibrate refine capture --projector projector.yaml -o projector.yaml")]
pub(super) struct RefineArguments {
    /// Files of points, or capture folders
    #[arg(value_name = "FILE", required_unless_present_any = ["things", "list_monitors"])]
    points: Vec<PathBuf>,
    /// Places of things, with the columns x_m, y_m and z_m, to steer a crosshair onto
    #[arg(long, value_name = "FILE", conflicts_with = "points")]
    things: Option<PathBuf>,
    #[command(flatten)]
    monitor: MonitorArguments,
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
    if arguments.monitor.print_list().map_err(Failure::refused)? {
        return Ok(());
    }
    let lens = super::read_lens(&arguments.projector)?;
    let input = match &arguments.things {
        None => input::read(&arguments.points)?,
        Some(path) => Input { samples: steered(arguments, path, &lens)?, camera_frame: None },
    };
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

/// What the user steers the crosshair onto; it starts where the projector's file expects each thing.
fn steered(arguments: &RefineArguments, things: &Path, lens: &Lens) -> Result<Vec<Sample>, Failure> {
    let things = read_places(things).map_err(Failure::unreadable)?;
    let file = ProjectorFile::read(&arguments.projector).map_err(Failure::unreadable)?;
    let old_pose = placing::pose_in_file(&file, None);
    steer(&things, lens, old_pose.as_ref(), &arguments.monitor)
}
