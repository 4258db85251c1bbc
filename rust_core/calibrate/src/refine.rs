//! `projector_calibrate refine`: the pose alone, for a projector that was bumped.

use std::path::PathBuf;

use anyhow::Context as _;
use clap::Args;
use rcs_calibration::{solve, SolveOptions};
use rcs_files::correspondences::read_places;
use rcs_files::projector::ProjectorFile;

use super::clicks::Clicks;
use super::input::Input;
use super::placing::{self, PlacingArguments};
use super::steer::{steer, Things};
use super::{input, solve as solving, Failure};
use rcs_node_support::lifecycle::EndRequest;
use rcs_node_support::monitor_arguments::MonitorArguments;

/// Solves for the pose alone, for a projector that was bumped; a flat wall is enough
///
/// Takes points or capture folders as solve does, and the projector's file, whose lens is kept as it is. By hand: the
/// projector shows a crosshair that you steer with the keyboard onto six or more things: those that you click with
/// rviz's Publish Point on the depth camera's cloud (--clicked), or whose places in the camera's optical frame a file
/// has (--things).
#[derive(Debug, Args)]
#[command(after_help = "\
Topics subscribed to with --clicked: /clicked_point (geometry_msgs/PointStamped), /tf and /tf_static
Exit codes: 0 written; 1 refused, nothing written; 2 invalid arguments or unreadable files

Examples: projector_calibrate refine capture --projector projector.yaml -o projector.yaml
          projector_calibrate refine --clicked --projector projector.yaml --monitor HDMI-1 -o projector.yaml")]
pub(super) struct RefineArguments {
    /// Files of points, or capture folders
    #[arg(value_name = "FILE", required_unless_present_any = ["things", "clicked", "list_monitors"])]
    points: Vec<PathBuf>,
    /// Places of things, with the columns x_m, y_m and z_m, to steer a crosshair onto
    #[arg(long, value_name = "FILE", conflicts_with = "points")]
    things: Option<PathBuf>,
    /// Steer the crosshair onto the things that are clicked in rviz meanwhile: points on this topic
    #[arg(
        long,
        value_name = "TOPIC",
        num_args = 0..=1,
        default_missing_value = "/clicked_point",
        conflicts_with_all = ["points", "things"]
    )]
    clicked: Option<String>,
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
    if arguments.monitor.tell_monitors().map_err(Failure::refused)? {
        return Ok(());
    }
    let lens = super::read_lens(&arguments.projector)?;
    let (input, frames) = match things(arguments)? {
        None => (input::read(&arguments.points)?, None),
        Some(things) => {
            let (samples, frames) = steer(things, &lens, &arguments.monitor)?;
            (Input { samples, camera_frame: None }, frames)
        }
    };
    let options = SolveOptions { known_lens: Some(lens), ..SolveOptions::new(lens.size_px) };
    let solution = solve(&input.samples, &options).map_err(Failure::refused)?;
    let pose = solving::first_pose(&solution)?;
    let report = solving::judge(&input.samples, solution, arguments.report.as_deref())?;
    let placed =
        arguments.placing.place(&pose.projector_from_camera, input.camera_frame.as_deref(), frames.as_ref())?;
    ProjectorFile::calibrated(&lens, &placed.parent, &placed.parent_from_projector)
        .write(&arguments.output)
        .map_err(Failure::refused)?;
    solving::summarise(&report);
    eprintln!("written: {}", arguments.output.display());
    Ok(())
}

/// What the user steers the crosshair onto, if that is asked for; it starts where the projector's file expects each
/// thing.
fn things(arguments: &RefineArguments) -> Result<Option<Things>, Failure> {
    let old = || ProjectorFile::read(&arguments.projector).map_err(Failure::unreadable);
    if let Some(topic) = &arguments.clicked {
        let camera = arguments.placing.camera(None).to_owned();
        let file = old()?;
        let old_place = placing::frame_in_file(&file, Some(&camera)).or(placing::frame_in_file(&file, None)).cloned();
        let end = EndRequest::watch_signals().context("cannot handle signals").map_err(Failure::Unreadable)?;
        return Ok(Some(Things::Clicked(Clicks { topic: topic.clone(), camera, old_place, end })));
    }
    let Some(path) = &arguments.things else { return Ok(None) };
    let things = read_places(path).map_err(Failure::unreadable)?;
    Ok(Some(Things::Given(things, placing::pose_in_file(&old()?, None))))
}
