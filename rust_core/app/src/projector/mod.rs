//! `projector`: a projector's latched CameraInfo and its static frames from one YAML file, and correcting its pose by
//! hand.

mod nudging;
mod publishers;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{bail, Context};
use clap::{Command, CommandFactory, Parser};
use rcs_files::projector::ProjectorFile;
use rcs_node_support::lifecycle;
use rcs_node_support::node_options::with_parameters;
use rcs_node_support::ros_names::{configures, publishes, serves, RosName};
use rcs_node_support::user_file;

use nudging::Nudging;
use publishers::Publishers;

/// Topics, services and settings of the node.
pub const ROS_NAMES: &[RosName] = &[
    publishes("/proj_view/camera_info", "sensor_msgs/CameraInfo", "intrinsics and distortion, latched"),
    publishes("/tf_static", "tf2_msgs/TFMessage", "the file's frames, latched"),
    configures("~", "nudges the CameraInfo's frame: x, y, z [m], roll, pitch, yaw [rad], up to ±0.5"),
    serves("~save", "std_srvs/Trigger", "writes the nudge into the file"),
    serves("~revert", "std_srvs/Trigger", "sets the nudge to 0; without a nudge, takes the last `~save` back"),
];

const DEFAULT_TOPIC: &str = "/proj_view/camera_info";
/// Period at which the shutdown request and simulated time are polled.
const POLL_PERIOD: Duration = Duration::from_millis(100);

/// Publishes a projector's geometry as a latched sensor_msgs/CameraInfo, and its frames on /tf_static.
///
/// The YAML file holds a CameraInfo as rostopic echo prints it, or as camera_calibration saves it (camera_matrix:
/// {rows, cols, data}), and optionally the keys frame_id, camera_info_topic and frames (a list of {parent, child,
/// translation: [x, y, z], rotation_rpy: [roll, pitch, yaw]} or of static_transform_publisher's arguments).
#[derive(Parser)]
#[command(
    name = "projector",
    display_name = "rviz_camera_stream",
    version,
    before_help = "\
Examples:
  projector projector.yaml --camera-info-topic /proj_view/camera_info",
    after_help = "\
Topics published: /proj_view/camera_info (sensor_msgs/CameraInfo, latched), /tf_static (tf2_msgs/TFMessage, latched)
Services: ~save writes the pose that dynamic_reconfigure has moved into the file, ~revert moves it back \
(std_srvs/Trigger)
Parameters: each option is one, too: --file is ~file
Exit codes: 0 ended by SIGINT, SIGTERM or rosnode kill; 1 the file or the node failed; 2 invalid arguments"
)]
struct ProjectorArguments {
    /// The projector's YAML file
    #[arg(value_name = "FILE")]
    positional: Option<PathBuf>,
    /// The projector's YAML file, as an option
    #[arg(long, conflicts_with = "positional")]
    file: Option<PathBuf>,
    /// The CameraInfo's topic [default: camera_info_topic of the file, else /proj_view/camera_info]
    #[arg(long, value_name = "TOPIC")]
    camera_info_topic: Option<String>,
    /// The CameraInfo's frame [default or none: frame_id or header.frame_id of the file]
    #[arg(long, value_name = "FRAME")]
    frame_id: Option<String>,
}

impl ProjectorArguments {
    fn path(&self) -> Option<&Path> {
        self.positional.as_deref().or(self.file.as_deref())
    }
}

/// The command line.
pub fn command() -> Command {
    ProjectorArguments::command()
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    lifecycle::run_main(|arguments: ProjectorArguments| run(&arguments))
}

fn run(arguments: &ProjectorArguments) -> anyhow::Result<()> {
    // An invalid file is reported at once, not when the master is up.
    arguments.path().map(read_file).transpose()?;
    lifecycle::with_node("projector", |node, end| {
        let arguments: ProjectorArguments = with_parameters(node)?;
        let path = arguments.path().context("no projector file: give FILE, --file FILE or the parameter ~file")?;
        let file = read(path, &arguments)?;
        for warning in file.warnings() {
            log::warn!("{}: {warning}", path.display());
        }
        let publishers = Publishers::open(node, &file, arguments.camera_info_topic.as_ref())?;
        let mut nudging = Nudging::start(node, path, file, publishers)?;
        while !end.wait_for(Duration::ZERO) {
            for call in node.calls().wait(POLL_PERIOD) {
                nudging.answer(node, call);
            }
            nudging.replace_zero_stamp(node)?;
        }
        Ok(())
    })
}

/// Reads the file.
fn read_file(path: &Path) -> anyhow::Result<ProjectorFile> {
    user_file::check(path)?;
    Ok(ProjectorFile::read(path)?)
}

/// Reads the file and applies the arguments.
fn read(path: &Path, arguments: &ProjectorArguments) -> anyhow::Result<ProjectorFile> {
    let mut file = read_file(path)?;
    if let Some(frame_id) = arguments.frame_id.as_ref().filter(|frame_id| *frame_id != "none") {
        file.camera_info.header.frame_id.clone_from(frame_id);
    }
    if file.camera_info.header.frame_id.is_empty() {
        bail!(
            "{}: no frame: the file needs frame_id (or header.frame_id); or give --frame-id or ~frame_id",
            path.display()
        );
    }
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_without_a_frame_is_refused_and_an_argument_gives_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("projector.yaml");
        std::fs::write(&path, "width: 100\nheight: 48\nK: [50, 0, 50, 0, 50, 24, 0, 0, 1]\n").unwrap();
        let read = |options: &[&str]| read(&path, &ProjectorArguments::parse_from([&["projector"], options].concat()));
        for options in [&[][..], &["--frame-id", "none"]] {
            let error = read(options).unwrap_err().to_string();
            assert!(error.contains("no frame") && error.contains("--frame-id"), "{error}");
        }
        assert_eq!(read(&["--frame-id", "proj"]).unwrap().camera_info.header.frame_id, "proj");
    }
}
