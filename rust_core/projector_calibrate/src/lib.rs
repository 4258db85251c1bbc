//! `projector_calibrate`: a projector's intrinsics and pose, measured and checked. One file or folder for each command.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod arguments;
mod board;
mod camera_chain;
mod clicks;
mod correspondences;
mod crosshair;
mod decode;
mod failure;
mod known_projector;
mod live;
mod manual;
mod patterns;
mod pictures;
mod placing;
mod refine;
mod scan;
mod show;
mod solve;
mod spots;
mod verify;
mod watch;
mod window_support;

use std::process::ExitCode;

use clap::{Command, CommandFactory, Parser, Subcommand};
use failure::Failure;
use rcs_node_support::lifecycle::{self, own_arguments};
use rcs_node_support::ros_names::{publishes, serves, subscribes, RosName};

/// Topics of the commands.
pub const ROS_NAMES: &[RosName] = &[
    subscribes(
        "/head_camera/rgb/image_raw",
        "sensor_msgs/Image or CompressedImage",
        "`scan`, `verify`, `refine --spots`, `watch`: mono8, rgb8, bgr8, rgba8 or bgra8",
    ),
    subscribes("/head_camera/rgb/camera_info", "sensor_msgs/CameraInfo", "`scan`, `verify`, `refine --spots`, `watch`"),
    subscribes(
        "/head_camera/depth_registered/image_raw",
        "sensor_msgs/Image or CompressedImage",
        "`scan`, `verify`, `refine --spots`, `watch`: 16UC1 (mm) or 32FC1 (m)",
    ),
    subscribes("CLOUD", "sensor_msgs/PointCloud2", "those with `--cloud`, in place of depth images"),
    subscribes("/tf, /tf_static", "tf2_msgs/TFMessage", "frames between camera and projector"),
    subscribes("/clicked_point", "geometry_msgs/PointStamped", "`refine --clicked`: points from rviz's Publish Point"),
    publishes("~preview", "sensor_msgs/Image", "`scan`: pixels decoded so far, latched"),
    publishes("TOPIC", "sensor_msgs/Image", "`scan`, `verify`, `refine --spots` with `--show-on`: the patterns"),
    publishes(
        "/camera_stream/patterns",
        "sensor_msgs/Image",
        "`watch`: spots, for the node with the screen (`--stream`)",
    ),
    publishes("/diagnostics", "diagnostic_msgs/DiagnosticArray", "`watch`: the drift, `drift_px`"),
    serves("~verify", "std_srvs/Trigger", "`watch`: measures the drift, for `/diagnostics`"),
];

/// Calibrates a projector: writes the file that the program projector publishes.
#[derive(Debug, Parser)]
#[command(
    name = "projector_calibrate",
    display_name = "rviz_camera_stream",
    version,
    before_help = "\
Examples:
  projector_calibrate scan --size 1280x800 --monitor HDMI-1 -o scan1
  projector_calibrate solve scan1 --size 1280x800 -o projector.yaml
  projector_calibrate verify projector.yaml --monitor HDMI-1",
    after_help = "Exit codes: 0 written or shown; 1 refused, nothing written; 2 invalid arguments or unreadable files"
)]
struct CalibrateArguments {
    #[command(subcommand)]
    command: CalibrateCommand,
}

#[derive(Debug, Subcommand)]
enum CalibrateCommand {
    Manual(manual::ManualArguments),
    Board(board::BoardArguments),
    Patterns(patterns::PatternsArguments),
    Show(show::ShowArguments),
    Scan(scan::ScanArguments),
    Decode(decode::DecodeArguments),
    Solve(solve::SolveArguments),
    Refine(refine::RefineArguments),
    Verify(verify::VerifyArguments),
    Watch(watch::WatchArguments),
}

/// The command line.
pub fn command() -> Command {
    CalibrateArguments::command()
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    let arguments = CalibrateArguments::parse_from(own_arguments());
    rcs_logging::start(false);
    rcs_process::name_threads();
    let result = match &arguments.command {
        CalibrateCommand::Manual(arguments) => manual::run(arguments),
        CalibrateCommand::Board(arguments) => board::run(arguments),
        CalibrateCommand::Patterns(arguments) => patterns::run(arguments),
        CalibrateCommand::Show(arguments) => show::run(arguments),
        CalibrateCommand::Scan(arguments) => scan::run(arguments),
        CalibrateCommand::Decode(arguments) => decode::run(arguments),
        CalibrateCommand::Solve(arguments) => solve::run(arguments),
        CalibrateCommand::Refine(arguments) => refine::run(arguments),
        CalibrateCommand::Verify(arguments) => verify::run(arguments),
        CalibrateCommand::Watch(arguments) => watch::run(arguments),
    };
    let status = match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    };
    // Ends the node after an error of a command.
    lifecycle::finish(&Ok(()));
    status
}
