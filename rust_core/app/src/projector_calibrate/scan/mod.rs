//! `projector_calibrate scan`: shows patterns with the projector, takes the camera's pictures of them, and writes what
//! was seen as a capture folder.
//!
//! [`session`] is the scan itself. It knows a [`devices::Screen`] and a [`devices::Camera`] and no more, so that tests
//! run it on simulated ones; [`screens`] and [`ros_camera`] are the real ones.

mod compare;
mod depth_average;
mod devices;
mod failure;
mod light;
mod orientation;
mod preview;
mod received;
mod ros_camera;
mod screens;
mod session;
#[cfg(test)]
mod tests;
mod verification;
mod verify_live;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use anyhow::{anyhow, Context};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use rcs_files::capture::CAPTURE_FILE;
use rcs_files::picture_file::{self, PictureFormat};
use rcs_ros::RosNode;
use rcs_window::{self as window, MonitorChoice, UserEvent, WindowOptions};

use super::arguments::{size, Size};
use super::Failure;
use crate::small_node::{self, EndRequest};
use devices::Screen;
use ros_camera::{CameraTopics, DepthTopic, RosCamera};
use screens::{TopicScreen, WindowScreen};
use session::{ScanEvent, ScanOptions, Scanned, Session};
pub(super) use verification::Verification;
pub(super) use verify_live::{verify_live, LiveOptions};

/// The widest code, so that there are no more stripes than can be decoded.
const MOST_STEP: i64 = 8;

/// Shows patterns with the projector and writes what the camera sees of them
///
/// Nothing may move meanwhile, half a minute or so. The camera's exposure must be fixed. Measured is the delay from
/// showing to seeing; checked are exposure, rest, and whether the picture is mirrored; a scan that would mislead is
/// refused. Ctrl-C, or Escape in the window, ends it: what was seen up to then is written if it is enough.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Topics subscribed to: --image (sensor_msgs/Image: mono8, rgb8, bgr8, rgba8, bgra8), --camera-info, and --depth (16UC1 in
millimetres, 32FC1 in metres) or --cloud; the defaults are those of Fetch's head camera
Exit codes: 0 written; 1 refused, nothing written; 2 invalid arguments, or a topic that is silent or cannot be used

Example: projector_calibrate scan --size 1280x800 --monitor HDMI-1 -o scan1")]
pub(super) struct ScanArguments {
    /// Width and height of the projector's picture, pixels: its native resolution
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Size,
    /// The folder to write to; made if it does not exist, a capture in it is replaced
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// The projector's monitor, by name or number [default: the last that is not primary, else the only one]
    #[arg(long, value_name = "NAME|INDEX", default_value = "", hide_default_value = true)]
    monitor: MonitorChoice,
    /// Publish the patterns on this topic, for a projector_window elsewhere, and open no window
    #[arg(long, value_name = "TOPIC", conflicts_with = "monitor")]
    show_on: Option<String>,
    /// The camera's pictures
    #[arg(long, value_name = "TOPIC", default_value = "/head_camera/rgb/image_raw")]
    image: String,
    /// Its CameraInfo
    #[arg(long, value_name = "TOPIC", default_value = "/head_camera/rgb/camera_info")]
    camera_info: String,
    /// Depth images that are registered to the pictures
    #[arg(long, value_name = "TOPIC", default_value = "/head_camera/depth_registered/image_raw")]
    depth: String,
    /// Take depth from an organised cloud with a point for each pixel instead
    #[arg(long, value_name = "TOPIC", conflicts_with = "depth")]
    cloud: Option<String>,
    /// Take no depth: what is written can be decoded, not solved
    #[arg(long, conflicts_with_all = ["depth", "cloud"])]
    no_depth: bool,
    /// Frames that each picture is the mean of
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=100))]
    frames: u8,
    /// Projector pixels that share a code, 1 to 8: from 2 on, wider stripes are shown in more pictures
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=MOST_STEP))]
    step: u32,
    /// Write what was decoded as a picture in false colours: red for columns, green for rows
    #[arg(long, value_name = "FILE.png")]
    preview: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// [`Failure`]: the scan was refused, or a topic, a window or a file cannot be used.
pub(super) fn run(arguments: &ScanArguments) -> Result<(), Failure> {
    check_files(arguments)?;
    let end = EndRequest::watch_signals().context("cannot handle signals").map_err(Failure::Unreadable)?;
    if let Some(topic) = &arguments.show_on {
        let Size(size_px) = arguments.size;
        let screen = |node: &RosNode| Ok(Box::new(TopicScreen::new(node, topic, size_px)?) as Box<dyn Screen>);
        return scan(arguments, &end, &AtomicBool::new(false), screen);
    }
    let (Size(size_px), scanned) = (arguments.size, arguments.clone());
    let options = WindowOptions { source: "the scan".to_owned(), monitor: arguments.monitor.clone(), screenshot: None };
    in_window(options, size_px, &end, move |screen, end, is_void| {
        scan(&scanned, end, is_void, |_| Ok(Box::new(screen)))
    })
}

/// Opens the window, which needs the main thread, and scans on another one: `work`, which is told of a monitor of
/// another size by the flag. The window closes when that is done; closing it before asks `work` to end.
fn in_window<T: Send + 'static>(
    options: WindowOptions,
    size_px: [u32; 2],
    end: &EndRequest,
    work: impl FnOnce(WindowScreen, &EndRequest, &AtomicBool) -> Result<T, Failure> + Send + 'static,
) -> Result<T, Failure> {
    let [width, height] = size_px;
    let is_void = Arc::new(AtomicBool::new(false));
    let mut refusal = None;
    let mut work = Some(work);
    let mut scanning: Option<JoinHandle<Result<T, Failure>>> = None;
    let shown = window::run_interactive(options, |event, sink| {
        let (UserEvent::Opened(monitor) | UserEvent::MonitorChanged(monitor)) = event else { return };
        if monitor.size_px != (width, height) {
            is_void.store(true, Ordering::Release);
            end.request();
            refusal = Some(anyhow!(
                "monitor {monitor} does not have the projector's {width}x{height} pixels: give its native resolution, \
                 and set the monitor to it without scaling"
            ));
            sink.close();
        } else if let Some(work) = work.take() {
            let screen = WindowScreen { sink: sink.clone(), monitor: monitor.name.clone(), size_px };
            let (end, is_void, closing) = (end.clone(), Arc::clone(&is_void), sink.clone());
            let work = move || {
                let result = work(screen, &end, &is_void);
                closing.close();
                result
            };
            match thread::Builder::new().name("scan".to_owned()).spawn(work) {
                Ok(thread) => scanning = Some(thread),
                Err(error) => {
                    refusal = Some(anyhow!("cannot start the scan's thread: {error}"));
                    sink.close();
                }
            }
        }
    });
    // The window may have been closed first.
    end.request();
    let scanned = scanning.map(|thread| thread.join());
    if let Some(refusal) = refusal {
        return Err(Failure::Refused(refusal));
    }
    shown.map_err(Failure::refused)?;
    let ended_early = || Err(Failure::Refused(anyhow!("ended before it began")));
    scanned.map_or_else(ended_early, |scanned| {
        scanned.unwrap_or_else(|_| Err(Failure::Refused(anyhow!("the scan's thread has ended early"))))
    })
}

/// Scans and writes. Nothing is written once `is_void` is set.
fn scan(
    arguments: &ScanArguments,
    end: &EndRequest,
    is_void: &AtomicBool,
    make_screen: impl FnOnce(&RosNode) -> anyhow::Result<Box<dyn Screen>>,
) -> Result<(), Failure> {
    let interrupted = || Failure::Refused(anyhow!("interrupted before the scan began"));
    let node = small_node::connect("projector_calibrate", end).map_err(Failure::unreadable)?;
    let node = node.ok_or_else(interrupted)?;
    let result = make_screen(&node).map_err(Failure::Unreadable).and_then(|mut screen| {
        let topics = arguments.topics();
        let mut camera = RosCamera::connect(&node, end, &topics).map_err(|error| {
            if end.is_requested() {
                interrupted()
            } else {
                Failure::unreadable(error)
            }
        })?;
        let Size(projector_px) = arguments.size;
        let options = ScanOptions {
            projector_px,
            step: arguments.step,
            frames: usize::from(arguments.frames),
            is_cancelled: &|| end.is_requested(),
        };
        let progress = Progress::new();
        let scanned = Session::new(&mut *screen, &mut camera, &options, &mut |event| progress.show(&event)).run();
        progress.bar.finish_and_clear();
        let scanned = scanned?;
        if is_void.load(Ordering::Acquire) {
            return Err(interrupted());
        }
        write(arguments, &scanned)
    });
    node.shutdown();
    result
}

/// Writes the capture and the preview.
fn write(arguments: &ScanArguments, scanned: &Scanned) -> Result<(), Failure> {
    let Scanned { capture, decoded, is_whole } = scanned;
    capture.write(&arguments.output).map_err(Failure::refused)?;
    if let Some(path) = &arguments.preview {
        let picture = preview::false_colours(decoded, capture.projector_size_px);
        picture_file::write(path, &picture).map_err(Failure::refused)?;
    }
    let (count, lit) = (decoded.count(), decoded.lit.max(1));
    eprintln!(
        "written{}: {} pictures, {count} pixels decoded ({:.0} % of the lit ones), {}",
        if *is_whole { "" } else { " though interrupted" },
        capture.pictures.len(),
        100.0 * count as f64 / lit as f64,
        arguments.output.join(CAPTURE_FILE).display()
    );
    Ok(())
}

/// Finds out before the scan what would keep its files from being written.
fn check_files(arguments: &ScanArguments) -> Result<(), Failure> {
    let has_place = |path: &Path| {
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if parent.is_dir() {
            Ok(())
        } else {
            Err(Failure::Unreadable(anyhow!("{}: the folder {} does not exist", path.display(), parent.display())))
        }
    };
    has_place(&arguments.output)?;
    if arguments.output.exists() && !arguments.output.is_dir() {
        return Err(Failure::Unreadable(anyhow!("{}: not a folder", arguments.output.display())));
    }
    if let Some(path) = &arguments.preview {
        PictureFormat::of(path).map_err(Failure::unreadable)?;
        has_place(path)?;
    }
    Ok(())
}

impl ScanArguments {
    fn topics(&self) -> CameraTopics {
        let depth = match &self.cloud {
            _ if self.no_depth => DepthTopic::None,
            Some(cloud) => DepthTopic::Cloud(cloud.clone()),
            None => DepthTopic::Image(self.depth.clone()),
        };
        CameraTopics { image: self.image.clone(), camera_info: self.camera_info.clone(), depth }
    }
}

/// The bar, the share that can be read, and what is logged.
struct Progress {
    bar: ProgressBar,
}

impl Progress {
    fn new() -> Self {
        let bar = ProgressBar::new_spinner().with_message("looking for the projector's light");
        Self { bar }
    }

    fn show(&self, event: &ScanEvent<'_>) {
        match event {
            ScanEvent::Delay(delay, pictures) => {
                let (seen, settled) = (delay.seen.as_millis(), delay.settled.as_millis());
                self.bar.suspend(|| log::info!("light is seen after {seen} ms and has settled after {settled} ms"));
                let style = ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} left, {msg}");
                self.bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
                self.bar.set_length(*pictures as u64);
                self.bar.set_position(0);
                self.bar.set_message("");
            }
            ScanEvent::Captured(readable) => {
                self.bar.inc(1);
                self.bar.set_message(format!("{:.0} % of the lit pixels read the last stripes", 100.0 * readable));
            }
            ScanEvent::Warning(warning) => self.bar.suspend(|| log::warn!("{warning}")),
        }
    }
}
