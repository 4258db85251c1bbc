//! Publishes the cylinder as MoveIt's collision object and as a marker.

use clap::ValueEnum;
use rcs_messages::geometry_msgs::{Pose, Quaternion, Vector3};
use rcs_messages::moveit_msgs::{CollisionObject, MelodicCollisionObject, SolidPrimitive};
use rcs_messages::std_msgs::{ColorRGBA, Header};
use rcs_messages::visualization_msgs::Marker;
use rcs_messages::Time;
use rcs_ros::{NodeError, Publisher, RosNode};

use super::cylinder::Cylinder;
use crate::poses::pose_message;

/// Definition of moveit_msgs/CollisionObject that the planner uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum MoveitMsgs {
    /// The definition of the environment's ROS_DISTRO
    Auto,
    /// moveit_msgs 0.11 and newer
    Noetic,
    /// moveit_msgs 0.10 and older: Melodic, Kinetic
    Melodic,
}

/// Releases of ROS with moveit_msgs 0.10 and older.
const OLDER_RELEASES: [&str; 6] = ["melodic", "lunar", "kinetic", "jade", "indigo", "hydro"];

impl MoveitMsgs {
    /// `true` for the older definition. `ros_distro` is the environment's ROS_DISTRO.
    fn is_older(self, ros_distro: Option<&str>) -> bool {
        match self {
            Self::Auto => ros_distro.is_some_and(|distro| OLDER_RELEASES.contains(&distro)),
            Self::Noetic => false,
            Self::Melodic => true,
        }
    }
}

/// Id, frame and colour of both messages.
#[derive(Clone, Debug)]
pub(super) struct Naming {
    /// Id of the collision object and namespace of the marker.
    pub(super) id: String,
    /// The frame of both.
    pub(super) frame_id: String,
    /// Red, green, blue, alpha from 0 to 1.
    pub(super) color: [f32; 4],
}

enum Objects {
    Noetic(Publisher<CollisionObject>),
    Melodic(Publisher<MelodicCollisionObject>),
}

/// Publisher of both messages, latched for planners that start later.
pub(super) struct Announcement {
    naming: Naming,
    objects: Objects,
    markers: Publisher<Marker>,
}

impl Announcement {
    /// Opens the topics.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub(super) fn start(
        node: &RosNode,
        naming: Naming,
        moveit: MoveitMsgs,
        [object_topic, marker_topic]: [&str; 2],
    ) -> Result<Self, NodeError> {
        let objects = if moveit.is_older(std::env::var("ROS_DISTRO").ok().as_deref()) {
            Objects::Melodic(node.latched_publisher(object_topic, 1)?)
        } else {
            Objects::Noetic(node.latched_publisher(object_topic, 1)?)
        };
        Ok(Self { naming, objects, markers: node.latched_publisher(marker_topic, 1)? })
    }

    /// Replaces the published cylinder; `None` removes it.
    ///
    /// # Errors
    /// See [`Publisher::send`].
    pub(super) fn send(&self, cylinder: Option<&Cylinder>, stamp: Time) -> std::io::Result<()> {
        let object = self.naming.object(cylinder, stamp);
        match &self.objects {
            Objects::Noetic(topic) => topic.send(object)?,
            Objects::Melodic(topic) => topic.send(object.into())?,
        }
        self.markers.send(self.naming.marker(cylinder, stamp))
    }
}

impl Naming {
    fn header(&self, stamp: Time) -> Header {
        Header { seq: 0, stamp, frame_id: self.frame_id.clone() }
    }

    fn object(&self, cylinder: Option<&Cylinder>, stamp: Time) -> CollisionObject {
        let upright = Quaternion { w: 1.0, ..Quaternion::default() };
        let none = CollisionObject {
            header: self.header(stamp),
            pose: Pose { orientation: upright, ..Pose::default() },
            id: self.id.clone(),
            operation: CollisionObject::REMOVE,
            ..CollisionObject::default()
        };
        let Some(cylinder) = cylinder else { return none };
        let shape =
            SolidPrimitive { r#type: SolidPrimitive::CYLINDER, dimensions: vec![cylinder.length_m, cylinder.radius_m] };
        CollisionObject {
            primitives: vec![shape],
            primitive_poses: vec![pose_message(&cylinder.pose)],
            operation: CollisionObject::ADD,
            ..none
        }
    }

    fn marker(&self, cylinder: Option<&Cylinder>, stamp: Time) -> Marker {
        let [r, g, b, a] = self.color;
        let none = Marker {
            header: self.header(stamp),
            ns: self.id.clone(),
            type_: i32::from(Marker::CYLINDER),
            action: i32::from(Marker::DELETE),
            ..Marker::default()
        };
        let Some(cylinder) = cylinder else { return none };
        let diameter_m = 2.0 * cylinder.radius_m;
        Marker {
            action: i32::from(Marker::ADD),
            pose: pose_message(&cylinder.pose),
            scale: Vector3 { x: diameter_m, y: diameter_m, z: cylinder.length_m },
            color: ColorRGBA { r, g, b, a },
            ..none
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;

    #[test]
    fn the_definition_is_that_of_the_environments_release_of_ros() {
        let is_older = |distro| MoveitMsgs::Auto.is_older(distro);
        assert_eq!(
            [Some("melodic"), Some("kinetic"), Some("noetic"), Some("debian"), None].map(is_older),
            [true, true, false, false, false]
        );
        assert!(MoveitMsgs::Melodic.is_older(Some("noetic")) && !MoveitMsgs::Noetic.is_older(Some("melodic")));
    }

    #[test]
    fn both_messages_are_the_cylinder_or_its_removal() {
        let (id, frame_id) = ("beam".to_owned(), "base_link".to_owned());
        let naming = Naming { id, frame_id, color: [1.0, 1.0, 0.0, 0.3] };
        let cylinder = Cylinder { pose: Isometry3::translation(1.0, 2.0, 3.0), length_m: 1.5, radius_m: 0.05 };
        let object = naming.object(Some(&cylinder), Time::default());
        assert_eq!(
            (object.operation, &*object.id, &*object.header.frame_id),
            (CollisionObject::ADD, "beam", "base_link")
        );
        assert_eq!(object.primitives[0].dimensions, [1.5, 0.05], "height, radius");
        assert_eq!((object.primitives[0].r#type, object.primitive_poses[0].position.z), (3, 3.0));
        assert_eq!((object.pose.orientation.w, object.primitive_poses[0].orientation.w), (1.0, 1.0));
        let marker = naming.marker(Some(&cylinder), Time::default());
        assert_eq!((marker.scale.x, marker.scale.z, marker.pose.position.y), (0.1, 1.5, 2.0));
        let gone = naming.object(None, Time::default());
        assert_eq!((gone.operation, gone.primitives.len(), &*gone.id), (CollisionObject::REMOVE, 0, "beam"));
        assert_eq!(naming.marker(None, Time::default()).action, i32::from(Marker::DELETE));
    }
}
