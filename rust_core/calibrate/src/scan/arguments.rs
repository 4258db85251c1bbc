//! What a user types after `projector_calibrate scan`.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::anyhow;
use clap::Args;
use rcs_calibration::patterns::Pattern;
use rcs_files::picture_file::PictureFormat;
use rcs_scan::{patterns, CameraTopics, DepthTopic};
use rcs_window::MonitorChoice;

use super::super::arguments::{size, Size};
use super::super::{show, Failure};
use super::topics::TopicArguments;

/// The widest code, so that there are no more stripes than can be decoded.
const MOST_STEP: i64 = 8;

/// Shows patterns with the projector and writes what the camera sees of them
///
/// Nothing may move meanwhile, half a minute or so. The camera's exposure must be fixed. Measured is the delay from
/// showing to seeing; checked are exposure, rest, and whether the picture is mirrored; a scan that would mislead is
/// refused. Ctrl-C, or Escape in the window, ends it: what was seen up to then is written if it is enough.
///
/// With --bag, a scan that was recorded: the camera's topics, while the patterns were shown by
/// `projector_calibrate show --patterns DIR --seconds 1 --pause 0.5`. No ROS master is needed.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Topics subscribed to: --image (sensor_msgs/Image: mono8, rgb8, bgr8, rgba8, bgra8; or CompressedImage), --camera-info,
and --depth (16UC1 in millimetres, 32FC1 in metres; or CompressedImage) or --cloud; the defaults are those of Fetch's
head camera
Topic published: ~preview (sensor_msgs/Image, latched), what is decoded so far in the colours of --preview
Exit codes: 0 written; 1 refused, nothing written; 2 invalid arguments, or a topic or a bag that is silent or cannot be
used

Examples: projector_calibrate scan --size 1280x800 --monitor HDMI-1 -o scan1
          projector_calibrate scan --bag scan.bag --size 1280x800 -o scan1")]
pub(crate) struct ScanArguments {
    /// Width and height of the projector's picture, pixels: its native resolution
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Size,
    /// The folder to write to; made if it does not exist, a capture in it is replaced
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: PathBuf,
    /// The projector's monitor, by name or number [default: the last that is not primary, else the only one]
    #[arg(long, value_name = "NAME|INDEX", default_value = "", hide_default_value = true)]
    pub(super) monitor: MonitorChoice,
    /// Publish the patterns on this topic, for a projector_window elsewhere, and open no window. With --bag: the bag's
    /// topic on which they were shown
    #[arg(long, value_name = "TOPIC", conflicts_with = "monitor")]
    pub(super) show_on: Option<String>,
    /// Scan what this bag has recorded, or several, such as the parts of a split recording: .bag or .mcap of ROS 1
    #[arg(long, value_name = "FILE.bag", num_args = 1.., conflicts_with = "monitor")]
    pub(super) bag: Vec<PathBuf>,
    /// With --bag: the folder of the patterns that were shown, or its patterns.yaml [default: those that the command
    /// patterns writes for --size and --step]
    #[arg(long, value_name = "DIR|FILE", requires = "bag")]
    pub(super) patterns: Option<PathBuf>,
    /// With --bag: leave out what was recorded before, seconds since its beginning
    #[arg(long, value_name = "SECONDS", requires = "bag", value_parser = seconds, default_value = "0")]
    pub(super) start: Duration,
    /// The camera's topics.
    #[command(flatten)]
    camera: TopicArguments,
    /// Take no depth: what is written can be decoded, not solved
    #[arg(long, conflicts_with_all = ["depth", "cloud"])]
    no_depth: bool,
    /// Frames that each picture is the mean of
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=100))]
    pub(super) frames: u8,
    /// Projector pixels that share a code, 1 to 8: from 2 on, wider stripes are shown in more pictures
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=MOST_STEP))]
    pub(super) step: u32,
    /// Write what was decoded as a picture in false colours: red for columns, green for rows
    #[arg(long, value_name = "FILE.png")]
    pub(super) preview: Option<PathBuf>,
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number of seconds".to_owned())?;
    Duration::try_from_secs_f64(seconds).map_err(|_| "not a number of seconds from 0 on".to_owned())
}

impl ScanArguments {
    /// The camera's topics.
    pub(super) fn topics(&self) -> CameraTopics {
        let topics = self.camera.topics();
        if self.no_depth {
            CameraTopics { depth: DepthTopic::None, ..topics }
        } else {
            topics
        }
    }

    /// The patterns that a recording shows, in their order.
    ///
    /// # Errors
    /// [`Failure::Unreadable`]: a list that cannot be read, or of another size than --size.
    pub(super) fn recorded_patterns(&self) -> Result<Vec<Pattern>, Failure> {
        let Size(size_px) = self.size;
        let Some(path) = &self.patterns else { return Ok(patterns(size_px, self.step)) };
        let list = show::read_list(path)?;
        if list.projector_size_px != size_px {
            let [width, height] = list.projector_size_px;
            let (path, [asked_width, asked_height]) = (path.display(), size_px);
            return Err(Failure::Unreadable(anyhow!(
                "{path}: patterns of {width}x{height} pixels, but --size says {asked_width}x{asked_height}"
            )));
        }
        Ok(list.patterns.into_iter().map(|(_, pattern)| pattern).collect())
    }

    /// Finds out before the scan what would keep its files from being written.
    ///
    /// # Errors
    /// [`Failure::Unreadable`].
    pub(super) fn check_files(&self) -> Result<(), Failure> {
        let has_place = |path: &Path| {
            let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
            if parent.is_dir() {
                Ok(())
            } else {
                Err(Failure::Unreadable(anyhow!("{}: the folder {} does not exist", path.display(), parent.display())))
            }
        };
        has_place(&self.output)?;
        if self.output.exists() && !self.output.is_dir() {
            return Err(Failure::Unreadable(anyhow!("{}: not a folder", self.output.display())));
        }
        if let Some(path) = &self.preview {
            PictureFormat::of(path).map_err(Failure::unreadable)?;
            has_place(path)?;
        }
        Ok(())
    }
}
