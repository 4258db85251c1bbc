//! `rviz/Polygon`: the outline of the last polygon of a topic.
//!
//! Its opacity has no effect: rviz's material for it replaces what is behind.

use std::sync::Arc;

use nalgebra::Isometry3;
use rcs_messages::geometry_msgs::PolygonStamped;
use rcs_rviz_config::PlainColorSettings;
use rcs_scene::{Blending, DisplayId, Geometry, LineTopology, Lines, Rgba};

use crate::framework::message_display::{DrawResult, InvalidFloats, MessageDisplay, MessageVisual};
use crate::parts::solids::drawable;

#[derive(Debug)]
pub(crate) struct PolygonVisual {
    display: DisplayId,
    color: [u8; 4],
}

pub(crate) fn create(display: DisplayId, settings: &PlainColorSettings) -> MessageDisplay<PolygonVisual> {
    let color = Rgba::from_rgb8(settings.color, settings.alpha).to_rgba8();
    let visual = PolygonVisual { display, color };
    MessageDisplay::new(&settings.topic, settings.queue_size, Some(1), visual)
}

impl MessageVisual for PolygonVisual {
    type Message = PolygonStamped;

    fn draw(&mut self, message: &PolygonStamped, fixed_from_frame: &Isometry3<f64>) -> DrawResult {
        let corners = message.polygon.points.iter().map(|point| [point.x, point.y, point.z]);
        let mut positions: Vec<[f32; 3]> = corners.collect();
        if positions.iter().flatten().any(|coordinate| !coordinate.is_finite()) {
            return Err(InvalidFloats);
        }
        positions.extend(positions.first().copied());
        let lines =
            Lines { positions, colors: vec![self.color], topology: LineTopology::Strip, blending: Blending::Replace };
        let geometry = Geometry::Lines(Arc::new(lines));
        Ok(Some(vec![drawable(self.display, fixed_from_frame.to_homogeneous(), geometry)]))
    }
}
