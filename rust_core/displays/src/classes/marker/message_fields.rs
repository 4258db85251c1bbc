//! The fields of a marker's message as rviz reads them: in single precision.

use rcs_messages::geometry_msgs::Point;
use rcs_messages::std_msgs::ColorRGBA;
use rcs_messages::visualization_msgs::Marker;
use rcs_messages::{point_xyz, translation_xyz};
use rcs_scene::Rgba;

/// A colour, not clamped.
pub(super) fn rgba(color: &ColorRGBA) -> Rgba {
    Rgba::new(color.r, color.g, color.b, color.a)
}

/// A point in metres; values past single precision become infinite.
pub(super) fn position(point: &Point) -> [f32; 3] {
    point_xyz(point).map(|coordinate| coordinate as f32)
}

/// The marker's scale in metres.
pub(super) fn scale(marker: &Marker) -> [f64; 3] {
    translation_xyz(&marker.scale)
}

/// Tolerance of a quaternion's squared length.
const QUATERNION_TOLERANCE: f64 = 10e-3;

/// `true` if a quaternion is a rotation, within rviz's tolerance.
pub(crate) fn is_unit_quaternion(xyzw: [f64; 4]) -> bool {
    let squared_length: f64 = xyzw.iter().map(|value| value * value).sum();
    (squared_length - 1.0).abs() < QUATERNION_TOLERANCE
}

pub(crate) fn is_finite_color(color: &ColorRGBA) -> bool {
    [color.r, color.g, color.b, color.a].iter().all(|channel| channel.is_finite())
}

/// Colours of the points, if their number matches.
pub(super) fn point_colors(marker: &Marker) -> Option<&[ColorRGBA]> {
    (!marker.colors.is_empty() && marker.colors.len() == marker.points.len()).then_some(&marker.colors)
}
