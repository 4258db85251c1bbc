//! The record of what was shown, on the topic `shown` beside the image topic: one message for each new image, with the
//! image's stamp, so that both join, and the time when it was on the screen.

use std::fmt;
use std::sync::Arc;

use rcs_messages::sensor_msgs::TimeReference;
use rcs_messages::std_msgs::Header;
use rcs_ros::{Publisher, RosNode};
use rcs_transforms::Time;
use rcs_window::OnScreen;

/// Publishes records of what was shown.
pub(crate) type ShownPublisher = Arc<Publisher<TimeReference>>;

/// Records that may wait for a slow subscriber.
pub(super) const QUEUE_SIZE: usize = 100;

/// The record of one image, which is published when it is on the screen.
pub(crate) struct ShownRecord {
    ros: Arc<RosNode>,
    publisher: ShownPublisher,
    header: Header,
    source: String,
}

impl ShownRecord {
    /// The record of an image with this header. `source` is [`source`].
    pub(crate) fn new(ros: &Arc<RosNode>, publisher: &ShownPublisher, header: Header, source: String) -> Self {
        Self { ros: Arc::clone(ros), publisher: Arc::clone(publisher), header, source }
    }
}

impl OnScreen for ShownRecord {
    fn shown(&self) {
        let (header, time_ref, source) = (self.header.clone(), self.ros.now(), self.source.clone());
        if let Err(error) = self.publisher.send(TimeReference { header, time_ref, source }) {
            log::warn!("{}: {error}", self.publisher.topic());
        }
    }
}

impl fmt::Debug for ShownRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ShownRecord")
            .field("header", &self.header)
            .field("source", &self.source)
            .finish_non_exhaustive()
    }
}

/// The content of an image: `CAMERA;DARK;OLDEST`, why it is black, if it is, and the stamp of its oldest data in
/// seconds, if they have stamps.
pub(crate) fn source(camera: &str, dark: Option<&str>, oldest: Option<Time>) -> String {
    let part = |text: &str| text.replace(';', ",");
    let seconds = |(secs, nanos): (u32, u32)| format!("{secs}.{nanos:09}");
    let oldest = oldest.map(|stamp| seconds(stamp.as_secs_nanos())).unwrap_or_default();
    format!("{};{};{oldest}", part(camera), part(dark.unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_has_three_parts_whatever_the_texts_have() {
        let oldest = Some(Time::from_secs_nanos(12, 34));
        assert_eq!(source("Left", None, oldest), "Left;;12.000000034");
        assert_eq!(source("a;b", Some("mask; stale"), None), "a,b;mask, stale;");
    }
}
