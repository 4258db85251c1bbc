//! What a user sees of a scan while it goes on: a bar with the share that is decoded, the log, and the picture of what
//! is decoded on a topic.

use std::sync::Arc;
use std::time::Duration;

use anyhow::Context;
use indicatif::{ProgressBar, ProgressStyle};
use rcs_messages::std_msgs::Header;
use rcs_messages::Image;
use rcs_ros::{NodeError, Publisher, RosNode};
use rcs_scan::preview::Reading;
use rcs_scan::ScanEvent;
use rcs_scene::Picture;

/// How often the bar is drawn while nothing happens.
const TICK: Duration = Duration::from_millis(200);
/// The topic of the picture, private to the node.
const PREVIEW_TOPIC: &str = "~preview";

/// The bar and the log, and the preview's topic for a scan with a node.
pub(super) struct Progress {
    bar: ProgressBar,
    reading: Option<Reading>,
    preview: Option<PreviewTopic>,
    camera_px: [u32; 2],
    projector_px: [u32; 2],
}

impl Progress {
    /// Nothing is seen yet. `doing` is what the scan does until the first picture was taken.
    pub(super) fn new(
        doing: &'static str,
        preview: Option<PreviewTopic>,
        camera_px: [u32; 2],
        projector_px: [u32; 2],
    ) -> Self {
        let bar = ProgressBar::new_spinner().with_message(doing);
        bar.enable_steady_tick(TICK);
        Self { bar, reading: None, preview, camera_px, projector_px }
    }

    /// Shows what happens.
    pub(super) fn show(&mut self, event: &ScanEvent<'_>) {
        match event {
            ScanEvent::Delay(delay, pictures) => {
                let (seen, settled) = (delay.seen.as_millis(), delay.settled.as_millis());
                self.bar.suspend(|| log::info!("light is seen after {seen} ms and has settled after {settled} ms"));
                self.count_to(*pictures);
            }
            ScanEvent::Captured { pictures, readable } => {
                self.bar.inc(1);
                Reading::take(&mut self.reading, pictures);
                let decoded = self.reading.as_ref().map_or(0.0, Reading::share);
                self.bar.set_message(format!(
                    "{:.0} % of the lit pixels decoded so far, {:.0} % read the last stripes",
                    100.0 * decoded,
                    100.0 * readable
                ));
                if let Some(reading) = self.reading.as_ref().filter(|_| self.preview.is_some()) {
                    self.publish(reading.picture(self.camera_px, self.projector_px));
                }
            }
            ScanEvent::Note(note) => self.bar.suspend(|| log::info!("{note}")),
            ScanEvent::Warning(warning) => self.bar.suspend(|| log::warn!("{warning}")),
        }
    }

    /// Starts a bar for so many pictures.
    pub(super) fn count_to(&self, pictures: usize) {
        let style = ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} left, {msg}");
        self.bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        self.bar.set_length(pictures as u64);
        self.bar.set_position(0);
        self.bar.set_message("");
    }

    /// Publishes a picture, if there is a topic for it.
    pub(super) fn publish(&self, picture: Picture) {
        if let Some(Err(error)) = self.preview.as_ref().map(|preview| preview.send(picture)) {
            self.bar.suspend(|| log::warn!("{error:#}"));
        }
    }

    /// Removes the bar.
    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// The topic of the picture. It is latched, so that a subscriber may come later.
pub(super) struct PreviewTopic {
    publisher: Publisher<Image>,
    frame_id: String,
}

impl PreviewTopic {
    /// Publishes the topic; the pictures are in the camera's frame.
    ///
    /// # Errors
    /// [`NodeError`] if the name, which may be remapped, is none.
    pub(super) fn new(node: &RosNode, frame_id: String) -> Result<Self, NodeError> {
        Ok(Self { publisher: node.latched_publisher(PREVIEW_TOPIC, 1)?, frame_id })
    }

    fn send(&self, picture: Picture) -> anyhow::Result<()> {
        let stamp = rcs_ros::node_time().map(|time| time.stamp).unwrap_or_default();
        let header = Header { stamp, frame_id: self.frame_id.clone(), ..Header::default() };
        let (size_px, step) = ([picture.width_px, picture.height_px], picture.step() as u32);
        let image = Image::new(header, size_px, picture.encoding.name(), step, Arc::new(picture.data));
        self.publisher.send(image).with_context(|| format!("cannot publish {}", self.publisher.topic()))
    }
}
