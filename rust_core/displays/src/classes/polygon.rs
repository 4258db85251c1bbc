//! `rviz/Polygon`: the outline of the last polygon of a topic.
//!
//! Its opacity has no effect: rviz's material for it replaces what is behind.

use std::sync::Arc;

use nalgebra::Isometry3;
use rcs_messages::geometry_msgs::PolygonStamped;
use rcs_rviz_config::PlainColorSettings;
use rcs_scene::{Blending, DisplayId, Drawable, Geometry, LineTopology, Lines, Rgba};

use crate::framework::display::Display;
use crate::framework::message_display::{InvalidFloats, MessageDisplay, MessageVisual};
use crate::parts::solids::drawable;

/// A Polygon display.
pub(crate) type PolygonDisplay = MessageDisplay<PolygonVisual>;

/// What a Polygon display draws.
#[derive(Debug)]
pub(crate) struct PolygonVisual {
    display: DisplayId,
    color: [u8; 4],
    drawables: Vec<Drawable>,
}

/// Makes a Polygon display.
pub(crate) fn create(display: DisplayId, settings: &PlainColorSettings) -> Box<dyn Display> {
    Box::new(PolygonDisplay::of(display, settings))
}

impl PolygonDisplay {
    /// A display that has no message yet.
    pub(crate) fn of(display: DisplayId, settings: &PlainColorSettings) -> Self {
        let color = Rgba::from_rgb8(settings.color, settings.alpha).to_rgba8();
        let visual = PolygonVisual { display, color, drawables: Vec::new() };
        Self::new(&settings.topic, settings.queue_size, visual)
    }
}

impl MessageVisual for PolygonVisual {
    type Message = PolygonStamped;

    fn show(&mut self, message: &PolygonStamped, fixed_from_frame: &Isometry3<f64>) -> Result<bool, InvalidFloats> {
        let corners = message.polygon.points.iter().map(|point| [point.x, point.y, point.z]);
        let mut positions: Vec<[f32; 3]> = corners.collect();
        if positions.iter().flatten().any(|coordinate| !coordinate.is_finite()) {
            return Err(InvalidFloats);
        }
        positions.extend(positions.first().copied());
        let lines =
            Lines { positions, colors: vec![self.color], topology: LineTopology::Strip, blending: Blending::Replace };
        let geometry = Geometry::Lines(Arc::new(lines));
        self.drawables = vec![drawable(self.display, fixed_from_frame.to_homogeneous(), geometry)];
        Ok(true)
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn clear(&mut self) {
        self.drawables.clear();
    }
}
