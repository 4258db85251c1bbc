//! `projector_calibrate refine`: the pose alone, for a projector that was bumped.

use std::path::PathBuf;

use clap::Args;
use rcs_calibration::SolveOptions;
use rcs_files::capture::CapturedRobot;
use rcs_files::correspondences::read_places;
use rcs_node_support::monitor_arguments::MonitorArguments;

use super::clicks::Clicks;
use super::correspondences::Correspondences;
use super::crosshair::{self, CrosshairTargets};
use super::known_projector::KnownProjector;
use super::placing::{frame_in_file, pose_in_file, PlacingArguments};
use super::solve::Solved;
use super::spots::{self, SpotsArguments};
use super::Failure;

/// Solves for the pose alone, for a projector that was bumped; a flat wall is enough
///
/// With --spots, the projector shows at most eight images of spots that the camera sees, in less than ten seconds; a
/// running projector, the node, gets the pose and saves it. Else takes points or capture folders as solve does. By
/// hand: the projector shows a crosshair that you move with the keyboard onto six or more points: those that you click
/// with rviz's Publish Point on the depth camera's cloud (--clicked), or of a file, in the camera's optical frame
/// (--things). The file keeps its lens, comments, names, topic and frames.
#[derive(Debug, Clone, Args)]
#[command(before_help = "\
Examples:
  projector_calibrate refine --spots --projector projector.yaml \\
      --show-on /camera_stream/patterns
  projector_calibrate refine capture --projector projector.yaml
  projector_calibrate refine --clicked --camera-frame camera_optical_frame \\
      --projector projector.yaml --monitor HDMI-1")]
#[command(after_help = "\
Topics subscribed to with --clicked: /clicked_point (geometry_msgs/PointStamped), /tf and /tf_static; with --spots: \
those of verify
Exit codes: 0 written; 1 refused, nothing written; 2 invalid arguments or unreadable files")]
pub(super) struct RefineArguments {
    /// Files of points, or capture folders
    #[arg(value_name = "FILE", required_unless_present_any = ["things", "clicked", "spots", "list_monitors"])]
    points: Vec<PathBuf>,
    /// Points to move a crosshair onto, with the columns x_m, y_m and z_m
    #[arg(long, value_name = "FILE", conflicts_with = "points")]
    things: Option<PathBuf>,
    /// Move the crosshair onto points that are clicked in rviz meanwhile: the topic
    #[arg(
        long,
        value_name = "TOPIC",
        num_args = 0..=1,
        default_missing_value = "/clicked_point",
        conflicts_with_all = ["points", "things"]
    )]
    clicked: Option<String>,
    #[command(flatten)]
    spots: SpotsArguments,
    #[command(flatten)]
    monitor: MonitorArguments,
    /// The projector's file with its lens
    #[arg(long, value_name = "FILE")]
    projector: PathBuf,
    /// The projector's file to write; one that is there keeps all but the pose [default: --projector]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
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
    let projector = KnownProjector::read(&arguments.projector)?;
    if arguments.spots.is_chosen() {
        let (monitor, spots) = (arguments.monitor.monitor.clone(), &arguments.spots);
        return spots::run(spots, monitor, projector, arguments.output.clone(), arguments.report.clone());
    }
    let lens = projector.lens;
    let (points, frames) = match targets(arguments, &projector)? {
        None => (Correspondences::read(&arguments.points)?, None),
        Some(targets) => {
            let (samples, frames) = crosshair::collect(targets, &lens, &arguments.monitor)?;
            (Correspondences { samples, camera_frame: None, robot: CapturedRobot::default() }, frames)
        }
    };
    let options = SolveOptions { known_lens: Some(lens), ..SolveOptions::new(lens.size_px) };
    let (camera, placing) = (points.camera_frame.as_deref(), &arguments.placing);
    let place = placing.camera_pose_like(&projector.file, camera, &points.robot, frames.as_ref())?;
    let solved = Solved::new(&points.samples, &options, arguments.report.as_deref())?;
    let output = arguments.output.as_deref().unwrap_or(&projector.path);
    projector.write(output, &place.parent, &solved.parent_from_projector(&place))?;
    solved.summarise();
    place.tell_written(output);
    Ok(())
}

/// The points that the user moves the crosshair onto, if that is asked for.
fn targets(arguments: &RefineArguments, projector: &KnownProjector) -> Result<Option<CrosshairTargets>, Failure> {
    let file = &projector.file;
    if let Some(topic) = &arguments.clicked {
        let camera = arguments.placing.camera(None)?.to_owned();
        let old_place = frame_in_file(file, Some(&camera)).or(frame_in_file(file, None)).cloned();
        return Ok(Some(CrosshairTargets::Clicked(Clicks { topic: topic.clone(), camera, old_place })));
    }
    let Some(path) = &arguments.things else { return Ok(None) };
    let points = read_places(path).map_err(Failure::unreadable)?;
    Ok(Some(CrosshairTargets::Given(points, pose_in_file(file, None))))
}
