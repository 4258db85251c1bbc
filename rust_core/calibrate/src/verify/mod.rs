//! `projector_calibrate verify`: how far light lands from where it should, on the things that the camera sees now or
//! on the points of a scan.

mod live;
mod points;

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::anyhow;
use clap::Args;
use rcs_window::MonitorChoice;

use super::scan::TopicArguments;
use super::Failure;

/// Measures how far the light of a calibrated projector lands from where it should
///
/// Lights spots, and outlines along depth edges, on the things that the camera sees now, and finds their light in the
/// camera's pictures. Afterwards both stay shown for you to look at. Given files of points or capture folders beside
/// --projector, compares with these instead and shows nothing.
#[derive(Debug, Args)]
#[command(after_help = "\
Topics subscribed to: --image (sensor_msgs/Image: mono8, rgb8, bgr8, rgba8, bgra8), --camera-info, and --depth (16UC1 in
millimetres, 32FC1 in metres) or --cloud; the defaults are those of Fetch's head camera. /tf, if the file places the
projector in another frame than the camera's
Exit codes: 0 within the limit; 1 beyond it, or too little light was found; 2 invalid arguments, unreadable files, or a
topic that is silent or cannot be used

Examples: projector_calibrate verify projector.yaml --limit 2 --monitor HDMI-1
          projector_calibrate verify capture --projector projector.yaml --limit 2")]
pub(super) struct VerifyArguments {
    /// The projector's file; with --projector, files of points or capture folders to compare it with
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,
    /// The projector's file
    #[arg(long, value_name = "FILE")]
    projector: Option<PathBuf>,
    /// The limit of the RMS, pixels of the projector
    #[arg(long, value_name = "PIXELS", default_value_t = 2.0)]
    limit: f64,
    /// The projector's monitor, by name or number [default: the last that is not primary, else the only one]
    #[arg(long, value_name = "NAME|INDEX", default_value = "", hide_default_value = true)]
    monitor: MonitorChoice,
    /// Publish the pictures on this topic, for a projector_window elsewhere, and open no window
    #[arg(long, value_name = "TOPIC", conflicts_with = "monitor")]
    show_on: Option<String>,
    /// The camera's topics.
    #[command(flatten)]
    camera: TopicArguments,
    /// Frames that each picture is the mean of
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=100))]
    frames: u8,
    /// Show spots and outlines for so long afterwards; Ctrl-C, or Escape in the window, ends it
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = hold)]
    hold: Duration,
    /// Write all distances as YAML
    #[arg(long, value_name = "FILE.yaml")]
    report: Option<PathBuf>,
    /// Write the camera's picture with arrows from where light should land to where it has landed
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
}

/// The longest that spots are shown, seconds.
const MOST_SECONDS: f64 = 1e6;

fn hold(text: &str) -> Result<Duration, String> {
    match text.parse() {
        Ok(seconds) if (0.0..=MOST_SECONDS).contains(&seconds) => Ok(Duration::from_secs_f64(seconds)),
        _ => Err(format!("not a number of seconds from 0 to {MOST_SECONDS}")),
    }
}

/// Runs the command.
pub(super) fn run(arguments: &VerifyArguments) -> Result<(), Failure> {
    let limit = arguments.limit;
    if !limit.is_finite() || limit <= 0.0 {
        return Err(Failure::Unreadable(anyhow!("--limit {limit} is not a positive number")));
    }
    match (&arguments.projector, &*arguments.files) {
        (Some(projector), []) | (None, [projector]) => live::run(arguments, projector),
        (Some(projector), files) => {
            if arguments.report.is_some() || arguments.picture.is_some() {
                let reason = "--report and --picture are of a live verification: give no files of points";
                return Err(Failure::Unreadable(anyhow!(reason)));
            }
            points::run(files, projector, limit)
        }
        (None, _) => Err(Failure::Unreadable(anyhow!("which projector? Give its file, alone or as --projector"))),
    }
}

/// Judges an RMS.
fn judge(rms_px: f64, limit: f64) -> Result<(), Failure> {
    if rms_px > limit {
        return Err(Failure::Refused(anyhow!("{rms_px:.2} px RMS are beyond the limit of {limit} px")));
    }
    Ok(())
}

/// Finds out before anything is shown whether a file can be written.
fn check_folder(path: &Path) -> Result<(), Failure> {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if parent.is_dir() {
        return Ok(());
    }
    Err(Failure::Unreadable(anyhow!("{}: the folder {} does not exist", path.display(), parent.display())))
}
