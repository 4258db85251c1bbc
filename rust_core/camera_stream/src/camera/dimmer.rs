//! Images at the operator's brightness: the last step before the outputs, which can only darken.
//!
//! Images are kept as their grants light them, so that a pause, a new mask and a fade do not depend on each other.
//! Black images stay as they are: a blackout never waits for a fade.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_light::Lit;
use rcs_render::Brightness;
use rcs_scene::Image;

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

    /// The image as it was dimmed last, if it was; with its own grant.
    pub(super) fn shown(&self, image: &FrameImage) -> FrameImage {
        let dimmed = self.dimmed.as_ref().zip(image.lit_image()).filter(|((of, _), lit)| of.is_same(lit));
        let Some(((_, dimmed), lit)) = dimmed else { return image.clone() };
        let Ok(shown) = lit.convert(|_| Ok::<_, Infallible>(Arc::clone(dimmed)));
        FrameImage::lit(shown)
    }

    /// The brightness of the last published image.
    pub(super) fn brightness(&self) -> Brightness {
        self.last.0
    }

    /// Time until another image of a fade is due.
    pub(super) fn until_step(&self, now: Instant) -> Duration {
        self.last.1.map_or(Duration::ZERO, |last| (last + STEP).saturating_duration_since(now))
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
