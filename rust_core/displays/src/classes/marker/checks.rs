//! What is odd about a marker, and whether it can be drawn all the same.
//!
//! Reproduces rviz's checks of markers and of arrays: what it calls an error keeps a marker from being shown (and takes
//! away the one that it would have replaced), all else is a warning.

use std::collections::BTreeSet;

use rcs_messages::geometry_msgs::Pose;
use rcs_messages::visualization_msgs::{Marker, MarkerArray};
use rcs_messages::{quaternion_xyzw, PlainTransform};

use super::numbers::{all_finite, is_finite_color, position, scale};
use crate::Level;

/// How far from 1 a quaternion's squared length may be.
const QUATERNION_TOLERANCE: f64 = 10e-3;

/// What was found in a message.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Findings {
    fatal: bool,
    texts: Vec<String>,
}

impl Findings {
    fn warn(&mut self, text: impl Into<String>) {
        self.texts.push(text.into());
    }

    fn error(&mut self, text: impl Into<String>) {
        self.fatal = true;
        self.texts.push(text.into());
    }

    /// Whether the marker cannot be drawn.
    pub(super) fn is_fatal(&self) -> bool {
        self.fatal
    }

    /// The findings as a status; `None` without any.
    pub(super) fn status(&self) -> Option<(Level, String)> {
        let level = if self.fatal { Level::Error } else { Level::Warn };
        (!self.texts.is_empty()).then(|| (level, self.texts.join(" \n")))
    }
}

/// Checks a marker that is to be added.
pub(super) fn check_marker(marker: &Marker) -> Findings {
    let mut found = Findings::default();
    if !all_finite(&PlainTransform::from(&marker.pose).translation) {
        found.error("the position is not finite");
    }
    match u8::try_from(marker.type_).unwrap_or(u8::MAX) {
        Marker::ARROW => {
            check_orientation(&marker.pose, &mut found);
            check_scale(marker, &mut found);
            check_color(marker, &mut found);
            check_arrow_points(marker, &mut found);
            found.no_colors(marker).no_text(marker).no_mesh(marker);
        }
        Marker::CUBE | Marker::SPHERE | Marker::CYLINDER => {
            check_orientation(&marker.pose, &mut found);
            check_scale(marker, &mut found);
            check_color(marker, &mut found);
            found.no_points(marker).no_colors(marker).no_text(marker).no_mesh(marker);
        }
        Marker::LINE_STRIP | Marker::LINE_LIST => {
            check_orientation(&marker.pose, &mut found);
            if marker.scale.x == 0.0 {
                found.warn("the line width (scale.x) is 0");
            }
            check_points(marker, &mut found);
            check_colors(marker, &mut found);
            found.no_text(marker).no_mesh(marker);
        }
        Marker::CUBE_LIST | Marker::SPHERE_LIST | Marker::TRIANGLE_LIST => {
            check_orientation(&marker.pose, &mut found);
            check_scale(marker, &mut found);
            check_points(marker, &mut found);
            check_colors(marker, &mut found);
            found.no_text(marker).no_mesh(marker);
        }
        Marker::POINTS => {
            if marker.scale.x == 0.0 || marker.scale.y == 0.0 {
                found.warn("the width (scale.x) or height (scale.y) of the points is 0");
            }
            check_points(marker, &mut found);
            check_colors(marker, &mut found);
            found.no_text(marker).no_mesh(marker);
        }
        Marker::TEXT_VIEW_FACING => {
            check_color(marker, &mut found);
            if marker.scale.z == 0.0 {
                found.warn("the height of the text (scale.z) is 0");
            }
            if marker.text.chars().all(|c| " \t\n\u{b}\u{c}\r".contains(c)) {
                found.error("the text is empty");
            }
            found.no_points(marker).no_colors(marker).no_mesh(marker);
        }
        Marker::MESH_RESOURCE => {
            check_orientation(&marker.pose, &mut found);
            check_color(marker, &mut found);
            check_scale(marker, &mut found);
            found.no_points(marker).no_colors(marker).no_text(marker);
            if marker.mesh_resource.is_empty() {
                found.error("mesh_resource is empty");
            }
        }
        _ => found.error(format!("there is no marker type {}", marker.type_)),
    }
    found
}

/// Things that the kind of marker makes no use of.
impl Findings {
    fn no_points(&mut self, marker: &Marker) -> &mut Self {
        if !marker.points.is_empty() {
            self.warn("points are ignored");
        }
        self
    }

    fn no_colors(&mut self, marker: &Marker) -> &mut Self {
        if !marker.colors.is_empty() {
            self.warn("colors are ignored");
        }
        self
    }

    fn no_text(&mut self, marker: &Marker) -> &mut Self {
        if !marker.text.is_empty() {
            self.warn("text is ignored");
        }
        self
    }

    fn no_mesh(&mut self, marker: &Marker) -> &mut Self {
        if !marker.mesh_resource.is_empty() {
            self.warn("mesh_resource is ignored");
        }
        if marker.mesh_use_embedded_materials {
            self.warn("mesh_use_embedded_materials is ignored");
        }
        self
    }
}

fn check_orientation(pose: &Pose, found: &mut Findings) {
    let xyzw = quaternion_xyzw(&pose.orientation);
    if !all_finite(&xyzw) {
        found.error("the orientation is not finite");
        return;
    }
    let squared_length: f64 = xyzw.iter().map(|value| value * value).sum();
    if xyzw == [0.0; 4] {
        found.warn("the orientation is not set (all zero) and taken for no rotation");
    } else if (squared_length - 1.0).abs() >= QUATERNION_TOLERANCE {
        found.warn("the orientation is not a unit quaternion");
    }
}

fn check_scale(marker: &Marker, found: &mut Findings) {
    let [x, y, z] = scale(marker);
    if !all_finite(&[x, y, z]) {
        found.error("the scale is not finite");
    }
    // An arrow's z is the length of its head, which need not be given.
    let is_arrow = marker.type_ == i32::from(Marker::ARROW);
    if x == 0.0 || y == 0.0 || (z == 0.0 && !is_arrow) {
        found.warn("the scale is 0 in x, y or z");
    }
}

fn check_color(marker: &Marker, found: &mut Findings) {
    let color = &marker.color;
    if !is_finite_color(color) {
        found.error("the color is not finite");
    }
    // All zero asks for the mesh's own colours.
    let own_colors = marker.type_ == i32::from(Marker::MESH_RESOURCE)
        && marker.mesh_use_embedded_materials
        && [color.r, color.g, color.b] == [0.0; 3];
    if color.a == 0.0 && !own_colors {
        found.warn("the marker is fully transparent (color.a is 0)");
    }
}

fn check_arrow_points(marker: &Marker, found: &mut Findings) {
    match marker.points.len() {
        0 => {}
        2 => {
            if !marker.points.iter().all(|point| position(point).iter().all(|value| value.is_finite())) {
                found.error("a point is not finite");
            }
        }
        count => found.error(format!("an arrow has 0 or 2 points, not {count}")),
    }
}

fn check_points(marker: &Marker, found: &mut Findings) {
    let count = marker.points.len();
    if count == 0 {
        found.error("there are no points");
    }
    match u8::try_from(marker.type_).unwrap_or(u8::MAX) {
        Marker::TRIANGLE_LIST if !count.is_multiple_of(3) => {
            found.error(format!("a triangle list has three points a triangle, but there are {count}"));
        }
        Marker::LINE_LIST if !count.is_multiple_of(2) => {
            found.error(format!("a line list has two points a line, but there are {count}"));
        }
        Marker::LINE_STRIP if count == 1 => found.error("a line strip has at least two points"),
        _ => {}
    }
}

fn check_colors(marker: &Marker, found: &mut Findings) {
    let (colors, points) = (marker.colors.len(), marker.points.len());
    if colors == 0 {
        check_color(marker, found);
        return;
    }
    let one_a_face = marker.type_ == i32::from(Marker::TRIANGLE_LIST) && 3 * colors == points;
    if colors != points && !one_a_face {
        found.error(format!("there are {colors} colors for {points} points"));
    }
}

/// Checks whether the markers of an array get into each other's way; never fatal.
pub(super) fn check_array(array: &MarkerArray) -> Findings {
    let mut found = Findings::default();
    let mut seen: BTreeSet<(&str, i32)> = BTreeSet::new();
    for marker in &array.markers {
        if marker.action == i32::from(Marker::DELETEALL) {
            if !seen.is_empty() {
                found.warn("DELETEALL after markers: they will not be seen");
            }
            seen.clear();
            continue;
        }
        let id = (marker.ns.as_str(), marker.id);
        if seen.insert(id) {
            continue;
        }
        if marker.action == i32::from(Marker::DELETE) {
            found.warn(format!("marker {}/{} is deleted by the array that adds it", marker.ns, marker.id));
            seen.remove(&id);
        } else {
            found.warn(format!("marker {}/{} is added more than once", marker.ns, marker.id));
        }
    }
    found
}
