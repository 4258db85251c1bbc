//! `nav_path_markers`: a planned `nav_msgs/Path` as arrows on the floor.

mod arrows;
mod markers;

use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;
use nalgebra::Isometry3;
use rcs_messages::nav_msgs::Path;
use rcs_messages::visualization_msgs::MarkerArray;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_ros::{NodeEvent, Publisher, RosNode};

use arrows::{Layout, MOST_ARROWS};
use markers::{Look, Sequence};
use rcs_node_support::lifecycle::{self, EndRequest};
use rcs_node_support::node_options::{color, number_within, rgba, with_parameters};
use rcs_node_support::node_status::{Level, NodeStatus};
use rcs_node_support::poses::rigid_pose;

/// How often the node looks whether it is to end.
const POLL_PERIOD: Duration = Duration::from_millis(100);
/// How long the last message may take to reach its subscribers.
const LAST_MESSAGE: Duration = Duration::from_millis(200);

/// Shows a planned nav_msgs/Path as arrows on the floor, in one visualization_msgs/MarkerArray.
///
/// The last arrow's tip is the goal. A new plan replaces the arrows of the one before with one message; an empty plan
/// and the end of the node delete them. Every option may be given as a private parameter, too: --goal-color is
/// ~goal_color. ROS's remappings and special arguments work.
#[derive(Parser)]
#[command(
    name = "nav_path_markers",
    display_name = "rviz_camera_stream",
    version,
    after_help = "\
Topics: the path (nav_msgs/Path), the markers (visualization_msgs/MarkerArray, latched), /diagnostics
Exit codes: 0 ended by SIGINT, SIGTERM or rosnode kill; 1 a parameter or the node failed; 2 invalid arguments

Example: nav_path_markers --spacing 0.4 --color '#3399ff' --markers-topic /path_arrows"
)]
struct Arguments {
    /// The topic of the path
    #[arg(long, value_name = "TOPIC", default_value = "/move_base/NavfnROS/plan")]
    path_topic: String,
    /// The topic of the arrows
    #[arg(long, value_name = "TOPIC", default_value = "/visualization_marker_array")]
    markers_topic: String,
    /// The markers' namespace, by which viewers can hide them
    #[arg(long, value_name = "NAME", default_value = "nav_path")]
    namespace: String,
    /// Length of an arrow along the path, metres
    #[arg(long, value_name = "M", default_value_t = 0.3, value_parser = size)]
    length: f64,
    /// From the tip of an arrow to that of the next, metres
    #[arg(long, value_name = "M", default_value_t = 0.5, value_parser = size)]
    spacing: f64,
    /// Width of an arrow, metres
    #[arg(long, value_name = "M", default_value_t = 0.08, value_parser = size)]
    width: f64,
    /// Thickness of an arrow, metres
    #[arg(long, value_name = "M", default_value_t = 0.01, value_parser = thickness)]
    thickness: f64,
    /// Height of the arrows above the path, metres
    #[arg(long, value_name = "M", default_value_t = 0.0, value_parser = height, allow_negative_numbers = true)]
    height: f64,
    /// Colour of the arrows: 'r; g; b' with each from 0 to 255, '#rrggbb' or a name
    #[arg(long, default_value = "#3399ff", value_parser = color)]
    color: [u8; 3],
    /// Colour of the last arrow
    #[arg(long, value_name = "COLOR", default_value = "#33cc33", value_parser = color)]
    goal_color: [u8; 3],
    /// Opacity, from 0 to 1
    #[arg(long, default_value_t = 1.0, value_parser = share)]
    alpha: f64,
    /// How long arrows stay when no plan follows, seconds; 0: until one does
    #[arg(long, value_name = "SECS", default_value_t = 0.0, value_parser = seconds)]
    lifetime: f64,
}

fn size(text: &str) -> Result<f64, String> {
    number_within(text, 0.01, 100.0)
}

fn thickness(text: &str) -> Result<f64, String> {
    number_within(text, 0.0001, 100.0)
}

fn height(text: &str) -> Result<f64, String> {
    number_within(text, -100.0, 100.0)
}

fn share(text: &str) -> Result<f64, String> {
    number_within(text, 0.0, 1.0)
}

fn seconds(text: &str) -> Result<f64, String> {
    number_within(text, 0.0, 86_400.0)
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    lifecycle::run_main(|_: Arguments| lifecycle::with_node("nav_path_markers", run))
}

fn run(node: &RosNode, end: &EndRequest) -> anyhow::Result<()> {
    let arguments: Arguments = with_parameters(node)?;
    let mut program = Program::start(node, &arguments)?;
    let subscription = node.subscribe(&arguments.path_topic, MessageKind::Path, 1)?;
    program.status.set(Level::Ok, &format!("no plan yet on {}", subscription.topic()), "");
    while !end.is_requested() {
        for event in node.events().wait(POLL_PERIOD) {
            if let NodeEvent::Message { message: AnyMessage::Path(path), .. } = event {
                program.show(&path)?;
            }
        }
        program.status.publish_if_due()?;
    }
    program.delete_all()
}

struct Program {
    layout: Layout,
    sequence: Sequence,
    markers: Publisher<MarkerArray>,
    status: NodeStatus,
    /// That of the arrows that are shown; none if there are none.
    frame_id: Option<String>,
}

impl Program {
    fn start(node: &RosNode, arguments: &Arguments) -> anyhow::Result<Self> {
        let look = Look {
            namespace: arguments.namespace.clone(),
            width_m: arguments.width,
            thickness_m: arguments.thickness,
            color: rgba(arguments.color, arguments.alpha),
            goal_color: rgba(arguments.goal_color, arguments.alpha),
            lifetime: Duration::from_secs_f64(arguments.lifetime),
        };
        Ok(Self {
            layout: Layout { length_m: arguments.length, spacing_m: arguments.spacing, height_m: arguments.height },
            sequence: Sequence::new(look),
            markers: node.latched_publisher(&arguments.markers_topic, 1)?,
            status: NodeStatus::start(node, "path")?,
            frame_id: None,
        })
    }

    /// Shows a plan in the place of the one before; one that cannot be shown takes the arrows away.
    fn show(&mut self, path: &Path) -> anyhow::Result<()> {
        let frame_id = frame_of(path);
        let Some(poses) = poses(path) else {
            self.status.set(Level::Error, "the plan has a pose that is not finite or not turned by a rotation", "");
            return self.delete_all();
        };
        if frame_id.is_empty() && !poses.is_empty() {
            self.status.set(Level::Error, "the plan has no frame_id", "");
            return self.delete_all();
        }
        let arrows = arrows::arrows(&poses, &self.layout);
        let (level, message) = match arrows.len() {
            0 => (Level::Ok, "the plan is empty"),
            MOST_ARROWS => (Level::Warn, "the plan has more arrows than are shown: those at its end are"),
            _ => (Level::Ok, "the plan is shown"),
        };
        self.status.set(level, message, &format!("{} poses in {frame_id}, {} arrows", poses.len(), arrows.len()));
        self.status.value("arrows", &arrows.len());
        self.status.value("frame", &frame_id);
        self.markers.send(self.sequence.show(&arrows, frame_id))?;
        self.frame_id = (!arrows.is_empty()).then(|| frame_id.to_owned());
        Ok(())
    }

    /// Deletes all arrows, and gives the message a moment to arrive.
    fn delete_all(&mut self) -> anyhow::Result<()> {
        self.status.value("arrows", &0);
        if let Some(frame_id) = self.frame_id.take() {
            self.markers.send(self.sequence.show(&[], &frame_id))?;
            std::thread::sleep(LAST_MESSAGE);
        }
        Ok(())
    }
}

/// The path's frame; where only its poses name one, theirs.
fn frame_of(path: &Path) -> &str {
    let of_poses = path.poses.first().map(|pose| pose.header.frame_id.as_str()).unwrap_or_default();
    if path.header.frame_id.is_empty() {
        of_poses
    } else {
        &path.header.frame_id
    }
}

/// The poses of a path; none if one of them is no place.
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
