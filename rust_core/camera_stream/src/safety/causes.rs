//! Why there is no light: the table of causes.
//!
//! | cause | beats a pause | beats test pictures | says why in the image (`~stale_note`) |
//! |---|---|---|---|
//! | a rule names a camera that the config does not have | yes | yes | no |
//! | a mask is missing, invalid or too old | yes | yes | no |
//! | the place of a keep-out frame is missing or too old | yes | yes | no |
//! | where the lens sends light around keep-out frames is unknown | yes | yes | no |
//! | the camera has no CameraInfo or pose | yes | where eyes are protected | where no eyes are protected |
//! | the CameraInfo or the camera's frame is too old | yes | where eyes are protected | yes |
//! | all that is shown is too old | yes | no | yes |
//! | nothing was drawn or confirmed in time: the node is busy, hangs or is gone | yes | where eyes are protected | no |
//! | an image that is black came on a topic (`projector_window`) | yes | no | it has what it has |
//!
//! Beside these, a window is black before its first image, without its camera or its monitor, and on key b; an image
//! whose blend weights have another size is black; and what a mask or a keep-out frame covers stays dark in all of a
//! window's modes.

use std::fmt;

/// A row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// A rule names a camera that the config does not have.
    UnknownCamera,
    /// A mask is missing, invalid or too old.
    Mask,
    /// The place of a keep-out frame is missing or too old.
    KeepOut,
    /// Where the lens sends light around keep-out frames is unknown.
    Lens,
    /// The camera has no CameraInfo or pose.
    NoCamera,
    /// The CameraInfo or the camera's frame is too old.
    CameraData,
    /// All that is shown is too old.
    Displays,
    /// Nothing was drawn or confirmed in time.
    Silence,
    /// A black image came on a topic.
    BlackImage,
}

impl Cause {
    /// Whether test pictures, which are for focusing before the robot runs, are dark, too.
    pub fn beats_test_pictures(self, protects_eyes: bool) -> bool {
        match self {
            Self::UnknownCamera | Self::Mask | Self::KeepOut | Self::Lens => true,
            Self::NoCamera | Self::CameraData | Self::Silence => protects_eyes,
            Self::Displays | Self::BlackImage => false,
        }
    }

    /// Whether the black image may say why it is black: not where it is unknown where eyes are.
    pub fn allows_note(self, protects_eyes: bool) -> bool {
        match self {
            Self::CameraData | Self::Displays => true,
            Self::NoCamera => !protects_eyes,
            Self::UnknownCamera | Self::Mask | Self::KeepOut | Self::Lens | Self::Silence | Self::BlackImage => false,
        }
    }

    /// Whether somebody has to put it right: it does not end when data come again.
    pub fn is_error(self) -> bool {
        self == Self::UnknownCamera
    }

    /// The name of the status that says so.
    pub fn status(self) -> &'static str {
        match self {
            Self::CameraData | Self::Displays => super::STALE,
            _ => "Dark",
        }
    }
}

/// Why a camera is dark.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dark {
    /// The row of the table.
    pub cause: Cause,
    /// The reason, such as missing or stale data.
    pub why: String,
}

impl Dark {
    pub(super) fn new(cause: Cause, why: impl Into<String>) -> Self {
        Self { cause, why: why.into() }
    }
}

impl fmt::Display for Dark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.why)
    }
}
