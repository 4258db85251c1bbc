//! TEXT_VIEW_FACING: text around the marker's position, `scale.z` high.

use std::sync::Arc;

use rcs_messages::visualization_msgs::Marker;
use rcs_scene::{HorizontalAlignment, Text, VerticalAlignment};

use super::message_fields::rgba;
use super::primitive::Parts;

pub(super) fn parts(marker: &Marker) -> Parts {
    let alignment = (HorizontalAlignment::Center, VerticalAlignment::Center);
    Parts::Text(Arc::new(Text::new(&marker.text, marker.scale.z as f32, rgba(&marker.color), alignment)))
}
