//! Culling of a display against a camera's view, for reports.
//!
//! Each drawable is enclosed in a box in its own frame (a cube about its origin where it turns to the eye). It is
//! outside when all eight corners lie beyond the same plane of the view frustum, so `Outside` is certain, while a box
//! beyond an edge of the frustum may count as inside. Clouds are enclosed without the size of their points, as Ogre
//! culls them.

use nalgebra::{Matrix4, Point3, Vector4};
use rcs_scene::{Camera, Drawable, Geometry, Mesh};

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
                if sample.any(|position| Enclosure::point(*position).reaches_into_view(&clip_from_object)) {
                    return Self::Inside;
                }
            }
            if let Geometry::Solids(solids) = geometry {
                let shapes: Vec<Option<Enclosure>> =
                    solids.shapes().iter().map(|mesh| Enclosure::of_mesh(mesh)).collect();
                let mut seen = solids.as_slice().iter().filter_map(|solid| {
                    let enclosure = shapes.get(solid.shape()).copied().flatten()?;
                    Some(enclosure.reaches_into_view(&(clip_from_fixed * solid.matrix())))
                });
                match seen.next() {
                    None => continue,
                    Some(first) if first || seen.any(|is_inside| is_inside) => return Self::Inside,
                    Some(_) => result = Self::Outside,
                }
            }
            let Some(enclosure) = Enclosure::of(geometry) else { continue };
            let clip_from_object = match geometry {
                Geometry::Text(_) | Geometry::Facing(_) => clip_from_fixed * without_rotation(fixed_from_object),
                _ => clip_from_object,
            };
            if enclosure.reaches_into_view(&clip_from_object) {
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

/// A box along the axes of an object's frame, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Enclosure {
    low: Point3<f64>,
    high: Point3<f64>,
}

impl Enclosure {
    fn point(position: [f32; 3]) -> Self {
        let point = Point3::from(position).cast();
        Self { low: point, high: point }
    }

    fn around(positions: impl Iterator<Item = [f32; 3]>) -> Option<Self> {
        let finite = positions.filter(|position| position.iter().all(|value| value.is_finite()));
        let (low, high) = finite.fold((None, None), |(low, high), position| {
            let each = |f: fn(f32, f32) -> f32, all: Option<[f32; 3]>| {
                let all = all.unwrap_or(position);
                Some([0, 1, 2].map(|axis: usize| f(all[axis], position[axis])))
            };
            (each(f32::min, low), each(f32::max, high))
        });
        Some(Self { low: Point3::from(low?).cast(), high: Point3::from(high?).cast() })
    }

    /// Cube about the origin that holds the corners in any rotation.
    fn of_turning(corners: impl Iterator<Item = Point3<f64>>) -> Option<Self> {
        let reach_m = corners.map(|corner| corner.coords.norm()).reduce(f64::max)?;
        Some(Self { low: Point3::from([-reach_m; 3]), high: Point3::from([reach_m; 3]) })
    }

    /// Box around a geometry in its own frame; `None` when it is empty.
    fn of(geometry: &Geometry) -> Option<Self> {
        match geometry {
            Geometry::Points(points) => Self::around(points.buffer.positions.iter().copied()),
            Geometry::Lines(lines) => Self::around(lines.positions.iter().copied()),
            Geometry::Ribbons(ribbons) => {
                let elements = ribbons.chains.iter().flatten();
                let middle = Self::around(elements.map(|element| element.position))?;
                let half_width = nalgebra::Vector3::repeat(f64::from(ribbons.width_m) / 2.0);
                Some(Self { low: middle.low - half_width, high: middle.high + half_width })
            }
            Geometry::Mesh { mesh, .. } => Self::of_mesh(mesh),
            // Each stands at a place of its own.
            Geometry::Solids(_) => None,
            Geometry::Text(text) => {
                let corners = text.glyphs().iter().flat_map(|glyph| text.quad(glyph));
                Self::of_turning(corners.map(|corner| Point3::from(corner.position).cast()))
            }
            Geometry::Cells(_) => Some(Self { low: Point3::origin(), high: Point3::new(1.0, 1.0, 0.0) }),
            Geometry::Facing(facing) => {
                let corners = facing.parts.iter().filter_map(|part| {
                    let corners = Self::of(&part.geometry)?.corners();
                    Some(corners.map(|corner| part.group_from_part.transform_point(&corner)))
                });
                Self::of_turning(corners.flatten())
            }
        }
    }

    fn of_mesh(mesh: &Mesh) -> Option<Self> {
        Self::around(mesh.vertices.iter().map(|vertex| vertex.position))
    }

    fn corners(&self) -> [Point3<f64>; 8] {
        std::array::from_fn(|i| {
            let side = |axis: usize| if i >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] };
            Point3::new(side(0), side(1), side(2))
        })
    }

    /// `true` if no plane of the frustum has all corners beyond it.
    fn reaches_into_view(&self, clip_from_object: &Matrix4<f64>) -> bool {
        let corners: [Vector4<f64>; 8] = self.corners().map(|corner| clip_from_object * corner.to_homogeneous());
        let is_beyond = |side: f64, axis: usize| corners.iter().all(|corner| corner.w + side * corner[axis] < 0.0);
        !(0..3).any(|axis| is_beyond(1.0, axis) || is_beyond(-1.0, axis))
    }
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
