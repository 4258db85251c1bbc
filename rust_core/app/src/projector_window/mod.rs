//! `projector_window`: an image topic full screen on a chosen monitor, pixel for pixel.

use std::process::ExitCode;
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use anyhow::Context;
use clap::Parser;
use rcs_messages::{AnyMessage, Image, MessageKind};
use rcs_ros::NodeEvent;
use rcs_window::{self as window, PictureError, PictureSink, ReceivedPicture, ScreenPicture};

use crate::monitor_arguments::MonitorArguments;
use crate::small_node::{self, EndRequest};

const DEFAULT_TOPIC: &str = "/proj_view/image";

/// Shows an image topic full screen on a monitor or projector, pixel for pixel, without scaling.
///
/// Picture pixel (u, v) is screen pixel (u, v). A warning is printed if picture and monitor differ in size; the picture
/// is then at the top left, on black. Encodings: rgb8, rgba8, bgr8, bgra8, mono8, mono16. Escape or q ends.
#[derive(Parser)]
#[command(
    name = "projector_window",
    display_name = "rviz_camera_stream",
    version,
    after_help = "\
Topic subscribed to: /proj_view/image (sensor_msgs/Image); image:=/topic remaps it, as for image_view
Exit codes: 0 ended by Escape, q, SIGINT, SIGTERM or rosnode kill; 1 the window or the node failed; 2 invalid arguments

Example: projector_window --monitor HDMI-1 image:=/proj_view/image"
)]
struct Arguments {
    /// The image topic [default: the remapping of image:=, else /proj_view/image]
    #[arg(long)]
    topic: Option<String>,
    #[command(flatten)]
    monitor: MonitorArguments,
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    small_node::run_main(run)
}

fn run(arguments: Arguments) -> anyhow::Result<()> {
    if arguments.monitor.print_list()? {
        return Ok(());
    }
    let topic =
        arguments.topic.or_else(|| small_node::remapping_of("image")).unwrap_or_else(|| DEFAULT_TOPIC.to_owned());
    let options = arguments.monitor.window_options(&topic);
    let end = EndRequest::watch_signals().context("cannot handle signals")?;

    // The window system needs the main thread; the node runs on another one and closes the window when it ends.
    let (outcome, node_outcome) = mpsc::channel();
    let node_end = end.clone();
    let shown = window::run(options, move |sink| {
        let closing = sink.clone();
        let following = move || {
            let result = follow_topic(&topic, &node_end, &sink);
            sink.close();
            // Nobody receives it if the window was closed first.
            let _ = outcome.send(result);
        };
        if let Err(error) = thread::Builder::new().name("node".to_owned()).spawn(following) {
            log::error!("cannot start the node's thread: {error}");
            closing.close();
        }
    });
    // Whatever the window's end was: the node unregisters. One that was never started has hung up.
    end.request();
    let node_result = node_outcome.recv_timeout(Duration::from_secs(4)).unwrap_or(Ok(()));
    shown?;
    node_result
}

/// Hands the topic's pictures to the window until the shutdown is requested.
fn follow_topic(topic: &str, end: &EndRequest, sink: &PictureSink) -> anyhow::Result<()> {
    let Some(node) = small_node::connect("projector_window", end)? else {
        return Ok(());
    };
    // A queue of one: the window shows the latest picture.
    let subscription = node.subscribe(topic, MessageKind::Image, 1)?;
    let mut last_error = None;
    while !end.is_requested() {
        for event in node.events().wait(Duration::from_millis(100)) {
            let NodeEvent::Message { message: AnyMessage::Image(image), .. } = event else {
                continue;
            };
            match picture(&image) {
                Ok(picture) => {
                    sink.show(picture);
                    last_error = None;
                }
                // Each kind of error is logged once, however many pictures arrive.
                Err(error) if last_error.as_ref() == Some(&error) => {}
                Err(error) => {
                    log::error!("topic {}: {error}", subscription.topic());
                    last_error = Some(error);
                }
            }
        }
    }
    drop(subscription);
    node.shutdown();
    Ok(())
}

fn picture(image: &Image) -> Result<ScreenPicture, PictureError> {
    ScreenPicture::from_received(&ReceivedPicture {
        width_px: image.width,
        height_px: image.height,
        step_bytes: image.step,
        encoding: &image.encoding,
        is_bigendian: image.is_bigendian != 0,
        data: image.data(),
    })
}
