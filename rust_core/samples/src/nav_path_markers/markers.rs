//! Arrows and a circle around the goal as one `visualization_msgs/MarkerArray` that replaces the one before.
//!
//! The arrows of a plan have the ids from 0 in one namespace: markers of the plan before that have the same id are
//! replaced, and all others are deleted by the same message. So a viewer never sees arrows of two plans, nor a moment
//! without any. The circle is the only marker of a second namespace.

use std::f64::consts::TAU;
use std::time::Duration;

use nalgebra::{Isometry3, Point3, Translation3};
use rcs_messages::geometry_msgs::{Point, Vector3};
use rcs_messages::std_msgs::{ColorRGBA, Header};
use rcs_messages::visualization_msgs::{Marker, MarkerArray};

use super::arrows::Arrow;
use crate::poses::pose_message;

/// Straight lines of the circle.
const CIRCLE_LINES: u32 = 48;

/// How arrows and the circle look.
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
    /// Colour of the last arrow and of the circle.
    pub(super) goal_color: [f32; 4],
    /// Radius of the circle, metres; 0: none.
    pub(super) goal_radius_m: f64,
    /// How long viewers keep them; zero: until they are replaced.
    pub(super) lifetime: Duration,
}

/// Makes the messages of one plan after the other.
#[derive(Debug)]
pub(super) struct Sequence {
    style: ArrowStyle,
    /// Highest number of ids used, which viewers may still hold.
    used: usize,
    /// `true` if viewers may still hold a circle.
    has_circle: bool,
}

impl Sequence {
    pub(super) fn new(style: ArrowStyle) -> Self {
        Self { style, used: 0, has_circle: false }
    }

    /// The message that shows these arrows and the goal in a frame, and no others.
    pub(super) fn show(&mut self, arrows: &[Arrow], goal: Option<Point3<f64>>, frame_id: &str) -> MarkerArray {
        let last = arrows.len().saturating_sub(1);
        let shown = arrows.iter().enumerate().map(|(index, arrow)| {
            let color = if index == last { self.style.goal_color } else { self.style.color };
            Marker {
                id: id(index),
                type_: i32::from(Marker::ARROW),
                scale: Vector3 { x: arrow.length_m, y: self.style.width_m, z: self.style.thickness_m },
                ..self.marker(&self.style.namespace, &arrow.pose, color, frame_id)
            }
        });
        let circle = goal.filter(|_| self.style.goal_radius_m > 0.0).map(|goal| self.circle(goal, frame_id));
        let delete = |namespace: &str, id: i32| Marker {
            header: Header { frame_id: frame_id.to_owned(), ..Header::default() },
            ns: namespace.to_owned(),
            id,
            action: i32::from(Marker::DELETE),
            ..Marker::default()
        };
        let deleted = (arrows.len()..self.used).map(|index| delete(&self.style.namespace, id(index)));
        let old_circle = (self.has_circle && circle.is_none()).then(|| delete(&self.goal_namespace(), 0));
        let has_circle = circle.is_some();
        let markers = shown.chain(circle).chain(deleted).chain(old_circle).collect();
        self.used = self.used.max(arrows.len());
        self.has_circle |= has_circle;
        MarkerArray { markers }
    }

    fn goal_namespace(&self) -> String {
        format!("{}_goal", self.style.namespace)
    }

    /// A horizontal circle.
    fn circle(&self, center: Point3<f64>, frame_id: &str) -> Marker {
        let point = |line: u32| {
            let (y, x) = (TAU * f64::from(line) / f64::from(CIRCLE_LINES)).sin_cos();
            Point { x: self.style.goal_radius_m * x, y: self.style.goal_radius_m * y, z: 0.0 }
        };
        let pose = Isometry3::from(Translation3::from(center));
        Marker {
            type_: i32::from(Marker::LINE_STRIP),
            scale: Vector3 { x: self.style.width_m, ..Vector3::default() },
            points: (0..=CIRCLE_LINES).map(point).collect(),
            ..self.marker(&self.goal_namespace(), &pose, self.style.goal_color, frame_id)
        }
    }

    /// The parts that arrows and the circle share.
    fn marker(&self, namespace: &str, pose: &Isometry3<f64>, [r, g, b, a]: [f32; 4], frame_id: &str) -> Marker {
        Marker {
            // Stamp zero with frame_locked: placed by the newest transform at each image, as the robot drives.
            header: Header { frame_id: frame_id.to_owned(), ..Header::default() },
            ns: namespace.to_owned(),
            action: i32::from(Marker::ADD),
            pose: pose_message(pose),
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
            goal_radius_m: 0.25,
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
        assert_eq!(ids(&sequence.show(&arrows(3), None, "map")), (vec![0, 1, 2], vec![]));
        assert_eq!(ids(&sequence.show(&arrows(1), None, "map")), (vec![0], vec![1, 2]));
        // Again, for a viewer that missed the message before.
        assert_eq!(ids(&sequence.show(&arrows(2), None, "map")), (vec![0, 1], vec![2]));
        assert_eq!(ids(&sequence.show(&[], None, "map")), (vec![], vec![0, 1, 2]));
    }

    #[test]
    fn the_last_arrow_has_the_goals_colour_and_all_follow_the_frame() {
        let shown = Sequence::new(style()).show(&arrows(2), None, "odom").markers;
        assert_eq!((shown[0].color.b, shown[1].color.g, shown[1].color.b), (1.0, 1.0, 0.0));
        assert!(shown.iter().all(|marker| marker.frame_locked && marker.header.frame_id == "odom"));
        assert_eq!((shown[1].pose.position.x, shown[1].scale.x, shown[1].scale.y), (1.0, 0.3, 0.1));
        assert_eq!((shown[0].lifetime.sec, shown[0].lifetime.nsec), (2, 500_000_000));
    }
    #[test]
    fn the_goal_is_a_circle_in_a_namespace_of_its_own_until_there_is_none() {
        let mut sequence = Sequence::new(style());
        let shown = sequence.show(&arrows(1), Some(Point3::new(2.0, 3.0, 0.1)), "map").markers;
        let [_, circle] = &shown[..] else { panic!("{shown:?}") };
        assert_eq!((circle.ns.as_str(), circle.id, circle.type_), ("plan_goal", 0, i32::from(Marker::LINE_STRIP)));
        assert_eq!((circle.pose.position.x, circle.pose.position.y, circle.pose.position.z), (2.0, 3.0, 0.1));
        assert_eq!((circle.scale.x, circle.color.g, circle.pose.orientation.w), (0.1, 1.0, 1.0));
        assert!(circle.points.iter().all(|point| (point.x.hypot(point.y) - 0.25).abs() < 1e-9 && point.z == 0.0));
        let ([first, .., last], true) = (&circle.points[..], circle.frame_locked) else { panic!("{circle:?}") };
        assert!((first.x - last.x).hypot(first.y - last.y) < 1e-9, "it is closed");
        let gone = sequence.show(&[], None, "map").markers;
        assert!(gone.iter().all(|marker| marker.action == i32::from(Marker::DELETE)), "{gone:?}");
        assert_eq!(
            gone.iter().map(|marker| (&*marker.ns, marker.id)).collect::<Vec<_>>(),
            [("plan", 0), ("plan_goal", 0)]
        );

        let mut without = Sequence::new(ArrowStyle { goal_radius_m: 0.0, ..style() });
        assert_eq!(without.show(&arrows(1), Some(Point3::origin()), "map").markers.len(), 1);
    }
}
