//! Validation of markers.
//!
//! A table ([`Needs`]) lists the fields that each type of marker reads; they are checked one by one. rviz's errors are
//! errors here: they keep a marker from being drawn and remove the one that it would have replaced. All else is a
//! warning.

use std::collections::HashSet;

use rcs_messages::geometry_msgs::Pose;
use rcs_messages::visualization_msgs::{Marker, MarkerArray};
use rcs_messages::{quaternion_xyzw, PlainTransform};

use super::message_fields::{is_finite_color, is_unit_quaternion, position, scale};
use crate::framework::world::all_finite;
use crate::Level;

/// White space of C's `isspace`; text of nothing else is empty.
const WHITESPACE: [char; 6] = [' ', '\t', '\n', '\u{b}', '\u{c}', '\r'];

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

    pub(super) fn is_fatal(&self) -> bool {
        self.fatal
    }

    pub(super) fn status(&self) -> Option<(Level, String)> {
        let level = if self.fatal { Level::Error } else { Level::Warn };
        (!self.texts.is_empty()).then(|| (level, self.texts.join(" \n")))
    }
}

/// Fields that a type of marker reads.
#[derive(Clone, Copy, Debug)]
struct Needs {
    orientation: bool,
    scale: Scale,
    points: Count,
    /// `true` if each point may have a colour of its own.
    point_colors: bool,
    text: bool,
    mesh: bool,
}

/// Parts of the scale that a type reads.
#[derive(Clone, Copy, Debug)]
enum Scale {
    /// All three, which must be finite; an arrow may leave its head's length (z) to rviz.
    Size { z_may_be_zero: bool },
    /// Width of lines in x.
    LineWidth,
    /// Width and height of points in x and y.
    PointSize,
    /// Height of text in z.
    TextHeight,
}

/// Number of points of a type.
#[derive(Clone, Copy, Debug)]
enum Count {
    /// No points.
    None,
    /// An arrow's start and end, if it has any.
    NoneOrTwo,
    /// At least one.
    Some,
    /// At least two.
    Two,
    /// Pairs or triples, which make a line or a triangle each.
    Groups { of: usize, name: &'static str },
}

impl Needs {
    /// Needs of a message's type; `None` for an unknown type.
    fn of(marker: &Marker) -> Option<Self> {
        let solid = Self {
            orientation: true,
            scale: Scale::Size { z_may_be_zero: false },
            points: Count::None,
            point_colors: false,
            text: false,
            mesh: false,
        };
        let list = |points| Self { points, point_colors: true, ..solid };
        Some(match u8::try_from(marker.type_).ok()? {
            Marker::CUBE | Marker::SPHERE | Marker::CYLINDER => solid,
            Marker::MESH_RESOURCE => Self { mesh: true, ..solid },
            Marker::ARROW => Self { scale: Scale::Size { z_may_be_zero: true }, points: Count::NoneOrTwo, ..solid },
            Marker::TEXT_VIEW_FACING => Self { orientation: false, scale: Scale::TextHeight, text: true, ..solid },
            Marker::CUBE_LIST | Marker::SPHERE_LIST => list(Count::Some),
            Marker::TRIANGLE_LIST => list(Count::Groups { of: 3, name: "triangle" }),
            Marker::POINTS => Self { orientation: false, scale: Scale::PointSize, ..list(Count::Some) },
            Marker::LINE_STRIP => Self { scale: Scale::LineWidth, ..list(Count::Two) },
            Marker::LINE_LIST => Self { scale: Scale::LineWidth, ..list(Count::Groups { of: 2, name: "line" }) },
            _ => return None,
        })
    }
}

/// Checks a marker that is to be added, field by field.
pub(super) fn check_marker(marker: &Marker) -> Findings {
    let mut found = Findings::default();
    if !all_finite(&PlainTransform::from(&marker.pose).translation) {
        found.error("the position is not finite");
    }
    let Some(needs) = Needs::of(marker) else {
        found.error(format!("unknown marker type {}", marker.type_));
        return found;
    };
    if needs.orientation {
        check_orientation(&marker.pose, &mut found);
    }
    check_scale(marker, needs.scale, &mut found);
    check_points(marker, needs.points, &mut found);
    check_colors(marker, needs.point_colors, &mut found);
    match (needs.text, marker.text.as_str()) {
        (true, text) if text.chars().all(|c| WHITESPACE.contains(&c)) => found.error("the text is empty"),
        (true, _) | (false, "") => {}
        (false, _) => found.warn("text is ignored"),
    }
    match (needs.mesh, marker.mesh_resource.as_str()) {
        (true, "") => found.error("mesh_resource is empty"),
        (true, _) | (false, "") => {}
        (false, _) => found.warn("mesh_resource is ignored"),
    }
    if marker.mesh_use_embedded_materials && !needs.mesh {
        found.warn("mesh_use_embedded_materials is ignored");
    }
    found
}

fn check_orientation(pose: &Pose, found: &mut Findings) {
    let xyzw = quaternion_xyzw(&pose.orientation);
    if !all_finite(&xyzw) {
        found.error("the orientation is not finite");
        return;
    }
    if xyzw == [0.0; 4] {
        found.warn("the orientation is not set (all zero) and taken for no rotation");
    } else if !is_unit_quaternion(xyzw) {
        found.warn("the orientation is not a unit quaternion");
    }
}

fn check_scale(marker: &Marker, read: Scale, found: &mut Findings) {
    let [x, y, z] = scale(marker);
    let warning = match read {
        Scale::Size { z_may_be_zero } => {
            if !all_finite(&[x, y, z]) {
                found.error("the scale is not finite");
            }
            let is_flat = x == 0.0 || y == 0.0 || (z == 0.0 && !z_may_be_zero);
            is_flat.then_some("the scale is 0 in x, y or z")
        }
        Scale::LineWidth => (x == 0.0).then_some("the line width (scale.x) is 0"),
        Scale::PointSize => {
            (x == 0.0 || y == 0.0).then_some("the width (scale.x) or height (scale.y) of the points is 0")
        }
        Scale::TextHeight => (z == 0.0).then_some("the height of the text (scale.z) is 0"),
    };
    if let Some(warning) = warning {
        found.warn(warning);
    }
}

fn check_points(marker: &Marker, needed: Count, found: &mut Findings) {
    let count = marker.points.len();
    match needed {
        Count::None if count > 0 => found.warn("points are ignored"),
        Count::None => {}
        Count::NoneOrTwo if count == 2 => {
            if !marker.points.iter().all(|point| position(point).iter().all(|value| value.is_finite())) {
                found.error("a point is not finite");
            }
        }
        Count::NoneOrTwo if count > 0 => found.error(format!("an arrow has 0 or 2 points, not {count}")),
        Count::NoneOrTwo => {}
        _ if count == 0 => found.error("there are no points"),
        Count::Two if count == 1 => found.error("a line strip has at least two points"),
        Count::Groups { of, name } if !count.is_multiple_of(of) => {
            let number = if of == 2 { "two" } else { "three" };
            found.error(format!("a {name} list has {number} points a {name}, but there are {count}"));
        }
        Count::Some | Count::Two | Count::Groups { .. } => {}
    }
}

/// Checks the marker's colour or, if it has some, those of its points.
fn check_colors(marker: &Marker, point_colors: bool, found: &mut Findings) {
    let (colors, points) = (marker.colors.len(), marker.points.len());
    if point_colors && colors > 0 {
        let one_a_face = marker.type_ == i32::from(Marker::TRIANGLE_LIST) && 3 * colors == points;
        if colors != points && !one_a_face {
            found.error(format!("there are {colors} colors for {points} points"));
        }
        return;
    }
    let color = &marker.color;
    if !is_finite_color(color) {
        found.error("the color is not finite");
    }
    // All zero stands for the mesh's own colours.
    let own_colors = marker.type_ == i32::from(Marker::MESH_RESOURCE)
        && marker.mesh_use_embedded_materials
        && [color.r, color.g, color.b] == [0.0; 3];
    if color.a == 0.0 && !own_colors {
        found.warn("the marker is fully transparent (color.a is 0)");
    }
    if colors > 0 {
        found.warn("colors are ignored");
    }
}

/// `true` if an array only adds markers with increasing ids, as large arrays mostly do.
fn adds_in_order(array: &MarkerArray) -> bool {
    let is_added = |marker: &Marker| u8::try_from(marker.action) == Ok(Marker::ADD);
    array.markers.iter().all(is_added) && array.markers.is_sorted_by(|a, b| a.ns == b.ns && a.id < b.id)
}

/// Checks whether the markers of an array cancel each other; never fatal.
pub(super) fn check_array(array: &MarkerArray) -> Findings {
    let mut found = Findings::default();
    if adds_in_order(array) {
        return found;
    }
    let mut seen: HashSet<(&str, i32)> = HashSet::with_capacity(array.markers.len());
    for marker in &array.markers {
        let id = (marker.ns.as_str(), marker.id);
        match u8::try_from(marker.action) {
            Ok(Marker::DELETEALL) if seen.is_empty() => {}
            Ok(Marker::DELETEALL) => {
                found.warn("DELETEALL after markers: they are not shown");
                seen.clear();
            }
            Ok(Marker::DELETE) if seen.remove(&id) => {
                found.warn(format!("marker {}/{} is deleted by the array that adds it", marker.ns, marker.id));
            }
            // As in rviz, an id that was deleted counts as one that was used.
            _ if !seen.insert(id) => {
                found.warn(format!("marker {}/{} is added more than once", marker.ns, marker.id));
            }
            _ => {}
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array(actions: &[(u8, i32)]) -> MarkerArray {
        let marker = |&(action, id): &(u8, i32)| Marker { action: action.into(), id, ..Marker::default() };
        MarkerArray { markers: actions.iter().map(marker).collect() }
    }

    #[test]
    fn an_array_that_cancels_its_own_markers_is_warned_about() {
        const ADD: u8 = Marker::ADD;
        let text = |actions: &[(u8, i32)]| check_array(&array(actions)).status().map(|(_, text)| text);
        assert_eq!(text(&[(ADD, 1), (ADD, 2), (Marker::DELETE, 3)]), None);
        assert_eq!(text(&[(Marker::DELETEALL, 0), (ADD, 1)]), None);
        assert_eq!(text(&[(ADD, 1), (ADD, 1)]).unwrap(), "marker /1 is added more than once");
        assert_eq!(text(&[(Marker::DELETE, 1), (ADD, 1)]).unwrap(), "marker /1 is added more than once");
        let deleted = "marker /1 is deleted by the array that adds it";
        assert_eq!(text(&[(ADD, 1), (Marker::DELETE, 1), (ADD, 1)]).unwrap(), deleted);
        assert_eq!(
            text(&[(ADD, 1), (Marker::DELETEALL, 0), (ADD, 1)]).unwrap(),
            "DELETEALL after markers: they are not shown"
        );
    }
}
