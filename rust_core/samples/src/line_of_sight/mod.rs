//! `line_of_sight`: the projector's beam to its target as a collision object, so that an arm plans around it.

mod announcement;
mod cylinder;

use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::{Command, CommandFactory, Parser};
use nalgebra::Point3;
use rcs_ros::{NodeEvent, RosNode};
use rcs_transforms::{Time, TransformTree};

use crate::target::{Target, TargetArguments};
use announcement::{Announcement, MoveitMsgs, Naming};
use cylinder::{Cylinder, CylinderShape};
use rcs_node_support::frames;
use rcs_node_support::lifecycle::{self, EndRequest};
use rcs_node_support::node_options::{color, rgba, with_parameters, within};
use rcs_node_support::node_status::{Level, NodeStatus};
use rcs_node_support::ros_names::{publishes, subscribes, RosName};

/// Topics of the node.
pub const ROS_NAMES: &[RosName] = &[
    subscribes(
        "TARGET",
        "geometry_msgs/PoseStamped, geometry_msgs/PointStamped or sensor_msgs/PointCloud2",
        "the target, unless it is a frame",
    ),
    subscribes("/tf, /tf_static", "tf2_msgs/TFMessage", "frames of lens and target"),
    publishes("/collision_object", "moveit_msgs/CollisionObject", "the cylinder, latched: added, moved, removed"),
    publishes("/line_of_sight_marker", "visualization_msgs/Marker", "the cylinder, latched"),
    publishes("/diagnostics", "diagnostic_msgs/DiagnosticArray", "whether there is a line of sight, and why not"),
];

/// Time for the last messages to reach their subscribers.
const FLUSH_TIME: Duration = Duration::from_millis(200);

/// Publishes the cylinder between a projector's lens and its target as a collision object of MoveIt's planning scene,
/// and as a marker.
///
/// An arm then plans around the light. The cylinder is removed when the target is gone and when the node ends. Every
/// option may be given as a private parameter, too: --target-frame is ~target_frame. ROS's remappings and special
/// arguments work.
#[derive(Parser)]
#[command(
    name = "line_of_sight",
    display_name = "rviz_camera_stream",
    version,
    before_help = "\
Examples:
  line_of_sight --target-cloud /widget/desired_object --radius 0.08",
    after_help = "\
Topics subscribed to: the target, /tf, /tf_static
Topics published: the collision object (moveit_msgs/CollisionObject, latched), the marker (visualization_msgs/Marker, \
latched), /diagnostics
Exit codes: 0 ended by SIGINT, SIGTERM or rosnode kill; 1 a parameter or the node failed; 2 invalid arguments"
)]
struct LineOfSightArguments {
    #[command(flatten)]
    target: TargetArguments,
    /// Frame of the projector's lens
    #[arg(long, value_name = "FRAME", default_value = "proj_view")]
    lens_frame: String,
    /// Radius of the cylinder [m]
    #[arg(long, value_name = "M", default_value_t = 0.05, value_parser = within(0.001, 10.0))]
    radius: f64,
    /// Gap at the lens, for the projector itself [m]
    #[arg(long, value_name = "M", default_value_t = 0.15, value_parser = within(0.0, 100.0))]
    lens_gap: f64,
    /// Gap at the target, which the arm may grasp [m]
    #[arg(long, value_name = "M", default_value_t = 0.1, value_parser = within(0.0, 100.0))]
    target_gap: f64,
    /// Publish the cylinder again when an end has moved by more than this [m]
    #[arg(long, value_name = "M", default_value_t = 0.01, value_parser = within(0.0, 100.0))]
    tolerance: f64,
    /// Id of the collision object and namespace of the marker
    #[arg(long, value_name = "NAME", default_value = "line_of_sight")]
    id: String,
    /// Topic of the collision object
    #[arg(long, value_name = "TOPIC", default_value = "/collision_object")]
    object_topic: String,
    /// Topic of the marker
    #[arg(long, value_name = "TOPIC", default_value = "/line_of_sight_marker")]
    marker_topic: String,
    /// Definition of moveit_msgs/CollisionObject that the planner uses
    #[arg(long, value_enum, default_value_t = MoveitMsgs::Auto)]
    moveit_msgs: MoveitMsgs,
    /// Colour of the marker: 'r; g; b' with each from 0 to 255, '#rrggbb' or a name
    #[arg(long, default_value = "#ffcc00", value_parser = color)]
    color: [u8; 3],
    /// Opacity of the marker, from 0 to 1
    #[arg(long, default_value_t = 0.3, value_parser = within(0.0, 1.0))]
    alpha: f64,
    /// How often the line is looked at, Hz
    #[arg(long, value_name = "HZ", default_value_t = 10.0, value_parser = within(0.1, 100.0))]
    rate: f64,
}

/// The command line.
pub fn command() -> Command {
    LineOfSightArguments::command()
}

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    lifecycle::run_main(|_: LineOfSightArguments| {
        lifecycle::with_node("line_of_sight", |node, end| follow(node, end, &with_parameters(node)?))
    })
}

/// Updates the cylinder until the shutdown is requested.
fn follow(node: &RosNode, end: &EndRequest, arguments: &LineOfSightArguments) -> anyhow::Result<()> {
    let given = &arguments.target;
    let mut target = Target::start(node, given.source()?, &given.fixed_frame, given.timeout())?;
    let mut line = PublishedLine::start(node, arguments)?;
    let mut tree = TransformTree::new();
    node.subscribe_transforms()?;
    let period = Duration::from_secs_f64(1.0 / arguments.rate);
    let mut updated = Instant::now();
    while !end.is_requested() {
        let left = period.saturating_sub(updated.elapsed());
        frames::take_events(node, left, &mut tree, |event| {
            if let NodeEvent::Message { topic, message, received, .. } = event {
                target.take(&topic, &message, received);
            }
        });
        if updated.elapsed() >= period {
            updated = Instant::now();
            line.update(node, &mut target, &tree)?;
        }
    }
    line.remove(node)
}

/// The published cylinder and its topics.
struct PublishedLine<'a> {
    arguments: &'a LineOfSightArguments,
    timeout: Option<Duration>,
    announcement: Announcement,
    status: NodeStatus,
    published: Option<Cylinder>,
}

impl<'a> PublishedLine<'a> {
    fn start(node: &RosNode, arguments: &'a LineOfSightArguments) -> anyhow::Result<Self> {
        let naming = Naming {
            id: arguments.id.clone(),
            frame_id: arguments.target.fixed_frame.clone(),
            color: rgba(arguments.color, arguments.alpha),
        };
        let topics = [arguments.object_topic.as_str(), &arguments.marker_topic];
        let announcement = Announcement::start(node, naming, arguments.moveit_msgs, topics)?;
        // A node that was killed may have left its latched cylinder.
        announcement.send(None, node.now())?;
        let status = NodeStatus::start(node, "line of sight")?;
        Ok(Self { arguments, timeout: arguments.target.timeout(), announcement, status, published: None })
    }

    fn update(&mut self, node: &RosNode, target: &mut Target, tree: &TransformTree) -> anyhow::Result<()> {
        match self.cylinder(target, tree, frames::now(node)) {
            Ok(cylinder) => {
                let is_moved = |published: &Cylinder| cylinder.moved_from(published) > self.arguments.tolerance;
                if self.published.as_ref().is_none_or(is_moved) {
                    self.announcement.send(Some(&cylinder), node.now())?;
                    self.published = Some(cylinder);
                }
                self.status.set(Level::Ok, "the line of sight is in the planning scene", "");
                self.status.value("length, metres", &format!("{:.3}", cylinder.length_m));
            }
            Err(reason) => {
                if self.published.take().is_some() {
                    self.announcement.send(None, node.now())?;
                }
                self.status.set(Level::Warn, &format!("no line of sight: {reason}"), "");
                self.status.value("length, metres", &0);
            }
        }
        Ok(self.status.publish_if_due()?)
    }

    /// The cylinder from the lens to the target now.
    ///
    /// # Errors
    /// A missing frame or target, as a status message.
    fn cylinder(&self, target: &mut Target, tree: &TransformTree, now: Time) -> Result<Cylinder, String> {
        let place = target.position(tree, now).map_err(|error| error.to_string())?;
        let lens_frame = &self.arguments.lens_frame;
        let found = tree.lookup_stamped(target.fixed_frame(), lens_frame, Time::ZERO);
        let (fixed_from_lens, stamp) = found.map_err(|error| error.to_string())?;
        let is_current = |timeout: Duration| now.secs_since(stamp) <= timeout.as_secs_f64();
        if stamp != Time::ZERO && !self.timeout.is_none_or(is_current) {
            return Err(format!("the lens frame {lens_frame} is stale"));
        }
        let shape = CylinderShape {
            radius_m: self.arguments.radius,
            lens_gap_m: self.arguments.lens_gap,
            target_gap_m: self.arguments.target_gap,
        };
        let lens = Point3::from(fixed_from_lens.translation.vector);
        Cylinder::between(lens, place, &shape).ok_or_else(|| "the target is too close to the lens".to_owned())
    }

    /// Removes the cylinder and waits for the messages to arrive.
    fn remove(&mut self, node: &RosNode) -> anyhow::Result<()> {
        if self.published.take().is_some() {
            self.announcement.send(None, node.now())?;
            std::thread::sleep(FLUSH_TIME);
        }
        Ok(())
    }
}
