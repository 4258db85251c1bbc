//! What the window shows: the newest picture, or black because pictures stopped coming, or what a key asked for.
//!
//! It knows no window system and no clock, so that it can be tested without either.

use std::time::{Duration, Instant};

use crate::keys::WindowKey;
use crate::screen_picture::ScreenPicture;
use crate::test_pictures::TestPicture;

/// What is to be on the screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Face<'a> {
    /// Nothing: no light.
    Black,
    /// A picture that came.
    Picture(&'a ScreenPicture),
    /// A test picture in the monitor's resolution.
    Test(TestPicture),
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

/// What the window shows.
#[derive(Debug)]
pub(crate) struct Content {
    picture: Option<ScreenPicture>,
    /// The newest picture while it is not shown.
    held_back: Option<ScreenPicture>,
    arrived: Option<Instant>,
    stale_timeout: Option<Duration>,
    is_stale: bool,
    mode: Mode,
}

impl Content {
    /// Black; later pictures are replaced by black when no other came for `stale_timeout`.
    pub(crate) fn new(stale_timeout: Option<Duration>) -> Self {
        let stale_timeout = stale_timeout.filter(|timeout| !timeout.is_zero());
        Self { picture: None, held_back: None, arrived: None, stale_timeout, is_stale: false, mode: Mode::Live }
    }

    /// Another time after which pictures are stale; zero: never.
    pub(crate) fn set_stale_timeout(&mut self, timeout: Duration) {
        self.stale_timeout = Some(timeout).filter(|timeout| !timeout.is_zero());
    }

    /// What is to be on the screen.
    pub(crate) fn face(&self) -> Face<'_> {
        match (self.mode, &self.picture) {
            (Mode::Test(index), _) => TestPicture::ALL.get(index).map_or(Face::Black, |test| Face::Test(*test)),
            (Mode::Live | Mode::Paused, Some(picture)) if !self.is_stale => Face::Picture(picture),
            _ => Face::Black,
        }
    }

    /// The picture that came last, if it is shown or would be.
    pub(crate) fn picture(&self) -> Option<&ScreenPicture> {
        self.picture.as_ref()
    }

    /// Takes a new picture. Returns the memory of one that is not needed any more, and whether the screen changes.
    pub(crate) fn take(&mut self, picture: ScreenPicture, now: Instant) -> (Option<ScreenPicture>, bool) {
        self.note_alive(now);
        match self.mode {
            Mode::Paused => (self.held_back.replace(picture), false),
            mode => (self.picture.replace(picture), mode == Mode::Live),
        }
    }

    /// There is no picture any more. Returns whether the screen changes.
    pub(crate) fn clear(&mut self) -> bool {
        (self.picture, self.held_back, self.arrived, self.is_stale) = (None, None, None, false);
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
        if self.mode != Mode::Paused {
            self.picture = self.held_back.take().or(self.picture.take());
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(level: u8) -> ScreenPicture {
        ScreenPicture::from_fn(1, 1, |_, _| [level; 3])
    }

    const BLACK: WindowKey = WindowKey::Character('b');
    const TEST: WindowKey = WindowKey::Character('t');

    #[test]
    fn without_a_timeout_the_last_picture_stays_and_with_one_it_goes() {
        let start = Instant::now();
        let later = |millis| start + Duration::from_millis(millis);
        for (timeout, expected) in [(None, Face::Picture(&picture(1))), (Some(Duration::from_secs(1)), Face::Black)] {
            let mut content = Content::new(timeout);
            content.take(picture(1), start);
            assert!(!content.check(later(999)));
            assert_eq!(content.face(), Face::Picture(&picture(1)));
            assert_eq!(content.check(later(1000)), timeout.is_some());
            assert_eq!(content.face(), expected);
            assert!(!content.check(later(5000)), "it happens once");
            assert_eq!(content.note_alive(later(5001)), timeout.is_some(), "the same picture again is current again");
            assert_eq!(content.face(), Face::Picture(&picture(1)));
        }
    }

    #[test]
    fn a_picture_that_is_confirmed_stays() {
        let start = Instant::now();
        let later = |millis| start + Duration::from_millis(millis);
        let mut content = Content::new(Some(Duration::from_secs(1)));
        assert!(!content.confirm(start), "there is none yet");
        assert_eq!(content.next_check(), None);
        content.take(picture(1), later(10));
        assert!(!content.confirm(later(900)));
        assert!(!content.check(later(1500)));
        assert!(content.check(later(1900)));
        assert!(!content.confirm(later(900)), "nothing new");
        assert_eq!(content.face(), Face::Black);
        assert!(content.confirm(later(2000)));
        assert_eq!(content.face(), Face::Picture(&picture(1)));
    }

    #[test]
    fn before_the_first_picture_nothing_is_stale() {
        let mut content = Content::new(Some(Duration::from_secs(1)));
        assert_eq!((content.next_check(), content.face()), (None, Face::Black));
        assert!(!content.check(Instant::now()));
    }

    #[test]
    fn a_pause_keeps_the_picture_and_ends_with_the_newest() {
        let now = Instant::now();
        let mut content = Content::new(None);
        content.take(picture(1), now);
        assert!(content.press(WindowKey::Space));
        assert!(!content.take(picture(2), now).1);
        assert_eq!(content.face(), Face::Picture(&picture(1)));
        assert!(content.press(WindowKey::Space));
        assert_eq!(content.face(), Face::Picture(&picture(2)));
    }

    #[test]
    fn black_and_test_pictures_are_left_with_the_key_that_asked_for_them() {
        let now = Instant::now();
        let mut content = Content::new(None);
        content.take(picture(1), now);
        content.press(BLACK);
        assert_eq!(content.face(), Face::Black);
        assert!(!content.take(picture(2), now).1, "black stays black");
        content.press(BLACK);
        assert_eq!(content.face(), Face::Picture(&picture(2)));
        for test in TestPicture::ALL {
            content.press(TEST);
            assert_eq!(content.face(), Face::Test(test));
        }
        content.press(TEST);
        assert_eq!(content.face(), Face::Picture(&picture(2)));
        content.press(TEST);
        content.press(BLACK);
        assert_eq!(content.face(), Face::Black);
        assert!(!content.press(WindowKey::Left), "other keys do nothing");
    }
}
