//! What a picture of a camera shows, and what it may show at a moment.

use std::sync::Arc;
use std::time::Instant;

use rcs_messages::sensor_msgs::CameraInfo;
use rcs_render::LastStep;
use rcs_scene::{Camera, DisplayId};
use rcs_transforms::Time;

use crate::camera_stream::safety::causes::Dark;
use crate::camera_stream::safety::permit::Permit;

/// What a picture shows.
#[derive(Clone, PartialEq)]
pub(crate) enum Content {
    /// The scene in this state, without the displays that are too old.
    Scene { version: u64, camera: Box<Camera>, hidden: Vec<DisplayId> },
    /// Nothing. The size is that before the picture is turned.
    Black { size_px: [u32; 2], dark: Dark, note: Note },
}

/// Whether a black picture says why it is black.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Note {
    Shown,
    NotShown,
}

/// A picture's content, what is done to it, and its CameraInfo.
#[derive(Clone)]
pub(crate) struct Drawn {
    pub(crate) content: Content,
    pub(crate) step: Arc<LastStep>,
    /// Whether the camera has masks on a topic, or keep-out frames.
    pub(crate) protects_eyes: bool,
    /// Another number where other data are left out, or of another config.
    pub(crate) scene: u64,
    pub(crate) info: Arc<CameraInfo>,
    /// Until when it is true if nothing new arrives.
    pub(crate) until: Option<Instant>,
    /// When its frames were looked up, in ROS time, if they were predicted.
    pub(crate) looked_up: Option<Time>,
}

impl Content {
    /// Whether one of the two shows something that the other must not.
    pub(crate) fn differs_in_age(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Scene { hidden: own, .. }, Self::Scene { hidden, .. }) => own != hidden,
            (Self::Black { .. }, Self::Black { .. }) => false,
            _ => true,
        }
    }
}

impl Drawn {
    /// The permit for a window to show something else in its place.
    pub(crate) fn permit(&self) -> Permit {
        let dark = match &self.content {
            Content::Scene { .. } => None,
            Content::Black { dark, .. } => Some(dark),
        };
        Permit::new(dark, self.protects_eyes, self.scene, &self.step)
    }

    /// Whether a picture of the other one looks the same.
    pub(crate) fn shows_the_same(&self, other: &Self) -> bool {
        self.content == other.content && self.step == other.step
    }

    /// Whether it has expired.
    pub(crate) fn is_over(&self, now: Instant) -> bool {
        self.until.is_some_and(|until| until < now)
    }
}

/// The size of a camera's pictures.
pub(crate) fn size_px(camera: &Camera) -> [u32; 2] {
    camera.lens().map_or([camera.width_px(), camera.height_px()], |lens| lens.size_px())
}
