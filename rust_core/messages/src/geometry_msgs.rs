//! `geometry_msgs`: lengths in metres, quaternions in the order x, y, z, w.

use crate::message::ros_message;
use crate::std_msgs::Header;

ros_message! {
    /// A point in space.
    "geometry_msgs/Point" "4a842b65f413084dc2b10fb484ea7f17" struct Point {
        x: f64,
        y: f64,
        z: f64,
    }

    /// A point in space, in single precision.
    "geometry_msgs/Point32" "cc153912f1453b708d221682bc23d9ac" struct Point32 {
        x: f32,
        y: f32,
        z: f32,
    }

    /// A vector in space.
    "geometry_msgs/Vector3" "4a842b65f413084dc2b10fb484ea7f17" struct Vector3 {
        x: f64,
        y: f64,
        z: f64,
    }

    /// A rotation. The default is all zeros, as in ROS, which is no rotation at all.
    "geometry_msgs/Quaternion" "a779879fadf0160734f906b8c19c7004" struct Quaternion {
        x: f64,
        y: f64,
        z: f64,
        w: f64,
    }

    /// A place and a rotation.
    "geometry_msgs/Pose" "e45d45a5a1ce597b249e23fb30fc871f" struct Pose {
        position: Point,
        orientation: Quaternion,
    }

    /// A pose in a frame.
    "geometry_msgs/PoseStamped" "d3812c3cbc69362b77dc0b19b345f8f5" struct PoseStamped {
        header: Header,
        pose: Pose,
    }

    /// Poses in one frame.
    "geometry_msgs/PoseArray" "916c28c5764443f268b296bb671b9d97" struct PoseArray {
        header: Header,
        poses: Vec<Pose>,
    }

    /// A point in a frame.
    "geometry_msgs/PointStamped" "c63aecb41bfdfd6b7e1fac37c7cbe7bf" struct PointStamped {
        header: Header,
        point: Point,
    }

    /// A translation and a rotation.
    "geometry_msgs/Transform" "ac9eff44abf714214112b05d54a3cf9b" struct Transform {
        translation: Vector3,
        rotation: Quaternion,
    }

    /// Where the frame `child_frame_id` is in the frame of the header.
    "geometry_msgs/TransformStamped" "b5764a33bfeb3588febc2682852579b0" struct TransformStamped {
        header: Header,
        child_frame_id: String,
        transform: Transform,
    }

    /// A closed outline.
    "geometry_msgs/Polygon" "cd60a26494a087f577976f0329fa120e" struct Polygon {
        points: Vec<Point32>,
    }

    /// An outline in a frame.
    "geometry_msgs/PolygonStamped" "c6be8f7dc3bee7fe9e8d296070f53340" struct PolygonStamped {
        header: Header,
        polygon: Polygon,
    }
}
