//! The kinds of markers, and their primitives.

use std::sync::Arc;

use nalgebra::Isometry3;
use rcs_messages::visualization_msgs::Marker;
use rcs_messages::PlainTransform;
use rcs_resources::MeshStore;
use rcs_scene::{HorizontalAlignment, Text, VerticalAlignment};

use super::arrow::ArrowMarker;
use super::mesh::{MeshMarker, NotShown};
use super::message_fields::rgba;
use super::primitive::Parts;
use super::shape::SolidMarker;
use super::triangles::TriangleMarker;
use super::{lines, point_lists};
use crate::framework::world::isometry;
use crate::SolidShape;

/// A marker's kind, with the state that rviz keeps between messages of the same marker.
#[derive(Clone, Debug)]
pub(super) enum MarkerKind {
    Arrow(ArrowMarker),
    Solid(SolidMarker),
    LineStrip,
    LineList,
    Points,
    Text,
    Mesh(Box<MeshMarker>),
    Triangles(TriangleMarker),
}

impl MarkerKind {
    /// Kind of a message's type; `None` for an unknown type.
    pub(super) fn of(marker: &Marker) -> Option<Self> {
        Some(match u8::try_from(marker.type_).ok()? {
            Marker::ARROW => Self::Arrow(ArrowMarker::default()),
            Marker::CUBE => Self::Solid(SolidMarker::new(SolidShape::Cube)),
            Marker::SPHERE => Self::Solid(SolidMarker::new(SolidShape::Sphere)),
            Marker::CYLINDER => Self::Solid(SolidMarker::new(SolidShape::Cylinder)),
            Marker::LINE_STRIP => Self::LineStrip,
            Marker::LINE_LIST => Self::LineList,
            Marker::CUBE_LIST | Marker::SPHERE_LIST | Marker::POINTS => Self::Points,
            Marker::TEXT_VIEW_FACING => Self::Text,
            Marker::MESH_RESOURCE => Self::Mesh(Box::default()),
            Marker::TRIANGLE_LIST => Self::Triangles(TriangleMarker::default()),
            _ => return None,
        })
    }

    /// `true` if a message is sure to have the same parts as the last one.
    pub(super) fn is_unchanged(&self, marker: &Marker) -> bool {
        match self {
            Self::Arrow(arrow) => arrow.is_unchanged(marker),
            Self::Solid(solid) => solid.is_unchanged(marker),
            _ => false,
        }
    }

    /// Builds the parts of a message of this kind.
    pub(super) fn parts(&mut self, marker: &Marker, meshes: &MeshStore) -> Result<Parts, NotShown> {
        Ok(match self {
            Self::Arrow(arrow) => arrow.parts(marker),
            Self::Solid(solid) => solid.parts(marker),
            Self::LineStrip => Parts::of(lines::strip(marker)),
            Self::LineList => Parts::of(lines::list(marker)),
            Self::Points => Parts::of(point_lists::primitives(marker)),
            Self::Text => text_parts(marker),
            Self::Mesh(mesh) => Parts::of(mesh.primitives(marker, meshes)?),
            Self::Triangles(triangles) => Parts::of(triangles.primitives(marker)),
        })
    }

    /// `true` if the mesh of the last message is loading or cannot be shown.
    pub(super) fn is_missing(&self) -> bool {
        matches!(self, Self::Mesh(mesh) if mesh.is_missing())
    }

    /// Rebuilds the parts of the last message, if its mesh was missing.
    pub(super) fn rebuild(&mut self, meshes: &MeshStore) -> Result<Parts, NotShown> {
        match self {
            Self::Mesh(mesh) => mesh.rebuild(meshes).map(Parts::of),
            _ => Ok(Parts::none()),
        }
    }

    /// Pose in the frame of the header; `None` when a relevant number is NaN or infinite. Text ignores its orientation.
    pub(super) fn frame_from_marker(&self, marker: &Marker) -> Option<Isometry3<f64>> {
        let mut pose = PlainTransform::from(&marker.pose);
        if matches!(self, Self::Text) {
            pose.rotation_xyzw = [0.0, 0.0, 0.0, 1.0];
        }
        isometry(&pose)
    }
}

/// TEXT_VIEW_FACING: text centred on the marker's position, `scale.z` high.
fn text_parts(marker: &Marker) -> Parts {
    let alignment = (HorizontalAlignment::Center, VerticalAlignment::Center);
    Parts::Text(Arc::new(Text::new(&marker.text, marker.scale.z as f32, rgba(&marker.color), alignment)))
}
