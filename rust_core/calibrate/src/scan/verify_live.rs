//! A verification with the projector's monitor or topic, and the camera's topics.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{anyhow, Context};
use indicatif::{ProgressBar, ProgressStyle};
use rcs_files::projector::ProjectorFile;
use rcs_ros::RosNode;
use rcs_scan::{Camera as _, ScanEvent, ScanOptions, Screen, Session, Verification};
use rcs_window::{MonitorChoice, WindowOptions};

use super::live::in_window;
use super::ros_camera::RosCamera;
use super::screens::TopicScreen;
use super::topics::TopicArguments;
use crate::{placing, Failure};
use rcs_node_support::lifecycle::{self, EndRequest};

/// What is verified, and with which devices.
#[derive(Debug, Clone)]
pub(crate) struct LiveOptions {
    /// The projector's file.
    pub(crate) projector: PathBuf,
    /// The projector's monitor.
    pub(crate) monitor: MonitorChoice,
    /// A topic to show on instead.
    pub(crate) show_on: Option<String>,
    /// The camera's topics.
    pub(crate) camera: TopicArguments,
    /// Frames that each picture is the mean of.
    pub(crate) frames: usize,
    /// How long spots and outlines are shown afterwards.
    pub(crate) hold: Duration,
}

/// Verifies a projector's file: opens the window, which needs the main thread, or publishes on the topic. `measured` is
/// called on another thread once the distances are known, while spots and outlines are still shown.
///
/// # Errors
/// [`Failure`]: nothing could be measured, or that of `measured`.
pub(crate) fn verify_live(
    options: &LiveOptions,
    measured: impl FnOnce(&Verification) -> Result<(), Failure> + Send + 'static,
) -> Result<(), Failure> {
    let file = ProjectorFile::read(&options.projector).map_err(Failure::unreadable)?;
    let lens = crate::read_lens(&options.projector)?;
    let end = EndRequest::watch_signals().context("cannot handle signals").map_err(Failure::Unreadable)?;
    let live = Live { options: options.clone(), file, lens };
    if let Some(topic) = options.show_on.clone() {
        let screen = |node: &RosNode| Ok(Box::new(TopicScreen::new(node, &topic, lens.size_px)?) as Box<dyn Screen>);
        return live.verify(&end, &AtomicBool::new(false), screen, measured);
    }
    let (source, monitor) = ("the verification".to_owned(), options.monitor.clone());
    let window = WindowOptions { source, monitor, ..WindowOptions::default() };
    in_window(&window, lens.size_px, &end, move |screen, end, is_void| {
        live.verify(end, is_void, |_| Ok(Box::new(screen)), measured)
    })
}

/// A verification that has not begun.
struct Live {
    options: LiveOptions,
    file: ProjectorFile,
    lens: rcs_calibration::Lens,
}

impl Live {
    fn verify(
        &self,
        end: &EndRequest,
        is_void: &AtomicBool,
        make_screen: impl FnOnce(&RosNode) -> anyhow::Result<Box<dyn Screen>>,
        measured: impl FnOnce(&Verification) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let node = lifecycle::connect("projector_calibrate", end).map_err(Failure::unreadable)?;
        let node = node.ok_or_else(interrupted)?;
        let result = make_screen(&node).map_err(Failure::Unreadable).and_then(|mut screen| {
            let verification = self.measure(&node, end, &mut *screen)?;
            if is_void.load(Ordering::Acquire) {
                return Err(interrupted());
            }
            let judged = measured(&verification);
            if !self.options.hold.is_zero() {
                log::info!(
                    "spots and outlines are shown for {:.0} s, or until Ctrl-C",
                    self.options.hold.as_secs_f64()
                );
            }
            end.wait_for(self.options.hold);
            judged
        });
        node.shutdown();
        result
    }

    fn measure(&self, node: &RosNode, end: &EndRequest, screen: &mut dyn Screen) -> Result<Verification, Failure> {
        let mut camera = RosCamera::connect(node, end, &self.options.camera.topics()).map_err(|error| {
            if end.is_requested() {
                interrupted()
            } else {
                Failure::unreadable(error)
            }
        })?;
        let pose = placing::pose_by_tf(&self.file, &self.options.projector, &camera.frame_id(), node, end)?;
        let options = ScanOptions {
            projector_px: self.lens.size_px,
            step: 1,
            frames: self.options.frames,
            is_cancelled: &|| end.is_requested(),
        };
        let bar = ProgressBar::new_spinner().with_message("looking for the projector's light");
        let verified =
            Session::new(screen, &mut camera, &options, &mut |event| show(&bar, &event)).verify(&self.lens, &pose);
        bar.finish_and_clear();
        Ok(verified?)
    }
}

fn interrupted() -> Failure {
    Failure::Refused(anyhow!("interrupted before the light was measured"))
}

/// Shows how far it is.
fn show(bar: &ProgressBar, event: &ScanEvent<'_>) {
    match event {
        ScanEvent::Delay(_, pictures) => {
            let style = ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} left");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.set_length(*pictures as u64);
            bar.set_position(0);
        }
        ScanEvent::Captured { .. } => bar.inc(1),
        ScanEvent::Note(note) => bar.suspend(|| log::info!("{note}")),
        ScanEvent::Warning(warning) => bar.suspend(|| log::warn!("{warning}")),
    }
}
