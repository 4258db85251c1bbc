//! Points that the user clicks in rviz with Publish Point, in the camera's optical frame.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::Point3;
use rcs_files::projector::StaticFrame;
use rcs_messages::geometry_msgs::PointStamped;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_node_support::lifecycle::{self, EndRequest};
use rcs_ros::NodeEvent;

use super::placing::{projector_from_parent, RobotFrames};

/// Timeout of TF after a click.
const TF_TIMEOUT: Duration = Duration::from_secs(3);
/// Time between two checks for the end of the program.
const POLL_PERIOD: Duration = Duration::from_millis(100);
/// Most clicks that wait to be received, or for TF.
const QUEUE_SIZE: usize = 20;

/// A point that was clicked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Click {
    /// The point in the camera's optical frame, metres.
    pub(super) point: Point3<f64>,
    /// The point in the projector's optical frame by its old pose, if that is known, metres.
    pub(super) in_projector: Option<Point3<f64>>,
}

/// Subscription to clicks.
#[derive(Debug)]
pub(super) struct Clicks {
    /// The topic of points.
    pub(super) topic: String,
    /// The camera's optical frame.
    pub(super) camera: String,
    /// The projector's old frame by its file.
    pub(super) old_place: Option<StaticFrame>,
}

impl Clicks {
    /// Listens until the end is requested, and returns the frames that TF has sent by then. A click that cannot be used
    /// is a warning.
    ///
    /// # Errors
    /// Errors of the node.
    pub(super) fn listen(&self, end: &EndRequest, mut take: impl FnMut(Click)) -> anyhow::Result<RobotFrames> {
        let mut frames = RobotFrames::default();
        let Some(node) = lifecycle::connect("projector_calibrate", end)? else { return Ok(frames) };
        node.subscribe_transforms()?;
        let clicked = node.subscribe(&self.topic, MessageKind::PointStamped, QUEUE_SIZE)?;
        let mut waiting = VecDeque::new();
        while !end.is_requested() {
            for event in node.events().wait(POLL_PERIOD) {
                frames.add(&event);
                let NodeEvent::Message { topic, message: AnyMessage::PointStamped(point), received, .. } = event else {
                    continue;
                };
                if topic == *clicked.topic() {
                    enqueue(&mut waiting, point, received);
                }
            }
            waiting.retain(|(point, received)| match self.click(&frames, point) {
                Ok(click) => {
                    take(click);
                    false
                }
                Err(error) if received.elapsed() > TF_TIMEOUT => {
                    log::warn!("ignored a click: {error:#}");
                    false
                }
                Err(_) => true,
            });
        }
        node.shutdown();
        Ok(frames)
    }

    /// A message as a click.
    fn click(&self, frames: &RobotFrames, message: &PointStamped) -> anyhow::Result<Click> {
        let given = Point3::new(message.point.x, message.point.y, message.point.z);
        let point = frames.newest(&self.camera, &message.header.frame_id)? * given;
        anyhow::ensure!(point.coords.iter().all(|value| value.is_finite()), "a coordinate is not finite");
        anyhow::ensure!(point.z > 0.0, "it is behind the camera, in {}", self.camera);
        let in_projector = self.old_place.as_ref().and_then(|place| {
            let parent_from_camera = frames.newest(&place.parent, &self.camera).ok()?;
            Some(projector_from_parent(place) * parent_from_camera * point)
        });
        Ok(Click { point, in_projector })
    }
}

/// Adds a click that waits for TF, and drops the oldest of more than [`QUEUE_SIZE`].
fn enqueue(waiting: &mut VecDeque<(Arc<PointStamped>, Instant)>, point: Arc<PointStamped>, received: Instant) {
    if waiting.len() == QUEUE_SIZE {
        waiting.pop_front();
        log::warn!("dropped the oldest click: more than {QUEUE_SIZE} wait for their frames");
    }
    waiting.push_back((point, received));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_clicks_without_frames_the_newest_wait() {
        let mut waiting = VecDeque::new();
        for number in 0..100 {
            let mut point = PointStamped::default();
            point.point.x = f64::from(number);
            enqueue(&mut waiting, Arc::new(point), Instant::now());
        }
        let queued: Vec<f64> = waiting.iter().map(|(point, _)| point.point.x).collect();
        assert_eq!(queued, (80..100).map(f64::from).collect::<Vec<_>>());
    }
}
