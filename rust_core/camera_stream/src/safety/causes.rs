//! Blackout: the table of causes.
//!
//! | cause | beats a pause | beats test pictures | says why in the image (`~stale_note`) |
//! |---|---|---|---|
//! | the operator has blacked it out (`~blackout`, the camera's switch, key b of its window) | yes | yes | no |
//! | a rule names a camera or display that the config does not have | yes | yes | no |
//! | a mask is missing, invalid or stale | yes | yes | no |
//! | the place of a keep-out frame is missing or stale | yes | yes | no |
//! | the lens around keep-out frames is unknown | yes | yes | no |
//! | the surface that confirms the light is missing, invalid or stale | yes | yes | no |
//! | the camera has no CameraInfo or pose | yes | where eyes are protected | where no eyes are protected |
//! | the CameraInfo or the camera's frame is stale | yes | where eyes are protected | yes |
//! | all displays are stale | yes | no | yes |
//! | nothing was drawn or confirmed in time: the node is busy, hangs or is gone | yes | where eyes are protected | no |
//! | an image that is black came on a topic (`projector_window`) | yes | no | it has what it has |
//!
//! Beside these, a window is black before its first image, and without its camera or its monitor; an image whose blend
//! weights have another size is black; and what a mask or a keep-out frame covers, or the last surface did not confirm,
//! stays dark in pauses and test pictures.

use std::fmt;

/// A row of the table, in its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum DarkCause {
    Blackout,
    UnknownName,
    Mask,
    KeepOut,
    Lens,
    Surface,
    NoCamera,
    CameraData,
    Displays,
    Silence,
    BlackImage,
}

impl DarkCause {
    /// `true` if test pictures, which are for focusing before the robot runs, are dark, too.
    pub(crate) fn beats_test_pictures(self, protects_eyes: bool) -> bool {
        match self {
            Self::Blackout | Self::UnknownName | Self::Mask | Self::KeepOut | Self::Lens | Self::Surface => true,
            Self::NoCamera | Self::CameraData | Self::Silence => protects_eyes,
            Self::Displays | Self::BlackImage => false,
        }
    }

    /// `true` if the black image may say why it is black: not while it is unknown where eyes are.
    pub(crate) fn allows_note(self, protects_eyes: bool) -> bool {
        match self {
            Self::CameraData | Self::Displays => true,
            Self::NoCamera => !protects_eyes,
            Self::Blackout | Self::UnknownName | Self::Mask | Self::KeepOut | Self::Lens | Self::Surface => false,
            Self::Silence | Self::BlackImage => false,
        }
    }

    /// `true` if it does not end when data come again: somebody has to correct it.
    pub(crate) fn is_error(self) -> bool {
        self == Self::UnknownName
    }

    pub(crate) fn status(self) -> &'static str {
        match self {
            Self::CameraData | Self::Displays => super::STALE,
            _ => "Dark",
        }
    }
}

/// Why a camera is dark.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct DarkReason {
    /// Row of the table.
    pub(crate) cause: DarkCause,
    /// Text for logs, statuses and notes.
    pub(crate) why: String,
}

impl DarkReason {
    pub(crate) fn new(cause: DarkCause, why: impl Into<String>) -> Self {
        Self { cause, why: why.into() }
    }
}

impl fmt::Display for DarkReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.why)
    }
}
