//! The robot during a scan: its description, and the frames from the camera's optical frame up to the root of TF.

use std::fmt;

use serde::de::{Deserializer, Error as _, SeqAccess, Visitor};
use serde::Deserialize;

use crate::projector::checked_numbers::Matrix;
use crate::projector::frames::{named_frame, unit_quaternion};
use crate::projector::StaticFrame;
use crate::yaml_text::{list, number, quoted};

/// Largest number of frames between a camera and the root of TF.
const MOST_FRAMES: usize = 1000;

/// The robot that carried the camera, as it was during the scan.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CapturedRobot {
    /// The URDF; `None` if there was none.
    pub description: Option<String>,
    /// Frames from the camera's optical frame up to the root of TF: the parent of each is the child of the next. Empty
    /// if the camera was not in TF.
    pub frames: Vec<CapturedFrame>,
}

/// A frame above the camera.
#[derive(Debug, Clone, PartialEq)]
pub struct CapturedFrame {
    /// Its pose in its parent during the scan.
    pub frame: StaticFrame,
    /// How it moves in its parent.
    pub motion: FrameMotion,
    /// Name of the joint that moves it; `None` if the description has none.
    pub joint: Option<String>,
}

/// How a frame moves in its parent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FrameMotion {
    /// Not at all.
    Fixed,
    /// It rotates within limits.
    Revolute,
    /// It rotates without limits.
    Continuous,
    /// It slides.
    Prismatic,
    /// It moves freely.
    Floating,
    /// It moves in a plane.
    Planar,
    /// Unknown: it was published on /tf, and the description does not have it.
    Moving,
}

impl FrameMotion {
    /// Its name in `capture.yaml`.
    fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Revolute => "revolute",
            Self::Continuous => "continuous",
            Self::Prismatic => "prismatic",
            Self::Floating => "floating",
            Self::Planar => "planar",
            Self::Moving => "moving",
        }
    }
}

/// Keys of an entry of `frames`.
#[derive(Deserialize)]
struct RawCapturedFrame {
    parent: String,
    child: String,
    translation: Matrix<3>,
    rotation_xyzw: Matrix<4>,
    motion: FrameMotion,
    joint: Option<String>,
}

impl RawCapturedFrame {
    fn frame(self) -> Result<CapturedFrame, String> {
        let (Matrix(translation_m), Matrix(rotation)) = (self.translation, self.rotation_xyzw);
        let [parent, child] = [&self.parent, &self.child].map(|name| name.trim_start_matches('/'));
        let frame = named_frame(parent, child, translation_m, unit_quaternion(rotation)?)?;
        Ok(CapturedFrame { frame, motion: self.motion, joint: self.joint })
    }
}

/// The list `frames`, checked to be a chain.
#[derive(Default)]
pub(super) struct FrameChain(pub(super) Vec<CapturedFrame>);

impl<'de> Deserialize<'de> for FrameChain {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ChainVisitor;
        impl<'de> Visitor<'de> for ChainVisitor {
            type Value = FrameChain;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a list of frames: {{parent, child, translation, rotation_xyzw, motion, joint}}")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<FrameChain, A::Error> {
                let mut frames: Vec<CapturedFrame> = Vec::new();
                while let Some(raw) = list.next_element::<RawCapturedFrame>()? {
                    frames.push(raw.frame().map_err(A::Error::custom)?);
                    check_chain(&frames).map_err(A::Error::custom)?;
                }
                Ok(FrameChain(frames))
            }
        }
        deserializer.deserialize_seq(ChainVisitor)
    }
}

/// Checks the last frame of a chain against those before.
fn check_chain(frames: &[CapturedFrame]) -> Result<(), String> {
    if frames.len() > MOST_FRAMES {
        return Err(format!("more than {MOST_FRAMES} frames"));
    }
    match frames {
        [.., below, above] if below.frame.parent != above.frame.child => {
            Err(format!("frame '{}' follows '{}', whose parent it is not", above.frame.child, below.frame.child))
        }
        _ => Ok(()),
    }
}

impl CapturedRobot {
    /// Checks that the frames can be read again.
    pub(super) fn check(&self) -> Result<(), String> {
        (1..=self.frames.len()).try_for_each(|count| check_chain(&self.frames[..count]))?;
        self.frames.iter().try_for_each(|CapturedFrame { frame, .. }| {
            let StaticFrame { parent, child, translation_m, rotation } = frame;
            if parent.starts_with('/') || child.starts_with('/') {
                return Err(format!("frame '{child}' in '{parent}': a slash in front"));
            }
            if translation_m.iter().chain(rotation.coords.iter()).any(|value| !value.is_finite()) {
                return Err(format!("frame '{child}': a number is not finite"));
            }
            named_frame(parent, child, *translation_m, *rotation).map(drop)
        })
    }

    /// Formats the list `frames`; empty without frames.
    pub(super) fn frame_lines(&self) -> String {
        if self.frames.is_empty() {
            return String::new();
        }
        self.frames.iter().fold("frames:\n".to_owned(), |text, frame| text + &frame_line(frame))
    }
}

fn frame_line(CapturedFrame { frame, motion, joint }: &CapturedFrame) -> String {
    let rotation = frame.rotation;
    format!(
        "  - {{parent: {}, child: {}, translation: {}, rotation_xyzw: {}, motion: {}{}}}\n",
        quoted(&frame.parent),
        quoted(&frame.child),
        list(&frame.translation_m, number),
        list(&[rotation.i, rotation.j, rotation.k, rotation.w], number),
        motion.name(),
        joint.as_ref().map(|joint| format!(", joint: {}", quoted(joint))).unwrap_or_default(),
    )
}
