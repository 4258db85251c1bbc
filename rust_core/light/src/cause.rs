//! The table of causes of a blackout. There are no others.
//!
//! | cause | test images, patterns | note in the image (`~stale_note`) |
//! |---|---|---|
//! | the operator has blacked it out (`~blackout`, the camera's switch, key B of its window) | dark | dark |
//! | a rule names a camera or display that the config does not have | dark | dark |
//! | a mask is missing, invalid or stale | dark | dark |
//! | the place of a keep-out frame is missing or stale | dark | dark |
//! | the lens around keep-out frames is unknown | dark | dark |
//! | the surface that confirms the light is missing, invalid or stale | dark | dark |
//! | the camera has no CameraInfo or pose | dark where eyes are protected | dark where eyes are protected |
//! | the CameraInfo or the camera's frame is stale | dark where eyes are protected | dark where eyes are protected |
//! | all displays are stale | lit | lit |
//! | the image is missing or stale (`projector_window`) | dark where a timeout is set | dark |
//! | the image is black (`projector_window`) | dark | dark |
//!
//! The scene is dark for each of them, paused or not.

use std::fmt;

/// Kind of content that asks for light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// The scene, live or paused.
    Scene,
    /// A test image or a calibration pattern, which shows no data.
    Test,
    /// A line of text that says why the image is black.
    Note,
}

/// A row of the table, in its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DarkCause {
    /// The operator has blacked it out.
    Blackout,
    /// A rule names what the config does not have.
    UnknownName,
    /// A mask is missing, invalid or stale.
    Mask,
    /// The place of a keep-out frame is missing or stale.
    KeepOut,
    /// The lens around keep-out frames is unknown.
    Lens,
    /// The surface that confirms the light is missing, invalid or stale.
    Surface,
    /// The camera has no CameraInfo or pose.
    NoCamera,
    /// The CameraInfo or the camera's frame is stale.
    CameraData,
    /// All displays are stale.
    Displays,
    /// The received image is missing or stale.
    NoImage,
    /// The received image is black.
    BlackImage,
}

impl DarkCause {
    /// The causes of a virtual camera. The operator's blackout is asked for with each decision.
    pub const OF_CAMERA: [Self; 8] = [
        Self::UnknownName,
        Self::Mask,
        Self::KeepOut,
        Self::Lens,
        Self::Surface,
        Self::NoCamera,
        Self::CameraData,
        Self::Displays,
    ];
    /// The causes of a window that shows received images.
    pub const OF_IMAGES: [Self; 2] = [Self::NoImage, Self::BlackImage];

    /// `true` if it darkens this content. `protects_eyes`: there are masks, keep-out frames, confirmed light or, for
    /// received images, a timeout.
    pub fn darkens(self, content: Content, protects_eyes: bool) -> bool {
        match (content, self) {
            (Content::Scene, _) => true,
            (_, Self::Displays) => false,
            (_, Self::NoCamera | Self::CameraData) | (Content::Test, Self::NoImage) => protects_eyes,
            (Content::Test | Content::Note, _) => true,
        }
    }

    /// `true` if it does not end when data come again: somebody has to correct it.
    pub fn is_error(self) -> bool {
        self == Self::UnknownName
    }
}

/// Why something is dark.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DarkReason {
    /// Row of the table.
    pub cause: DarkCause,
    /// Text for logs, statuses and notes.
    pub why: String,
}

impl DarkReason {
    /// The reason of a cause.
    pub fn new(cause: DarkCause, why: impl Into<String>) -> Self {
        Self { cause, why: why.into() }
    }
}

impl fmt::Display for DarkReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.why)
    }
}

#[cfg(test)]
mod tests {
    use super::DarkCause::*;
    use super::*;

    #[test]
    fn each_cause_darkens_the_scene_and_those_about_eyes_darken_tests_and_notes() {
        for cause in DarkCause::OF_CAMERA.into_iter().chain(DarkCause::OF_IMAGES).chain([Blackout]) {
            let dark = |content| [false, true].map(|protects_eyes| cause.darkens(content, protects_eyes));
            assert_eq!(dark(Content::Scene), [true, true], "{cause:?}");
            let (test, note) = match cause {
                Displays => ([false, false], [false, false]),
                NoCamera | CameraData => ([false, true], [false, true]),
                NoImage => ([false, true], [true, true]),
                Blackout | UnknownName | Mask | KeepOut | Lens | Surface | BlackImage => ([true, true], [true, true]),
            };
            assert_eq!((dark(Content::Test), dark(Content::Note)), (test, note), "{cause:?}");
            assert_eq!(cause.is_error(), cause == UnknownName);
        }
    }
}
