//! Whether a camera has nothing to show, so that its projector may be verified meanwhile.

use std::time::Instant;

use rcs_light::DarkCause;
use rcs_window::ScreenImage;

use super::frame::FrameContent;
use super::output::CameraPublisher;

impl CameraPublisher {
    /// Why the camera is not dark only because there is nothing to show; `None` if it is.
    pub(crate) fn why_busy(&self) -> Option<String> {
        let operator = self.operator();
        if let Some(dark) = self.dark_reason(&operator) {
            return (dark.cause != DarkCause::Displays).then_some(dark.why);
        }
        if let Some(caller) = operator.paused {
            return Some(format!("paused by {caller}"));
        }
        let Some(last) = &self.buffers.front else { return Some("no image so far".to_owned()) };
        match &last.spec.content {
            FrameContent::Test { .. } => Some("a test picture or a pattern is shown".to_owned()),
            FrameContent::Black { dark, .. } | FrameContent::Note { dark, .. } => {
                (dark.cause != DarkCause::Displays).then(|| dark.why.clone())
            }
            FrameContent::Scene { .. } => {
                let image = last.image.content(Instant::now());
                let is_black = ScreenImage::from_image(&image).is_ok_and(|image| image.is_black());
                (!is_black).then(|| "the scene is shown".to_owned())
            }
        }
    }
}
