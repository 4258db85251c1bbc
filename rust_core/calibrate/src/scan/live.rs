//! A live scan: in a window on the projector's monitor, or on a topic.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use anyhow::{anyhow, Context};
use rcs_ros::RosNode;
use rcs_scan::{preview, Camera, ScanOptions, Screen, Session};
use rcs_scene::join_within;
use rcs_window::{self as window, UserEvent, WindowOptions};

use super::super::arguments::Size;
use super::super::Failure;
use super::arguments::ScanArguments;
use super::progress::{PreviewTopic, Progress};
use super::ros_camera::RosCamera;
use super::screens::{TopicScreen, WindowScreen};
use super::write;
use rcs_node_support::lifecycle::{self, EndRequest};
use rcs_node_support::window_watch::WindowWatch;

/// How long the work may take to end once it is asked to: it may be writing its files.
const END_PATIENCE: Duration = Duration::from_secs(10);

/// Scans live and writes.
///
/// # Errors
/// [`Failure`]: the scan was refused, or a topic, a window or a file cannot be used.
pub(super) fn scan(arguments: &ScanArguments) -> Result<(), Failure> {
    let end = EndRequest::watch_signals().context("cannot handle signals").map_err(Failure::Unreadable)?;
    if let Some(topic) = &arguments.show_on {
        let Size(size_px) = arguments.size;
        let screen = |node: &RosNode| Ok(Box::new(TopicScreen::new(node, topic, size_px)?) as Box<dyn Screen>);
        return scan_on(arguments, &end, &AtomicBool::new(false), screen);
    }
    let (Size(size_px), scanned) = (arguments.size, arguments.clone());
    let (source, monitor) = ("the scan".to_owned(), arguments.monitor.clone());
    let options = WindowOptions { source, monitor, ..WindowOptions::default() };
    in_window(&options, size_px, &end, move |screen, end, is_void| {
        scan_on(&scanned, end, is_void, |_| Ok(Box::new(screen)))
    })
}

/// Opens the window and runs `work` on another thread. The flag is set if the monitor has
/// another size. The window closes when `work` is done; closing it before asks `work` to end.
pub(super) fn in_window<T: Send + 'static>(
    options: &WindowOptions,
    size_px: [u32; 2],
    end: &EndRequest,
    work: impl FnOnce(WindowScreen, &EndRequest, &AtomicBool) -> Result<T, Failure> + Send + 'static,
) -> Result<T, Failure> {
    let [width, height] = size_px;
    let is_void = Arc::new(AtomicBool::new(false));
    let mut refusal = None;
    let mut work = Some(work);
    let mut scanning: Option<JoinHandle<Result<T, Failure>>> = None;
    // The work may be writing its files: it ends by itself.
    let is_working = Arc::new(AtomicBool::new(false));
    let (watched_end, watched_work) = (end.clone(), Arc::clone(&is_working));
    let watch = WindowWatch::start(1, move || watched_end.is_requested() && !watched_work.load(Ordering::Acquire))
        .context("cannot watch the window")
        .map_err(Failure::Refused)?;
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
            let is_working = Arc::clone(&is_working);
            is_working.store(true, Ordering::Release);
            let work = move || {
                let result = work(screen, &end, &is_void);
                is_working.store(false, Ordering::Release);
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
    drop(watch);
    // The window may have been closed first.
    end.request();
    let scanned = scanning.map(|thread| join_within(thread, END_PATIENCE));
    if let Some(refusal) = refusal {
        return Err(Failure::Refused(refusal));
    }
    shown.map_err(Failure::refused)?;
    let ended_early = || Err(Failure::Refused(anyhow!("ended before it began")));
    scanned.map_or_else(ended_early, |scanned| match scanned {
        Some(Ok(result)) => result,
        Some(Err(_)) => Err(Failure::Refused(anyhow!("the scan's thread has ended early"))),
        None => Err(Failure::Refused(anyhow!("the scan's thread does not end, so it is left behind"))),
    })
}

/// Scans and writes. Nothing is written once `is_void` is set.
fn scan_on(
    arguments: &ScanArguments,
    end: &EndRequest,
    is_void: &AtomicBool,
    make_screen: impl FnOnce(&RosNode) -> anyhow::Result<Box<dyn Screen>>,
) -> Result<(), Failure> {
    let interrupted = || Failure::Refused(anyhow!("interrupted before the scan began"));
    let node = lifecycle::connect("projector_calibrate", end).map_err(Failure::unreadable)?;
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
        let topic = PreviewTopic::new(&node, camera.frame_id()).map_err(Failure::unreadable)?;
        let camera_px = camera.lens().size_px;
        let mut progress = Progress::new("looking for the projector's light", Some(topic), camera_px, projector_px);
        let scanned = Session::new(&mut *screen, &mut camera, &options, &mut |event| progress.show(&event)).run();
        progress.finish();
        let scanned = scanned?;
        progress.publish(preview::of_decoded(&scanned.decoded, projector_px));
        if is_void.load(Ordering::Acquire) {
            return Err(interrupted());
        }
        write(arguments, &scanned)
    });
    node.shutdown();
    result
}
