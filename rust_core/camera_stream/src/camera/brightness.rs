//! A camera that follows the operator's brightness, which may be on its way to another one.

use std::time::{Duration, Instant};

use anyhow::Result;

use super::frame::FrameSpec;
use super::output::CameraPublisher;
use crate::outputs::FrameImage;

impl CameraPublisher {
    /// Publishes the last image again if the operator's brightness has changed since, unless the next frame has other
    /// light or other stale data.
    ///
    /// # Errors
    /// The outputs'.
    pub(super) fn follow_brightness(&mut self, next: Option<&FrameSpec>) -> Result<()> {
        let is_step = self.until_dimmed(Instant::now()) == Some(Duration::ZERO);
        // An image that is triggered has the brightness of its own time.
        let is_due = is_step && !self.timing.schedule.is_triggered();
        let stays = |last: &FrameSpec, next: &FrameSpec| {
            last.has_light_of(next) && !last.content.differs_in_staleness(&next.content)
        };
        let last = self.buffers.front.as_mut().filter(|last| is_due && next.is_none_or(|next| stays(&last.spec, next)));
        let Some(last) = last else { return Ok(()) };
        last.is_published = false;
        self.publish_last(None)
    }

    /// The last image as it is shown.
    pub(crate) fn shown_image(&self) -> Option<FrameImage> {
        self.buffers.front.as_ref().map(|front| self.dimmer.shown(&front.image))
    }

    /// Time until the last image is due at another brightness; `None` if its brightness stays.
    pub(super) fn until_dimmed(&self, now: Instant) -> Option<Duration> {
        let lit = self.buffers.front.as_ref()?.image.lit_image()?;
        let fade = self.context.control.brightness().fade;
        let is_other = fade.at(now) != self.dimmer.brightness() || !fade.is_over(now);
        (is_other && lit.grant().is_valid(now)).then(|| self.dimmer.until_step(now))
    }
}
