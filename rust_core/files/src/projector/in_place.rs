//! Another pose for a frame of a projector's file, written in place: only the text of numbers changes.
//!
//! The YAML parser tells where each value stands. The pose is written in the form that the entry has: `rotation_rpy`,
//! `rotation_xyzw`, or static_transform_publisher's arguments; keys that are missing are added before `child`. Numbers
//! that stay the same keep their text. The result is parsed again and compared, so that a file in a form that is not
//! understood here, such as one with aliases, is refused and not damaged.

use std::f64::consts::{PI, TAU};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, UnitQuaternion};

use super::file::{read_text, split_preamble, ProjectorFile};
use super::frames::{finite, without_slash, StaticFrame};
use super::key_error::key_error;
use super::write::{frame_entry, write_text};
use crate::yaml_spans::{first_document, Content, Node};
use crate::yaml_text::{list, number};
use crate::FileError;

/// Written numbers are multiples of 1e-12 m, or rad. The noise of the arithmetic is below.
const STEPS_PER_UNIT: f64 = 1e12;
/// Numbers that differ by less are the same.
const RESOLUTION: f64 = 1.0 / STEPS_PER_UNIT;
/// Largest difference between a pose and the written one, metres and radians.
const TOLERANCE: f64 = 1e-9;
/// Below this cosine of the pitch, yaw and roll are about the same axis.
const GIMBAL_LOCK: f64 = 1e-12;

/// A replacement of some bytes of a text.
struct Edit {
    start: usize,
    end: usize,
    text: String,
}

/// Writes the pose of `child` in its parent into a projector's file. All other bytes stay; the file is replaced
/// atomically, links and permissions are kept. The file of before is kept as [`file_before`]. Returns what the file
/// holds then.
///
/// # Errors
/// [`FileError`] if the file cannot be read or written, has no such frame, or has it in a form that cannot be edited.
pub fn write_pose(path: &Path, child: &str, parent_from_child: &Isometry3<f64>) -> Result<ProjectorFile, FileError> {
    check_writable(path)?;
    let before = read_text(path)?;
    let text = text_with_pose(path, &before, child, parent_from_child)?;
    write_text(&file_before(path), &before)?;
    write_text(path, &text)?;
    ProjectorFile::parse(path, &text)
}

/// The file that keeps what a projector's file was before [`write_pose`]: `projector.yaml.1`.
pub fn file_before(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".1");
    name.into()
}

/// Writes the file of before [`write_pose`] back. Returns what it holds.
///
/// # Errors
/// [`FileError`] if it is not there, is no projector's file, or cannot be written.
pub fn restore_before(path: &Path) -> Result<ProjectorFile, FileError> {
    let before = file_before(path);
    let text = read_text(&before)?;
    let file = ProjectorFile::parse(&before, &text)?;
    check_writable(path)?;
    write_text(path, &text)?;
    Ok(file)
}

/// Writes the text of a projector's file with another pose of a frame to `target`, which may be the same file. A frame
/// that the text does not have yet is added at its end.
///
/// # Errors
/// [`FileError`] if a file cannot be read or written, has the frame in another parent, or is in a form that cannot be
/// edited.
pub fn write_frame(source: &Path, target: &Path, frame: &StaticFrame) -> Result<(), FileError> {
    if target.exists() {
        check_writable(target)?;
    }
    let text = read_text(source)?;
    write_text(target, &text_with_frame(source, &text, frame)?)
}

/// The text of a projector's file with a frame, see [`write_frame`].
fn text_with_frame(path: &Path, text: &str, frame: &StaticFrame) -> Result<String, FileError> {
    let before = ProjectorFile::parse(path, text)?;
    let [parent, child] = [&frame.parent, &frame.child].map(|name| without_slash(name));
    match before.frames.iter().find(|known| known.child == child) {
        Some(known) if known.parent == parent => text_with_pose(path, text, child, &frame.parent_from_child()),
        Some(known) => {
            let problem = format!("frames: places {child} in {}, not in {parent}", known.parent);
            Err(FileError::new(path, problem))
        }
        None => {
            let entry = frame_entry(frame).map_err(|error| key_error(path, error))?;
            let line_end = if text.ends_with('\n') { "" } else { "\n" };
            let key = if before.frames.is_empty() { "frames:\n" } else { "" };
            let edited = format!("{text}{line_end}{key}{entry}");
            let is_added = |after: ProjectorFile| {
                after.frames.len() == before.frames.len() + 1
                    && after.frames.last().is_some_and(|last| last.child == child && last.parent == parent)
                    && ProjectorFile { frames: before.frames.clone(), ..after } == before
            };
            if ProjectorFile::parse(path, &edited).is_ok_and(is_added) {
                return Ok(edited);
            }
            Err(FileError::new(path, format_args!("frames: add an entry of '{child}' in '{parent}' by hand")))
        }
    }
}

/// Checks that a file may be written. A read-only one is not replaced, although its folder would allow it.
///
/// # Errors
/// [`FileError`] with the reason.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    let check = || {
        let known = fs::metadata(path)?;
        if !known.is_file() {
            return Err(io::Error::other("it is not a regular file"));
        }
        if known.permissions().readonly() {
            return Err(io::Error::other("the file is read-only"));
        }
        File::options().write(true).open(path).map(drop)
    };
    check().map_err(|error| FileError::writing(path, error))
}

/// The text of a projector's file with another pose of `child` in its parent; `path` is for errors.
///
/// # Errors
/// [`FileError`] for an invalid text, one without the frame, and one that has it in a form that cannot be edited.
pub fn text_with_pose(
    path: &Path,
    text: &str,
    child: &str,
    parent_from_child: &Isometry3<f64>,
) -> Result<String, FileError> {
    let before = ProjectorFile::parse(path, text)?;
    let child = without_slash(child);
    let index = before.frames.iter().position(|frame| frame.child == child);
    let index = index.ok_or_else(|| FileError::new(path, format_args!("frames: no entry has the child '{child}'")))?;
    let refused = || {
        let problem = format!(
            "frames: the entry of '{child}' is in a form that cannot be edited; write it as {{parent, child, \
             translation, rotation_rpy}}"
        );
        FileError::new(path, problem)
    };
    let (preamble, yaml) = split_preamble(text);
    let root = first_document(yaml).ok_or_else(refused)?;
    let entry = root.get("frames").and_then(|frames| frames.items().get(index)).ok_or_else(refused)?;
    let edited = entry_edits(yaml, entry, parent_from_child).ok_or_else(refused)?;
    let edited = format!("{preamble}{}", apply(yaml, edited));
    let after = ProjectorFile::parse(path, &edited).map_err(|_| refused())?;
    if is_with_pose(before, &after, index, parent_from_child) {
        Ok(edited)
    } else {
        Err(refused())
    }
}

/// `true` if `after` is `before` with another pose of one frame.
fn is_with_pose(mut before: ProjectorFile, after: &ProjectorFile, index: usize, pose: &Isometry3<f64>) -> bool {
    let (Some(old), Some(new)) = (before.frames.get_mut(index), after.frames.get(index)) else { return false };
    let written = new.parent_from_child();
    (old.translation_m, old.rotation) = (new.translation_m, new.rotation);
    let is_close = (written.translation.vector - pose.translation.vector).norm() < TOLERANCE
        && written.rotation.angle_to(&pose.rotation) < TOLERANCE;
    is_close && before == *after
}

/// Applies edits, which do not overlap.
fn apply(text: &str, mut edits: Vec<Edit>) -> String {
    edits.sort_by_key(|edit| edit.start);
    let (mut edited, mut next) = (String::new(), 0);
    for edit in edits {
        edited += text.get(next..edit.start).unwrap_or_default();
        edited += &edit.text;
        next = edit.end;
    }
    edited + text.get(next..).unwrap_or_default()
}

/// The edits of an entry of `frames`; `None` for one that cannot be edited.
fn entry_edits(text: &str, entry: &Node, pose: &Isometry3<f64>) -> Option<Vec<Edit>> {
    if entry.scalar().is_some() {
        return word_edits(text, entry, pose);
    }
    if let Some(arguments) = entry.get("transform") {
        return word_edits(text, arguments, pose);
    }
    let Content::Map(_) = entry.content else { return None };
    let translation: [f64; 3] = pose.translation.vector.into();
    let mut edits = match entry.get("translation") {
        Some(old) => list_edits(old, &translation)?,
        None if pose.translation.vector.norm() < RESOLUTION => Vec::new(),
        None => vec![addition(text, entry, "translation", &translation)?],
    };
    edits.extend(match (entry.get("rotation_rpy"), entry.get("rotation_xyzw")) {
        (Some(old), _) => list_edits(old, &rpy_near(&pose.rotation, numbers_of(old)))?,
        (None, Some(old)) => list_edits(old, &xyzw_near(&pose.rotation, numbers_of(old)))?,
        (None, None) if pose.rotation.angle() < RESOLUTION => Vec::new(),
        (None, None) => vec![addition(text, entry, "rotation_rpy", &rpy_near(&pose.rotation, [0.0; 3]))?],
    });
    Some(edits)
}

/// The edits of static_transform_publisher's arguments: x y z yaw pitch roll, or x y z qx qy qz qw.
fn word_edits(text: &str, arguments: &Node, pose: &Isometry3<f64>) -> Option<Vec<Edit>> {
    let expected: Vec<&str> = arguments.scalar()?.split_ascii_whitespace().collect();
    let is_separator = |c: char| c.is_ascii_whitespace() || c == '"' || c == '\'';
    let mut next = arguments.bytes.start;
    let words = text.get(arguments.bytes.clone())?.split(is_separator).map(|word| {
        let start = next;
        next += word.len() + 1;
        (start, word)
    });
    // A comment may follow.
    let words: Vec<(usize, &str)> = words.filter(|(_, word)| !word.is_empty()).take(expected.len()).collect();
    if !words.iter().map(|(_, word)| *word).eq(expected) {
        return None;
    }
    let old: Vec<f64> = words.iter().map_while(|(_, word)| finite(word)).collect();
    let [x, y, z] = pose.translation.vector.into();
    let new = match *old.as_slice() {
        [_, _, _, yaw, pitch, roll] => {
            let [roll, pitch, yaw] = rpy_near(&pose.rotation, [roll, pitch, yaw]);
            vec![x, y, z, yaw, pitch, roll]
        }
        [_, _, _, qx, qy, qz, qw] => [&[x, y, z][..], &xyzw_near(&pose.rotation, [qx, qy, qz, qw])].concat(),
        _ => return None,
    };
    Some(number_edits(&words, &new))
}

/// The edits of a list of numbers; `None` for another value, such as an alias.
fn list_edits(old: &Node, new: &[f64]) -> Option<Vec<Edit>> {
    let numbers = old.items().iter().map(|item| Some((item.bytes.start, item.scalar()?)));
    let numbers: Vec<(usize, &str)> = numbers.collect::<Option<_>>()?;
    (numbers.len() == new.len()).then(|| number_edits(&numbers, new))
}

/// The edits of those numbers, each with its first byte, that do not stay the same.
fn number_edits(old: &[(usize, &str)], new: &[f64]) -> Vec<Edit> {
    let edit = |((start, old), new): (&(usize, &str), &f64)| {
        let is_same = old.parse::<f64>().is_ok_and(|old| (old - new).abs() < RESOLUTION);
        (!is_same).then(|| Edit { start: *start, end: start + old.len(), text: rounded(*new) })
    };
    old.iter().zip(new).filter_map(edit).collect()
}

/// A key that is missing, before `child`.
fn addition(text: &str, entry: &Node, key: &str, values: &[f64]) -> Option<Edit> {
    let (child, _) = entry.entry("child")?;
    let (start, is_flow) = (child.bytes.start, text.get(entry.bytes.start..)?.starts_with('{'));
    let separator = if is_flow {
        ", ".to_owned()
    } else {
        let line_end = if text.contains("\r\n") { "\r\n" } else { "\n" };
        format!("{line_end}{}", " ".repeat(child.column))
    };
    Some(Edit { start, end: start, text: format!("{key}: {}{separator}", list(values, rounded)) })
}

/// A number without the noise of the arithmetic.
fn rounded(value: f64) -> String {
    // Not minus zero.
    number((value * STEPS_PER_UNIT).round() / STEPS_PER_UNIT + 0.0)
}

/// The numbers of a list; zeros if it is none.
fn numbers_of<const N: usize>(list: &Node) -> [f64; N] {
    let number = |item: &Node| item.scalar().and_then(|text| text.parse().ok()).unwrap_or(0.0);
    let numbers: Vec<f64> = list.items().iter().map(number).collect();
    numbers.try_into().unwrap_or([0.0; N])
}

/// Roll, pitch and yaw about fixed axes: of those with this rotation the nearest to other ones.
fn rpy_near(rotation: &UnitQuaternion<f64>, near: [f64; 3]) -> [f64; 3] {
    let matrix = rotation.to_rotation_matrix().into_inner();
    let yaw = match matrix.m11.hypot(matrix.m21) {
        cos_pitch if cos_pitch < GIMBAL_LOCK => near[2],
        _ => matrix.m21.atan2(matrix.m11),
    };
    // Roll and pitch of what remains when the yaw is taken away, which is exact at a gimbal lock as well.
    let with_yaw = |yaw: f64| {
        let (sin, cos) = yaw.sin_cos();
        let roll = (sin * matrix.m13 - cos * matrix.m23).atan2(cos * matrix.m22 - sin * matrix.m12);
        let pitch = (-matrix.m31).atan2(cos * matrix.m11 + sin * matrix.m21);
        let turns_nearest = |angle: f64, near: f64| angle + ((near - angle) / TAU).round() * TAU;
        [turns_nearest(roll, near[0]), turns_nearest(pitch, near[1]), turns_nearest(yaw, near[2])]
    };
    let distance = |rpy: &[f64; 3]| rpy.iter().zip(&near).map(|(angle, near)| (angle - near).abs()).sum::<f64>();
    let [one, other] = [with_yaw(yaw), with_yaw(yaw + PI)];
    if distance(&other) < distance(&one) {
        other
    } else {
        one
    }
}

/// The quaternion with the sign of another one.
fn xyzw_near(rotation: &UnitQuaternion<f64>, near: [f64; 4]) -> [f64; 4] {
    let xyzw: [f64; 4] = rotation.coords.into();
    let dot: f64 = xyzw.iter().zip(&near).map(|(a, b)| a * b).sum();
    xyzw.map(|number| if dot < 0.0 { -number } else { number })
}

#[cfg(test)]
mod tests;
