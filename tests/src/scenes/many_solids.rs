//! Very many small solids and labels, as the bytes of one message each: markers, poses of a path, a long text.
//!
//! Everything stands in the view of [`CAMERA`], 2 to 6 metres away, so that a marker of 5 cm covers some 4 to 12
//! pixels; but for poses as lines, which are all round it.

use nalgebra::{UnitQuaternion, Vector3};
use rcs_messages::geometry_msgs::{Pose, PoseArray, PoseStamped};
use rcs_messages::nav_msgs::Path;
use rcs_messages::visualization_msgs::{Marker, MarkerArray};
use rcs_messages::{AnyMessage, MessageKind, RosMsg};
use rcs_scene::{Camera, CameraError};

use super::rendering::camera;

/// The image's width and height, and the focal length, in pixels.
pub const CAMERA: ([u32; 2], f64) = ([640, 480], 500.0);

/// A kind of scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Markers of one type.
    Markers(u8),
    /// Spheres, each with a label over it.
    LabelledSpheres,
    /// Poses of a path, as axes.
    PathAxes,
    /// Poses of a path, as arrows.
    PathArrows,
    /// Poses of a path round the camera, as one line.
    PathLine,
    /// Poses of an array, as solid arrows.
    PoseArrows,
    /// Poses of an array round the camera, as three lines each.
    FlatArrows,
    /// One text marker of this number of characters in lines of a thousand.
    Text,
}

/// A scene and how many things are in it.
#[derive(Clone, Copy, Debug)]
pub struct ManySolids {
    /// What is in it.
    pub content: Content,
    /// How many markers, poses or characters.
    pub count: usize,
}

fn pose(number: usize, shift_m: f64) -> Pose {
    let share = |step: f64| (number as f64 * step).fract();
    let z = 2.0 + 4.0 * share(0.819_172_513_396_164_4);
    let (u, v) = (share(0.754_877_666_246_693) - 0.5, share(0.569_840_290_998_053) - 0.5);
    let mut pose = Pose::default();
    (pose.position.x, pose.position.y, pose.position.z) = (u * 1.2 * z + shift_m, v * 0.9 * z, z);
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(u, v, z) * 3.0);
    let [x, y, z, w] = turn.coords.into();
    (pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w) = (x, y, z, w);
    pose
}

/// Up to 2 m away from the camera, on all sides.
fn pose_around(number: usize, shift_m: f64) -> Pose {
    let mut pose = pose(number, shift_m);
    let share = |step: f64| (number as f64 * step).fract() * 4.0 - 2.0;
    let position = &mut pose.position;
    (position.x, position.y) = (share(0.754_877_666_246_693) + shift_m, share(0.569_840_290_998_053));
    position.z = share(0.819_172_513_396_164_4);
    pose
}

fn marker(marker_type: u8, number: usize, shift_m: f64) -> Marker {
    let mut marker =
        Marker { type_: marker_type.into(), id: number as i32, ns: "many".to_owned(), ..Marker::default() };
    marker.header.frame_id = "map".to_owned();
    marker.pose = pose(number, shift_m);
    let size_m = if marker_type == Marker::ARROW { [0.1, 0.01, 0.01] } else { [0.05; 3] };
    [marker.scale.x, marker.scale.y, marker.scale.z] = size_m;
    let level = |step: usize| 0.2 + (number * step % 80) as f32 / 100.0;
    (marker.color.r, marker.color.g, marker.color.b, marker.color.a) = (level(37), level(91), level(53), 1.0);
    if marker_type == Marker::TEXT_VIEW_FACING {
        marker.text = format!("item {number}");
    }
    marker
}

impl ManySolids {
    /// The displays of a config that show it.
    pub fn config(&self) -> String {
        let display = match self.content {
            Content::PathAxes => "Class: rviz/Path, Topic: /many, Pose Style: Axes, Length: 0.06, Radius: 0.006",
            Content::PathArrows => {
                "Class: rviz/Path, Topic: /many, Pose Style: Arrows, Shaft Length: 0.06, Head Length: 0.03, \
                 Shaft Diameter: 0.01, Head Diameter: 0.02"
            }
            Content::PathLine => "Class: rviz/Path, Topic: /many, Line Style: Lines",
            Content::FlatArrows => "Class: rviz/PoseArray, Topic: /many, Shape: Arrow (Flat), Arrow Length: 0.06",
            Content::PoseArrows => {
                "Class: rviz/PoseArray, Topic: /many, Shape: Arrow (3D), Shaft Length: 0.06, Head Length: 0.03, \
                 Shaft Radius: 0.01, Head Radius: 0.02"
            }
            _ => "Class: rviz/MarkerArray, Marker Topic: /many",
        };
        format!("  - {{{display}, Name: many, Enabled: true}}\n")
    }

    /// The message as it is sent; `shift_m` moves all of it sideways.
    pub fn bytes(&self, shift_m: f64) -> Vec<u8> {
        let numbers = 0..self.count;
        match self.content {
            Content::Markers(marker_type) => array(numbers.map(|number| marker(marker_type, number, shift_m))),
            Content::LabelledSpheres => array(numbers.map(|number| {
                let kind = if number % 2 == 0 { Marker::SPHERE } else { Marker::TEXT_VIEW_FACING };
                let mut marker = marker(kind, number, shift_m);
                marker.pose = pose(number / 2, shift_m);
                marker
            })),
            Content::Text => {
                let mut text = marker(Marker::TEXT_VIEW_FACING, 0, shift_m);
                text.pose = Pose::default();
                text.pose.position.z = 4.0;
                let letter = |number| if number % 1000 == 999 { '\n' } else { char::from(b'!' + (number % 90) as u8) };
                text.text = numbers.map(letter).collect();
                array(std::iter::once(text))
            }
            Content::PathAxes | Content::PathArrows | Content::PathLine => {
                let place = if self.content == Content::PathLine { pose_around } else { pose };
                let mut path = Path::default();
                path.header.frame_id = "map".to_owned();
                path.poses =
                    numbers.map(|i| PoseStamped { pose: place(i, shift_m), ..PoseStamped::default() }).collect();
                encoded(&path)
            }
            Content::PoseArrows | Content::FlatArrows => {
                let place = if self.content == Content::FlatArrows { pose_around } else { pose };
                let mut poses = PoseArray::default();
                poses.header.frame_id = "map".to_owned();
                poses.poses = numbers.map(|number| place(number, shift_m)).collect();
                encoded(&poses)
            }
        }
    }

    /// The message's type.
    pub fn kind(&self) -> MessageKind {
        match self.content {
            Content::PathAxes | Content::PathArrows | Content::PathLine => MessageKind::Path,
            Content::PoseArrows | Content::FlatArrows => MessageKind::PoseArray,
            _ => MessageKind::MarkerArray,
        }
    }

    /// What takes all of it away.
    pub fn removal(&self) -> AnyMessage {
        match self.content {
            Content::PathAxes | Content::PathArrows | Content::PathLine => {
                let mut path = Path::default();
                path.header.frame_id = "map".to_owned();
                AnyMessage::Path(path.into())
            }
            Content::PoseArrows | Content::FlatArrows => {
                let mut poses = PoseArray::default();
                poses.header.frame_id = "map".to_owned();
                AnyMessage::PoseArray(poses.into())
            }
            _ => {
                let mut all = Marker { action: Marker::DELETEALL.into(), ..Marker::default() };
                all.header.frame_id = "map".to_owned();
                AnyMessage::MarkerArray(MarkerArray { markers: vec![all] }.into())
            }
        }
    }
}

/// The camera that sees everything.
///
/// # Errors
/// None for its numbers.
pub fn many_solids_camera() -> Result<Camera, CameraError> {
    camera(CAMERA.0, CAMERA.1)
}

/// A MarkerArray's bytes, written one marker at a time.
fn array(markers: impl Iterator<Item = Marker>) -> Vec<u8> {
    let mut bytes = vec![0; 4];
    let mut count = 0_u32;
    for marker in markers {
        bytes.extend(encoded(&marker));
        count += 1;
    }
    bytes[..4].copy_from_slice(&count.to_le_bytes());
    bytes
}

/// A message's bytes without the length that goes before them.
fn encoded(message: &impl RosMsg) -> Vec<u8> {
    let mut bytes = Vec::new();
    // Writing to memory does not fail.
    let _ = message.encode(&mut bytes);
    bytes
}
