//! Static frames of a projector's file: keys and values, or static_transform_publisher's arguments.

use std::collections::HashSet;
use std::fmt;

use nalgebra::{Isometry3, Quaternion, UnitQuaternion};
use rcs_messages::geometry_msgs::{Quaternion as QuaternionMessage, Transform, TransformStamped, Vector3};
use rcs_messages::std_msgs::Header;
use rcs_messages::Time;
use serde::de::{Deserializer, Error as _, MapAccess, Visitor};
use serde::Deserialize;

use super::checked_numbers::Matrix;

/// Frame of the table's top, which `projector_calibrate solve --table` writes.
pub const TABLE_FRAME: &str = "table";
/// Largest error of a quaternion's norm; smaller ones are normalised.
const NORM_TOLERANCE: f64 = 0.01;
/// Rounding error of a norm, which is not normalised, so that a written file is read back exactly.
const NORM_ROUNDING: f64 = 1e-14;

/// A frame that is fixed in its parent.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticFrame {
    /// Parent frame.
    pub parent: String,
    /// Child frame.
    pub child: String,
    /// Origin of the child in the parent, metres.
    pub translation_m: [f64; 3],
    /// Orientation of the child in the parent.
    pub rotation: UnitQuaternion<f64>,
}

impl StaticFrame {
    /// Creates a frame with a pose in its parent.
    pub fn new(parent: &str, child: &str, parent_from_child: &Isometry3<f64>) -> Self {
        Self {
            parent: parent.to_owned(),
            child: child.to_owned(),
            translation_m: parent_from_child.translation.vector.into(),
            // Composed rotations drift from the norm 1, which the file needs.
            rotation: UnitQuaternion::new_normalize(parent_from_child.rotation.into_inner()),
        }
    }

    /// Takes points of the child to the parent.
    pub fn parent_from_child(&self) -> Isometry3<f64> {
        // A rotation that was written by hand is rounded.
        let rotation = UnitQuaternion::new_normalize(self.rotation.into_inner());
        Isometry3::from_parts(self.translation_m.into(), rotation)
    }

    /// Message for `/tf_static`.
    pub fn to_message(&self, stamp: Time) -> TransformStamped {
        let [x, y, z] = self.translation_m;
        let rotation = self.rotation;
        TransformStamped {
            header: Header { seq: 0, stamp, frame_id: self.parent.clone() },
            child_frame_id: self.child.clone(),
            transform: Transform {
                translation: Vector3 { x, y, z },
                rotation: QuaternionMessage { x: rotation.i, y: rotation.j, z: rotation.k, w: rotation.w },
            },
        }
    }
}

/// One entry of `frames`: keys and values, or one line of text.
pub(super) struct FrameEntry(pub(super) StaticFrame);

impl<'de> Deserialize<'de> for FrameEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct FrameVisitor;
        impl<'de> Visitor<'de> for FrameVisitor {
            type Value = FrameEntry;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(
                    f,
                    "a frame: {{parent, child, translation, rotation_rpy}} or 'x y z yaw pitch roll parent child'"
                )
            }

            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<FrameEntry, E> {
                frame_from_text(text).map(FrameEntry).map_err(E::custom)
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<FrameEntry, A::Error> {
                let raw = RawFrame::deserialize(serde::de::value::MapAccessDeserializer::new(map))?;
                raw.frame().map(FrameEntry).map_err(A::Error::custom)
            }
        }
        deserializer.deserialize_any(FrameVisitor)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFrame {
    parent: String,
    child: String,
    translation: Option<Matrix<3>>,
    rotation_rpy: Option<Matrix<3>>,
    rotation_xyzw: Option<Matrix<4>>,
    transform: Option<String>,
}

impl RawFrame {
    fn frame(self) -> Result<StaticFrame, String> {
        let (translation_m, rotation) = match (self.translation, self.rotation_rpy, self.rotation_xyzw, self.transform)
        {
            (None, None, None, Some(text)) => {
                let numbers: Option<Vec<f64>> = text.split_ascii_whitespace().map(finite).collect();
                let numbers = numbers.ok_or_else(|| format!("transform '{text}': not all are finite numbers"))?;
                placement(&numbers)?
            }
            (_, _, _, Some(_)) => {
                return Err("transform excludes translation and rotation_...".to_owned());
            }
            (_, Some(_), Some(_), _) => return Err("rotation_rpy and rotation_xyzw exclude each other".to_owned()),
            (translation, Some(Matrix([roll, pitch, yaw])), None, None) => {
                (or_origin(translation), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
            }
            (translation, None, Some(Matrix(xyzw)), None) => (or_origin(translation), unit_quaternion(xyzw)?),
            (translation, None, None, None) => (or_origin(translation), UnitQuaternion::identity()),
        };
        named_frame(&self.parent, &self.child, translation_m, rotation)
    }
}

fn or_origin(translation: Option<Matrix<3>>) -> [f64; 3] {
    translation.map_or([0.0; 3], |Matrix(translation)| translation)
}

/// A finite number.
pub(super) fn finite(word: &str) -> Option<f64> {
    word.parse().ok().filter(|number: &f64| number.is_finite())
}

/// A rotation of a quaternion, which may be rounded.
pub(crate) fn unit_quaternion([x, y, z, w]: [f64; 4]) -> Result<UnitQuaternion<f64>, String> {
    let quaternion = Quaternion::new(w, x, y, z);
    let norm = quaternion.norm();
    if (norm - 1.0).abs() > NORM_TOLERANCE {
        return Err(format!("the quaternion (x {x}, y {y}, z {z}, w {w}) has the norm {norm:.3} where 1 is needed"));
    }
    if (norm - 1.0).abs() < NORM_ROUNDING {
        return Ok(UnitQuaternion::new_unchecked(quaternion));
    }
    Ok(UnitQuaternion::new_normalize(quaternion))
}

/// Parses static_transform_publisher's numbers: x y z yaw pitch roll, or x y z qx qy qz qw.
fn placement(numbers: &[f64]) -> Result<([f64; 3], UnitQuaternion<f64>), String> {
    match *numbers {
        [x, y, z, yaw, pitch, roll] => Ok(([x, y, z], UnitQuaternion::from_euler_angles(roll, pitch, yaw))),
        [x, y, z, qx, qy, qz, qw] => Ok(([x, y, z], unit_quaternion([qx, qy, qz, qw])?)),
        _ => {
            Err(format!("{} numbers where 6 (x y z yaw pitch roll) or 7 (x y z qx qy qz qw) are needed", numbers.len()))
        }
    }
}

/// Parses static_transform_publisher's arguments: numbers, parent, child and an unused period in milliseconds.
fn frame_from_text(text: &str) -> Result<StaticFrame, String> {
    let words: Vec<&str> = text.split_ascii_whitespace().collect();
    let numbers: Vec<f64> = words.iter().map_while(|word| finite(word)).collect();
    let (translation_m, rotation) = placement(&numbers).map_err(|reason| format!("frame '{text}': {reason}"))?;
    match words.get(numbers.len()..) {
        Some([parent, child]) => named_frame(parent, child, translation_m, rotation),
        Some([parent, child, period]) if finite(period).is_some() => {
            named_frame(parent, child, translation_m, rotation)
        }
        _ => Err(format!("frame '{text}': parent and child must follow the numbers")),
    }
}

/// A frame with names in tf2's form.
pub(crate) fn named_frame(
    parent: &str,
    child: &str,
    translation_m: [f64; 3],
    rotation: UnitQuaternion<f64>,
) -> Result<StaticFrame, String> {
    let [parent, child] = [parent, child].map(without_slash);
    if parent.is_empty() || child.is_empty() {
        return Err("parent and child need names".to_owned());
    }
    if parent == child {
        return Err(format!("frame '{child}' cannot be its own parent"));
    }
    Ok(StaticFrame { parent: parent.to_owned(), child: child.to_owned(), translation_m, rotation })
}

/// Checks that no frame has two parents.
pub(super) fn check_placed_once(frames: &[StaticFrame]) -> Result<(), String> {
    let mut children = HashSet::new();
    let name = |frame: &StaticFrame| without_slash(&frame.child).to_owned();
    match frames.iter().map(name).find(|child| !children.insert(child.clone())) {
        Some(twice) => Err(format!("frame '{twice}' is placed twice")),
        None => Ok(()),
    }
}

/// The name without a leading slash, which tf2 does not allow.
pub(super) fn without_slash(name: &str) -> &str {
    name.strip_prefix('/').unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_static_frame_becomes_its_message() {
        let frame = frame_from_text("1 2 3 0 0 0.6 0.8 map proj").unwrap();
        let message = frame.to_message(Time { sec: 5, nsec: 6 });
        assert_eq!(message.header.frame_id, "map");
        assert_eq!(message.header.stamp, Time { sec: 5, nsec: 6 });
        assert_eq!(message.child_frame_id, "proj");
        assert_eq!(message.transform.translation, Vector3 { x: 1.0, y: 2.0, z: 3.0 });
        assert!((message.transform.rotation.z - 0.6).abs() < 1e-12);
        assert!((message.transform.rotation.w - 0.8).abs() < 1e-12);
    }
}
