//! A camera's images at the operator's brightness: the last step before the outputs, which can only darken.
//!
//! Images are kept as their grants light them, so that a pause, a new mask and a fade do not depend on each other. Black
//! images stay as they are: a blackout never waits for a fade.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Result;
use rcs_light::Lit;
use rcs_render::Brightness;
use rcs_scene::Image;

use super::frame::FrameSpec;
use super::output::CameraPublisher;
use crate::outputs::FrameImage;

/// Time between two images of a fade.
const STEP: Duration = Duration::from_millis(33);

/// Dims the images of a camera, each once.
pub(super) struct Dimmer {
    /// The brightness of the last published image, and its time.
    last: (Brightness, Option<Instant>),
    /// The last dimmed image and what it was made of.
    dimmed: Option<(Lit<Arc<Image>>, Arc<Image>)>,
}

impl Default for Dimmer {
    fn default() -> Self {
        Self { last: (Brightness::FULL, None), dimmed: None }
    }
}

impl Dimmer {
    /// The image at a brightness, with its own grant.
    pub(super) fn apply(&mut self, image: &FrameImage, brightness: Brightness, now: Instant) -> FrameImage {
        let (before, _) = std::mem::replace(&mut self.last, (brightness, Some(now)));
        let Some(lit) = image.lit_image().filter(|_| brightness != Brightness::FULL) else {
            self.dimmed = None;
            return image.clone();
        };
        let known = self.dimmed.take().filter(|(source, _)| before == brightness && source.is_same(lit));
        let dim = |drawn: &Arc<Image>| {
            let mut image = Image::clone(drawn);
            brightness.apply(&mut image);
            Arc::new(image)
        };
        let Ok(dimmed) = lit.convert(|drawn| {
            let dimmed = known.map_or_else(|| dim(drawn), |(_, dimmed)| dimmed);
            self.dimmed = Some((lit.clone(), Arc::clone(&dimmed)));
            Ok::<_, Infallible>(dimmed)
        });
        FrameImage::lit(dimmed)
    }

    fn until_step(&self, now: Instant) -> Duration {
        self.last.1.map_or(Duration::ZERO, |last| (last + STEP).saturating_duration_since(now))
    }
}

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
        let front = &self.buffers.front.as_ref()?.image;
        let dimmed = self.dimmer.dimmed.as_ref().zip(front.lit_image()).filter(|((of, _), lit)| of.is_same(lit));
        let Some(((_, dimmed), lit)) = dimmed else { return Some(front.clone()) };
        let Ok(shown) = lit.convert(|_| Ok::<_, Infallible>(Arc::clone(dimmed)));
        Some(FrameImage::lit(shown))
    }

    /// Time until the last image is due at another brightness; `None` if its brightness stays.
    pub(super) fn until_dimmed(&self, now: Instant) -> Option<Duration> {
        let lit = self.buffers.front.as_ref()?.image.lit_image()?;
        let fade = self.context.control.brightness().fade;
        let is_other = fade.at(now) != self.dimmer.last.0 || !fade.is_over(now);
        (is_other && lit.grant().is_valid(now)).then(|| self.dimmer.until_step(now))
    }
}

#[cfg(test)]
mod tests {
    use rcs_light::Grant;

    use super::*;

    #[test]
    fn full_brightness_costs_nothing_and_an_image_is_dimmed_once() {
        let (mut dimmer, now) = (Dimmer::default(), Instant::now());
        let mut white = Image::default();
        white.reset(2, 1, rcs_scene::Encoding::Mono8);
        white.data.fill(200);
        let lit = FrameImage::lit(Grant::of_tool().show(Arc::new(white)).unwrap());
        let half = Brightness::new(0.5).unwrap();
        let mut apply = |brightness| dimmer.apply(&lit, brightness, now).content(now);
        assert!(Arc::ptr_eq(&apply(Brightness::FULL), &lit.content(now)));
        let dimmed = apply(half);
        assert_eq!(dimmed.data, [100, 100]);
        assert!(Arc::ptr_eq(&apply(half), &dimmed));
        assert_eq!(apply(Brightness::DARK).data, [0, 0]);
        assert_eq!(apply(half).data, [100, 100], "from the image as it was lit");
        assert_eq!(lit.content(now).data, [200, 200]);
    }
}
