//! The devices of a live scan or verification: the projector, in a window on its monitor or by a topic, and the robot's
//! camera.
//!
//! A window needs the main thread, so the work runs on another one. If the monitor has another size than the projector,
//! the window closes and the session is void: its work ends without writing anything.

mod known_topics;
mod progress;
mod ros_camera;
mod screens;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use std::thread::JoinHandle;

use anyhow::{anyhow, Context};
use clap::Args;
use rcs_node_support::lifecycle::{self, EndRequest};
use rcs_node_support::window_watch::WindowWatch;
use rcs_ros::{NodeError, RosNode};
use rcs_scan::{CameraTopics, DepthTopic, ProjectorScreen};
use rcs_window::{self as window, ImageSink, MonitorChoice, UserEvent, WindowOptions};

use super::window_support::{check_monitor, join, spawn};
use super::Failure;
pub(super) use progress::Progress;
pub(super) use ros_camera::{PlacedProjector, RosCamera};
use screens::WindowScreen;
pub(super) use screens::{ImageTopic, TopicScreen};

/// The projector's monitor and the camera, as a user names them.
#[derive(Debug, Clone, Args)]
pub(super) struct DeviceArguments {
    /// The projector's monitor, by name or number [default: the last that is not primary, else the only one]
    #[arg(long, value_name = "NAME|INDEX", default_value = "", hide_default_value = true)]
    pub(super) monitor: MonitorChoice,
    /// The camera.
    #[command(flatten)]
    pub(super) camera: CameraArguments,
}

/// The camera, as a user names it.
#[derive(Debug, Clone, Args)]
pub(super) struct CameraArguments {
    /// The camera's images
    #[arg(long, value_name = "TOPIC", default_value = "/head_camera/rgb/image_raw")]
    image: String,
    /// Its CameraInfo
    #[arg(long, value_name = "TOPIC", default_value = "/head_camera/rgb/camera_info")]
    camera_info: String,
    /// Depth images that are registered to the images
    #[arg(long, value_name = "TOPIC", default_value = "/head_camera/depth_registered/image_raw")]
    depth: String,
    /// Take depth from an organised cloud with a point for each pixel instead
    #[arg(long, value_name = "TOPIC", conflicts_with = "depth")]
    cloud: Option<String>,
    /// Frames that each image is the mean of
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=100))]
    pub(super) frames: u8,
}

impl CameraArguments {
    /// The camera's topics, with depth.
    pub(super) fn topics(&self) -> CameraTopics {
        let depth = match &self.cloud {
            Some(cloud) => DepthTopic::Cloud(cloud.clone()),
            None => DepthTopic::Image(self.depth.clone()),
        };
        CameraTopics { image: self.image.clone(), camera_info: self.camera_info.clone(), depth }
    }
}

/// A live session that has not begun.
pub(super) struct LiveSetup {
    /// Its name in messages, such as `the scan`.
    pub(super) name: &'static str,
    pub(super) monitor: MonitorChoice,
    pub(super) topics: CameraTopics,
    /// A topic to show on instead of the monitor.
    pub(super) show_on: Option<String>,
    pub(super) projector_px: [u32; 2],
    /// `false` if the camera may be without calibration.
    pub(super) needs_lens: bool,
    /// The projector's optical frame, for images on a topic; may be empty.
    pub(super) projector_frame: String,
}

/// A live session with its devices.
pub(super) struct LiveSession<'a> {
    pub(super) node: &'a RosNode,
    pub(super) end: &'a EndRequest,
    pub(super) camera: RosCamera<'a>,
    pub(super) screen: Box<dyn ProjectorScreen>,
    name: &'static str,
    is_void: &'a AtomicBool,
}

impl LiveSession<'_> {
    /// Checks that the session is not void, before anything is written.
    ///
    /// # Errors
    /// [`Failure::Refused`]; the monitor's size is reported in its place.
    pub(super) fn check_valid(&self) -> Result<(), Failure> {
        if self.is_void.load(Ordering::Acquire) {
            return Err(interrupted(self.name));
        }
        Ok(())
    }
}

fn interrupted(name: &str) -> Failure {
    Failure::Interrupted(anyhow!("interrupted before {name} began"))
}

/// State that the window's thread and the work share.
#[derive(Clone)]
struct LiveState {
    end: EndRequest,
    node: Arc<RosNode>,
    is_void: Arc<AtomicBool>,
    is_working: Arc<AtomicBool>,
}

impl LiveState {
    /// Starts the work on a thread of its own, which closes the window in the end.
    fn spawn(
        &self,
        sink: ImageSink,
        work: impl FnOnce(&Self) -> Result<(), Failure> + Send + 'static,
    ) -> anyhow::Result<JoinHandle<Result<(), Failure>>> {
        let state = self.clone();
        state.is_working.store(true, Ordering::Release);
        spawn("scan", move || {
            let result = work(&state);
            state.is_working.store(false, Ordering::Release);
            sink.close();
            result
        })
    }
}

impl LiveSetup {
    /// Connects to the master, then the devices, and runs `work`.
    ///
    /// # Errors
    /// [`Failure`]: no master answers, a topic or a window cannot be used, or the error of `work`.
    pub(super) fn run(
        self,
        work: impl FnOnce(&mut LiveSession<'_>) -> Result<(), Failure> + Send + 'static,
    ) -> Result<(), Failure> {
        let end = EndRequest::watch_signals().context("cannot handle signals").map_err(Failure::Unreadable)?;
        let node = lifecycle::connect_now("projector_calibrate", &end).map_err(|error| match error {
            NodeError::NoMaster { .. } => {
                Failure::Unreadable(anyhow!("{error}: start roscore or the robot, or set ROS_MASTER_URI to its master"))
            }
            error => Failure::unreadable(error),
        })?;
        let node = node.ok_or_else(|| interrupted(self.name))?;
        let state = LiveState { end, node, is_void: Arc::default(), is_working: Arc::default() };
        if let Some(topic) = &self.show_on {
            let size_px = self.projector_px;
            let screen = |node: &RosNode| {
                let topic = ImageTopic::new(node, topic, self.projector_frame.clone())?;
                Ok(Box::new(TopicScreen { topic, size_px }) as Box<dyn ProjectorScreen>)
            };
            return self.connect_devices(&state, screen, work);
        }
        self.run_in_window(&state, work)
    }

    /// Opens the window and runs `work` on another thread. Closing the window asks `work` to end.
    fn run_in_window(
        self,
        state: &LiveState,
        work: impl FnOnce(&mut LiveSession<'_>) -> Result<(), Failure> + Send + 'static,
    ) -> Result<(), Failure> {
        let (name, size_px, monitor) = (self.name, self.projector_px, self.monitor.clone());
        let watched = state.clone();
        // While it works, it may be writing files, and ends by itself.
        let is_ending = move || watched.end.is_requested() && !watched.is_working.load(Ordering::Acquire);
        let watch = WindowWatch::start(1, is_ending).context("cannot watch the window").map_err(Failure::Refused)?;
        let mut start = Some((self, work));
        let mut working = None;
        let mut refusal = None;
        let options = WindowOptions { source: name.to_owned(), monitor, ..WindowOptions::default() };
        let shown = window::run_interactive(&options, |event, sink| {
            let (UserEvent::Opened(monitor) | UserEvent::MonitorChanged(monitor)) = event else { return };
            let started = check_monitor(monitor, size_px).and_then(|()| {
                let Some((setup, work)) = start.take() else { return Ok(()) };
                let screen = WindowScreen { sink: sink.clone(), monitor: monitor.name.clone(), size_px };
                let work = move |state: &LiveState| setup.connect_devices(state, |_| Ok(Box::new(screen)), work);
                working = Some(state.spawn(sink.clone(), work)?);
                Ok(())
            });
            if let Err(error) = started {
                state.is_void.store(true, Ordering::Release);
                state.end.request();
                refusal = Some(error);
                sink.close();
            }
        });
        drop(watch);
        // The window may have been closed first.
        state.end.request();
        let result = working.map(|thread| join(thread, name));
        if let Some(refusal) = refusal {
            return Err(Failure::Refused(refusal));
        }
        shown.map_err(Failure::refused)?;
        result.unwrap_or_else(|| Ok(Err(interrupted(name)))).map_err(Failure::Refused)?
    }

    /// Connects the screen and the camera, runs `work` and ends the node.
    fn connect_devices(
        &self,
        state: &LiveState,
        make_screen: impl FnOnce(&RosNode) -> anyhow::Result<Box<dyn ProjectorScreen>>,
        work: impl FnOnce(&mut LiveSession<'_>) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let LiveState { end, node, is_void, .. } = state;
        let name = self.name;
        let result = make_screen(node).map_err(Failure::Unreadable).and_then(|screen| {
            let camera = RosCamera::connect(node, end, &self.topics, self.needs_lens);
            let camera =
                camera.map_err(|error| if end.is_requested() { interrupted(name) } else { Failure::Unreadable(error) });
            work(&mut LiveSession { node, end, camera: camera?, screen, name, is_void })
        });
        node.shutdown();
        result
    }
}
