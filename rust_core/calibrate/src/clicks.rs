//! Things that the user clicks in rviz with Publish Point, as points of the camera's optical frame.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::Point3;
use rcs_files::projector::StaticFrame;
use rcs_messages::geometry_msgs::PointStamped;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_ros::NodeEvent;

use super::placing::{projector_from_parent, Frames};
use rcs_node_support::lifecycle::{self, EndRequest};

/// How long TF is waited for after a click.
const PATIENCE: Duration = Duration::from_secs(3);
/// How often the end is looked for.
const POLL_PERIOD: Duration = Duration::from_millis(100);
/// Clicks that wait to be looked at, and for TF, at most.
const QUEUE_SIZE: usize = 20;

/// A thing that was clicked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Click {
    /// The point in the camera's optical frame, metres.
    pub(super) point: Point3<f64>,
    /// The same in the projector's optical frame by its old pose, if that is known.
    pub(super) in_projector: Option<Point3<f64>>,
}

/// Where clicks come from.
#[derive(Debug)]
pub(super) struct Clicks {
    /// The topic of points.
    pub(super) topic: String,
    /// The camera's optical frame.
    pub(super) camera: String,
    /// Where the projector's file places it.
    pub(super) old_place: Option<StaticFrame>,
    /// When to end.
    pub(super) end: EndRequest,
}

impl Clicks {
    /// Listens until the end is requested, and returns the frames that TF has told by then.
    ///
    /// # Errors
    /// ROS's; a click that cannot be used is a warning.
    pub(super) fn listen(&self, mut take: impl FnMut(Click)) -> anyhow::Result<Frames> {
        let mut frames = Frames::default();
        let Some(node) = lifecycle::connect("projector_calibrate", &self.end)? else { return Ok(frames) };
        node.subscribe_transforms()?;
        let clicked = node.subscribe(&self.topic, MessageKind::PointStamped, QUEUE_SIZE)?;
        let mut waiting = VecDeque::new();
        while !self.end.is_requested() {
            for event in node.events().wait(POLL_PERIOD) {
                frames.take(&event);
                match event {
                    NodeEvent::Message { topic, message: AnyMessage::PointStamped(point), received, .. }
                        if topic == *clicked.topic() =>
                    {
                        keep(&mut waiting, point, received);
                    }
                    _ => {}
                }
            }
            waiting.retain(|(point, received)| match self.click(&frames, point) {
                Ok(click) => {
                    take(click);
                    false
                }
                Err(error) if received.elapsed() > PATIENCE => {
                    log::warn!("the click is left out: {error:#}");
                    false
                }
                Err(_) => true,
            });
        }
        node.shutdown();
        Ok(frames)
    }

    /// A message as a click.
    fn click(&self, frames: &Frames, message: &PointStamped) -> anyhow::Result<Click> {
        let given = Point3::new(message.point.x, message.point.y, message.point.z);
        let point = frames.newest(&self.camera, &message.header.frame_id)? * given;
        anyhow::ensure!(point.coords.iter().all(|value| value.is_finite()), "it is no place");
        anyhow::ensure!(point.z > 0.0, "it lies behind the camera, in {}", self.camera);
        let in_projector = self.old_place.as_ref().and_then(|place| {
            let parent_from_camera = frames.newest(&place.parent, &self.camera).ok()?;
            Some(projector_from_parent(place) * parent_from_camera * point)
        });
        Ok(Click { point, in_projector })
    }
}

/// Has a click wait for TF. Of more than [`QUEUE_SIZE`], the oldest is left out.
fn keep(waiting: &mut VecDeque<(Arc<PointStamped>, Instant)>, point: Arc<PointStamped>, received: Instant) {
    if waiting.len() == QUEUE_SIZE {
        waiting.pop_front();
        log::warn!("the oldest click is left out: more than {QUEUE_SIZE} wait for their frames");
    }
    waiting.push_back((point, received));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_clicks_whose_frames_do_not_come_the_newest_wait() {
        let mut waiting = VecDeque::new();
        for number in 0..100 {
            let mut point = PointStamped::default();
            point.point.x = f64::from(number);
            keep(&mut waiting, Arc::new(point), Instant::now());
        }
        let kept: Vec<f64> = waiting.iter().map(|(point, _)| point.point.x).collect();
        assert_eq!(kept, (80..100).map(f64::from).collect::<Vec<_>>());
    }
}
