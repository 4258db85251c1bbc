//! The window's content: the newest picture, or black because pictures stopped coming, or what a key asked for as far
//! as that may be lit.
//!
//! It knows no window system and no clock, so that it can be tested without either.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_scene::Picture;

use crate::keys::WindowKey;
use crate::light::{Light, Mask, WindowPermit};
use crate::screen_picture::ScreenPicture;
use crate::test_pictures::TestPicture;

/// What is to be on the screen.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Face<'a> {
    /// Nothing: no light.
    Black,
    /// A picture that came.
    Picture(&'a ScreenPicture),
    /// A test picture in the monitor's resolution, as far as the mask allows it.
    Test(TestPicture, Option<&'a Arc<dyn Mask>>),
}

/// What the user asked for with a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    /// The pictures as they come.
    Live,
    /// The picture that was shown when the key was pressed.
    Paused,
    /// Black.
    Black,
    /// One of [`TestPicture::ALL`].
    Test(usize),
}

/// A picture that came.
#[derive(Debug, Default)]
pub(crate) struct Image {
    /// As the screen takes it.
    pub(crate) picture: ScreenPicture,
    /// Before its mask.
    pub(crate) drawn: Option<Arc<Picture>>,
    /// What may be lit in its place.
    pub(crate) permit: WindowPermit,
}

/// What the window shows.
#[derive(Debug)]
pub(crate) struct Content {
    /// The newest; none while it is held.
    newest: Option<Image>,
    /// The paused picture.
    held: Option<Image>,
    /// What may be lit in place of the newest picture; none before the first.
    permit: Option<WindowPermit>,
    /// What test pictures may light without a picture, and when pictures have stopped.
    silent_test: Light,
    arrived: Option<Instant>,
    stale_timeout: Option<Duration>,
    is_stale: bool,
    mode: Mode,
}

impl Content {
    /// Black; later pictures are replaced by black when no other came for `stale_timeout`.
    pub(crate) fn new(stale_timeout: Option<Duration>, silent_test: Light) -> Self {
        let stale_timeout = stale_timeout.filter(|timeout| !timeout.is_zero());
        let (newest, held, permit, arrived) = (None, None, None, None);
        Self { newest, held, permit, silent_test, arrived, stale_timeout, is_stale: false, mode: Mode::Live }
    }

    /// Another time after which pictures are stale; zero: never.
    pub(crate) fn set_stale_timeout(&mut self, timeout: Duration) {
        self.stale_timeout = Some(timeout).filter(|timeout| !timeout.is_zero());
    }

    /// What is to be on the screen.
    pub(crate) fn face(&self) -> Face<'_> {
        let permit = self.permit.as_ref().filter(|_| !self.is_stale);
        match (self.mode, permit) {
            (Mode::Test(index), permit) => {
                let light = permit.map_or(&self.silent_test, |permit| &permit.test);
                let test = TestPicture::ALL.get(index).filter(|_| !light.is_nothing());
                let mask = match light {
                    Light::Masked(mask) => Some(mask),
                    Light::All | Light::Nothing => None,
                };
                test.map_or(Face::Black, |test| Face::Test(*test, mask))
            }
            (Mode::Black, _) | (_, None) => Face::Black,
            (Mode::Paused, Some(permit)) if !permit.paused.is_nothing() => picture_of(self.held.as_ref()),
            (Mode::Live | Mode::Paused, Some(_)) => picture_of(self.newest.as_ref()),
        }
    }

    /// The picture that came last, or is held.
    pub(crate) fn picture(&self) -> Option<&ScreenPicture> {
        self.newest.as_ref().or(self.held.as_ref()).map(|image| &image.picture)
    }

    /// Takes a new picture. Returns the memory of one that is not needed any more, and whether the screen changes.
    pub(crate) fn take(&mut self, image: Image, now: Instant) -> (Option<ScreenPicture>, bool) {
        let mut changes = self.note_alive(now) | self.set_permit(&image.permit);
        let old = self.newest.replace(image);
        match self.mode {
            Mode::Live => changes = true,
            Mode::Paused => changes |= self.go_on_holding(),
            Mode::Black | Mode::Test(_) => {}
        }
        (old.map(|image| image.picture), changes)
    }

    /// The newest picture is shown again. Returns whether the screen changes by that.
    pub(crate) fn repeat(&mut self, permit: &WindowPermit, now: Instant) -> bool {
        self.note_alive(now) | self.set_permit(permit)
    }

    fn set_permit(&mut self, permit: &WindowPermit) -> bool {
        let old = self.permit.replace(permit.clone());
        match self.mode {
            Mode::Test(_) => old.is_none_or(|old| old.test.differs(&permit.test)),
            Mode::Paused => old.is_none_or(|old| old.paused.differs(&permit.paused)),
            Mode::Live | Mode::Black => false,
        }
    }

    /// Keeps what is paused as it may be lit now, or holds the newest picture from now on. Returns whether what is held
    /// has changed.
    fn go_on_holding(&mut self) -> bool {
        // The newest is shown, which is dark for a reason.
        let Some(permit) = self.permit.as_ref().filter(|permit| !permit.paused.is_nothing()) else { return true };
        match (&mut self.held, &permit.paused) {
            (Some(held), Light::Masked(mask)) if held.permit.scene == permit.scene => {
                let masked = held.drawn.as_ref().map(|drawn| mask.post_process(drawn));
                let is_read = masked.is_some_and(|masked| held.picture.read(&(&masked).into()).is_ok());
                if !is_read {
                    self.held = self.newest.take();
                }
                true
            }
            (Some(held), _) if held.permit.scene == permit.scene => false,
            _ => {
                self.held = self.newest.take().or(self.held.take());
                true
            }
        }
    }

    /// There is no picture any more. Returns whether the screen changes.
    pub(crate) fn clear(&mut self) -> bool {
        (self.newest, self.held, self.permit, self.arrived, self.is_stale) = (None, None, None, None, false);
        true
    }

    /// Pictures keep coming. Returns whether the screen changes by that.
    pub(crate) fn note_alive(&mut self, now: Instant) -> bool {
        self.arrived = Some(now);
        let was_stale = std::mem::replace(&mut self.is_stale, false);
        if was_stale {
            log::info!("pictures come again");
        }
        was_stale
    }

    /// The picture that came last was called current then. Returns whether the screen changes by that.
    pub(crate) fn confirm(&mut self, at: Instant) -> bool {
        self.arrived.is_some_and(|arrived| arrived < at) && self.note_alive(at)
    }

    /// When [`check`](Self::check) is to be called, if pictures do not go on.
    pub(crate) fn next_check(&self) -> Option<Instant> {
        self.arrived?.checked_add(self.stale_timeout.filter(|_| !self.is_stale)?)
    }

    /// Checks whether the pictures have stopped. Returns whether the screen changes.
    pub(crate) fn check(&mut self, now: Instant) -> bool {
        if self.next_check().is_none_or(|at| now < at) {
            return false;
        }
        self.is_stale = true;
        let seconds = self.stale_timeout.unwrap_or_default().as_secs_f64();
        log::warn!("no picture for {seconds} s: the window is black until there is one");
        true
    }

    /// Does what a key asks for; pressed again, it goes back to the pictures. Returns whether that is anything.
    pub(crate) fn press(&mut self, key: WindowKey) -> bool {
        let wanted = match key {
            WindowKey::Space | WindowKey::Character('p' | 'P') => Mode::Paused,
            WindowKey::Character('b' | 'B') => Mode::Black,
            WindowKey::Character('t' | 'T') => self.next_test(),
            _ => return false,
        };
        self.mode = if self.mode == wanted { Mode::Live } else { wanted };
        match self.mode {
            Mode::Live => log::info!("showing pictures"),
            Mode::Paused => log::info!("paused: the picture stays until the key is pressed again"),
            Mode::Black => log::info!("black until the key is pressed again"),
            Mode::Test(index) => {
                log::info!("test picture {}", TestPicture::ALL.get(index).map_or("", |test| test.name()));
            }
        }
        match self.mode {
            // A picture that is dark for a reason is not held.
            Mode::Paused => {
                self.go_on_holding();
            }
            _ => self.newest = self.newest.take().or(self.held.take()),
        }
        self.held = self.held.take().filter(|_| self.mode == Mode::Paused);
        true
    }

    /// The next test picture, and after the last one the pictures.
    fn next_test(&self) -> Mode {
        match self.mode {
            Mode::Test(index) if index + 1 < TestPicture::ALL.len() => Mode::Test(index + 1),
            Mode::Test(_) => Mode::Live,
            _ => Mode::Test(0),
        }
    }
}

fn picture_of(image: Option<&Image>) -> Face<'_> {
    image.map_or(Face::Black, |image| Face::Picture(&image.picture))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(level: u8) -> Image {
        Image { picture: ScreenPicture::from_fn(1, 1, |_, _| [level; 3]), ..Image::default() }
    }

    fn content(timeout_secs: Option<u64>) -> Content {
        Content::new(timeout_secs.map(Duration::from_secs), Light::All)
    }

    /// The content of a screen of one pixel: its level, or the test picture's name and whether it is masked.
    fn shown(content: &Content) -> String {
        match content.face() {
            Face::Black => "black".to_owned(),
            Face::Picture(picture) => (picture.pixels()[0] & 0xff).to_string(),
            Face::Test(test, mask) => format!("{}{}", test.name(), if mask.is_some() { " masked" } else { "" }),
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

    /// Adds its number to what was drawn.
    #[derive(Debug)]
    struct Added(u8);

    impl Mask for Added {
        fn post_process(&self, drawn: &Picture) -> Picture {
            let data = drawn.data.iter().map(|level| level + self.0).collect();
            Picture { data, ..drawn.clone() }
        }

        fn shares(&self, _: [u32; 2]) -> Picture {
            Picture::default()
        }
    }

    /// A picture of this level that was drawn as a hundred more.
    fn masked(level: u8, scene: u64, mask: u8) -> Image {
        let mut drawn = Picture::default();
        drawn.reset(1, 1, rcs_scene::Encoding::Mono8);
        drawn.data = vec![level + 100];
        let light = || Light::Masked(Arc::new(Added(mask)));
        Image {
            drawn: Some(Arc::new(drawn)),
            permit: WindowPermit { paused: light(), test: light(), scene },
            ..picture(level)
        }
    }

    fn dark(test: Light) -> Image {
        Image { permit: WindowPermit { paused: Light::Nothing, test, scene: 0 }, ..picture(0) }
    }

    #[test]
    fn a_dark_picture_beats_a_pause_and_what_was_held_comes_back_after_it() {
        let now = Instant::now();
        let mut content = content(None);
        content.take(picture(1), now);
        content.press(WindowKey::Space);
        assert!(content.take(dark(Light::All), now).1);
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
        content.take(dark(Light::All), now);
        content.press(WindowKey::Space);
        assert_eq!(shown(&content), "0");
        content.take(picture(1), now);
        content.take(picture(2), now);
        assert_eq!(shown(&content), "1");
    }

    #[test]
    fn what_is_held_below_a_mask_is_masked_anew_with_each_picture() {
        let now = Instant::now();
        let mut content = content(None);
        content.take(masked(1, 0, 5), now);
        content.press(WindowKey::Space);
        assert_eq!(shown(&content), "1");
        assert!(content.take(masked(2, 0, 7), now).1);
        assert_eq!(shown(&content), "108", "drawn as 101, and the mask of now");
        assert!(content.take(masked(3, 0, 9), now).1);
        assert_eq!(shown(&content), "110");
    }

    #[test]
    fn a_pause_goes_on_with_the_newest_picture_where_other_data_are_left_out() {
        let now = Instant::now();
        let mut content = content(None);
        content.take(masked(1, 0, 5), now);
        content.press(WindowKey::Space);
        assert!(content.take(masked(2, 1, 7), now).1);
        assert_eq!(shown(&content), "2");
        content.take(masked(3, 1, 7), now);
        assert_eq!(shown(&content), "109", "it is held from then on");
    }

    #[test]
    fn masks_beat_test_pictures_and_what_is_only_too_old_does_not() {
        let now = Instant::now();
        let name = TestPicture::ALL[0].name();
        let mut content = Content::new(Some(Duration::from_secs(1)), Light::Nothing);
        content.press(TEST);
        assert_eq!(shown(&content), "black", "no mask has come yet");
        assert!(content.take(masked(1, 0, 5), now).1);
        assert_eq!(shown(&content), format!("{name} masked"));
        assert!(content.take(dark(Light::Nothing), now).1);
        assert_eq!(shown(&content), "black", "the mask is too old");
        assert!(content.take(dark(Light::All), now).1);
        assert_eq!(shown(&content), name, "something else is too old");
        assert!(content.check(now + Duration::from_secs(1)));
        assert_eq!(shown(&content), "black", "nothing is known of masks any more");
        content.clear();
        assert_eq!(shown(&content), "black", "nor without a camera");
    }
}
