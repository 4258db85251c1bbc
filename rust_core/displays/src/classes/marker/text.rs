//! TEXT_VIEW_FACING: text around the marker's position, `scale.z` high.

use std::sync::Arc;

use nalgebra::Matrix4;
use rcs_messages::visualization_msgs::Marker;
use rcs_scene::{Geometry, HorizontalAlignment, Text, VerticalAlignment};

use super::message_fields::rgba;
use super::primitive::Primitive;

/// The text, centred both ways.
pub(super) fn primitives(marker: &Marker) -> Vec<Primitive> {
    let alignment = (HorizontalAlignment::Center, VerticalAlignment::Center);
    let text = Text::new(&marker.text, marker.scale.z as f32, rgba(&marker.color), alignment);
    vec![Primitive::new(Matrix4::identity(), Geometry::Text(Arc::new(text)))]
}
