//! Calibration pattern: an image from `projector_calibrate` on `~patterns`, shown for a while in place of the scene.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_messages::Image;

use crate::safety::mask_image::grey_levels;

/// Time for which a pattern is shown unless another one follows.
const SHOWN_FOR: Duration = Duration::from_secs(3);

/// Calibration pattern of the projector's size.
#[derive(Debug)]
pub(crate) struct Pattern {
    /// Optical frame of the projector; empty: any projector of this size.
    frame_id: String,
    size_px: [u32; 2],
    levels: Arc<Vec<u8>>,
    received: Instant,
}

impl Pattern {
    /// Converts an image message.
    ///
    /// # Errors
    /// The encoding is not mono8, or bytes are missing.
    pub(crate) fn new(image: &Image, received: Instant) -> Result<Self, String> {
        let frame_id = image.header.frame_id.trim_start_matches('/').to_owned();
        Ok(Self { frame_id, size_px: [image.width, image.height], levels: Arc::new(grey_levels(image)?), received })
    }

    /// `true` while the pattern is to be shown.
    pub(crate) fn is_current(&self, now: Instant) -> bool {
        now.saturating_duration_since(self.received) < SHOWN_FOR
    }

    /// Time from which the pattern is not shown any more.
    pub(crate) fn until(&self) -> Instant {
        self.received + SHOWN_FOR
    }

    /// `true` if the pattern is for a projector with this optical frame and image size.
    pub(crate) fn fits(&self, frame_id: &str, size_px: [u32; 2]) -> bool {
        let is_of_frame = self.frame_id.is_empty() || self.frame_id == frame_id.trim_start_matches('/');
        is_of_frame && self.size_px == size_px
    }

    /// Why no camera shows the pattern: what came and what the cameras expect. `None` if it fits one of them. Cameras
    /// are optical frames with image sizes.
    pub(crate) fn misfit(&self, cameras: &[(&str, [u32; 2])]) -> Option<String> {
        if cameras.iter().any(|(frame_id, size_px)| self.fits(frame_id, *size_px)) {
            return None;
        }
        let place = |frame_id: &str, [width, height]: [u32; 2]| match frame_id {
            "" => format!("{width}x{height} pixels"),
            frame_id => format!("{width}x{height} pixels for frame {frame_id}"),
        };
        let mut expected: Vec<String> = cameras.iter().map(|(frame_id, size_px)| place(frame_id, *size_px)).collect();
        expected.dedup();
        let came = place(&self.frame_id, self.size_px);
        Some(match expected.as_slice() {
            [] => format!("a pattern of {came} came before any CameraInfo; check the camera_info topics"),
            expected => format!(
                "a pattern of {came} fits no camera, which take {}; calibrate with the projector's size and frame",
                expected.join(" or ")
            ),
        })
    }

    /// Grey levels, row by row.
    pub(crate) fn levels(&self) -> Arc<Vec<u8>> {
        Arc::clone(&self.levels)
    }
}

/// Patterns are equal if they are the same message.
impl PartialEq for Pattern {
    fn eq(&self, other: &Self) -> bool {
        self.received == other.received
    }
}

#[cfg(test)]
mod tests {
    use rcs_messages::std_msgs::Header;

    use super::*;

    fn pattern(frame_id: &str, size_px: [u32; 2]) -> Pattern {
        let header = Header { frame_id: frame_id.to_owned(), ..Header::default() };
        let levels = Arc::new(vec![255; (size_px[0] * size_px[1]) as usize]);
        Pattern::new(&Image::new(header, size_px, "mono8", size_px[0], levels), Instant::now()).unwrap()
    }

    #[test]
    fn a_pattern_of_another_size_or_frame_is_named_with_what_was_expected() {
        let cameras = [("left_lens", [64, 40]), ("right_lens", [80, 50])];
        assert_eq!(pattern("", [80, 50]).misfit(&cameras), None);
        assert_eq!(pattern("/left_lens", [64, 40]).misfit(&cameras), None);
        let why = |frame_id: &str, size_px| pattern(frame_id, size_px).misfit(&cameras).unwrap();
        let expected = "which take 64x40 pixels for frame left_lens or 80x50 pixels for frame right_lens;";
        let of_size = why("", [32, 20]);
        assert!(of_size.starts_with("a pattern of 32x20 pixels fits no camera") && of_size.contains(expected));
        let of_frame = why("right_lens", [64, 40]);
        assert!(of_frame.contains("64x40 pixels for frame right_lens fits no camera") && of_frame.contains(expected));
        assert!(pattern("", [8, 8]).misfit(&[]).unwrap().contains("before any CameraInfo"));
    }
}
