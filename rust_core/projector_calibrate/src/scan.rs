//! `projector_calibrate scan`: the scan engine of [`rcs_scan`] on ROS topics and a window, or on a bag.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::anyhow;
use clap::Args;
use rcs_calibration::board::Chessboard;
use rcs_calibration::patterns::Pattern;
use rcs_files::capture::CAPTURE_FILE;
use rcs_files::image_file::{self, ImageFormat};
use rcs_files::image_folder::extensions;
use rcs_scan::recorded::{self, BagFootage, RecordedOptions};
use rcs_scan::{
    patterns, preview, CameraTopics, DepthTopic, ScanCamera, ScanEvent, ScanOptions, ScanResult, ScanSession,
};

use super::arguments::{check_output, chessboard, seconds, size_px};
use super::board::BoardScan;
use super::live::{DeviceArguments, ImageTopic, LiveSession, LiveSetup, Progress};
use super::pictures::Pictures;
use super::placing::read_projector;
use super::{show, Failure};

/// The topic of the preview, private to the node.
const PREVIEW_TOPIC: &str = "~preview";
/// The folder of an incomplete capture, in the folder of the complete one.
const INCOMPLETE_FOLDER: &str = "incomplete";
/// The largest step: more patterns cannot be decoded.
const MAX_STEP: i64 = 8;

/// Shows patterns with the projector and writes what the camera sees of them
///
/// Nothing may move meanwhile, half a minute or so. The camera's exposure must be fixed. Measures the delay from
/// showing to seeing; refuses a scan with a wrong exposure, motion or a mirrored image. Ctrl-C, or Escape in the
/// window, ends it: the images so far are written into DIR/incomplete if they are enough, and a capture in DIR stays.
///
/// With --bag, a scan that was recorded: the camera's topics, while the patterns were shown by
/// `projector_calibrate show --patterns DIR --seconds 1 --pause 0.5`. No ROS master is needed.
#[derive(Debug, Clone, Args)]
#[command(before_help = "\
Examples:
  projector_calibrate scan --size 1280x800 --monitor HDMI-1 -o scan1
  projector_calibrate scan --bag scan.bag --size 1280x800 -o scan1
  projector_calibrate scan --board chessboard:10x7:25mm --size 1280x800 \\
      -o boards --image /webcam/image_raw --camera-info /webcam/camera_info
  projector_calibrate scan --board chessboard:10x7:25mm --size 1280x800 \\
      -o boards --pictures photos")]
#[command(after_help = "\
Topics subscribed to: --image (sensor_msgs/Image: mono8, rgb8, bgr8, rgba8, bgra8; or CompressedImage), \
--camera-info, and --depth (16UC1 in millimetres, 32FC1 in metres; or CompressedImage) or --cloud; the defaults are \
those of Fetch's head camera. /tf, /tf_static and the parameter robot_description, which the capture keeps for solve
Topic published: ~preview (sensor_msgs/Image, latched), what is decoded so far in the colours of --preview
Exit codes: 0 written; 1 refused, nothing written; 2 invalid arguments, no master, or a topic or a bag that is silent \
or cannot be used; 130 interrupted")]
pub(super) struct ScanArguments {
    /// Width and height of the projector's image, pixels: its native resolution
    #[arg(long, value_name = "WxH", value_parser = size_px)]
    size: [u32; 2],
    /// The folder to write to; made if it does not exist, a capture in it is replaced by a complete one
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// The devices.
    #[command(flatten)]
    devices: DeviceArguments,
    /// Publish the patterns on this topic, for a projector_window elsewhere, and open no window. With --bag: the bag's
    /// topic on which they were shown
    #[arg(long, value_name = "TOPIC", conflicts_with = "monitor")]
    show_on: Option<String>,
    /// Scan what this bag has recorded, or several, such as the parts of a split recording: .bag or .mcap of ROS 1
    #[arg(long, value_name = "FILE.bag", num_args = 1.., conflicts_with = "monitor")]
    bag: Vec<PathBuf>,
    /// Scan a printed chessboard in several poses, without depth; the log says how to hold it
    #[arg(long, value_name = "chessboard:CxR:SIDE", value_parser = chessboard, conflicts_with = "bag")]
    board: Option<Chessboard>,
    #[command(flatten)]
    pictures: PictureArguments,
    /// With --bag or --pictures: the folder of the patterns that were shown, or its patterns.yaml [default: those that
    /// the command patterns writes for --size and --step]
    #[arg(long, value_name = "DIR|FILE")]
    patterns: Option<PathBuf>,
    /// With --bag: leave out what was recorded before, seconds since its beginning
    #[arg(long, value_name = "SECONDS", requires = "bag", value_parser = seconds, default_value = "0")]
    start: Duration,
    /// Take no depth: what is written can be decoded, not solved
    #[arg(long, conflicts_with_all = ["depth", "cloud"])]
    no_depth: bool,
    /// Projector pixels that share a code, 1 to 8: from 2 on, wider stripes are shown in more images
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=MAX_STEP))]
    step: u32,
    /// Write what was decoded as an image in false colours: red for columns, green for rows
    #[arg(long, value_name = "FILE.png", conflicts_with = "board")]
    preview: Option<PathBuf>,
}

/// Images in files in place of a camera.
#[derive(Debug, Clone, Args)]
struct PictureArguments {
    /// Take the camera's images in DIR, one of each pattern; with --board, a folder of them for each pose
    #[arg(long = "pictures", value_name = "DIR", conflicts_with_all = ["bag", "monitor", "show_on"])]
    images: Option<PathBuf>,
    /// With --pictures: the camera's file, if it is calibrated
    #[arg(long, value_name = "FILE", requires = "images")]
    camera: Option<PathBuf>,
    /// With --pictures and --camera: depth that is registered to them, a PNG of 16 bits in millimetres
    #[arg(long, value_name = "FILE.png", requires = "camera", conflicts_with = "board")]
    depth_picture: Option<PathBuf>,
}

/// Runs the command.
pub(super) fn run(arguments: &ScanArguments) -> Result<(), Failure> {
    arguments.check_files()?;
    if !arguments.bag.is_empty() {
        return scan_bags(arguments);
    }
    let board = arguments.board_scan();
    if let Some(folder) = &arguments.pictures.images {
        let pictures = arguments.pictures(folder)?;
        return match board {
            Some(scan) => scan.of_folders(&pictures),
            None => scan_pictures(arguments, &pictures),
        };
    }
    let setup = LiveSetup {
        name: "the scan",
        monitor: arguments.devices.monitor.clone(),
        topics: arguments.topics(),
        show_on: arguments.show_on.clone(),
        projector_px: arguments.size,
        needs_lens: board.is_none(),
        projector_frame: String::new(),
    };
    let arguments = arguments.clone();
    if let Some(scan) = board {
        let frames = usize::from(arguments.devices.camera.frames);
        return setup.run(move |session| scan.live(session, arguments.step, frames));
    }
    setup.run(move |session| scan_live(session, &arguments))
}

/// Scans live and writes the capture.
fn scan_live(session: &mut LiveSession<'_>, arguments: &ScanArguments) -> Result<(), Failure> {
    let (end, projector_px) = (session.end, arguments.size);
    let options = ScanOptions {
        projector_px,
        step: arguments.step,
        frames: usize::from(arguments.devices.camera.frames),
        is_cancelled: &|| end.is_requested(),
    };
    let topic = ImageTopic::new(session.node, PREVIEW_TOPIC, session.camera.frame_id()).map_err(Failure::unreadable)?;
    session.camera.follow_robot().map_err(Failure::unreadable)?;
    let camera_px = session.camera.lens().size_px;
    let mut progress = Progress::new("looking for the projector's light", Some(topic), camera_px, projector_px);
    let mut observe = |event: ScanEvent<'_>| progress.show(&event);
    let scanned = ScanSession::new(&mut *session.screen, &mut session.camera, &options, &mut observe).scan();
    let mut scanned = progress.finish_scan(scanned)?;
    scanned.capture.robot = session.camera.robot();
    progress.publish(preview::of_decoded(&scanned.decoded, projector_px));
    session.check_valid()?;
    write(arguments, scanned)
}

/// Scans what bags have recorded.
fn scan_bags(arguments: &ScanArguments) -> Result<(), Failure> {
    let options = RecordedOptions {
        projector_px: arguments.size,
        patterns: arguments.recorded_patterns()?,
        frames: arguments.devices.camera.frames.into(),
    };
    let shown = arguments.show_on.as_deref();
    let footage = BagFootage::open(&arguments.bag, &arguments.topics(), shown, arguments.start)?;
    let mut progress = Progress::new("reading the bag", None, footage.lens.size_px, arguments.size);
    let scanned = recorded::scan(&footage, &options, &mut |event| progress.show(&event));
    write(arguments, progress.finish_scan(scanned)?)
}

/// Scans the images in a folder.
fn scan_pictures(arguments: &ScanArguments, pictures: &Pictures<'_>) -> Result<(), Failure> {
    let folder = pictures.folder.display();
    let set = pictures.read(pictures.folder)?;
    if set.greys.is_empty() {
        let text = anyhow!("{folder}: no pictures ({}): give the folder with one of each pattern", extensions());
        return Err(Failure::Unreadable(text));
    }
    match pictures.scan(pictures.folder, set) {
        Ok(scanned) => write(arguments, scanned),
        Err(failure) if failure.is_refusal() => Err(Failure::Refused(anyhow!("{folder}: {failure}"))),
        Err(failure) => Err(Failure::Unreadable(anyhow!("{folder}: {failure}"))),
    }
}

/// Writes the capture and the preview. An incomplete capture replaces no complete one, and is an error.
fn write(arguments: &ScanArguments, scanned: ScanResult) -> Result<(), Failure> {
    let ScanResult { capture, decoded, ended } = scanned;
    if capture.robot.frames.is_empty() && arguments.pictures.images.is_none() {
        log::warn!(
            "no chain of frames in the capture: '{}' is not in TF; solve cannot tell whether joints move the camera",
            capture.camera_frame_id
        );
    }
    let folder = match &ended {
        None => arguments.output.clone(),
        Some(_) => arguments.output.join(INCOMPLETE_FOLDER),
    };
    // The folder of the complete capture.
    fs::create_dir_all(&arguments.output).map_err(Failure::refused)?;
    capture.write(&folder).map_err(Failure::refused)?;
    if let Some(path) = arguments.preview.as_ref().filter(|_| ended.is_none()) {
        let image = preview::of_decoded(&decoded, capture.projector_size_px);
        image_file::write(path, &image).map_err(Failure::refused)?;
    }
    eprintln!(
        "written{}: {} pictures, {} pixels decoded ({:.0} % of the lit ones), {}",
        if ended.is_none() { "" } else { ", incomplete" },
        capture.images.len(),
        decoded.count(),
        100.0 * decoded.share(),
        folder.join(CAPTURE_FILE).display()
    );
    ended.map_or(Ok(()), |failure| Err(failure.into()))
}

impl ScanArguments {
    /// The camera's topics.
    fn topics(&self) -> CameraTopics {
        let topics = self.devices.camera.topics();
        if self.no_depth || self.board.is_some() {
            CameraTopics { depth: DepthTopic::None, ..topics }
        } else {
            topics
        }
    }

    /// The scan of a board, if it is one.
    fn board_scan(&self) -> Option<BoardScan> {
        let (projector_px, output) = (self.size, self.output.clone());
        self.board.map(|board| BoardScan { board, projector_px, output })
    }

    /// Images in files.
    fn pictures<'a>(&'a self, folder: &'a Path) -> Result<Pictures<'a>, Failure> {
        let camera = self.pictures.camera.as_deref().map(read_projector).transpose()?;
        let (projector_px, patterns) = (self.size, self.recorded_patterns()?);
        Ok(Pictures { folder, projector_px, patterns, camera, depth: self.pictures.depth_picture.as_deref() })
    }

    /// The patterns of a recording, in their order.
    ///
    /// # Errors
    /// [`Failure::Unreadable`]: a list that cannot be read, or of another size than --size.
    fn recorded_patterns(&self) -> Result<Vec<Pattern>, Failure> {
        let Some(path) = &self.patterns else { return Ok(patterns(self.size, self.step)) };
        let list = show::read_list(path)?;
        if list.projector_size_px != self.size {
            let [width, height] = list.projector_size_px;
            let (path, [asked_width, asked_height]) = (path.display(), self.size);
            return Err(Failure::Unreadable(anyhow!(
                "{path}: patterns of {width}x{height} pixels, but --size says {asked_width}x{asked_height}"
            )));
        }
        Ok(list.patterns.into_iter().map(|(_, pattern)| pattern).collect())
    }

    /// Checks before the scan that its files can be written.
    fn check_files(&self) -> Result<(), Failure> {
        if self.patterns.is_some() && self.bag.is_empty() && self.pictures.images.is_none() {
            return Err(Failure::Unreadable(anyhow!("--patterns needs --bag or --pictures")));
        }
        check_output(&self.output)?;
        if self.output.exists() && !self.output.is_dir() {
            return Err(Failure::Unreadable(anyhow!("{}: not a folder", self.output.display())));
        }
        if let Some(path) = &self.preview {
            ImageFormat::of(path).map_err(Failure::unreadable)?;
            check_output(path)?;
        }
        Ok(())
    }
}
