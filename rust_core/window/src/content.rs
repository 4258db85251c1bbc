//! The window's content: the newest image while its grant holds, else black. Independent of window system and clock,
//! for tests.

use std::sync::Arc;
use std::time::Instant;

use rcs_light::{Grant, Lit};

use crate::screen_image::ScreenImage;

/// The content of a window over time.
#[derive(Debug, Default)]
pub(crate) struct WindowContent {
    newest: Option<Lit<Arc<ScreenImage>>>,
    /// `true` if the image was on the screen at the last [`check`](Self::check).
    is_lit: bool,
}

impl WindowContent {
    /// The image on the screen; `None` for black.
    pub(crate) fn on_screen(&self, now: Instant) -> Option<&ScreenImage> {
        self.newest.as_ref()?.content(now).map(Arc::as_ref)
    }

    /// Takes a new image. Returns the one before, for its memory.
    pub(crate) fn take(&mut self, image: Lit<Arc<ScreenImage>>) -> Option<ScreenImage> {
        Arc::into_inner(self.newest.replace(image)?.into_memory())
    }

    /// Takes a grant of the newest image. Returns `true` if it is one of that.
    pub(crate) fn renew(&mut self, grant: &Grant) -> bool {
        self.newest.as_mut().is_some_and(|newest| newest.renew(grant))
    }

    /// Drops the image.
    pub(crate) fn clear(&mut self) {
        self.newest = None;
    }

    /// Time of the next [`check`](Self::check), unless something else happens before.
    pub(crate) fn next_check(&self) -> Option<Instant> {
        self.newest.as_ref().filter(|_| self.is_lit).map(|newest| newest.grant().until())
    }

    /// Checks whether the grant still holds. Returns `true` if the screen changes.
    pub(crate) fn check(&mut self, now: Instant) -> bool {
        let is_lit = self.on_screen(now).is_some();
        let was_lit = std::mem::replace(&mut self.is_lit, is_lit);
        let has_ended = |newest: &Lit<_>| newest.grant().until() <= now;
        if was_lit && !is_lit && self.newest.as_ref().is_some_and(has_ended) {
            log::warn!("no picture in time: the window is black until there is one");
        }
        was_lit != is_lit
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use rcs_light::{Content, DarkReason, Evidence, Generation, LightRules};

    use super::*;

    fn grant(generation: &Generation, now: Instant) -> Grant {
        let evidence = Evidence::unknown(&[], LightRules::none(Duration::from_secs(1)), Arc::default());
        let decided: Result<_, DarkReason> = evidence.decide(Content::Scene, [1, 1], Ok(generation.clone()), now);
        decided.unwrap()
    }

    fn image(level: u8, grant: Grant) -> Lit<Arc<ScreenImage>> {
        grant.show(Arc::new(ScreenImage::from_fn(1, 1, |_, _| [level; 3]))).unwrap()
    }

    /// The level of a screen of one pixel; `None` for black.
    fn shown(content: &WindowContent, now: Instant) -> Option<u32> {
        content.on_screen(now).map(|image| image.pixels()[0] & 0xff)
    }

    #[test]
    fn a_image_is_shown_until_its_grant_ends_and_again_when_it_is_renewed() {
        let (start, generation) = (Instant::now(), Generation::default());
        let later = |millis| start + Duration::from_millis(millis);
        let mut content = WindowContent::default();
        assert!(!content.check(start) && shown(&content, start).is_none() && content.next_check().is_none());
        content.take(image(1, grant(&generation, start)));
        assert!(content.check(start));
        assert_eq!((shown(&content, later(999)), content.next_check()), (Some(1), Some(later(1000))));
        content.renew(&grant(&generation, later(900)));
        assert!(!content.check(later(1000)));
        assert!(content.check(later(1900)) && shown(&content, later(1900)).is_none());
        content.renew(&grant(&generation, later(2000)));
        assert!(content.check(later(2000)) && shown(&content, later(2000)) == Some(1));
    }

    #[test]
    fn a_word_of_the_operator_voids_the_image_and_a_later_grant_does_not_bring_it_back() {
        let (now, mut generation) = (Instant::now(), Generation::default());
        let mut content = WindowContent::default();
        content.take(image(1, grant(&generation, now)));
        content.check(now);
        generation.advance();
        assert!(content.check(now) && shown(&content, now).is_none());
        content.renew(&grant(&generation, now));
        assert_eq!(shown(&content, now), None, "it is an old picture");
        content.take(image(2, grant(&generation, now)));
        assert_eq!(shown(&content, now), Some(2));
        content.clear();
        assert!(!content.check(now) && shown(&content, now).is_none());
    }
}
