//! `projector_calibrate watch`: publishes a projector's drift, measured on request or while there is nothing to show.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{anyhow, Context};
use clap::Args;
use rcs_messages::std_srvs::{Trigger, TriggerReq};
use rcs_node_support::lifecycle::{self, EndRequest};
use rcs_node_support::node_status::{Level, NodeStatus};
use rcs_ros::{RosNode, ServiceCall};
use rcs_scan::{ProjectorScreen, ScanEvent, ScanOptions, ScanSession};

use super::arguments::positive_seconds;
use super::known_projector::KnownProjector;
use super::live::{CameraArguments, ImageTopic, RosCamera, TopicScreen};
use super::Failure;

/// Period of checks for service calls and the end.
const POLL_PERIOD: Duration = Duration::from_millis(100);
/// Timeout of the call of `is_idle`.
const IDLE_TIMEOUT: Duration = Duration::from_secs(2);

/// Verifies a projector on request, or while there is nothing to show, and publishes its drift
///
/// A node: the service ~verify measures the reprojection error as verify does, on the screen of a camera_stream. With
/// --every, it measures by itself, but only while that node's images are dark because there is nothing to show.
/// /diagnostics has the drift in pixels, a warning beyond --limit. It changes nothing: refine mends.
#[derive(Debug, Clone, Args)]
#[command(before_help = "\
Examples:
  projector_calibrate watch projector.yaml --every 600 --limit 3")]
#[command(after_help = "\
Topics subscribed to: as verify. Topics published: /diagnostics, and ~patterns of the camera_stream
Service: ~verify (std_srvs/Trigger)
Exit codes: 0 ended by SIGINT, SIGTERM or rosnode kill; 2 invalid arguments, or a topic that is silent")]
pub(super) struct WatchArguments {
    /// The projector's file, which is read anew for each measurement
    #[arg(value_name = "FILE")]
    projector: PathBuf,
    /// The node that has the projector's screen
    #[arg(long, value_name = "NODE", default_value = "/camera_stream")]
    stream: String,
    /// Measure at this interval, too, while there is nothing to show
    #[arg(long, value_name = "SECONDS", value_parser = positive_seconds)]
    every: Option<Duration>,
    /// The limit of the RMS error, pixels of the projector
    #[arg(long, value_name = "PIXELS", default_value_t = 2.0)]
    limit: f64,
    /// The camera.
    #[command(flatten)]
    camera: CameraArguments,
}

/// Runs the command.
pub(super) fn run(arguments: &WatchArguments) -> Result<(), Failure> {
    if !arguments.limit.is_finite() || arguments.limit <= 0.0 {
        return Err(Failure::Unreadable(anyhow!("--limit {} is not a positive number", arguments.limit)));
    }
    let size_px = KnownProjector::read(&arguments.projector)?.lens.size_px;
    let end = EndRequest::watch_signals().context("cannot handle signals").map_err(Failure::Unreadable)?;
    let node = lifecycle::connect("projector_watch", &end).map_err(Failure::unreadable)?;
    let Some(node) = node else { return Ok(()) };
    let mut camera = RosCamera::connect(&node, &end, &arguments.camera.topics(), true).map_err(Failure::Unreadable)?;
    camera.follow_robot().map_err(Failure::unreadable)?;
    camera.set_paused(true);
    let topic = format!("{}/patterns", arguments.stream.trim_end_matches('/'));
    let topic = ImageTopic::new(&node, &topic, String::new()).map_err(Failure::unreadable)?;
    let mut watch = Watch {
        arguments,
        node: &node,
        end: &end,
        camera,
        screen: TopicScreen { topic, size_px },
        status: NodeStatus::start(&node, "projection drift").map_err(Failure::unreadable)?,
    };
    watch.serve()
}

/// Running watch node.
struct Watch<'a> {
    arguments: &'a WatchArguments,
    node: &'a RosNode,
    end: &'a EndRequest,
    camera: RosCamera<'a>,
    screen: TopicScreen,
    status: NodeStatus,
}

impl Watch<'_> {
    /// Answers calls and measures by itself until the end.
    fn serve(&mut self) -> Result<(), Failure> {
        let verify = self.node.serve_trigger("~verify").map_err(Failure::unreadable)?;
        self.status.set(Level::Ok, "not measured yet", "");
        let mut due = self.arguments.every.map(|every| Instant::now() + every);
        while !self.end.is_requested() {
            for call in self.node.calls().wait(POLL_PERIOD) {
                if let ServiceCall::Trigger { service, reply, .. } = call {
                    if service == verify {
                        // A caller does not wait for as long as it takes.
                        reply.send(true, "measuring: /diagnostics tells the drift in some seconds");
                        self.measure();
                    }
                }
            }
            if due.is_some_and(|due| Instant::now() >= due) {
                if self.has_nothing_to_show() {
                    self.measure();
                }
                due = self.arguments.every.map(|every| Instant::now() + every);
            }
            self.status.publish_if_due().map_err(|error| Failure::Refused(error.into()))?;
        }
        Ok(())
    }

    /// `true` if the node with the screen has nothing to show. One that does not answer may be showing something.
    fn has_nothing_to_show(&self) -> bool {
        let service = format!("{}/is_idle", self.arguments.stream.trim_end_matches('/'));
        match self.node.call::<Trigger>(&service, &TriggerReq {}, IDLE_TIMEOUT) {
            Ok(answer) => {
                log::info!("{}: {}", self.arguments.stream, answer.message);
                answer.success
            }
            Err(error) => {
                log::warn!("not measured: {error}");
                false
            }
        }
    }

    /// Measures the drift and sets the status.
    fn measure(&mut self) {
        self.camera.set_paused(false);
        let drift = self.drift();
        self.camera.set_paused(true);
        // Never left lit.
        let [width, height] = self.screen.size_px.map(|side| side as usize);
        let dark = self.screen.show(vec![0; width * height]);
        let limit = self.arguments.limit;
        let (level, text) = match drift.and_then(|drift| dark.map(|()| drift)) {
            Ok([rms_px, median_px]) => {
                self.status.value("drift_px", &format_args!("{rms_px:.2}"));
                self.status.value("median_px", &format_args!("{median_px:.2}"));
                let text = format!("the projection is off by {rms_px:.2} px RMS");
                match rms_px <= limit {
                    true => (Level::Ok, text),
                    false => (Level::Warn, format!("{text}, beyond the limit of {limit} px: refine the pose")),
                }
            }
            Err(error) => (Level::Warn, format!("not measured: {}", rcs_logging::one_line(&error))),
        };
        self.status.set(level, &text, "");
    }

    /// RMS and median of the reprojection error, pixels of the projector.
    fn drift(&mut self) -> anyhow::Result<[f64; 2]> {
        let projector = KnownProjector::read(&self.arguments.projector).map_err(Failure::into_error)?;
        self.screen.size_px = projector.lens.size_px;
        let pose = self.camera.place(&projector).map_err(Failure::into_error)?.projector_from_camera();
        let end = self.end;
        let frames = usize::from(self.arguments.camera.frames);
        let options =
            ScanOptions { projector_px: projector.lens.size_px, step: 1, frames, is_cancelled: &|| end.is_requested() };
        let mut observe = |event: ScanEvent<'_>| {
            if let ScanEvent::Warning(warning) = event {
                log::warn!("{warning}");
            }
        };
        let session = ScanSession::new(&mut self.screen, &mut self.camera, &options, &mut observe);
        let all = session.verify(&projector.lens, &pose)?.result.all();
        Ok([all.rms[0], all.median[0]])
    }
}
