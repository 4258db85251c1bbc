//! Culling of a display against a camera's view, for reports.
//!
//! Each drawable is enclosed in a box in its own frame (a cube about its origin where it turns to the eye). It is
//! outside when all of it lies beyond the same plane of the view frustum, so `Outside` is certain, while a box
//! beyond an edge of the frustum may count as inside. Clouds are enclosed without the size of their points, as Ogre
//! culls them.

use nalgebra::{Matrix4, Point3};
use rcs_scene::{Aabb, Camera, Drawable, Geometry, InFrustum, Mesh};

/// Visibility of a display in a camera's view, without its Visibility property and occlusion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InView {
    /// The display has no drawables.
    Empty,
    /// All drawables are outside the camera's view.
    Outside,
    /// At least one drawable may be in the view.
    Inside,
}

impl InView {
    /// Tests drawables against the view of a camera. Visits all positions unless something is soon found inside.
    pub(crate) fn of(drawables: &[Drawable], camera: &Camera) -> Self {
        let clip_from_fixed = camera.clip_from_view() * camera.fixed_from_view().inverse().to_homogeneous();
        let mut result = Self::Empty;
        for Drawable { geometry, fixed_from_object, .. } in drawables {
            let clip_from_object = clip_from_fixed * fixed_from_object;
            if let Geometry::Points(points) = geometry {
                // Most clouds are in view, and a few of their points show it.
                let positions = &points.buffer.positions;
                let mut sample = positions.iter().step_by(positions.len() / 64 + 1);
                let is_inside = |position: &[f32; 3]| {
                    let place = Aabb::around([*position]);
                    place.is_some_and(|place| reaches_into_view(&place, &clip_from_object))
                };
                if sample.any(is_inside) {
                    return Self::Inside;
                }
            }
            if let Geometry::Solids(solids) = geometry {
                let shapes: Vec<Option<Aabb>> = solids.shapes().iter().map(|mesh| bounds_of_mesh(mesh)).collect();
                let mut seen = solids.as_slice().iter().filter_map(|solid| {
                    let bounds = shapes.get(solid.shape()).copied().flatten()?;
                    Some(reaches_into_view(&bounds, &(clip_from_fixed * solid.matrix())))
                });
                match seen.next() {
                    None => continue,
                    Some(first) if first || seen.any(|is_inside| is_inside) => return Self::Inside,
                    Some(_) => result = Self::Outside,
                }
            }
            let Some(bounds) = bounds(geometry) else { continue };
            let clip_from_object = match geometry {
                Geometry::Text(_) | Geometry::Facing(_) => clip_from_fixed * without_rotation(fixed_from_object),
                _ => clip_from_object,
            };
            if reaches_into_view(&bounds, &clip_from_object) {
                return Self::Inside;
            }
            result = Self::Outside;
        }
        result
    }
}

/// Place and largest scale of a drawable that turns to the eye.
fn without_rotation(fixed_from_object: &Matrix4<f64>) -> Matrix4<f64> {
    let scale = (0..3).map(|axis| fixed_from_object.fixed_view::<3, 1>(0, axis).norm()).fold(0.0, f64::max);
    let mut matrix = Matrix4::new_scaling(scale);
    matrix.set_column(3, &fixed_from_object.column(3).into_owned());
    matrix
}

/// Cube about the origin that holds the corners in any rotation.
fn of_turning(corners: impl Iterator<Item = Point3<f64>>) -> Option<Aabb> {
    let reach_m = corners.map(|corner| corner.coords.norm()).reduce(f64::max)?;
    Some(Aabb::new([-reach_m; 3].into(), [reach_m; 3].into()))
}

/// Box around a geometry in its own frame; `None` when it is empty.
fn bounds(geometry: &Geometry) -> Option<Aabb> {
    match geometry {
        Geometry::Points(points) => Aabb::around(points.buffer.positions.iter().copied()),
        Geometry::Packed(points) => points.bounds(),
        Geometry::Lines(lines) => Aabb::around(lines.positions.iter().copied()),
        Geometry::Ribbons(ribbons) => {
            let elements = ribbons.chains.iter().flatten();
            let middle = Aabb::around(elements.map(|element| element.position))?;
            Some(middle.grown(f64::from(ribbons.width_m) / 2.0))
        }
        Geometry::Mesh { mesh, .. } => bounds_of_mesh(mesh),
        // Each stands at a place of its own.
        Geometry::Solids(_) => None,
        Geometry::Text(text) => {
            let corners = text.glyphs().iter().flat_map(|glyph| text.quad(glyph));
            of_turning(corners.map(|corner| Point3::from(corner.position).cast()))
        }
        Geometry::Cells(_) => Some(Aabb::new(Point3::origin(), Point3::new(1.0, 1.0, 0.0))),
        Geometry::Facing(facing) => {
            let corners = facing.parts.iter().filter_map(|part| {
                let corners = bounds(&part.geometry)?.corners();
                Some(corners.map(|corner| part.group_from_part.transform_point(&corner)))
            });
            of_turning(corners.flatten())
        }
    }
}

fn bounds_of_mesh(mesh: &Mesh) -> Option<Aabb> {
    Aabb::around(mesh.vertices.iter().map(|vertex| vertex.position))
}

/// `true` if no plane of the frustum has all of the box beyond it.
fn reaches_into_view(bounds: &Aabb, clip_from_object: &Matrix4<f64>) -> bool {
    bounds.in_frustum(clip_from_object, 0.0) != InFrustum::Outside
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::{Isometry3, Vector3};
    use rcs_scene::{
        Blending, Facing, FacingPart, HorizontalAlignment, Intrinsics, LineTopology, Lines, PointBuffer, PointColors,
        PointStyle, Points, RenderGroup, Rgba, RibbonElement, Ribbons, Solids, Text, VerticalAlignment,
    };

    use super::*;
    use crate::SolidShape;

    /// Looks along z; at 10 m its view reaches 10 m to each side.
    fn camera() -> Camera {
        let p = [50.0, 0.0, 50.0, 0.0, 0.0, 50.0, 50.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        Camera::new(Intrinsics::from_p(100, 100, &p).unwrap(), &Isometry3::identity(), 0.01)
    }

    fn lines(positions: &[[f32; 3]]) -> Geometry {
        let (colors, topology, blending) = (vec![[255; 4]], LineTopology::Strip, Blending::Replace);
        Geometry::Lines(Arc::new(Lines { positions: positions.to_vec(), colors, topology, blending }))
    }

    fn text() -> Geometry {
        let alignment = (HorizontalAlignment::Center, VerticalAlignment::Center);
        Geometry::Text(Arc::new(Text::new("AA", 1.0, Rgba::WHITE, alignment)))
    }

    fn at(geometry: Geometry, x: f64, y: f64, z: f64) -> InView {
        let fixed_from_object = Matrix4::new_translation(&Vector3::new(x, y, z));
        let sort_point = Point3::origin();
        let drawable = Drawable { display: 0, fixed_from_object, sort_point, group: RenderGroup::Main, geometry };
        InView::of(&[drawable], &camera())
    }

    #[test]
    fn a_box_is_outside_only_beyond_one_side_of_the_view() {
        let bar = || lines(&[[-1.0, 0.0, 0.0], [f32::NAN; 3], [1.0, 0.0, 0.0]]);
        for (x, y, z) in [(0.0, 0.0, 10.0), (10.9, 9.9, 10.0), (-10.9, -9.9, 10.0), (0.0, 0.0, 99.0)] {
            assert_eq!(at(bar(), x, y, z), InView::Inside, "{x} {y} {z}");
        }
        let outside = [(11.1, 0.0, 10.0), (-11.1, 0.0, 10.0), (0.0, 10.1, 10.0), (0.0, 0.0, -0.1), (0.0, 0.0, 100.1)];
        for (x, y, z) in outside {
            assert_eq!(at(bar(), x, y, z), InView::Outside, "{x} {y} {z}");
        }
        assert_eq!(at(lines(&[]), 0.0, 0.0, 10.0), InView::Empty);
        assert_eq!(InView::of(&[], &camera()), InView::Empty);
    }

    #[test]
    fn what_encloses_the_eye_is_inside_although_no_corner_is_in_view() {
        assert_eq!(at(lines(&[[-50.0; 3], [50.0; 3]]), 0.0, 0.0, 0.0), InView::Inside);
    }

    #[test]
    fn of_several_drawables_one_in_view_is_enough() {
        let beside = |x| Drawable {
            display: 0,
            fixed_from_object: Matrix4::new_translation(&Vector3::new(x, 0.0, 10.0)),
            sort_point: Point3::origin(),
            group: RenderGroup::Main,
            geometry: lines(&[[0.0; 3], [1.0; 3]]),
        };
        // The box around both would reach across the view.
        assert_eq!(InView::of(&[beside(-30.0), beside(30.0)], &camera()), InView::Outside);
        assert_eq!(InView::of(&[beside(-30.0), beside(3.0), beside(30.0)], &camera()), InView::Inside);
    }

    #[test]
    fn of_many_solids_one_in_view_is_enough() {
        let solids = |places: &[f64]| {
            let mut solids = Solids::default();
            for &x in places {
                let place = Matrix4::new_translation(&Vector3::new(x, 0.0, 10.0));
                assert!(solids.push(&SolidShape::Cube.mesh(), &place, Rgba::WHITE));
            }
            at(Geometry::Solids(Arc::new(solids)), 0.0, 0.0, 0.0)
        };
        assert_eq!(solids(&[]), InView::Empty);
        assert_eq!(solids(&[-30.0, 11.1, 30.0]), InView::Outside);
        assert_eq!(solids(&[-30.0, 10.4, 30.0]), InView::Inside);
    }

    #[test]
    fn clouds_count_by_their_centres_and_ribbons_with_their_width() {
        let cloud = |x: f32| {
            let mut positions = vec![[500.0, 0.0, 10.0]; 1000];
            positions[777][0] = x;
            let buffer = PointBuffer { positions, colors: PointColors::Uniform([255; 4]) };
            let style = PointStyle::FlatSquares { side_m: 9.0 };
            Geometry::Points(Points { buffer: Arc::new(buffer), style, alpha: 1.0, blended: false, auto_size: false })
        };
        assert_eq!(at(cloud(9.0), 0.0, 0.0, 0.0), InView::Inside);
        assert_eq!(at(cloud(11.0), 0.0, 0.0, 0.0), InView::Outside);
        let ribbon = |width_m| {
            let chain = [11.0, 12.0].map(|x| RibbonElement { position: [x, 0.0, 10.0], color: [255; 4] }).to_vec();
            Geometry::Ribbons(Arc::new(Ribbons { chains: vec![chain], width_m, blending: Blending::Replace }))
        };
        assert_eq!(at(ribbon(0.5), 0.0, 0.0, 0.0), InView::Outside);
        assert_eq!(at(ribbon(4.0), 0.0, 0.0, 0.0), InView::Inside);
    }

    #[test]
    fn what_turns_to_the_eye_counts_wherever_it_may_turn() {
        assert_eq!(at(text(), 0.0, 10.6, 10.0), InView::Inside);
        assert_eq!(at(text(), 0.0, 15.0, 10.0), InView::Outside);
        let group = || {
            let group_from_part = Matrix4::new_translation(&Vector3::new(0.0, 5.0, 0.0));
            let parts = vec![FacingPart { group_from_part, sort_point: None, geometry: text() }];
            Geometry::Facing(Arc::new(Facing { forward: Vector3::x(), up: Vector3::z(), parts }))
        };
        assert_eq!(at(group(), 14.0, 0.0, 10.0), InView::Inside);
        assert_eq!(at(group(), 30.0, 0.0, 10.0), InView::Outside);
    }
}
