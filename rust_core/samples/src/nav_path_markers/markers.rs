//! Arrows as one `visualization_msgs/MarkerArray` that replaces the one before.
//!
//! The arrows of a plan have the ids from 0 in one namespace: markers of the plan before that have the same id are
//! replaced, and all others are deleted by the same message. So a viewer never sees arrows of two plans, nor a moment
//! without any.

use std::time::Duration;

use rcs_messages::geometry_msgs::Vector3;
use rcs_messages::std_msgs::{ColorRGBA, Header};
use rcs_messages::visualization_msgs::{Marker, MarkerArray};

use super::arrows::Arrow;
use crate::poses::pose_message;

/// How arrows style.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ArrowStyle {
    /// The markers' namespace.
    pub(super) namespace: String,
    /// Across, along the floor, metres.
    pub(super) width_m: f64,
    /// Up, metres.
    pub(super) thickness_m: f64,
    /// Red, green, blue, alpha from 0 to 1.
    pub(super) color: [f32; 4],
    /// Colour of the last arrow.
    pub(super) goal_color: [f32; 4],
    /// How long viewers keep them; zero: until they are replaced.
    pub(super) lifetime: Duration,
}

/// Makes the messages of one plan after the other.
#[derive(Debug)]
pub(super) struct Sequence {
    style: ArrowStyle,
    /// Highest number of ids used, which viewers may still hold.
    used: usize,
}

impl Sequence {
    pub(super) fn new(style: ArrowStyle) -> Self {
        Self { style, used: 0 }
    }

    /// The message that shows these arrows in a frame, and no others.
    pub(super) fn show(&mut self, arrows: &[Arrow], frame_id: &str) -> MarkerArray {
        let last = arrows.len().saturating_sub(1);
        let shown = arrows.iter().enumerate().map(|(index, arrow)| {
            let color = if index == last { self.style.goal_color } else { self.style.color };
            self.marker(index, arrow, color, frame_id)
        });
        let deleted = (arrows.len()..self.used).map(|index| Marker {
            header: Header { frame_id: frame_id.to_owned(), ..Header::default() },
            ns: self.style.namespace.clone(),
            id: id(index),
            action: i32::from(Marker::DELETE),
            ..Marker::default()
        });
        let markers = shown.chain(deleted).collect();
        self.used = self.used.max(arrows.len());
        MarkerArray { markers }
    }

    fn marker(&self, index: usize, arrow: &Arrow, [r, g, b, a]: [f32; 4], frame_id: &str) -> Marker {
        Marker {
            // Stamp zero with frame_locked: placed by the newest transform at each image, as the robot drives.
            header: Header { frame_id: frame_id.to_owned(), ..Header::default() },
            ns: self.style.namespace.clone(),
            id: id(index),
            type_: i32::from(Marker::ARROW),
            action: i32::from(Marker::ADD),
            pose: pose_message(&arrow.pose),
            scale: Vector3 { x: arrow.length_m, y: self.style.width_m, z: self.style.thickness_m },
            color: ColorRGBA { r, g, b, a },
            lifetime: rcs_messages::Duration::from_nanos(
                i64::try_from(self.style.lifetime.as_nanos()).unwrap_or_default(),
            ),
            frame_locked: true,
            ..Marker::default()
        }
    }
}

/// There are never more markers than fit.
fn id(index: usize) -> i32 {
    i32::try_from(index).unwrap_or(i32::MAX)
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;

    fn arrows(count: usize) -> Vec<Arrow> {
        let arrow = |index| Arrow { pose: Isometry3::translation(index as f64, 0.0, 0.0), length_m: 0.3 };
        (0..count).map(arrow).collect()
    }

    fn style() -> ArrowStyle {
        ArrowStyle {
            namespace: "plan".to_owned(),
            width_m: 0.1,
            thickness_m: 0.01,
            color: [0.0, 0.5, 1.0, 1.0],
            goal_color: [0.0, 1.0, 0.0, 1.0],
            lifetime: Duration::from_millis(2500),
        }
    }

    /// Ids that are shown and deleted.
    fn ids(message: &MarkerArray) -> (Vec<i32>, Vec<i32>) {
        let (shown, deleted): (Vec<&Marker>, Vec<&Marker>) =
            message.markers.iter().partition(|marker| marker.action == i32::from(Marker::ADD));
        let ids = |markers: Vec<&Marker>| markers.iter().map(|marker| marker.id).collect();
        (ids(shown), ids(deleted))
    }

    #[test]
    fn one_message_shows_a_plan_and_deletes_what_it_lacks() {
        let mut sequence = Sequence::new(style());
        assert_eq!(ids(&sequence.show(&arrows(3), "map")), (vec![0, 1, 2], vec![]));
        assert_eq!(ids(&sequence.show(&arrows(1), "map")), (vec![0], vec![1, 2]));
        // Again, for a viewer that missed the message before.
        assert_eq!(ids(&sequence.show(&arrows(2), "map")), (vec![0, 1], vec![2]));
        assert_eq!(ids(&sequence.show(&[], "map")), (vec![], vec![0, 1, 2]));
    }

    #[test]
    fn the_last_arrow_has_the_goals_colour_and_all_follow_the_frame() {
        let shown = Sequence::new(style()).show(&arrows(2), "odom").markers;
        assert_eq!((shown[0].color.b, shown[1].color.g, shown[1].color.b), (1.0, 1.0, 0.0));
        assert!(shown.iter().all(|marker| marker.frame_locked && marker.header.frame_id == "odom"));
        assert_eq!((shown[1].pose.position.x, shown[1].scale.x, shown[1].scale.y), (1.0, 0.3, 0.1));
        assert_eq!((shown[0].lifetime.sec, shown[0].lifetime.nsec), (2, 500_000_000));
    }
}
