//! Received targets that wait for the transforms of their stamps.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use nalgebra::{Point3, Vector3};
use rcs_displays::time_from_stamp;
use rcs_messages::std_msgs::Header;
use rcs_messages::{point_xyz, AnyMessage, PointCloud2};
use rcs_transforms::{Time, TransformTree};

/// Time that a target waits for its transform.
const TRANSFORM_TIMEOUT: Duration = Duration::from_secs(2);
/// Most waiting targets; the oldest is dropped.
const MOST_WAITING: usize = 200;

/// A received target in its own frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ReceivedTarget {
    frame: String,
    stamp: Time,
    point: Point3<f64>,
    received: Instant,
}

impl ReceivedTarget {
    /// The position in a message.
    ///
    /// # Errors
    /// The reason why it has none.
    pub(super) fn of(message: &AnyMessage, received: Instant) -> Result<Self, String> {
        let (header, point) = match message {
            AnyMessage::PoseStamped(pose) => (&pose.header, point_xyz(&pose.pose.position).into()),
            AnyMessage::PointStamped(point) => (&point.header, point_xyz(&point.point).into()),
            AnyMessage::PointCloud2(cloud) => (&cloud.header, centroid(cloud)?),
            other => return Err(format!("{} is no target", other.kind().ros_type())),
        };
        let Header { stamp, frame_id, .. } = header;
        if frame_id.is_empty() {
            return Err("it has no frame_id".to_owned());
        }
        if !point.coords.iter().all(|number| number.is_finite()) {
            return Err("it is not finite".to_owned());
        }
        Ok(Self { frame: frame_id.clone(), stamp: time_from_stamp(*stamp), point, received })
    }
}

/// The mean of a cloud's finite points.
fn centroid(cloud: &PointCloud2) -> Result<Point3<f64>, String> {
    let points = cloud.positions().map_err(|error| error.to_string())?;
    let finite = points.filter(|point| point.iter().all(|number| number.is_finite()));
    let (sum, count) =
        finite.fold((Vector3::zeros(), 0.0), |(sum, count), point| (sum + Vector3::from(point), count + 1.0));
    if count > 0.0 {
        Ok(Point3::from(sum / count))
    } else {
        Err("the cloud has no points".to_owned())
    }
}

/// Targets that wait for their transform, the oldest first.
#[derive(Debug, Default)]
pub(super) struct PendingTargets(VecDeque<ReceivedTarget>);

impl PendingTargets {
    pub(super) fn push(&mut self, sighting: ReceivedTarget) {
        if self.0.len() >= MOST_WAITING {
            self.0.pop_front();
        }
        self.0.push_back(sighting);
    }

    /// The newest target whose transform is known, in the fixed frame, and when it was received; an error if none is
    /// known and the oldest has timed out; `None` otherwise.
    pub(super) fn place(
        &mut self,
        tree: &TransformTree,
        fixed_frame: &str,
    ) -> Option<Result<(Point3<f64>, Instant), String>> {
        let found = self.0.iter().enumerate().rev().find_map(|(index, waits)| {
            let fixed_from_target = tree.lookup(fixed_frame, &waits.frame, waits.stamp).ok()?;
            Some((index, (fixed_from_target * waits.point, waits.received)))
        });
        if let Some((index, place)) = found {
            // Older ones are superseded.
            self.0.drain(..=index);
            return Some(Ok(place));
        }
        self.0.front().filter(|first| first.received.elapsed() > TRANSFORM_TIMEOUT)?;
        let late = self.0.pop_front()?;
        tree.lookup(fixed_frame, &late.frame, late.stamp).err().map(|error| Err(error.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use rcs_messages::geometry_msgs::PointStamped;
    use rcs_transforms::RawTransform;

    use super::*;

    fn point(x: f64, secs: u32, frame: &str) -> AnyMessage {
        let mut message = PointStamped::default();
        message.header.frame_id = frame.to_owned();
        message.header.stamp.sec = secs;
        message.point.x = x;
        AnyMessage::PointStamped(message.into())
    }

    fn moved(tree: &mut TransformTree, secs: u32, x: f64) {
        let transform = RawTransform {
            parent: "map",
            child: "camera",
            stamp: Time::from_secs_nanos(secs, 0),
            translation: [x, 0.0, 0.0],
            rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
        };
        tree.insert(&transform, false, "test").unwrap();
    }

    #[test]
    fn a_target_is_placed_where_its_frame_was_at_its_stamp() {
        let (mut tree, mut waiting) = (TransformTree::new(), PendingTargets::default());
        let now = Instant::now();
        moved(&mut tree, 10, 1.0);
        waiting.push(ReceivedTarget::of(&point(0.5, 11, "camera"), now).unwrap());
        waiting.push(ReceivedTarget::of(&point(0.6, 13, "camera"), now).unwrap());
        assert_eq!(waiting.place(&tree, "map"), None, "its transform is still to come");
        moved(&mut tree, 12, 3.0);
        assert_eq!(waiting.place(&tree, "map"), Some(Ok((Point3::new(2.5, 0.0, 0.0), now))));
        assert_eq!(waiting.place(&tree, "map"), None, "the newer one waits");
        moved(&mut tree, 14, 3.0);
        assert_eq!(waiting.place(&tree, "map"), Some(Ok((Point3::new(3.6, 0.0, 0.0), now))));
        assert_eq!(waiting.0.len(), 0);
    }

    #[test]
    fn what_waits_in_vain_is_reported() {
        let (tree, mut waiting) = (TransformTree::new(), PendingTargets::default());
        let Some(long_ago) = Instant::now().checked_sub(TRANSFORM_TIMEOUT * 2) else { return };
        waiting.push(ReceivedTarget::of(&point(0.5, 11, "camera"), long_ago).unwrap());
        let error = waiting.place(&tree, "map").unwrap().unwrap_err();
        assert!(error.contains("map") && error.contains("camera"), "{error}");
        assert_eq!(waiting.place(&tree, "map"), None);
    }

    #[test]
    fn what_has_no_place_is_refused() {
        let refused = |message: &AnyMessage| ReceivedTarget::of(message, Instant::now()).unwrap_err();
        assert_eq!(refused(&point(f64::NAN, 0, "camera")), "it is not finite");
        assert_eq!(refused(&point(0.0, 0, "")), "it has no frame_id");
        assert!(refused(&AnyMessage::PointCloud2(PointCloud2::default().into())).contains("no field x"));
        assert!(refused(&AnyMessage::Path(rcs_messages::nav_msgs::Path::default().into())).contains("no target"));
    }
}
