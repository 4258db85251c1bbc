//! A marker of an interactive marker's control: its primitives and pose, without namespace, action and lifetime.

use nalgebra::Isometry3;
use rcs_messages::visualization_msgs::Marker;
use rcs_resources::MeshStore;

use super::checks::check_marker;
use super::kind::Kind;
use super::primitive::Primitive;

/// The primitives of a marker, and its pose in the frame of its header.
#[derive(Clone, Debug)]
pub(crate) struct ControlMarker {
    pub(crate) frame_from_marker: Isometry3<f64>,
    pub(crate) parts: Vec<Primitive>,
}

impl ControlMarker {
    /// Builds a marker as rviz draws a new one. `None` for one that rviz refuses.
    ///
    /// # Errors
    /// Why a marker that is in order shows nothing (its mesh cannot be loaded).
    pub(crate) fn of(marker: &Marker, meshes: &MeshStore) -> Result<Option<Self>, String> {
        if check_marker(marker).is_fatal() {
            return Ok(None);
        }
        let Some(mut kind) = Kind::of(marker) else { return Ok(None) };
        let Some(frame_from_marker) = kind.frame_from_marker(marker) else { return Ok(None) };
        Ok(Some(Self { frame_from_marker, parts: kind.primitives(marker, meshes)? }))
    }
}
