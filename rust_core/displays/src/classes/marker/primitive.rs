//! The primitives that a marker is drawn with, in its own frame.

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, Point3};
use rcs_scene::{DisplayId, Drawable, Geometry, Material, Mesh, RenderGroup};

use crate::parts::bounds::middle;

/// The point of a translucent primitive by which it is sorted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SortPoint {
    /// The primitive's origin.
    Origin,
    /// This point of the fixed frame, wherever the marker stands: for clouds and chains Ogre takes the middle of the
    /// box around their points, whose coordinates are the marker's, for a position in the fixed frame.
    Fixed(Point3<f64>),
}

/// A primitive of a marker.
#[derive(Clone, Debug)]
pub(crate) struct Primitive {
    /// Takes the geometry to the marker's own frame.
    pub(crate) marker_from_part: Matrix4<f64>,
    /// What is drawn; shared, so that a marker can move without being built again.
    pub(crate) geometry: Geometry,
    /// Its place among translucent things.
    pub(crate) sort_point: SortPoint,
}

impl Primitive {
    /// A primitive that is sorted by its origin.
    pub(super) fn new(marker_from_part: Matrix4<f64>, geometry: Geometry) -> Self {
        Self { marker_from_part, geometry, sort_point: SortPoint::Origin }
    }

    /// Triangles, sorted by their origin.
    pub(super) fn mesh(marker_from_part: Matrix4<f64>, mesh: Arc<Mesh>, material: Material) -> Self {
        Self::new(marker_from_part, Geometry::Mesh { mesh, material: Arc::new(material) })
    }

    /// Something in the marker's own frame that is sorted by the middle of the box around these points.
    pub(super) fn sorted_by_middle(positions: impl IntoIterator<Item = [f32; 3]>, geometry: Geometry) -> Self {
        let sort_point = SortPoint::Fixed(middle(positions).map(f64::from).into());
        Self { marker_from_part: Matrix4::identity(), geometry, sort_point }
    }

    /// The drawable of a marker at a pose in the fixed frame.
    pub(crate) fn placed(&self, display: DisplayId, fixed_from_marker: &Isometry3<f64>) -> Drawable {
        let fixed_from_object = fixed_from_marker.to_homogeneous() * self.marker_from_part;
        let sort_point = match self.sort_point {
            SortPoint::Origin => Point3::from(fixed_from_object.fixed_view::<3, 1>(0, 3).into_owned()),
            SortPoint::Fixed(point) => point,
        };
        Drawable { display, fixed_from_object, sort_point, group: RenderGroup::Main, geometry: self.geometry.clone() }
    }
}
