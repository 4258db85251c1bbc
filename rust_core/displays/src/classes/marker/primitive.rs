//! The primitives of a marker, in its own frame.

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3x4, Matrix4, Point3, Vector4};
use rcs_scene::{DisplayId, Drawable, Geometry, Material, Mesh, RenderGroup, Rgba, Text};
use smallvec::SmallVec;

use crate::parts::bounds::middle;
use crate::parts::gathering::{solid_color, Gathering};
use crate::SolidShape;

/// Point of a translucent primitive by which it is sorted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SortPoint {
    Origin,
    /// This point of the fixed frame, wherever the marker is: for clouds and chains Ogre takes the middle of the box
    /// around their points in the marker's frame as if it were in the fixed frame.
    Fixed(Point3<f64>),
}

#[derive(Clone, Debug)]
pub(crate) struct Primitive {
    pub(crate) marker_from_part: Matrix4<f64>,
    /// Shared, so that a marker can move without being built again.
    pub(crate) geometry: Geometry,
    pub(crate) sort_point: SortPoint,
}

impl Primitive {
    /// A primitive that is sorted by its origin.
    pub(super) fn new(marker_from_part: Matrix4<f64>, geometry: Geometry) -> Self {
        Self { marker_from_part, geometry, sort_point: SortPoint::Origin }
    }

    pub(super) fn mesh(marker_from_part: Matrix4<f64>, mesh: Arc<Mesh>, material: Material) -> Self {
        Self::new(marker_from_part, Geometry::Mesh { mesh, material: Arc::new(material) })
    }

    /// A primitive in the marker's own frame that is sorted by the middle of the box around these points.
    pub(super) fn sorted_by_middle(positions: impl IntoIterator<Item = [f32; 3]>, geometry: Geometry) -> Self {
        let sort_point = SortPoint::Fixed(middle(positions).map(f64::from).into());
        Self { marker_from_part: Matrix4::identity(), geometry, sort_point }
    }

    pub(crate) fn placed(&self, display: DisplayId, fixed_from_marker: &Isometry3<f64>) -> Drawable {
        let fixed_from_object = fixed_from_marker.to_homogeneous() * self.marker_from_part;
        let sort_point = match self.sort_point {
            SortPoint::Origin => Point3::from(fixed_from_object.fixed_view::<3, 1>(0, 3).into_owned()),
            SortPoint::Fixed(point) => point,
        };
        Drawable { display, fixed_from_object, sort_point, group: RenderGroup::Main, geometry: self.geometry.clone() }
    }
}

/// The primitives of a marker. There may be a hundred thousand markers, most of them a solid or a text.
#[derive(Clone, Debug)]
pub(super) enum Parts {
    /// Solids of one colour, mostly one of them, without an allocation for each.
    Solids(Rgba, SmallVec<[SolidPart; 1]>),
    Text(Arc<Text>),
    Primitives(Box<[Primitive]>),
}

#[derive(Clone, Debug)]
pub(super) struct SolidPart {
    /// The upper three rows of the matrix to the marker's frame.
    marker_from_solid: Matrix3x4<f64>,
    mesh: Arc<Mesh>,
}

impl Parts {
    pub(super) fn none() -> Self {
        Self::Primitives(Box::default())
    }

    /// Solids of a colour, each with its matrix to the marker's frame.
    pub(super) fn solids<const N: usize>(color: Rgba, solids: [(SolidShape, Matrix4<f64>); N]) -> Self {
        let part = |(shape, marker_from_solid): (SolidShape, Matrix4<f64>)| SolidPart {
            marker_from_solid: marker_from_solid.fixed_view::<3, 4>(0, 0).into_owned(),
            mesh: shape.mesh(),
        };
        Self::Solids(color, solids.into_iter().map(part).collect())
    }

    /// Parts of primitives, as solids where that is possible.
    pub(super) fn of(primitives: Vec<Primitive>) -> Self {
        let solids: Option<Vec<(Rgba, SolidPart)>> = primitives.iter().map(SolidPart::of).collect();
        match solids.as_deref() {
            Some([(color, _), rest @ ..]) if rest.iter().all(|(other, _)| other == color) => {
                Self::Solids(*color, solids.iter().flatten().map(|(_, part)| part.clone()).collect())
            }
            _ => Self::Primitives(primitives.into()),
        }
    }

    pub(super) fn into_primitives(self) -> Vec<Primitive> {
        match self {
            Self::Solids(color, parts) => {
                let material = Arc::new(Material::lit(color));
                let primitive = |part: SolidPart| {
                    let matrix = part.matrix();
                    Primitive::new(matrix, Geometry::Mesh { mesh: part.mesh, material: material.clone() })
                };
                parts.into_iter().map(primitive).collect()
            }
            Self::Text(text) => vec![Primitive::new(Matrix4::identity(), Geometry::Text(text))],
            Self::Primitives(primitives) => primitives.into(),
        }
    }

    /// Adds the drawables of a marker at a pose in the fixed frame.
    pub(super) fn gather(&self, display: DisplayId, fixed_from_marker: &Isometry3<f64>, gathering: &mut Gathering) {
        match self {
            Self::Solids(color, parts) => {
                let fixed_from_marker = fixed_from_marker.to_homogeneous();
                for part in parts {
                    gathering.solid(&part.mesh, &(fixed_from_marker * part.matrix()), *color);
                }
            }
            Self::Text(text) => {
                let text = Primitive::new(Matrix4::identity(), Geometry::Text(text.clone()));
                gathering.drawable(text.placed(display, fixed_from_marker));
            }
            Self::Primitives(primitives) => {
                for primitive in primitives {
                    gathering.drawable(primitive.placed(display, fixed_from_marker));
                }
            }
        }
    }
}

impl SolidPart {
    fn matrix(&self) -> Matrix4<f64> {
        let mut matrix = Matrix4::identity();
        matrix.fixed_view_mut::<3, 4>(0, 0).copy_from(&self.marker_from_solid);
        matrix
    }

    fn of(primitive: &Primitive) -> Option<(Rgba, Self)> {
        let Primitive { marker_from_part, geometry: Geometry::Mesh { mesh, material }, sort_point } = primitive else {
            return None;
        };
        let is_plain = *sort_point == SortPoint::Origin && marker_from_part.row(3) == Vector4::w().transpose();
        let color = solid_color(mesh, material).filter(|_| is_plain)?;
        let marker_from_solid = marker_from_part.fixed_view::<3, 4>(0, 0).into_owned();
        Some((color, Self { marker_from_solid, mesh: mesh.clone() }))
    }
}
