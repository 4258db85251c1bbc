//! `nav_path_markers`: a planned `nav_msgs/Path` as arrows on the floor, and a circle around its goal.

mod arrows;
mod markers;

use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use clap::{Command, CommandFactory, Parser};
use nalgebra::{Isometry3, Point3, Vector3};
use rcs_messages::nav_msgs::Path;
use rcs_messages::visualization_msgs::MarkerArray;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_ros::{NodeEvent, Publisher, RosNode};

use crate::poses::rigid_pose;
use arrows::{ArrowLayout, MOST_ARROWS};
use markers::{ArrowStyle, Sequence};
use rcs_node_support::lifecycle::{self, EndRequest};
use rcs_node_support::node_options::{color, rgba, with_parameters, within};
use rcs_node_support::node_status::{Level, NodeStatus};
use rcs_node_support::ros_names::{publishes, subscribes, RosName};

/// Topics of the node.
pub const ROS_NAMES: &[RosName] = &[
    subscribes("/move_base/NavfnROS/plan", "nav_msgs/Path", "the plan"),
    subscribes("/move_base/TrajectoryPlannerROS/global_plan", "nav_msgs/Path", "its followed part"),
    publishes("/visualization_marker_array", "visualization_msgs/MarkerArray", "arrows and circle, latched"),
    publishes("/diagnostics", "diagnostic_msgs/DiagnosticArray", "whether the plan is shown, and as how many arrows"),
];

/// Period at which the node polls for its shutdown.
const POLL_PERIOD: Duration = Duration::from_millis(100);
/// Time for the last message to reach its subscribers.
const FLUSH_TIME: Duration = Duration::from_millis(200);

/// Shows a planned nav_msgs/Path as arrows on the floor and a circle around its goal, in one
/// visualization_msgs/MarkerArray.
///
/// The last arrow's tip is the goal. Of several topics, the plan that came last is shown. A new plan replaces the
/// arrows of the one before with one message; an empty plan and the end of the node delete them. Every option may be
/// given as a private parameter, too: --goal-color is ~goal_color. ROS's remappings and special arguments work.
#[derive(Parser)]
#[command(
    name = "nav_path_markers",
    display_name = "rviz_camera_stream",
    version,
    before_help = "\
Examples:
  nav_path_markers --spacing 0.4 --markers-topic /path_arrows",
    after_help = "\
Topics: the path (nav_msgs/Path), the markers (visualization_msgs/MarkerArray, latched), /diagnostics
Exit codes: 0 ended by SIGINT, SIGTERM or rosnode kill; 1 a parameter or the node failed; 2 invalid arguments"
)]
struct PathMarkersArguments {
    /// Topic of the path; may be repeated
    #[arg(
        long,
        value_name = "TOPIC",
        default_values = ["/move_base/NavfnROS/plan", "/move_base/TrajectoryPlannerROS/global_plan"]
    )]
    path_topic: Vec<String>,
    /// Topic of the markers
    #[arg(long, value_name = "TOPIC", default_value = "/visualization_marker_array")]
    markers_topic: String,
    /// Namespace of the markers, by which viewers can hide them
    #[arg(long, value_name = "NAME", default_value = "nav_path")]
    namespace: String,
    /// Length of an arrow along the path [m]
    #[arg(long, value_name = "M", default_value_t = 0.3, value_parser = within(0.01, 100.0))]
    length: f64,
    /// Distance from tip to tip [m]
    #[arg(long, value_name = "M", default_value_t = 0.5, value_parser = within(0.01, 100.0))]
    spacing: f64,
    /// Width of an arrow [m]
    #[arg(long, value_name = "M", default_value_t = 0.08, value_parser = within(0.01, 100.0))]
    width: f64,
    /// Thickness of an arrow [m]
    #[arg(long, value_name = "M", default_value_t = 0.01, value_parser = within(0.0001, 100.0))]
    thickness: f64,
    /// Height of the arrows above the path [m]
    #[arg(long, value_name = "M", default_value_t = 0.0, value_parser = within(-100.0, 100.0), allow_negative_numbers = true)]
    height: f64,
    /// Colour of the arrows: 'r; g; b' with each from 0 to 255, '#rrggbb' or a name
    #[arg(long, default_value = "#3399ff", value_parser = color)]
    color: [u8; 3],
    /// Colour of the last arrow and the circle
    #[arg(long, value_name = "COLOR", default_value = "#33cc33", value_parser = color)]
    goal_color: [u8; 3],
    /// Radius of the goal's circle [m; 0: none]
    #[arg(long, value_name = "M", default_value_t = 0.35, value_parser = within(0.0, 100.0))]
    goal_radius: f64,
    /// Opacity, from 0 to 1
    #[arg(long, default_value_t = 1.0, value_parser = within(0.0, 1.0))]
    alpha: f64,
    /// Lifetime of arrows without a new plan [s; 0: unlimited]
    #[arg(long, value_name = "SECS", default_value_t = 0.0, value_parser = within(0.0, 86_400.0))]
    lifetime: f64,
}

/// The command line.
pub fn command() -> Command {
    PathMarkersArguments::command()
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    lifecycle::run_main(|_: PathMarkersArguments| lifecycle::with_node("nav_path_markers", run))
}

fn run(node: &RosNode, end: &EndRequest) -> anyhow::Result<()> {
    let arguments: PathMarkersArguments = with_parameters(node)?;
    let mut markers = PathMarkers::start(node, &arguments)?;
    let subscribe = |topic: &String| node.subscribe(topic, MessageKind::Path, 1);
    let subscriptions = arguments.path_topic.iter().map(subscribe).collect::<Result<Vec<_>, _>>()?;
    let topics: Vec<&str> = subscriptions.iter().map(|subscription| &**subscription.topic()).collect();
    markers.status.set(Level::Ok, &format!("no plan yet on {}", topics.join(" or ")), "");
    while !end.is_requested() {
        for event in node.events().wait(POLL_PERIOD) {
            if let NodeEvent::Message { topic, message: AnyMessage::Path(path), .. } = event {
                markers.take(&topic, &path)?;
            }
        }
        markers.status.publish_if_due()?;
    }
    markers.delete_all()
}

/// The markers of the current plan.
struct PathMarkers {
    layout: ArrowLayout,
    sequence: Sequence,
    markers: Publisher<MarkerArray>,
    status: NodeStatus,
    /// Frame of the published arrows, and the topic of their plan; `None` if there are none.
    shown: Option<(String, Arc<str>)>,
}

impl PathMarkers {
    fn start(node: &RosNode, arguments: &PathMarkersArguments) -> anyhow::Result<Self> {
        let style = ArrowStyle {
            namespace: arguments.namespace.clone(),
            width_m: arguments.width,
            thickness_m: arguments.thickness,
            color: rgba(arguments.color, arguments.alpha),
            goal_color: rgba(arguments.goal_color, arguments.alpha),
            goal_radius_m: arguments.goal_radius,
            lifetime: Duration::from_secs_f64(arguments.lifetime),
        };
        Ok(Self {
            layout: ArrowLayout {
                length_m: arguments.length,
                spacing_m: arguments.spacing,
                height_m: arguments.height,
            },
            sequence: Sequence::new(style),
            markers: node.latched_publisher(&arguments.markers_topic, 1)?,
            status: NodeStatus::start(node, "path")?,
            shown: None,
        })
    }

    /// Shows a topic's plan. An empty one ends only the plan of its own topic.
    fn take(&mut self, topic: &Arc<str>, path: &Path) -> anyhow::Result<()> {
        let is_of_another = self.shown.as_ref().is_some_and(|(_, shown)| shown != topic);
        if path.poses.is_empty() && is_of_another {
            return Ok(());
        }
        self.show(topic, path)
    }

    /// Replaces the arrows by those of a plan; an invalid plan deletes them.
    fn show(&mut self, topic: &Arc<str>, path: &Path) -> anyhow::Result<()> {
        let frame_id = frame_of(path);
        let Some(poses) = poses(path) else {
            self.status.set(Level::Error, "the plan has a pose with a non-finite number or an invalid quaternion", "");
            return self.delete_all();
        };
        if frame_id.is_empty() && !poses.is_empty() {
            self.status.set(Level::Error, "the plan has no frame_id", "");
            return self.delete_all();
        }
        let arrows = arrows::arrows(&poses, &self.layout);
        let (level, message) = match arrows.len() {
            0 => (Level::Ok, "the plan is empty"),
            MOST_ARROWS => (Level::Warn, "the plan is too long: only its last arrows are shown"),
            _ => (Level::Ok, "the plan is shown"),
        };
        self.status.set(level, message, &format!("{} poses in {frame_id}, {} arrows", poses.len(), arrows.len()));
        self.status.value("arrows", &arrows.len());
        self.status.value("frame", &frame_id);
        let goal = poses.last().map(|goal| Point3::from(goal.translation.vector + Vector3::z() * self.layout.height_m));
        self.markers.send(self.sequence.show(&arrows, goal, frame_id))?;
        self.shown = (!arrows.is_empty()).then(|| (frame_id.to_owned(), Arc::clone(topic)));
        Ok(())
    }

    /// Deletes all arrows and waits for the message to arrive.
    fn delete_all(&mut self) -> anyhow::Result<()> {
        self.status.value("arrows", &0);
        if let Some((frame_id, _)) = self.shown.take() {
            self.markers.send(self.sequence.show(&[], None, &frame_id))?;
            std::thread::sleep(FLUSH_TIME);
        }
        Ok(())
    }
}

/// Frame of the path, or of its poses if only they name one.
fn frame_of(path: &Path) -> &str {
    let of_poses = path.poses.first().map(|pose| pose.header.frame_id.as_str()).unwrap_or_default();
    if path.header.frame_id.is_empty() {
        of_poses
    } else {
        &path.header.frame_id
    }
}

/// Poses of a path; `None` if one is invalid.
fn poses(path: &Path) -> Option<Vec<Isometry3<f64>>> {
    path.poses.iter().map(|stamped| rigid_pose(&stamped.pose)).collect()
}

#[cfg(test)]
mod tests {
    use rcs_messages::geometry_msgs::PoseStamped;

    use super::*;

    #[test]
    fn the_frame_is_the_paths_own_or_its_poses() {
        let mut path = Path::default();
        assert_eq!(frame_of(&path), "");
        path.poses.push(PoseStamped::default());
        path.poses[0].header.frame_id = "odom".to_owned();
        assert_eq!(frame_of(&path), "odom");
        path.header.frame_id = "map".to_owned();
        assert_eq!(frame_of(&path), "map");
    }

    #[test]
    fn a_pose_without_rotation_is_a_place_and_one_that_is_not_finite_is_not() {
        let mut path = Path::default();
        path.poses.push(PoseStamped::default());
        assert_eq!(poses(&path), Some(vec![Isometry3::identity()]));
        path.poses[0].pose.position.y = f64::NAN;
        assert_eq!(poses(&path), None);
    }
}
