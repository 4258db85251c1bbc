//! Groups that turn to the camera as one: an interactive marker's controls that face the view.
//!
//! Unlike [`Text`](crate::Text), which turns by itself, such a group may hold any geometry, and its parts keep their
//! places in the group. Reproduces rviz's `VIEW_FACING` controls, which turn for each camera: one axis of the group
//! goes into the camera's viewing direction, another upwards on its image.

use std::borrow::Cow;
use std::sync::Arc;

use nalgebra::{Matrix4, Point3, Unit, UnitQuaternion, Vector3};

use crate::{Camera, DisplayId, Drawable, Facing, Geometry, RenderGroup, Scene};

/// Tolerance of the cosine within which two directions are opposite; Ogre's value.
const OPPOSITE_TOLERANCE: f64 = 1e-6;

impl Facing {
    /// The group at a place in the fixed frame.
    pub fn into_drawable(self, display: DisplayId, place: Vector3<f64>) -> Drawable {
        Drawable {
            display,
            fixed_from_object: Matrix4::new_translation(&place),
            sort_point: place.into(),
            group: RenderGroup::Main,
            geometry: Geometry::Facing(Arc::new(self)),
        }
    }

    /// The rotation from the group's frame to the fixed frame for a camera.
    fn fixed_from_group(&self, camera: &Camera) -> UnitQuaternion<f64> {
        let fixed_from_view = camera.fixed_from_view().rotation;
        let looking = shortest_turn(&self.forward, &(fixed_from_view * -Vector3::z()));
        shortest_turn(&(looking * self.up), &(fixed_from_view * Vector3::y())) * looking
    }
}

/// The shortest turn from one direction to another. For opposite ones a half turn about the normal of the first and the
/// x axis, or of it and the y axis where it lies along x.
fn shortest_turn(from: &Vector3<f64>, to: &Vector3<f64>) -> UnitQuaternion<f64> {
    let (from, to) = (from.normalize(), to.normalize());
    if from.dot(&to) < OPPOSITE_TOLERANCE - 1.0 {
        let axis = Unit::try_new(Vector3::x().cross(&from), OPPOSITE_TOLERANCE)
            .unwrap_or_else(|| Unit::new_normalize(Vector3::y().cross(&from)));
        return UnitQuaternion::from_axis_angle(&axis, std::f64::consts::PI);
    }
    UnitQuaternion::rotation_between(&from, &to).unwrap_or_default()
}

impl Scene {
    /// The scene for one camera: each [`Geometry::Facing`] is replaced by its parts, turned to the camera.
    pub fn seen_from(&self, camera: &Camera) -> Cow<'_, Self> {
        if !self.drawables.iter().any(|drawable| matches!(drawable.geometry, Geometry::Facing(_))) {
            return Cow::Borrowed(self);
        }
        let mut drawables = Vec::with_capacity(self.drawables.len());
        for drawable in &self.drawables {
            match &drawable.geometry {
                Geometry::Facing(facing) => drawables.extend(turned(drawable, facing, camera)),
                _ => drawables.push(drawable.clone()),
            }
        }
        Cow::Owned(Self { drawables, light: self.light })
    }
}

fn turned<'a>(drawable: &'a Drawable, facing: &'a Facing, camera: &Camera) -> impl Iterator<Item = Drawable> + 'a {
    let place = drawable.fixed_from_object.fixed_view::<3, 1>(0, 3).into_owned();
    let fixed_from_group = Matrix4::new_translation(&place) * facing.fixed_from_group(camera).to_homogeneous();
    let parts = facing.parts.iter().filter(|part| !matches!(part.geometry, Geometry::Facing(_)));
    parts.map(move |part| {
        let fixed_from_object = fixed_from_group * part.group_from_part;
        let origin = Point3::from(fixed_from_object.fixed_view::<3, 1>(0, 3).into_owned());
        Drawable {
            fixed_from_object,
            sort_point: part.sort_point.unwrap_or(origin),
            geometry: part.geometry.clone(),
            display: drawable.display,
            group: drawable.group,
        }
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;
    use proptest::prelude::*;

    use super::*;
    use crate::{FacingPart, HorizontalAlignment, Intrinsics, Rgba, Text, VerticalAlignment};

    fn camera(fixed_from_optical: &Isometry3<f64>) -> Camera {
        let p = [500.0, 0.0, 320.0, 0.0, 0.0, 500.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        Camera::new(Intrinsics::from_p(640, 480, &p).unwrap(), fixed_from_optical, 0.01)
    }

    fn text() -> Geometry {
        let alignment = (HorizontalAlignment::Center, VerticalAlignment::Center);
        Geometry::Text(Arc::new(Text::new("a", 1.0, Rgba::WHITE, alignment)))
    }

    /// A group at (1, 2, 3) with something one metre up in it.
    fn scene(forward: Vector3<f64>, up: Vector3<f64>) -> Scene {
        let group_from_part = Matrix4::new_translation(&up);
        let facing =
            Facing { forward, up, parts: vec![FacingPart { group_from_part, sort_point: None, geometry: text() }] };
        Scene { drawables: vec![facing.into_drawable(7, Vector3::new(1.0, 2.0, 3.0))], light: None }
    }

    /// Distance in metres of the middle of the upper part from the camera's up direction, for a camera at this pose.
    fn off_upright(fixed_from_optical: &Isometry3<f64>, forward: Vector3<f64>, up: Vector3<f64>) -> f64 {
        let seen = scene(forward, up).seen_from(&camera(fixed_from_optical)).into_owned();
        assert_eq!(seen.drawables[0].display, 7);
        let offset = seen.drawables[0].sort_point.coords - Vector3::new(1.0, 2.0, 3.0);
        // The optical frame's y points down.
        (offset + fixed_from_optical * Vector3::y()).norm()
    }

    proptest! {
        #[test]
        fn up_in_the_group_is_up_on_the_image(turn in prop::array::uniform3(-4.0..4.0_f64), axis in 0..3_usize) {
            let fixed_from_optical = Isometry3::new(Vector3::new(0.3, -2.0, 1.0), turn.into());
            let (mut forward, mut up) = (Vector3::zeros(), Vector3::zeros());
            (forward[axis], up[(axis + 2) % 3]) = (1.0, 1.0);
            let off = off_upright(&fixed_from_optical, forward, up);
            // Directions that are opposite but for the tolerance, which is an angle of 1.4 mrad, are taken for
            // opposite; an angle of 20 nrad has the cosine 1.
            let looking = shortest_turn(&forward, &(fixed_from_optical * Vector3::z()));
            let is_opposite = (looking * up).dot(&(fixed_from_optical * Vector3::y())) > 1.0 - OPPOSITE_TOLERANCE;
            let allowed = if is_opposite { (2.0 * OPPOSITE_TOLERANCE).sqrt() * 1.001 } else { 3e-8 };
            prop_assert!(off < allowed, "{off} m");
        }
    }

    #[test]
    fn a_camera_that_stands_on_its_head_but_for_a_milliradian_sees_a_half_turn() {
        let rolled = |roll: f64| Isometry3::rotation(Vector3::z() * roll);
        // Without a roll the optical frame's y, down, is the group's up.
        let off = |roll: f64| off_upright(&rolled(roll), Vector3::z(), Vector3::y());
        assert!((off(0.001) - 0.001).abs() < 1e-8, "{}", off(0.001));
        assert!(off(0.0) < 1e-9 && off(0.0015) < 1e-9, "{} {}", off(0.0), off(0.0015));
    }

    #[test]
    fn a_camera_facing_backwards_sees_a_half_turn_about_the_vertical() {
        let facing = Facing { forward: Vector3::x(), up: Vector3::z(), parts: Vec::new() };
        // Facing along −x with z up.
        let columns = [-Vector3::x(), Vector3::y(), -Vector3::z()];
        let optical = nalgebra::Rotation3::from_matrix_unchecked(nalgebra::Matrix3::from_columns(&[
            columns[1], columns[2], columns[0],
        ]));
        let camera =
            camera(&Isometry3::from_parts(Vector3::zeros().into(), UnitQuaternion::from_rotation_matrix(&optical)));
        let turn = facing.fixed_from_group(&camera);
        assert!((turn * Vector3::x() + Vector3::x()).norm() < 1e-9);
        assert!((turn * Vector3::z() - Vector3::z()).norm() < 1e-9);
    }

    #[test]
    fn a_scene_without_groups_is_not_copied() {
        let mut scene = scene(Vector3::x(), Vector3::z());
        let camera = camera(&Isometry3::identity());
        assert!(matches!(scene.seen_from(&camera), Cow::Owned(_)));
        scene.drawables[0].geometry = text();
        assert!(matches!(scene.seen_from(&camera), Cow::Borrowed(_)));
    }
}
