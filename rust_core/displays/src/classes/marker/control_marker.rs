//! A marker of an interactive marker's control: its primitives and pose, without namespace, action and lifetime.

use nalgebra::Isometry3;
use rcs_messages::visualization_msgs::Marker;
use rcs_resources::MeshStore;

use super::checks::check_marker;
use super::kind::MarkerKind;
use super::mesh::NotShown;
use super::primitive::{Parts, Primitive};

/// The primitives of a marker, and its pose in the frame of its header.
#[derive(Clone, Debug)]
pub(crate) struct ControlMarker {
    pub(crate) frame_from_marker: Isometry3<f64>,
    /// Empty while the marker's mesh is missing.
    pub(crate) parts: Vec<Primitive>,
    kind: MarkerKind,
}

impl ControlMarker {
    /// Builds a new marker. `None` for one that rviz refuses. Returns also why a valid marker shows nothing: its mesh
    /// is loading, or cannot be loaded.
    pub(crate) fn of(marker: &Marker, meshes: &MeshStore) -> Option<(Self, Option<NotShown>)> {
        if check_marker(marker).is_fatal() {
            return None;
        }
        let mut kind = MarkerKind::of(marker)?;
        let frame_from_marker = kind.frame_from_marker(marker)?;
        let (parts, not_shown) = split(kind.parts(marker, meshes));
        Some((Self { frame_from_marker, parts, kind }, not_shown))
    }

    /// `true` if the marker's mesh is loading or cannot be shown.
    pub(crate) fn is_missing(&self) -> bool {
        self.kind.is_missing()
    }

    /// Rebuilds a marker whose mesh was missing. Returns why it still shows nothing.
    pub(crate) fn rebuild(&mut self, meshes: &MeshStore) -> Option<NotShown> {
        let (parts, not_shown) = split(self.kind.rebuild(meshes));
        self.parts = parts;
        not_shown
    }
}

fn split(built: Result<Parts, NotShown>) -> (Vec<Primitive>, Option<NotShown>) {
    match built {
        Ok(parts) => (parts.into_primitives(), None),
        Err(not_shown) => (Vec::new(), Some(not_shown)),
    }
}
