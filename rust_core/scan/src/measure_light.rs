//! Measures the projector's light at the beginning of a scan, and takes the image of each pattern.
//!
//! Black and white alternate. That finds the camera pixels that the projector lights, and the delay from showing a
//! picture to seeing it, which no fixed sleep would know: window system, projector, camera and network each take their
//! time. White that is held for a second also tells whether brightness is steady, and whether the camera is at rest.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use rcs_calibration::patterns::Pattern;

use crate::compare::{is_same, mean, sample, Change, Rest, MOST_MOVED};
use crate::failure::ScanFailure;
use crate::light::{average, clipped_share, lit_pixels, Delay, Light, LEAST_LIT, MOST_CHANGE};
use crate::session::Session;

/// How long the first black is shown before it is believed.
const FIRST_LOOK: Duration = Duration::from_secs(2);
/// How long light may take to be seen, and then to come to rest.
const LONGEST_DELAY: Duration = Duration::from_secs(5);
/// How long black and white are watched each time after they were seen.
const HOLD: Duration = Duration::from_secs(1);
/// The least frames of that time.
const LEAST_HELD: usize = 6;
/// Frames that the white picture is the mean of.
const AVERAGED: usize = 5;
/// A level has settled when it is this close to the last one, as a share of the projector's light.
const SETTLED: f64 = 0.04;

/// Black or white, watched from showing on.
struct Watched {
    delay: Delay,
    /// How much brightness changed afterwards, levels: more of the light than stays, or flicker.
    change: f64,
    /// The largest difference of frames at rest.
    noise: f64,
    /// The mean of the last frames.
    picture: Vec<u8>,
}

impl Session<'_> {
    /// Looks at black and white.
    ///
    /// # Errors
    /// [`ScanFailure`]: no light is seen, it is not steady or too much, or something moves.
    pub(crate) fn find_light(&mut self) -> Result<Light, ScanFailure> {
        let all = sample(self.camera_px());
        let (dark, dark_noise) = self.first_black(&all)?;
        let (white, noise) = self.first_white(&all, &dark, dark_noise)?;
        let lit = lit_pixels(&dark, &white, &all, noise);
        let (low, high) = (mean(&dark, &lit), mean(&white, &lit));
        let mut watched = Vec::new();
        for pattern in [Pattern::Black, Pattern::White, Pattern::Black, Pattern::White] {
            watched.push(self.watch(&pattern, &lit, [low, high])?);
        }
        let longest = |of: fn(&Delay) -> Duration| watched.iter().map(|one| of(&one.delay)).max().unwrap_or_default();
        let delay = Delay { seen: longest(|delay| delay.seen), settled: longest(|delay| delay.settled) };
        let noise = watched.iter().map(|one| one.noise).fold(0.0, f64::max);
        let change = watched.iter().map(|one| one.change).fold(0.0, f64::max) / (high - low);
        let whites = [&watched[1].picture, &watched[3].picture];
        let between = Change::between(whites[0], whites[1], &lit, noise);
        let change = change.max(between.brightness.abs() * high / (high - low));
        if change > MOST_CHANGE {
            return Err(ScanFailure::Unsteady { change });
        }
        if between.moved > MOST_MOVED {
            return Err(ScanFailure::Moved { share: between.moved });
        }
        let clipped = clipped_share(whites[1], &lit)?;
        Ok(Light { delay, lit, noise, clipped, contrast: high - low })
    }

    /// The black picture, however late it comes, and its noise.
    fn first_black(&mut self, at: &[usize]) -> Result<(Vec<u8>, f64), ScanFailure> {
        let shown = self.show(&Pattern::Black)?;
        let (mut rest, mut after) = (Rest::default(), shown);
        loop {
            let frame = self.frame(after)?;
            after = frame.received;
            rest.push(&frame.grey, at);
            let elapsed = after.saturating_duration_since(shown);
            if elapsed >= FIRST_LOOK && rest.is_reached() {
                return Ok((frame.grey, rest.noise()));
            }
            if elapsed > FIRST_LOOK + LONGEST_DELAY {
                return Err(ScanFailure::Restless { secs: elapsed.as_secs_f64() });
            }
        }
    }

    /// The white picture once it is at rest, and its noise.
    fn first_white(&mut self, at: &[usize], dark: &[u8], noise: f64) -> Result<(Vec<u8>, f64), ScanFailure> {
        let shown = self.show(&Pattern::White)?;
        let (mut rest, mut after) = (Rest::default(), shown);
        loop {
            let frame = self.frame(after)?;
            after = frame.received;
            let share = lit_pixels(dark, &frame.grey, at, noise).len() as f64 / at.len().max(1) as f64;
            if share >= LEAST_LIT {
                rest.push(&frame.grey, at);
                if rest.is_reached() {
                    return Ok((frame.grey, rest.noise()));
                }
            }
            let elapsed = after.saturating_duration_since(shown);
            if elapsed > 2 * LONGEST_DELAY || (elapsed > LONGEST_DELAY && share < LEAST_LIT) {
                return Err(if share < LEAST_LIT {
                    self.no_light()
                } else {
                    ScanFailure::Restless { secs: elapsed.as_secs_f64() }
                });
            }
        }
    }

    /// Shows black or white and watches the lit pixels until some time after they have followed. `levels` are those of
    /// black and white.
    fn watch(&mut self, pattern: &Pattern, lit: &[usize], levels: [f64; 2]) -> Result<Watched, ScanFailure> {
        let [low, high] = levels;
        let half = 0.5 * (low + high);
        let is_white = *pattern == Pattern::White;
        let shown = self.show(pattern)?;
        let mut after = shown;
        // When each frame was received, and its level, from the first one on that shows the pattern.
        let mut held: Vec<(Duration, f64)> = Vec::new();
        let mut last: VecDeque<Vec<u8>> = VecDeque::new();
        let mut rest = Rest::default();
        loop {
            let frame = self.frame(after)?;
            after = frame.received;
            let (elapsed, level) = (after.saturating_duration_since(shown), mean(&frame.grey, lit));
            if held.is_empty() && (level > half) != is_white {
                if elapsed > LONGEST_DELAY {
                    return Err(self.no_light());
                }
                continue;
            }
            held.push((elapsed, level));
            rest.push(&frame.grey, lit);
            last.push_back(frame.grey);
            if last.len() > AVERAGED {
                last.pop_front();
            }
            if held.len() >= LEAST_HELD && elapsed >= held[0].0 + HOLD {
                break;
            }
        }
        let tail = &held[held.len() - AVERAGED..];
        let end = tail.iter().map(|(_, level)| level).sum::<f64>() / tail.len() as f64;
        let is_settled = |level: f64| (level - end).abs() <= SETTLED * (high - low);
        let settled = held.iter().rposition(|(_, level)| !is_settled(*level)).map_or(0, |late| late + 1);
        let settled = held[settled.min(held.len() - 1)].0;
        // More light than stays is a camera that adapts; levels that jump at the end are flicker.
        let beyond = held.iter().map(|(_, level)| if is_white { level - end } else { end - level });
        let jump = tail.iter().map(|(_, level)| (level - end).abs());
        let change = beyond.chain(jump).fold(0.0, f64::max);
        Ok(Watched {
            delay: Delay { seen: held[0].0, settled },
            change,
            noise: rest.noise(),
            picture: average(last.iter()),
        })
    }

    fn no_light(&self) -> ScanFailure {
        ScanFailure::NoLight { screen: self.screen_name() }
    }

    /// Shows a pattern and gives the mean of some frames once it has settled: after the delay that was measured, as
    /// soon as two frames are the same. If they are the same as the `last` picture, it may not be seen yet, so that it
    /// gets as much time again.
    pub(crate) fn capture(
        &mut self,
        pattern: &Pattern,
        light: &Light,
        last: Option<&[u8]>,
    ) -> Result<Vec<u8>, ScanFailure> {
        let shown = self.show(pattern)?;
        self.capture_shown(shown, light, last)
    }

    /// [`Self::capture`] of what is shown since a time.
    pub(crate) fn capture_shown(
        &mut self,
        shown: Instant,
        light: &Light,
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
            if elapsed > 2 * settled + LONGEST_DELAY {
                return Err(ScanFailure::Restless { secs: elapsed.as_secs_f64() });
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
            let wanted = self.options().frames;
            if alike.len() >= wanted.max(2) {
                let needless = alike.len() - wanted;
                alike.drain(..needless);
                return Ok(average(alike.iter()));
            }
        }
    }
}
