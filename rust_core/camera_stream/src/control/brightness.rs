//! The brightness that the operator has set, and the fade to it.

use std::time::{Duration, Instant};

use rcs_render::Brightness;

/// Longest fade, seconds.
pub(crate) const LONGEST_FADE_SECS: f64 = 5.0;

/// A brightness that changes evenly from one share to another. Its clock is the computer's, so that it goes on without
/// data.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fade {
    from: f64,
    to: f64,
    begun: Instant,
    lasts: Duration,
}

impl Default for Fade {
    /// Full brightness.
    fn default() -> Self {
        Self::steady(1.0)
    }
}

impl Fade {
    /// A brightness that stays.
    pub(super) fn steady(share: f64) -> Self {
        Self { from: share, to: share, begun: Instant::now(), lasts: Duration::ZERO }
    }

    /// The share at its end.
    pub(crate) fn target(&self) -> f64 {
        self.to
    }

    /// A fade from the present brightness to another.
    pub(super) fn towards(&self, to: f64, secs: f64, now: Instant) -> Self {
        let from = self.share(now);
        let lasts = if from == to { Duration::ZERO } else { Duration::from_secs_f64(secs) };
        Self { from, to, begun: now, lasts }
    }

    /// The share at a time.
    pub(crate) fn share(&self, now: Instant) -> f64 {
        let passed = now.saturating_duration_since(self.begun);
        if passed >= self.lasts {
            return self.to;
        }
        self.from + (self.to - self.from) * passed.as_secs_f64() / self.lasts.as_secs_f64()
    }

    /// The brightness at a time; black if it were no share.
    pub(crate) fn at(&self, now: Instant) -> Brightness {
        Brightness::new(self.share(now)).unwrap_or(Brightness::DARK)
    }

    pub(crate) fn is_over(&self, now: Instant) -> bool {
        now.saturating_duration_since(self.begun) >= self.lasts
    }
}

/// A brightness as the operator has set it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BrightnessSetting {
    pub(crate) fade: Fade,
    /// Duration of later fades.
    pub(crate) fade_secs: f64,
}

impl BrightnessSetting {
    /// The setting with other values, where they are given.
    ///
    /// # Errors
    /// A value out of its range; nothing is to change then.
    pub(super) fn with(self, share: Option<f64>, fade_secs: Option<f64>, now: Instant) -> Result<Self, String> {
        let within = |name: &str, value: f64, most: f64| {
            let is_within = (0.0..=most).contains(&value);
            is_within.then_some(value).ok_or_else(|| format!("{name}: {value} is no number from 0 to {most}"))
        };
        let share = share.map(|share| within("brightness", share, 1.0)).transpose()?;
        let fade_secs = fade_secs.map(|secs| within("fade_seconds", secs, LONGEST_FADE_SECS)).transpose()?;
        let fade_secs = fade_secs.unwrap_or(self.fade_secs);
        let fade = share.filter(|share| *share != self.fade.to).map(|share| self.fade.towards(share, fade_secs, now));
        Ok(Self { fade: fade.unwrap_or(self.fade), fade_secs })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brightness(share: f64) -> Brightness {
        Brightness::new(share).unwrap()
    }

    #[test]
    fn a_fade_is_even_and_another_one_begins_where_it_is() {
        let now = Instant::now();
        let after = |secs: f64| now + Duration::from_secs_f64(secs);
        let down = BrightnessSetting::default().with(Some(0.0), Some(4.0), now).unwrap();
        let at = |setting: &BrightnessSetting, secs| setting.fade.at(after(secs));
        assert_eq!([0.0, 1.0, 4.0, 9.0].map(|secs| at(&down, secs)), [1.0, 0.75, 0.0, 0.0].map(brightness));
        assert!(!down.fade.is_over(after(3.9)) && down.fade.is_over(after(4.0)));
        let again = down.with(Some(0.0), None, after(3.0)).unwrap();
        assert_eq!(at(&again, 4.0), Brightness::DARK, "the same wish does not begin anew");
        let up = down.with(Some(1.0), Some(1.0), after(2.0)).unwrap();
        assert_eq!([2.0, 2.5, 3.0].map(|secs| at(&up, secs)), [0.5, 0.75, 1.0].map(brightness));
        let cut = down.with(Some(0.25), Some(0.0), after(1.0)).unwrap();
        assert_eq!(at(&cut, 1.0), brightness(0.25));
    }

    #[test]
    fn a_value_out_of_range_changes_nothing() {
        let (now, setting) = (Instant::now(), BrightnessSetting::default());
        for wrong in [f64::NAN, -0.1, 1.01, f64::INFINITY] {
            assert!(setting.with(Some(wrong), None, now).unwrap_err().starts_with("brightness: "));
        }
        for wrong in [f64::NAN, -1.0, 5.1] {
            let error = setting.with(Some(0.5), Some(wrong), now).unwrap_err();
            assert!(error.starts_with("fade_seconds: ") && error.ends_with("from 0 to 5"), "{error}");
        }
    }
}
