//! A pattern of a calibration, which `projector_calibrate` sends on `~patterns` and the projector shows for a while.

use std::time::{Duration, Instant};

use rcs_messages::Image;

use crate::safety::mask_image::grey_levels;

/// Time that a pattern is shown for unless another one follows.
const SHOWN_FOR: Duration = Duration::from_secs(3);

/// An image of the projector's size, in place of the scene.
#[derive(Debug)]
pub(crate) struct Pattern {
    /// Optical frame of the projector; empty: any of this size.
    frame_id: String,
    size_px: [u32; 2],
    levels: Vec<u8>,
    received: Instant,
}

impl Pattern {
    /// Reads an image message.
    ///
    /// # Errors
    /// Another encoding than mono8, or too few bytes.
    pub(crate) fn new(image: &Image, received: Instant) -> Result<Self, String> {
        let frame_id = image.header.frame_id.trim_start_matches('/').to_owned();
        Ok(Self { frame_id, size_px: [image.width, image.height], levels: grey_levels(image)?, received })
    }

    /// `true` until it is too old.
    pub(crate) fn is_current(&self, now: Instant) -> bool {
        now.saturating_duration_since(self.received) < SHOWN_FOR
    }

    /// End of the time that it is shown for.
    pub(crate) fn until(&self) -> Instant {
        self.received + SHOWN_FOR
    }

    /// `true` if it is for the projector with this optical frame and images of this size.
    pub(crate) fn fits(&self, frame_id: &str, size_px: [u32; 2]) -> bool {
        let is_of_frame = self.frame_id.is_empty() || self.frame_id == frame_id.trim_start_matches('/');
        is_of_frame && self.size_px == size_px
    }

    /// Grey levels, row by row.
    pub(crate) fn levels(&self) -> &[u8] {
        &self.levels
    }
}

/// Each message is a pattern of its own.
impl PartialEq for Pattern {
    fn eq(&self, other: &Self) -> bool {
        self.received == other.received
    }
}
