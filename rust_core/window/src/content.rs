//! The window's content: the newest picture, black for stale pictures, or the view that a key selected, within its
//! permit. Independent of window system and clock, for tests.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::keys::WindowKey;
use crate::light::{LightLimit, Mask, WindowPermit, WindowView};
use crate::screen_picture::ScreenPicture;
use crate::test_pictures::TestPicture;

/// The content of the screen.
#[derive(Debug, Clone, Copy)]
pub(crate) enum ScreenContent<'a> {
    /// No light.
    Black,
    /// A received picture.
    Picture(&'a ScreenPicture),
    /// A test picture in the monitor's resolution, within the mask.
    Test(TestPicture, Option<&'a Arc<dyn Mask>>),
}

/// The view that the user selected with a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ViewMode {
    /// The newest picture.
    Live,
    /// The picture at the time of the key press.
    Paused,
    /// Black.
    Black,
    /// A test picture.
    Test(TestPicture),
}

/// A received picture.
#[derive(Debug, Default)]
pub(crate) struct ContentImage {
    /// The picture in the screen's format.
    pub(crate) picture: ScreenPicture,
    /// Limits of content in its place.
    pub(crate) permit: WindowPermit,
}

/// The content of a window over time.
#[derive(Debug)]
pub(crate) struct WindowContent {
    /// The newest picture; `None` while it is held.
    newest: Option<ContentImage>,
    /// The paused picture.
    held: Option<ContentImage>,
    /// Limits of content in place of the newest picture; `None` before the first.
    permit: Option<WindowPermit>,
    /// Limit of test pictures before the first picture, and when pictures are stale.
    silent_test: LightLimit,
    arrived: Option<Instant>,
    stale_timeout: Option<Duration>,
    is_stale: bool,
    mode: ViewMode,
}

impl WindowContent {
    /// Black until the first picture, and `stale_timeout` after the last one.
    pub(crate) fn new(stale_timeout: Option<Duration>, silent_test: LightLimit) -> Self {
        let stale_timeout = stale_timeout.filter(|timeout| !timeout.is_zero());
        let (newest, held, permit, arrived) = (None, None, None, None);
        Self { newest, held, permit, silent_test, arrived, stale_timeout, is_stale: false, mode: ViewMode::Live }
    }

    /// Sets the time after which pictures are stale; zero: never.
    pub(crate) fn set_stale_timeout(&mut self, timeout: Duration) {
        self.stale_timeout = Some(timeout).filter(|timeout| !timeout.is_zero());
    }

    /// The content of the screen.
    pub(crate) fn on_screen(&self) -> ScreenContent<'_> {
        let permit = self.permit.as_ref().filter(|_| !self.is_stale);
        match (self.mode, permit) {
            (ViewMode::Test(test), permit) => {
                let light = permit.map_or(&self.silent_test, |permit| &permit.test);
                let test = Some(test).filter(|_| !light.is_nothing());
                let mask = match light {
                    LightLimit::Masked(mask) => Some(mask),
                    LightLimit::All | LightLimit::Nothing => None,
                };
                test.map_or(ScreenContent::Black, |test| ScreenContent::Test(test, mask))
            }
            (ViewMode::Black, _) | (_, None) => ScreenContent::Black,
            (ViewMode::Paused, Some(permit)) if permit.is_lit => picture_of(self.held.as_ref()),
            (ViewMode::Live | ViewMode::Paused, Some(_)) => picture_of(self.newest.as_ref()),
        }
    }

    /// The newest picture, or the held one.
    pub(crate) fn picture(&self) -> Option<&ScreenPicture> {
        self.newest.as_ref().or(self.held.as_ref()).map(|image| &image.picture)
    }

    /// Takes a new picture. Returns a replaced picture for its memory, and whether the screen changes.
    pub(crate) fn take(&mut self, image: ContentImage, now: Instant) -> (Option<ScreenPicture>, bool) {
        let mut changes = self.note_alive(now) | self.set_permit(&image.permit);
        let old = self.newest.replace(image);
        match self.mode {
            ViewMode::Live => changes = true,
            ViewMode::Paused => changes |= self.update_held(),
            ViewMode::Black | ViewMode::Test(_) => {}
        }
        (old.map(|image| image.picture), changes)
    }

    /// Takes the newest picture again, with its permit. Returns `true` if the screen changes.
    pub(crate) fn repeat(&mut self, permit: &WindowPermit, now: Instant) -> bool {
        self.note_alive(now) | self.set_permit(permit)
    }

    fn set_permit(&mut self, permit: &WindowPermit) -> bool {
        let old = self.permit.replace(permit.clone());
        match self.mode {
            ViewMode::Test(_) => old.is_none_or(|old| old.test.differs(&permit.test)),
            ViewMode::Paused => old.is_none_or(|old| old.is_lit != permit.is_lit),
            ViewMode::Live | ViewMode::Black => false,
        }
    }

    /// Holds the newest picture from now on, unless one is held. Returns `true` if the screen changes.
    fn update_held(&mut self) -> bool {
        // A newest picture without light is shown in place of the held one, and is not held.
        if self.permit.as_ref().is_some_and(|permit| permit.is_lit) {
            if self.held.is_some() {
                return false;
            }
            self.held = self.newest.take();
        }
        true
    }

    /// Drops all pictures. Returns `true` if the screen changes.
    pub(crate) fn clear(&mut self) -> bool {
        (self.newest, self.held, self.permit, self.arrived, self.is_stale) = (None, None, None, None, false);
        true
    }

    /// Records that pictures are current. Returns `true` if the screen changes.
    pub(crate) fn note_alive(&mut self, now: Instant) -> bool {
        self.arrived = Some(now);
        let was_stale = std::mem::replace(&mut self.is_stale, false);
        if was_stale {
            log::info!("pictures arrive again");
        }
        was_stale
    }

    /// Records that the newest picture was current at a time. Returns `true` if the screen changes.
    pub(crate) fn confirm(&mut self, at: Instant) -> bool {
        self.arrived.is_some_and(|arrived| arrived < at) && self.note_alive(at)
    }

    /// Time of the next [`check`](Self::check), unless another picture arrives.
    pub(crate) fn next_check(&self) -> Option<Instant> {
        self.arrived?.checked_add(self.stale_timeout.filter(|_| !self.is_stale)?)
    }

    /// Checks for stale pictures. Returns `true` if the screen changes.
    pub(crate) fn check(&mut self, now: Instant) -> bool {
        if self.next_check().is_none_or(|at| now < at) {
            return false;
        }
        self.is_stale = true;
        let seconds = self.stale_timeout.unwrap_or_default().as_secs_f64();
        log::warn!("no picture for {seconds} s: the window is black until there is one");
        true
    }

    /// Selects the view of a key; pressed again, the key returns to the pictures. Returns `false` for other keys.
    pub(crate) fn press(&mut self, key: WindowKey) -> bool {
        let wanted = match key {
            WindowKey::Space | WindowKey::Character('p' | 'P') => ViewMode::Paused,
            WindowKey::Character('b' | 'B') => ViewMode::Black,
            WindowKey::Character('t' | 'T') => self.next_test(),
            _ => return false,
        };
        self.mode = if self.mode == wanted { ViewMode::Live } else { wanted };
        match self.mode {
            ViewMode::Live => log::info!("showing pictures"),
            ViewMode::Paused => log::info!("paused: the picture stays until the key is pressed again"),
            ViewMode::Black => log::info!("black until the key is pressed again"),
            ViewMode::Test(test) => log::info!("test picture {}", test.name()),
        }
        match self.mode {
            // A blacked-out picture is not held.
            ViewMode::Paused => {
                self.update_held();
            }
            _ => self.newest = self.newest.take().or(self.held.take()),
        }
        self.held = self.held.take().filter(|_| self.mode == ViewMode::Paused);
        true
    }

    /// Selects a view for the program. Returns `true` if the screen changes.
    pub(crate) fn set_view(&mut self, view: WindowView) -> bool {
        let mode = match view {
            WindowView::Live => ViewMode::Live,
            WindowView::Black => ViewMode::Black,
            WindowView::Test(test) => ViewMode::Test(test),
        };
        std::mem::replace(&mut self.mode, mode) != mode
    }

    /// The next test picture; after the last one, the pictures.
    fn next_test(&self) -> ViewMode {
        let current = if let ViewMode::Test(test) = self.mode { Some(test) } else { None };
        TestPicture::after(current).map_or(ViewMode::Live, ViewMode::Test)
    }
}

fn picture_of(image: Option<&ContentImage>) -> ScreenContent<'_> {
    image.map_or(ScreenContent::Black, |image| ScreenContent::Picture(&image.picture))
}

#[cfg(test)]
mod tests {
    use rcs_scene::Picture;

    use super::*;

    fn picture(level: u8) -> ContentImage {
        ContentImage { picture: ScreenPicture::from_fn(1, 1, |_, _| [level; 3]), ..ContentImage::default() }
    }

    fn content(timeout_secs: Option<u64>) -> WindowContent {
        WindowContent::new(timeout_secs.map(Duration::from_secs), LightLimit::All)
    }

    /// The level of a screen of one pixel, or the test picture's name and whether it is masked.
    fn shown(content: &WindowContent) -> String {
        match content.on_screen() {
            ScreenContent::Black => "black".to_owned(),
            ScreenContent::Picture(picture) => (picture.pixels()[0] & 0xff).to_string(),
            ScreenContent::Test(test, mask) => {
                format!("{}{}", test.name(), if mask.is_some() { " masked" } else { "" })
            }
        }
    }

    const BLACK: WindowKey = WindowKey::Character('b');
    const TEST: WindowKey = WindowKey::Character('t');

    #[test]
    fn without_a_timeout_the_last_picture_stays_and_with_one_it_goes() {
        let start = Instant::now();
        let later = |millis| start + Duration::from_millis(millis);
        for (timeout, expected) in [(None, "1"), (Some(1), "black")] {
            let mut content = content(timeout);
            content.take(picture(1), start);
            assert!(!content.check(later(999)));
            assert_eq!(shown(&content), "1");
            assert_eq!(content.check(later(1000)), timeout.is_some());
            assert_eq!(shown(&content), expected);
            assert!(!content.check(later(5000)), "it happens once");
            assert_eq!(content.note_alive(later(5001)), timeout.is_some(), "the same picture again is current again");
            assert_eq!(shown(&content), "1");
        }
    }

    #[test]
    fn a_picture_that_is_confirmed_stays() {
        let start = Instant::now();
        let later = |millis| start + Duration::from_millis(millis);
        let mut content = content(Some(1));
        assert!(!content.confirm(start), "there is none yet");
        assert_eq!(content.next_check(), None);
        content.take(picture(1), later(10));
        assert!(!content.confirm(later(900)));
        assert!(!content.check(later(1500)));
        assert!(content.check(later(1900)));
        assert!(!content.confirm(later(900)), "nothing new");
        assert_eq!(shown(&content), "black");
        assert!(content.confirm(later(2000)));
        assert_eq!(shown(&content), "1");
    }

    #[test]
    fn before_the_first_picture_nothing_is_stale() {
        let mut content = content(Some(1));
        assert_eq!((content.next_check(), shown(&content)), (None, "black".to_owned()));
        assert!(!content.check(Instant::now()));
    }

    #[test]
    fn a_pause_keeps_the_picture_and_ends_with_the_newest() {
        let now = Instant::now();
        let mut content = content(None);
        content.take(picture(1), now);
        assert!(content.press(WindowKey::Space));
        assert!(!content.take(picture(2), now).1);
        assert_eq!(shown(&content), "1");
        assert!(content.press(WindowKey::Space));
        assert_eq!(shown(&content), "2");
    }

    #[test]
    fn black_and_test_pictures_are_left_with_the_key_that_asked_for_them() {
        let now = Instant::now();
        let mut content = content(None);
        content.take(picture(1), now);
        content.press(BLACK);
        assert_eq!(shown(&content), "black");
        assert!(!content.take(picture(2), now).1, "black stays black");
        content.press(BLACK);
        assert_eq!(shown(&content), "2");
        for test in TestPicture::ALL {
            content.press(TEST);
            assert_eq!(shown(&content), test.name());
        }
        content.press(TEST);
        assert_eq!(shown(&content), "2");
        content.press(TEST);
        content.press(BLACK);
        assert_eq!(shown(&content), "black");
        assert!(!content.press(WindowKey::Left), "other keys do nothing");
    }

    #[test]
    fn pictures_that_stop_coming_beat_a_pause_but_not_a_test_picture() {
        let start = Instant::now();
        let later = |millis| start + Duration::from_millis(millis);
        let mut content = content(Some(1));
        content.take(picture(1), start);
        content.press(WindowKey::Character('p'));
        content.take(picture(2), later(500));
        assert_eq!(shown(&content), "1");
        assert!(content.check(later(1500)));
        assert_eq!(shown(&content), "black");
        content.press(TEST);
        assert_eq!(shown(&content), TestPicture::ALL[0].name());
        content.press(WindowKey::Space);
        assert_eq!(shown(&content), "black");
    }

    #[derive(Debug)]
    struct AllDark;

    impl Mask for AllDark {
        fn shares(&self, _: [u32; 2]) -> Picture {
            Picture::default()
        }
    }

    fn masked(level: u8) -> ContentImage {
        let test = LightLimit::Masked(Arc::new(AllDark));
        ContentImage { permit: WindowPermit { test, is_lit: true }, ..picture(level) }
    }

    fn dark(test: LightLimit) -> ContentImage {
        ContentImage { permit: WindowPermit { test, is_lit: false }, ..picture(0) }
    }

    #[test]
    fn a_dark_picture_beats_a_pause_and_what_was_held_comes_back_after_it() {
        let now = Instant::now();
        let mut content = content(None);
        content.take(picture(1), now);
        content.press(WindowKey::Space);
        assert!(content.take(dark(LightLimit::All), now).1);
        assert_eq!(shown(&content), "0");
        assert!(content.take(picture(2), now).1);
        assert_eq!(shown(&content), "1");
        content.press(WindowKey::Space);
        assert_eq!(shown(&content), "2");
    }

    #[test]
    fn a_pause_that_begins_in_the_dark_holds_the_first_picture_with_light() {
        let now = Instant::now();
        let mut content = content(None);
        content.take(dark(LightLimit::All), now);
        content.press(WindowKey::Space);
        assert_eq!(shown(&content), "0");
        content.take(picture(1), now);
        content.take(picture(2), now);
        assert_eq!(shown(&content), "1");
    }

    #[test]
    fn masks_beat_test_pictures_and_what_is_only_too_old_does_not() {
        let now = Instant::now();
        let name = TestPicture::ALL[0].name();
        let mut content = WindowContent::new(Some(Duration::from_secs(1)), LightLimit::Nothing);
        content.press(TEST);
        assert_eq!(shown(&content), "black", "no mask has come yet");
        assert!(content.take(masked(1), now).1);
        assert_eq!(shown(&content), format!("{name} masked"));
        assert!(content.take(dark(LightLimit::Nothing), now).1);
        assert_eq!(shown(&content), "black", "the mask is too old");
        assert!(content.take(dark(LightLimit::All), now).1);
        assert_eq!(shown(&content), name, "something else is too old");
        assert!(content.check(now + Duration::from_secs(1)));
        assert_eq!(shown(&content), "black", "nothing is known of masks any more");
        content.clear();
        assert_eq!(shown(&content), "black", "nor without a camera");
    }
}
