//! Content of the window: the newest image, a paused one or a test image, each under a grant, else black.
//!
//! The window is a last hop like the node's own: an image must be current (where a timeout is set) and not black, which
//! its publisher has a reason for, and the operator's black, which the next run keeps, comes before all.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_light::{
    BlackoutFile, Blackouts, Condition, Content, DarkCause, DarkReason, Evidence, Generation, LightRules, Lit,
    Measured, Now,
};
use rcs_transforms::Time;
use rcs_window::test_images::TestImage;
use rcs_window::{ImageSink, MonitorInfo, ScreenImage, WindowKey};

/// Limit of the light where images do not become stale: it is granted anew ten times a second.
const UNGUARDED_LIMIT: Duration = Duration::from_secs(5);
const BY_KEY: &str = "key b";

/// A received image.
struct ReceivedImage {
    image: Arc<ScreenImage>,
    is_black: bool,
    measured: Measured,
}

/// The state of the window.
pub(super) struct Viewer {
    monitor: MonitorInfo,
    /// Age from which images are stale; zero: never.
    timeout: Duration,
    newest: Option<ReceivedImage>,
    /// The paused image.
    held: Option<Arc<ScreenImage>>,
    is_paused: bool,
    test: Option<(TestImage, Arc<ScreenImage>)>,
    blackouts: Blackouts,
    /// `None` until the node has its name.
    file: Option<BlackoutFile>,
    generation: Generation,
    /// The image that the window has; `None` for black.
    shown: Option<Lit<Arc<ScreenImage>>>,
    /// The time of the last decision.
    last_now: Now,
    /// Why it is black, as far as that was logged.
    dark: Option<DarkCause>,
}

impl Viewer {
    /// Black: nothing has come yet.
    pub(super) fn new(monitor: MonitorInfo, timeout: Duration) -> Self {
        Self {
            monitor,
            timeout,
            newest: None,
            held: None,
            is_paused: false,
            test: None,
            blackouts: Blackouts::default(),
            file: None,
            generation: Generation::default(),
            shown: None,
            last_now: Now { ros: Time::ZERO, steady: Instant::now(), resumed: None },
            dark: None,
        }
    }

    pub(super) fn set_monitor(&mut self, monitor: MonitorInfo) {
        self.monitor = monitor;
        if let Some((test, _)) = self.test {
            self.set_test(Some(test));
        }
    }

    pub(super) fn set_timeout(&mut self, timeout: Duration) {
        self.timeout = timeout;
    }

    /// Takes the file of blackouts, with the one that the last run has left.
    pub(super) fn set_file(&mut self, file: BlackoutFile) {
        let kept = file.read();
        self.file = Some(file);
        match self.blackouts.all.is_some() {
            true => self.keep_blackouts(),
            false if kept.all.is_some() => {
                log::warn!("black as the last run was; Shift+L releases it");
                self.blackouts = kept;
                self.generation.advance();
            }
            false => {}
        }
    }

    /// Takes an image.
    pub(super) fn take(&mut self, image: ScreenImage, measured: Measured) {
        let is_black = image.is_black();
        let image = Arc::new(image);
        if self.is_paused && self.held.is_none() && !is_black {
            self.held = Some(Arc::clone(&image));
        }
        self.newest = Some(ReceivedImage { image, is_black, measured });
    }

    /// Takes a key: B, Shift+L, P or the space bar, T. Returns `true` if it has one of them.
    pub(super) fn press(&mut self, key: WindowKey) -> bool {
        match key {
            WindowKey::Character('b' | 'B') => self.set_black(true),
            WindowKey::Character('L') => self.set_black(false),
            WindowKey::Space | WindowKey::Character('p' | 'P') => {
                self.is_paused ^= true;
                let newest = self.newest.as_ref().filter(|newest| self.is_paused && !newest.is_black);
                self.held = newest.map(|newest| Arc::clone(&newest.image));
                log::info!("{}", if self.is_paused { "paused until key p" } else { "showing images" });
            }
            WindowKey::Character('t' | 'T') => {
                self.set_test(TestImage::after(self.test.as_ref().map(|(test, _)| *test)));
                match &self.test {
                    Some((test, _)) => log::info!("test picture {}", test.name()),
                    None => log::info!("showing images"),
                }
            }
            _ => return false,
        }
        true
    }

    fn set_black(&mut self, on: bool) {
        if self.blackouts.all.is_some() == on {
            return;
        }
        self.blackouts.all = on.then(|| BY_KEY.to_owned());
        self.generation.advance();
        log::warn!("{}", if on { "black by key b until Shift+L" } else { "black is released by Shift+L" });
        self.keep_blackouts();
    }

    fn keep_blackouts(&self) {
        if let Some(Err(error)) = self.file.as_ref().map(|file| file.write(&self.blackouts)) {
            log::error!("the blackout is not kept for a restart: {error}");
        }
    }

    fn set_test(&mut self, test: Option<TestImage>) {
        let (width, height) = self.monitor.size_px;
        self.test = test.and_then(|test| {
            let image = ScreenImage::from_image(&test.draw([width, height], &self.monitor.name)).ok()?;
            Some((test, Arc::new(image)))
        });
    }

    /// Hands the window what it may show now.
    pub(super) fn present(&mut self, sink: &ImageSink, now: Now) {
        self.last_now = now;
        let lit = self.choose(now);
        self.log_dark(lit.as_ref().err());
        let Ok(lit) = lit else {
            if self.shown.take().is_some() {
                sink.clear();
            }
            return;
        };
        let is_renewed = self.shown.as_mut().is_some_and(|shown| shown.is_same(&lit) && shown.renew(lit.grant()));
        if is_renewed {
            sink.renew(lit.grant());
        } else {
            sink.show_lit(lit.clone());
            self.shown = Some(lit);
        }
    }

    /// Hands the window what a key has changed, until the next turn of the node.
    pub(super) fn present_now(&mut self, sink: &ImageSink) {
        let now = Now { steady: Instant::now(), ..self.last_now };
        self.present(sink, now);
    }

    fn choose(&self, now: Now) -> Result<Lit<Arc<ScreenImage>>, DarkReason> {
        let (content, image) = match (&self.test, &self.held, &self.newest) {
            (Some((_, image)), ..) => (Content::Test, Some(image)),
            (None, Some(held), _) => (Content::Scene, Some(held)),
            (None, None, newest) => (Content::Scene, newest.as_ref().map(|newest| &newest.image)),
        };
        let (width, height) = image.map(|image| image.size_px()).unwrap_or_default();
        let operator = match &self.blackouts.all {
            Some(by) => Err(DarkReason::new(DarkCause::Blackout, format!("black by {by}"))),
            None => Ok(self.generation.clone()),
        };
        let grant = self.evidence(now).decide(content, [width, height], operator, now.steady)?;
        let lit = image.and_then(|image| grant.show(Arc::clone(image)));
        lit.ok_or_else(|| DarkReason::new(DarkCause::NoImage, "there is no image"))
    }

    fn evidence(&self, now: Now) -> Evidence {
        let is_guarded = !self.timeout.is_zero();
        let limit = if is_guarded { self.timeout } else { UNGUARDED_LIMIT };
        let rules = LightRules { protects_eyes: is_guarded, must_confirm: false, limit };
        let mut evidence = Evidence::unknown(&DarkCause::OF_IMAGES, rules, Arc::default());
        let image = match &self.newest {
            None => Condition::Dark("no image has come yet".to_owned()),
            Some(newest) if is_guarded => newest.measured.condition("image", self.timeout, now),
            Some(_) => Condition::Always,
        };
        evidence.set(DarkCause::NoImage, image);
        let is_black = self.newest.as_ref().is_some_and(|newest| newest.is_black);
        let black = if is_black { Condition::Dark("the image is black".to_owned()) } else { Condition::Always };
        evidence.set(DarkCause::BlackImage, black);
        evidence
    }

    /// Logs when the images become stale, and when they are current again.
    fn log_dark(&mut self, dark: Option<&DarkReason>) {
        let cause = dark.map(|dark| dark.cause);
        if self.dark == cause {
            return;
        }
        match dark {
            Some(dark) if dark.cause == DarkCause::NoImage && self.newest.is_some() => {
                log::warn!("the window is black: {dark}");
            }
            None if self.dark == Some(DarkCause::NoImage) => log::info!("images are shown again"),
            _ => {}
        }
        self.dark = cause;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn monitor() -> MonitorInfo {
        MonitorInfo { size_px: (64, 48), ..MonitorInfo::default() }
    }

    fn image(level: u8) -> ScreenImage {
        ScreenImage::from_fn(2, 1, |_, _| [level; 3])
    }

    /// A viewer with an image at 100 s, and the time after some seconds.
    fn viewer(timeout_secs: f64, level: u8) -> (Viewer, impl Fn(f64) -> Now) {
        let start = Instant::now();
        let mut viewer = Viewer::new(monitor(), Duration::from_secs_f64(timeout_secs));
        let stamp = Time::from_secs_f64(100.0);
        viewer.take(image(level), Measured { stamp, received: start });
        let now = move |secs: f64| Now {
            ros: Time::from_secs_f64(100.0 + secs),
            steady: start + Duration::from_secs_f64(secs),
            resumed: None,
        };
        (viewer, now)
    }

    fn dark(viewer: &Viewer, now: Now) -> Option<DarkCause> {
        viewer.choose(now).err().map(|dark| dark.cause)
    }

    const B: WindowKey = WindowKey::Character('b');
    const L: WindowKey = WindowKey::Character('L');
    const T: WindowKey = WindowKey::Character('t');

    #[test]
    fn an_image_is_shown_while_it_is_current_by_its_stamp() {
        let (mut viewer, now) = viewer(1.0, 9);
        assert_eq!([dark(&viewer, now(0.9)), dark(&viewer, now(1.1))], [None, Some(DarkCause::NoImage)]);
        let late = Measured { stamp: Time::from_secs_f64(100.0), received: now(5.0).steady };
        viewer.take(image(9), late);
        assert_eq!(dark(&viewer, now(5.0)), Some(DarkCause::NoImage), "five seconds on its way");
        let (viewer, now) = self::viewer(0.0, 9);
        assert_eq!(dark(&viewer, now(1000.0)), None, "without a timeout");
    }

    #[test]
    fn the_operators_black_beats_all_and_is_no_toggle() {
        let (mut viewer, now) = viewer(1.0, 9);
        viewer.press(T);
        (0..30).for_each(|_| assert!(viewer.press(B)));
        assert_eq!(dark(&viewer, now(0.0)), Some(DarkCause::Blackout));
        assert!(!viewer.press(WindowKey::Character('l')) && viewer.press(L));
        assert_eq!(dark(&viewer, now(0.0)), None);
    }

    #[test]
    fn a_black_image_beats_a_pause_and_a_test_image() {
        let (mut viewer, now) = viewer(1.0, 9);
        viewer.press(WindowKey::Space);
        viewer.take(image(0), Measured { stamp: now(0.1).ros, received: now(0.1).steady });
        assert_eq!(dark(&viewer, now(0.2)), Some(DarkCause::BlackImage));
        viewer.press(T);
        assert_eq!(dark(&viewer, now(0.2)), Some(DarkCause::BlackImage));
        viewer.take(image(7), Measured { stamp: now(0.2).ros, received: now(0.2).steady });
        assert_eq!(dark(&viewer, now(0.2)), None);
        assert!(dark(&viewer, now(5.0)).is_some(), "nor do stale images let a test picture be");
    }

    #[test]
    fn a_pause_keeps_its_image_and_test_images_go_on_one_by_one() {
        let (mut viewer, now) = viewer(0.0, 1);
        let shown = |viewer: &Viewer| {
            let lit = viewer.choose(now(0.0)).unwrap();
            let image = lit.content(now(0.0).steady).unwrap();
            let mut pixels = [0; 64 * 48];
            image.draw_unscaled(&mut pixels, 64);
            (image.size_px(), pixels[0] & 0xff)
        };
        viewer.press(WindowKey::Space);
        viewer.take(image(2), Measured { stamp: now(0.0).ros, received: now(0.0).steady });
        assert_eq!(shown(&viewer), ((2, 1), 1));
        viewer.press(WindowKey::Space);
        assert_eq!(shown(&viewer), ((2, 1), 2));
        for _ in TestImage::ALL {
            viewer.press(T);
            assert_eq!(shown(&viewer).0, (64, 48));
        }
        viewer.press(T);
        assert_eq!(shown(&viewer), ((2, 1), 2));
        assert!(!viewer.press(WindowKey::Left), "other keys do nothing");
    }

    #[test]
    fn test_images_before_any_image_are_for_focusing_where_nothing_is_guarded() {
        for (timeout_secs, expected) in [(0.0, None), (1.0, Some(DarkCause::NoImage))] {
            let mut viewer = Viewer::new(monitor(), Duration::from_secs_f64(timeout_secs));
            assert_eq!(
                dark(&viewer, Now { ros: Time::ZERO, steady: Instant::now(), resumed: None }),
                Some(DarkCause::NoImage)
            );
            viewer.press(T);
            assert_eq!(dark(&viewer, Now { ros: Time::ZERO, steady: Instant::now(), resumed: None }), expected);
        }
    }

    #[test]
    fn black_is_kept_for_the_next_run() {
        let folder = tempfile::tempdir().unwrap();
        let file = || BlackoutFile::of_node(Some(folder.path()), "/projector_window");
        let (mut first, _) = viewer(0.0, 9);
        first.press(B);
        first.set_file(file());
        let (mut second, now) = viewer(0.0, 9);
        second.set_file(file());
        assert_eq!(dark(&second, now(0.0)), Some(DarkCause::Blackout));
        second.press(L);
        let (mut third, now) = viewer(0.0, 9);
        third.set_file(file());
        assert_eq!(dark(&third, now(0.0)), None);
    }
}
