//! The kinds of markers, and what each is drawn with.

use nalgebra::Isometry3;
use rcs_messages::visualization_msgs::Marker;
use rcs_messages::PlainTransform;
use rcs_resources::MeshStore;

use super::arrow::Arrow;
use super::mesh::{MeshMarker, NotShown};
use super::primitive::Parts;
use super::shape::Solid;
use super::triangles::Triangles;
use super::{lines, point_lists, text};
use crate::framework::world::isometry;
use crate::Shape;

/// A marker's kind, with what rviz keeps of one message when the next comes for the same marker.
#[derive(Clone, Debug)]
pub(super) enum Kind {
    Arrow(Arrow),
    Solid(Solid),
    LineStrip,
    LineList,
    Points,
    Text,
    Mesh(Box<MeshMarker>),
    Triangles(Triangles),
}

impl Kind {
    /// The kind of a message's type; `None` for a type that there is not.
    pub(super) fn of(marker: &Marker) -> Option<Self> {
        Some(match u8::try_from(marker.type_).ok()? {
            Marker::ARROW => Self::Arrow(Arrow::default()),
            Marker::CUBE => Self::Solid(Solid::new(Shape::Cube)),
            Marker::SPHERE => Self::Solid(Solid::new(Shape::Sphere)),
            Marker::CYLINDER => Self::Solid(Solid::new(Shape::Cylinder)),
            Marker::LINE_STRIP => Self::LineStrip,
            Marker::LINE_LIST => Self::LineList,
            Marker::CUBE_LIST | Marker::SPHERE_LIST | Marker::POINTS => Self::Points,
            Marker::TEXT_VIEW_FACING => Self::Text,
            Marker::MESH_RESOURCE => Self::Mesh(Box::default()),
            Marker::TRIANGLE_LIST => Self::Triangles(Triangles::default()),
            _ => return None,
        })
    }

    /// Whether a message is sure to show what the last one did, if elsewhere.
    pub(super) fn is_unchanged(&self, marker: &Marker) -> bool {
        match self {
            Self::Arrow(arrow) => arrow.is_unchanged(marker),
            Self::Solid(solid) => solid.is_unchanged(marker),
            _ => false,
        }
    }

    /// Builds what a message of this kind shows.
    ///
    /// # Errors
    /// Why it shows nothing.
    pub(super) fn parts(&mut self, marker: &Marker, meshes: &MeshStore) -> Result<Parts, NotShown> {
        Ok(match self {
            Self::Arrow(arrow) => arrow.parts(marker),
            Self::Solid(solid) => solid.parts(marker),
            Self::LineStrip => Parts::of(lines::strip(marker)),
            Self::LineList => Parts::of(lines::list(marker)),
            Self::Points => Parts::of(point_lists::primitives(marker)),
            Self::Text => text::parts(marker),
            Self::Mesh(mesh) => Parts::of(mesh.primitives(marker, meshes)?),
            Self::Triangles(triangles) => Parts::of(triangles.primitives(marker)),
        })
    }

    /// Whether the mesh of the last message is loading or cannot be shown.
    pub(super) fn is_missing(&self) -> bool {
        matches!(self, Self::Mesh(mesh) if mesh.is_missing())
    }

    /// Builds what the last message shows, if it is a mesh that was missing.
    ///
    /// # Errors
    /// Why it shows nothing.
    pub(super) fn rebuild(&mut self, meshes: &MeshStore) -> Result<Parts, NotShown> {
        match self {
            Self::Mesh(mesh) => mesh.rebuild(meshes).map(Parts::of),
            _ => Ok(Parts::none()),
        }
    }

    /// The marker's pose in the frame of its header; `None` when a number that counts is NaN or infinite. Text does not
    /// turn with its pose, and its orientation may be anything.
    pub(super) fn frame_from_marker(&self, marker: &Marker) -> Option<Isometry3<f64>> {
        let mut pose = PlainTransform::from(&marker.pose);
        if matches!(self, Self::Text) {
            pose.rotation_xyzw = [0.0, 0.0, 0.0, 1.0];
        }
        isometry(&pose)
    }
}
