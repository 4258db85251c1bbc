//! `visualization_msgs`.

use crate::geometry_msgs::{Point, Pose, Vector3};
use crate::message::ros_message;
use crate::std_msgs::{ColorRGBA, Header};
use crate::Duration;

ros_message! {
    /// One thing to draw, or to take away again.
    "visualization_msgs/Marker" "4048c9de2a16f4ae8e0538085ebf1b97" struct Marker {
        [
            ARROW: u8 = 0,
            CUBE: u8 = 1,
            SPHERE: u8 = 2,
            CYLINDER: u8 = 3,
            LINE_STRIP: u8 = 4,
            LINE_LIST: u8 = 5,
            CUBE_LIST: u8 = 6,
            SPHERE_LIST: u8 = 7,
            POINTS: u8 = 8,
            TEXT_VIEW_FACING: u8 = 9,
            MESH_RESOURCE: u8 = 10,
            TRIANGLE_LIST: u8 = 11,
            ADD: u8 = 0,
            MODIFY: u8 = 0,
            DELETE: u8 = 2,
            DELETEALL: u8 = 3,
        ]
        header: Header,
        ns: String,
        id: i32,
        type_: i32,
        action: i32,
        pose: Pose,
        scale: Vector3,
        color: ColorRGBA,
        lifetime: Duration,
        frame_locked: bool,
        points: Vec<Point>,
        colors: Vec<ColorRGBA>,
        text: String,
        mesh_resource: String,
        mesh_use_embedded_materials: bool,
    }

    /// Several markers at once.
    "visualization_msgs/MarkerArray" "d155b9ce5188fbaf89745847fd5882d7" struct MarkerArray {
        markers: Vec<Marker>,
    }
}
