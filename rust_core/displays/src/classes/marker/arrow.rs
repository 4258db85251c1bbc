//! ARROW: along x with the marker's scale, or between two points.
//!
//! An arrow that is sent again with the same id keeps the values that its new form does not set, as in rviz: one by two
//! points the scale of an earlier one by pose, one by pose the start of an earlier one by two points.

use nalgebra::{Matrix4, Vector3};
use rcs_messages::visualization_msgs::Marker;
use rcs_scene::Rgba;

use super::message_fields::{position, rgba, scale};
use super::primitive::Parts;
use crate::parts::solids::{arrow_from_upright, arrow_pose, ArrowSize};

/// Proportions of an arrow by pose; the scale makes it slender.
const BY_POSE: ArrowSize =
    ArrowSize { shaft_length_m: 0.77, shaft_diameter_m: 1.0, head_length_m: 0.23, head_diameter_m: 2.0 };

/// Share of the head in the length of an arrow by two points without a head length.
const HEAD_SHARE: f64 = 0.23;

/// State of an arrow marker between messages.
#[derive(Clone, Debug)]
pub(super) struct ArrowMarker {
    start: Vector3<f64>,
    scale: [f64; 3],
    by_pose: Option<Rgba>,
}

impl Default for ArrowMarker {
    fn default() -> Self {
        Self { start: Vector3::zeros(), scale: [1.0; 3], by_pose: None }
    }
}

impl ArrowMarker {
    /// `true` if a message repeats the current arrow by pose.
    pub(super) fn is_unchanged(&self, marker: &Marker) -> bool {
        let asks = (marker.points.len() != 2, scale(marker), Some(rgba(&marker.color)));
        self.by_pose.is_some() && asks == (true, self.scale, self.by_pose)
    }

    pub(super) fn parts(&mut self, marker: &Marker) -> Parts {
        let color = rgba(&marker.color);
        self.by_pose = None;
        let (direction, size) = match marker.points.as_slice() {
            [start, end] => {
                let [start, end] = [start, end].map(|point| Vector3::from(position(point)).cast::<f64>());
                self.start = start;
                (end - start, size_by_points(marker, (end - start).norm()))
            }
            _ => {
                (self.scale, self.by_pose) = (scale(marker), Some(color));
                (Vector3::x(), BY_POSE)
            }
        };
        // In the arrow's frame −z points forward and x is up.
        let [length, sideways, upwards] = self.scale;
        let marker_from_arrow = arrow_pose(self.start, &direction)
            * Matrix4::new_nonuniform_scaling(&Vector3::new(upwards, sideways, length));
        let marker_from_upright = marker_from_arrow * arrow_from_upright();
        let parts = size.upright_from_parts();
        Parts::solids(color, parts.map(|(shape, upright_from_part)| (shape, marker_from_upright * upright_from_part)))
    }
}

fn size_by_points(marker: &Marker, distance_m: f64) -> ArrowSize {
    let [shaft_diameter_m, head_diameter_m, head_length_m] = scale(marker);
    let head_length_m =
        if head_length_m == 0.0 { HEAD_SHARE * distance_m } else { head_length_m.min(distance_m).max(0.0) };
    ArrowSize { shaft_length_m: distance_m - head_length_m, shaft_diameter_m, head_length_m, head_diameter_m }
}
