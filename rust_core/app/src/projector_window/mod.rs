//! `projector_window`: an image topic full screen on a chosen monitor, pixel for pixel.

mod for_display;
mod viewer;

use std::process::ExitCode;
use std::sync::{mpsc, Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::Context;
use clap::{Command, CommandFactory, Parser, ValueEnum};
use rcs_displays::{time_from_stamp, unpack_image};
use rcs_light::{BlackoutFile, Measured, Now, Pulse};
use rcs_messages::{header, AnyMessage, Image, MessageKind};
use rcs_process::lock;
use rcs_ros::{NodeError, NodeEvent, RosNode};
use rcs_transforms::Time;
use rcs_window::{
    self as window, ImageSink, MonitorChoice, MonitorInfo, ReceivedImage, ScreenImage, UserEvent, WindowRole,
};

use rcs_node_support::lifecycle::{self, EndRequest};
use rcs_node_support::monitor_arguments::MonitorArguments;
use rcs_node_support::node_options::{with_parameters, within, COMMAND_LINE_ONLY};
use rcs_node_support::ros_names::{subscribes, RosName};
use rcs_node_support::window_watch::WindowWatch;
use viewer::Viewer;

/// Topics of the node.
pub const ROS_NAMES: &[RosName] = &[
    subscribes("/proj_view/image", "sensor_msgs/Image", "the image: encodings of image_view, and 8UC1, 8UC3, 8UC4"),
    subscribes(
        "/proj_view/image/compressed",
        "sensor_msgs/CompressedImage",
        "in its place, with `--image-transport compressed`: JPEG or PNG",
    ),
];

/// The node's name where the command line gives none.
const NAME: &str = "projector_window";
/// How often what is shown is decided anew.
const TURN: Duration = Duration::from_millis(100);
/// How often a monitor that is not there is looked for.
const MONITOR_PERIOD: Duration = Duration::from_secs(1);
const DEFAULT_TOPIC: &str = "/proj_view/image";

/// Shows an image topic full screen on a monitor or projector, pixel for pixel, without scaling.
///
/// Image pixel (u, v) is screen pixel (u, v). A warning is printed if image and monitor differ in size; the image
/// is then at the top left, on black. Encodings: what image_view shows (colours, mono, Bayer, YUV, depth); compressed:
/// JPEG, PNG. Keys: Escape or q ends; b is black until Shift+L, space or p pauses and resumes, t shows the next test
/// image.
#[derive(Parser)]
#[command(
    name = "projector_window",
    display_name = "rviz_camera_stream",
    version,
    before_help = "\
Examples:
  projector_window --monitor HDMI-1 image:=/proj_view/image",
    after_help = "\
Topic subscribed to: /proj_view/image (sensor_msgs/Image); image:=/topic remaps it, as for image_view
Parameters: each option is one, too: --stale-timeout is ~stale_timeout
Exit codes: 0 ended by Escape, q, SIGINT, SIGTERM or rosnode kill; 1 the window or the node failed; 2 invalid \
arguments"
)]
struct WindowArguments {
    /// The image topic [default: the remapping of image:=, else /proj_view/image]
    #[arg(long)]
    topic: Option<String>,
    /// How images are sent: raw, or compressed on TOPIC/compressed (sensor_msgs/CompressedImage)
    #[arg(long, value_enum, default_value = "raw")]
    image_transport: Transport,
    /// Black out while the newest image is older than this, by its stamp and here [s; none or 0: never]
    #[arg(long, value_name = "SECS", default_value = "none", value_parser = stale_timeout)]
    stale_timeout: Duration,
    /// Instead of showing a topic, keep the window of another program, which has this title, over the monitor
    #[arg(long, value_name = "TITLE", help_heading = COMMAND_LINE_ONLY)]
    #[arg(conflicts_with_all = ["topic", "image_transport", "stale_timeout", "screenshot"])]
    place: Option<String>,
    #[command(flatten)]
    monitor: MonitorArguments,
}

/// How images are sent.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Transport {
    Raw,
    Compressed,
}

impl WindowArguments {
    fn topic(&self) -> String {
        let topic = self.topic.clone().or_else(|| rcs_ros::remapping_of("image"));
        topic.unwrap_or_else(|| DEFAULT_TOPIC.to_owned())
    }
}

/// Age from which images are stale; zero: never.
fn stale_timeout(text: &str) -> Result<Duration, String> {
    let secs = if text == "none" { 0.0 } else { within(0.0, 86_400.0)(text)? };
    Ok(Duration::from_secs_f64(secs))
}

/// The command line.
pub fn command() -> Command {
    WindowArguments::command()
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    rcs_window::run_black_window().unwrap_or_else(|| lifecycle::run_main(run))
}

fn run(arguments: WindowArguments) -> anyhow::Result<()> {
    if arguments.monitor.tell_monitors()? {
        return Ok(());
    }
    let end = EndRequest::watch_signals().context("cannot handle signals")?;
    if let Some(title) = &arguments.place {
        let _watch = watch(&end)?;
        return Ok(window::keep_over(title, &arguments.monitor.monitor, || end.is_requested())?);
    }
    // A window that waits for the master is black, on the monitor of the command line.
    let node = match lifecycle::connect_now(NAME, &end) {
        Err(NodeError::NoMaster { .. }) => None,
        connected => connected?,
    };
    let arguments = node.as_deref().map_or(Ok(arguments), with_parameters)?;
    show_topic(arguments, node, &end)
}

/// Ends the process if the window does not end in time.
fn watch(end: &EndRequest) -> anyhow::Result<WindowWatch> {
    let end = end.clone();
    WindowWatch::start(0, move || end.is_requested()).context("cannot watch the window")
}

/// Waits for a monitor that is not connected yet. Returns `false` if the shutdown is requested before it is.
fn wait_for_monitor(choice: &MonitorChoice, end: &EndRequest) -> anyhow::Result<bool> {
    let mut is_told = false;
    while !end.is_requested() {
        match choice.resolve(&window::list_monitors()?) {
            Ok(_) => return Ok(true),
            Err(error) if !is_told => log::warn!("{error}; waiting for it"),
            Err(_) => {}
        }
        is_told = true;
        thread::sleep(MONITOR_PERIOD);
    }
    Ok(false)
}

/// Shows a topic until the window is closed or the shutdown is requested.
fn show_topic(arguments: WindowArguments, node: Option<Arc<RosNode>>, end: &EndRequest) -> anyhow::Result<()> {
    let watch = watch(end)?;
    if !wait_for_monitor(&arguments.monitor.monitor, end)? {
        return Ok(());
    }
    let mut options = arguments.monitor.window_options(&arguments.topic());
    options.role = WindowRole::Guarded;
    options.light_limit = Some(arguments.stale_timeout).filter(|timeout| !timeout.is_zero());
    let sink = ImageSink::new().context("cannot open a window")?;
    // The node runs on a thread of its own and closes the window when it ends.
    let (outcome, node_outcome) = mpsc::sync_channel(1);
    let node_end = end.clone();
    let viewer = Arc::new(Mutex::new(Viewer::new(MonitorInfo::default(), arguments.stale_timeout)));
    let (following_viewer, following_sink) = (Arc::clone(&viewer), sink.clone());
    let mut following = Some(move || {
        let result = follow_topic(node, arguments, &node_end, &following_viewer, &following_sink);
        following_sink.close();
        // Nobody receives it if the window was closed first.
        let _ = outcome.send(result);
    });
    let shown = window::run_with(&options, &sink, |event, sink| match event {
        UserEvent::Opened(monitor) => {
            lock(&viewer).set_monitor(monitor.clone());
            let started =
                following.take().map(|following| thread::Builder::new().name("node".to_owned()).spawn(following));
            if let Some(Err(error)) = started {
                log::error!("cannot start the node's thread: {error}");
                sink.close();
            }
        }
        UserEvent::MonitorChanged(monitor) => lock(&viewer).set_monitor(monitor.clone()),
        // A key that is held down would toggle something again and again.
        UserEvent::Key { is_repeat: true, .. } => {}
        UserEvent::Key { key, .. } => {
            let mut viewer = lock(&viewer);
            if viewer.press(key) {
                viewer.present_now(sink);
            }
        }
    });
    drop(watch);
    // The node unregisters however the window ended.
    end.request();
    let node_result = node_outcome.recv_timeout(Duration::from_secs(4)).unwrap_or(Ok(()));
    shown?;
    node_result
}

/// Shows the topic's images until the shutdown is requested.
fn follow_topic(
    node: Option<Arc<RosNode>>,
    arguments: WindowArguments,
    end: &EndRequest,
    viewer: &Mutex<Viewer>,
    sink: &ImageSink,
) -> anyhow::Result<()> {
    let (node, arguments) = match node {
        Some(node) => (node, arguments),
        None => {
            let Some(node) = lifecycle::connect(NAME, end)? else { return Ok(()) };
            let arguments: WindowArguments = with_parameters(&node)?;
            lock(viewer).set_timeout(arguments.stale_timeout);
            (node, arguments)
        }
    };
    let topic = arguments.topic();
    let (topic, kind) = match arguments.image_transport {
        Transport::Raw => (topic, MessageKind::Image),
        Transport::Compressed => (format!("{topic}/compressed"), MessageKind::CompressedImage),
    };
    // A queue of one: the window shows the latest image.
    let subscription = node.subscribe(&topic, kind, 1)?;
    lock(viewer).set_file(BlackoutFile::of_node(rcs_ros::ros_folder().as_deref(), node.name()));
    let (mut last_error, pulse) = (None, Pulse::start(Instant::now()));
    while !end.is_requested() {
        let events = node.events().wait(TURN);
        pulse.beat(Instant::now());
        for event in events {
            let NodeEvent::Message { message, received, .. } = event else { continue };
            match image(subscription.topic(), &message) {
                Ok(image) => {
                    let stamp = header(&message).map(|header| time_from_stamp(header.stamp)).unwrap_or(Time::ZERO);
                    let measured = Measured { stamp, received };
                    image.into_iter().for_each(|image| lock(viewer).take(image, measured));
                    last_error = None;
                }
                // An error that repeats is logged once.
                Err(error) if last_error.as_ref() == Some(&error) => {}
                Err(error) => {
                    log::error!("topic {}: {error}", subscription.topic());
                    last_error = Some(error);
                }
            }
        }
        let steady = Instant::now();
        let now = Now { ros: time_from_stamp(node.now()), steady, resumed: pulse.resumed(steady) };
        lock(viewer).present(sink, now);
    }
    drop(subscription);
    // Here, because the window may wait for a display server that hangs.
    node.shutdown();
    Ok(())
}

/// The image of a message; `None` for other types.
fn image(topic: &str, message: &AnyMessage) -> Result<Option<ScreenImage>, String> {
    match message {
        AnyMessage::Image(image) => read(image).map(Some),
        AnyMessage::CompressedImage(packed) => read(&unpack_image(topic, packed)?).map(Some),
        _ => Ok(None),
    }
}

fn read(image: &Image) -> Result<ScreenImage, String> {
    let image = for_display::for_display(image)?;
    let received = ReceivedImage {
        width_px: image.width,
        height_px: image.height,
        step_bytes: image.step,
        encoding: &image.encoding,
        is_bigendian: image.is_bigendian != 0,
        data: image.data(),
    };
    ScreenImage::from_received(&received).map_err(|error| error.to_string())
}
