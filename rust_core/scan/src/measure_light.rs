//! Measures the projector's light at the beginning of a session, and takes the image of each pattern.
//!
//! Black and white alternate. That finds the camera pixels that the projector lights, and the delay from showing a
//! image to seeing it, which no fixed sleep would know: window system, projector, camera and network each take their
//! time. White that is held for a second also tells whether the brightness is steady and whether the camera moves.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use rcs_calibration::patterns::Pattern;

use crate::compare::{is_same, mean, sample, ImageChange, SettledDetector, MAX_MOVED};
use crate::failure::ScanFailure;
use crate::light::{average, clipped_share, lit_pixels, Delay, Illumination, MAX_CHANGE, MIN_LIT};
use crate::session::ScanSession;

/// Least time of the first black: the camera may still see what was shown before.
const FIRST_BLACK: Duration = Duration::from_secs(2);
/// Timeout for light to be seen, and then to settle.
const MAX_DELAY: Duration = Duration::from_secs(5);
/// Time that black and white are observed for after they were seen.
const HOLD: Duration = Duration::from_secs(1);
/// The least frames of that time.
const MIN_HELD: usize = 6;
/// Frames that the white image is the mean of.
const AVERAGED: usize = 5;
/// A settled level is this close to the last one, as a share of the projector's light.
const SETTLED: f64 = 0.04;

/// Least time of the first black, and time that black is observed for, of a brief look.
const BRIEF_BLACK: Duration = Duration::from_millis(400);
const BRIEF_HOLD: Duration = Duration::from_millis(300);

/// The camera's response to black or white.
struct StepResponse {
    delay: Delay,
    /// The change of brightness afterwards, levels: overshoot or flicker.
    change: f64,
    /// The largest difference of settled frames.
    noise: f64,
    /// The mean of the last frames.
    image: Vec<u8>,
}

impl ScanSession<'_> {
    /// Measures the projector's light with black and white.
    ///
    /// # Errors
    /// [`ScanFailure`]: no light is seen, it is not steady or too much, or something moves.
    pub(crate) fn measure_light(&mut self) -> Result<Illumination, ScanFailure> {
        let all = sample(self.camera.lens().size_px);
        let (black, black_noise) = self.settled(&Pattern::Black, &all, FIRST_BLACK, |_| true)?;
        let is_lit =
            |grey: &[u8]| lit_pixels(&black, grey, &all, black_noise).len() as f64 >= MIN_LIT * all.len() as f64;
        let (white, noise) = self.settled(&Pattern::White, &all, Duration::ZERO, is_lit)?;
        let lit = lit_pixels(&black, &white, &all, noise);
        let (low, high) = (mean(&black, &lit), mean(&white, &lit));
        let mut responses = Vec::new();
        for pattern in [Pattern::Black, Pattern::White, Pattern::Black, Pattern::White] {
            responses.push(self.step_response(&pattern, &lit, [low, high], HOLD)?);
        }
        let longest = |of: fn(&Delay) -> Duration| responses.iter().map(|one| of(&one.delay)).max().unwrap_or_default();
        let delay = Delay { seen: longest(|delay| delay.seen), settled: longest(|delay| delay.settled) };
        let noise = responses.iter().map(|one| one.noise).fold(0.0, f64::max);
        let change = responses.iter().map(|one| one.change).fold(0.0, f64::max) / (high - low);
        let whites = [&responses[1].image, &responses[3].image];
        let between = ImageChange::between(whites[0], whites[1], &lit, noise);
        let change = change.max(between.brightness.abs() * high / (high - low));
        if change > MAX_CHANGE {
            return Err(ScanFailure::Unsteady(change));
        }
        if between.moved > MAX_MOVED {
            return Err(ScanFailure::Moved(between.moved));
        }
        let clipped = clipped_share(whites[1], &lit);
        Ok(Illumination { delay, lit, noise, clipped, contrast: high - low })
    }

    /// Measures the projector's light with a single flash of white, in about a second. That the brightness is steady is
    /// for [`Self::check_unchanged`] to find. Returns the image of black, too.
    ///
    /// # Errors
    /// [`ScanFailure`]: no light is seen.
    pub(crate) fn look_briefly(&mut self) -> Result<(Illumination, Vec<u8>), ScanFailure> {
        let all = sample(self.camera.lens().size_px);
        let (black, black_noise) = self.settled(&Pattern::Black, &all, BRIEF_BLACK, |_| true)?;
        let is_lit =
            |grey: &[u8]| lit_pixels(&black, grey, &all, black_noise).len() as f64 >= MIN_LIT * all.len() as f64;
        let (white, noise) = self.settled(&Pattern::White, &all, Duration::ZERO, is_lit)?;
        let lit = lit_pixels(&black, &white, &all, noise);
        let levels = [mean(&black, &lit), mean(&white, &lit)];
        let clipped = clipped_share(&white, &lit);
        let StepResponse { delay, noise, image, .. } = self.step_response(&Pattern::Black, &lit, levels, BRIEF_HOLD)?;
        let noise = noise.max(black_noise);
        Ok((Illumination { delay, lit, noise, clipped, contrast: levels[1] - levels[0] }, image))
    }

    /// Shows a pattern for at least some time until the frames that pass `is_lit` have settled. Returns the last frame
    /// and its noise.
    fn settled(
        &mut self,
        pattern: &Pattern,
        at: &[usize],
        least: Duration,
        is_lit: impl Fn(&[u8]) -> bool,
    ) -> Result<(Vec<u8>, f64), ScanFailure> {
        let shown = self.show(pattern)?;
        let (mut detector, mut after) = (SettledDetector::default(), shown);
        loop {
            let frame = self.frame(after)?;
            after = frame.received;
            let elapsed = after.saturating_duration_since(shown);
            let is_lit = is_lit(&frame.grey);
            if is_lit {
                detector.push(&frame.grey, at);
                if elapsed >= least && detector.is_settled() {
                    return Ok((frame.grey, detector.noise()));
                }
            } else if elapsed > MAX_DELAY {
                return Err(self.no_light());
            }
            if elapsed > 2 * MAX_DELAY {
                return Err(ScanFailure::Restless(elapsed.as_secs_f64()));
            }
        }
    }

    /// Shows black or white and observes the lit pixels until some time after they have followed. `levels` are the mean
    /// levels of black and white, `hold` is that time.
    fn step_response(
        &mut self,
        pattern: &Pattern,
        lit: &[usize],
        levels: [f64; 2],
        hold: Duration,
    ) -> Result<StepResponse, ScanFailure> {
        let [low, high] = levels;
        let half = 0.5 * (low + high);
        let is_white = *pattern == Pattern::White;
        let shown = self.show(pattern)?;
        let mut after = shown;
        // Time and level of each frame, from the first one on that shows the pattern.
        let mut held: Vec<(Duration, f64)> = Vec::new();
        let mut last: VecDeque<Vec<u8>> = VecDeque::new();
        let mut detector = SettledDetector::default();
        loop {
            let frame = self.frame(after)?;
            after = frame.received;
            let (elapsed, level) = (after.saturating_duration_since(shown), mean(&frame.grey, lit));
            if held.is_empty() && (level > half) != is_white {
                if elapsed > MAX_DELAY {
                    return Err(self.no_light());
                }
                continue;
            }
            held.push((elapsed, level));
            detector.push(&frame.grey, lit);
            last.push_back(frame.grey);
            if last.len() > AVERAGED {
                last.pop_front();
            }
            if held.len() >= MIN_HELD && elapsed >= held[0].0 + hold {
                break;
            }
        }
        let tail = &held[held.len() - AVERAGED..];
        let end = tail.iter().map(|(_, level)| level).sum::<f64>() / tail.len() as f64;
        let is_settled = |level: f64| (level - end).abs() <= SETTLED * (high - low);
        let settled = held.iter().rposition(|(_, level)| !is_settled(*level)).map_or(0, |late| late + 1);
        let settled = held[settled.min(held.len() - 1)].0;
        // Overshoot is a camera that adapts; levels that jump at the end are flicker.
        let overshoot = held.iter().map(|(_, level)| if is_white { level - end } else { end - level });
        let jump = tail.iter().map(|(_, level)| (level - end).abs());
        let change = overshoot.chain(jump).fold(0.0, f64::max);
        let delay = Delay { seen: held[0].0, settled };
        Ok(StepResponse { delay, change, noise: detector.noise(), image: average(last.iter()) })
    }

    fn no_light(&self) -> ScanFailure {
        ScanFailure::NoLight(self.screen.name())
    }

    /// Shows a pattern and returns the mean of some frames once it has settled: after the measured delay, as soon as
    /// two frames are the same. If they are the same as the `last` image, the pattern may not be seen yet, and gets as
    /// much time again.
    pub(crate) fn capture(
        &mut self,
        pattern: &Pattern,
        light: &Illumination,
        last: Option<&[u8]>,
    ) -> Result<Vec<u8>, ScanFailure> {
        let shown = self.show(pattern)?;
        self.capture_shown(shown, light, last)
    }

    /// Like [`Self::capture`], of an image that is shown since a time.
    pub(crate) fn capture_shown(
        &mut self,
        shown: Instant,
        light: &Illumination,
        last: Option<&[u8]>,
    ) -> Result<Vec<u8>, ScanFailure> {
        let settled = light.delay.settled.mul_f64(1.25);
        let mut previous: Option<Vec<u8>> = None;
        let mut after = shown + settled;
        let mut alike = VecDeque::new();
        loop {
            let frame = self.frame(after)?;
            after = frame.received;
            let elapsed = after.saturating_duration_since(shown);
            if elapsed > 2 * settled + MAX_DELAY {
                return Err(ScanFailure::Restless(elapsed.as_secs_f64()));
            }
            let is_like = |other: &[u8]| is_same(other, &frame.grey, &light.lit, light.noise);
            if last.is_some_and(is_like) && elapsed < 2 * settled {
                continue;
            }
            if previous.as_deref().is_some_and(|previous| !is_like(previous)) {
                alike.clear();
            }
            previous = Some(frame.grey.clone());
            alike.push_back(frame.grey);
            let wanted = self.options.frames;
            if alike.len() >= wanted.max(2) {
                return Ok(average(alike.range(alike.len() - wanted..)));
            }
        }
    }

    /// Compares an early white image with white now.
    ///
    /// # Errors
    /// [`ScanFailure::Unsteady`] and [`ScanFailure::Moved`].
    pub(crate) fn check_unchanged(&mut self, first_white: &[u8], light: &Illumination) -> Result<(), ScanFailure> {
        let last = self.capture(&Pattern::White, light, None)?;
        ImageChange::between(first_white, &last, &light.lit, light.noise).check()
    }
}
