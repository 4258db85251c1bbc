//! The controls that rviz's client makes: handles for a control that has no markers of its own, and the title.
//!
//! Reproduces the sizes and colours of the `interactive_markers` library: two arrows for what moves along an axis, a
//! ring of bright and dark teeth for what turns, a plain ring for a plane. A handle lies along the x axis of its
//! control's orientation and is as red, green and blue as that axis goes along x, y and z, at half opacity.

use std::f64::consts::TAU;

use rcs_messages::geometry_msgs::{Point, Quaternion, Vector3};
use rcs_messages::quaternion_xyzw;
use rcs_messages::std_msgs::ColorRGBA;
use rcs_messages::visualization_msgs::{InteractiveMarker, InteractiveMarkerControl, Marker};

const WHITE: ColorRGBA = ColorRGBA { r: 1.0, g: 1.0, b: 1.0, a: 1.0 };
const HANDLE_ALPHA: f32 = 0.5;

/// Start and end of an arrow, in sizes of the marker.
const ARROW_SPAN: [f64; 2] = [0.5, 0.9];
/// An arrow's shaft's diameter, head's diameter and head's length, in sizes of the marker.
const ARROW_THICKNESS: [f64; 3] = [0.15, 0.25, 0.2];

const RING_STEPS: usize = 36;
const RING_INNER_RADIUS: f64 = 0.5;
const RING_OUTER_RADIUS: f64 = 0.65;
/// The brightness of a ring's dark teeth.
const DARK: f32 = 0.6;

/// The height of a button's text and its height above the marker, in sizes of the marker.
const BUTTON_SIZE: f64 = 0.25;
const BUTTON_HEIGHT: f64 = 1.2;
/// Shift of a button's text back and down, in heights of the text.
const BUTTON_SHIFT: f64 = -0.1;

/// The height of a title's text and its height above the marker, in sizes of the marker.
const TITLE_SIZE: f64 = 0.15;
const TITLE_HEIGHT: f64 = 1.4;

/// Gives a control without markers the handle of its interaction mode. One that opens a menu becomes a text that faces
/// the view.
pub(super) fn add_default(size: f64, control: &mut InteractiveMarkerControl) {
    match control.interaction_mode {
        InteractiveMarkerControl::MOVE_AXIS => {
            control.markers = [1.0, -1.0].map(|side| arrow(size, &control.orientation, side)).into();
        }
        InteractiveMarkerControl::MOVE_PLANE => control.markers = vec![ring(size, &control.orientation, plain_face)],
        InteractiveMarkerControl::ROTATE_AXIS => control.markers = vec![ring(size, &control.orientation, turning_face)],
        InteractiveMarkerControl::MOVE_ROTATE => control.markers = vec![ring(size, &control.orientation, moving_face)],
        InteractiveMarkerControl::MENU => {
            control.orientation_mode = InteractiveMarkerControl::VIEW_FACING;
            control.independent_marker_orientation = false;
            let height = BUTTON_SIZE * size;
            let mut button = text(&control.description, height);
            button.pose.position.x = BUTTON_SHIFT * height;
            button.pose.position.z = BUTTON_HEIGHT * size + BUTTON_SHIFT * height;
            control.markers = vec![button];
        }
        _ => {}
    }
}

/// The control that shows a marker's description above it.
pub(super) fn title(marker: &InteractiveMarker) -> InteractiveMarkerControl {
    let size = f64::from(marker.scale);
    let mut title = text(&marker.description, TITLE_SIZE * size);
    title.pose.position.z = TITLE_HEIGHT * size;
    InteractiveMarkerControl {
        interaction_mode: InteractiveMarkerControl::NONE,
        orientation_mode: InteractiveMarkerControl::VIEW_FACING,
        always_visible: true,
        markers: vec![title],
        ..InteractiveMarkerControl::default()
    }
}

fn text(text: &str, height_m: f64) -> Marker {
    Marker {
        type_: Marker::TEXT_VIEW_FACING.into(),
        scale: Vector3 { x: height_m, y: height_m, z: height_m },
        color: WHITE,
        text: text.to_owned(),
        ..Marker::default()
    }
}

fn arrow(size: f64, orientation: &Quaternion, side: f64) -> Marker {
    let [x, y, z] = ARROW_THICKNESS.map(|thickness| thickness * size);
    let mut arrow = Marker {
        type_: Marker::ARROW.into(),
        scale: Vector3 { x, y, z },
        color: axis_color(orientation),
        points: ARROW_SPAN.map(|end| Point { x: side * size * end, y: 0.0, z: 0.0 }).into(),
        ..Marker::default()
    };
    arrow.pose.orientation = orientation.clone();
    arrow
}

/// A corner of a ring: on the outer circle or not, and which step of it.
type Corner = (bool, usize);

/// The triangles of one step of a ring, each with its colour; `None` where the ring has one colour.
type Faces = [([Corner; 3], Option<ColorRGBA>); 2];

fn plain_face(i: usize, _: &ColorRGBA) -> Faces {
    let faces = [[(false, i), (true, i), (false, i + 1)], [(true, i), (true, i + 1), (false, i + 1)]];
    faces.map(|corners| (corners, None))
}

fn turning_face(i: usize, base: &ColorRGBA) -> Faces {
    let color = shade(base, if i.is_multiple_of(2) { DARK } else { 1.0 });
    let faces = [[(false, i), (true, i + 1), (false, i + 1)], [(false, i + 1), (true, i + 1), (true, i + 2)]];
    faces.map(|corners| (corners, Some(color.clone())))
}

/// Dark teeth at even steps; the bright ones between them keep the handle's own opacity, which then counts twice.
fn moving_face(i: usize, base: &ColorRGBA) -> Faces {
    let color = if i.is_multiple_of(2) { shade(base, DARK) } else { base.clone() };
    let faces = if i.is_multiple_of(2) {
        [[(false, i), (true, i + 1), (false, i + 1)], [(false, i + 1), (true, i + 1), (false, i + 2)]]
    } else {
        [[(true, i - 1), (true, i), (false, i - 1)], [(true, i), (true, i + 1), (false, i + 1)]]
    };
    faces.map(|corners| (corners, Some(color.clone())))
}

fn ring(size: f64, orientation: &Quaternion, faces: fn(usize, &ColorRGBA) -> Faces) -> Marker {
    let color = axis_color(orientation);
    let corner = |(is_outer, step): Corner| {
        let angle = (step % RING_STEPS) as f64 / RING_STEPS as f64 * TAU;
        let radius = if is_outer { RING_OUTER_RADIUS } else { RING_INNER_RADIUS };
        Point { x: 0.0, y: radius * angle.cos(), z: radius * angle.sin() }
    };
    let (mut points, mut colors) = (Vec::with_capacity(6 * RING_STEPS), Vec::new());
    for (corners, face_color) in (0..RING_STEPS).flat_map(|step| faces(step, &color)) {
        points.extend(corners.map(corner));
        colors.extend(face_color);
    }
    let mut ring = Marker {
        type_: Marker::TRIANGLE_LIST.into(),
        scale: Vector3 { x: size, y: size, z: size },
        color,
        points,
        colors,
        ..Marker::default()
    };
    ring.pose.orientation = orientation.clone();
    ring
}

fn shade(color: &ColorRGBA, brightness: f32) -> ColorRGBA {
    ColorRGBA { r: color.r * brightness, g: color.g * brightness, b: color.b * brightness, a: 1.0 }
}

/// Colour of the rotated x axis: its components along x, y and z, scaled to a maximum of one.
fn axis_color(orientation: &Quaternion) -> ColorRGBA {
    let [x, y, z, w] = quaternion_xyzw(orientation);
    let axis = nalgebra::UnitQuaternion::try_new(nalgebra::Quaternion::new(w, x, y, z), 0.0).unwrap_or_default()
        * nalgebra::Vector3::x();
    let [r, g, b] = (axis.abs() / axis.amax()).cast::<f32>().into();
    ColorRGBA { r, g, b, a: HANDLE_ALPHA }
}
