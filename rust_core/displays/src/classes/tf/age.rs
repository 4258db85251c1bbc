//! The age of a frame's last transform, and how it fades the frame's colours.

use std::time::Duration;

use rcs_scene::Rgba;
use rcs_transforms::Time;

const GREY: Rgba = Rgba::new(0.7, 0.7, 0.7, 1.0);

/// rviz's factor for a third.
const THIRD: f64 = 0.333_333_3;

/// Shortest period at which a fading colour is updated; longer if the change would be invisible.
const FADE_STEP: Duration = Duration::from_millis(33);

/// Levels of a colour channel within a third of the timeout.
const LEVELS: u32 = 256;

/// Effect of the age on a frame's colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fade {
    Fresh,
    /// Share of the colour (1 to 0), the rest is grey.
    ToGrey(f32),
    /// Grey with this opacity (1 to 0).
    Out(f32),
    Gone,
}

impl Fade {
    pub(super) fn apply(self, color: Rgba) -> Rgba {
        match self {
            Self::Fresh => color,
            Self::ToGrey(left) => {
                let mix = |channel: f32, grey: f32| channel * left + grey * (1.0 - left);
                let [r, g, b, a] = color.to_array();
                Rgba::new(mix(r, GREY.r), mix(g, GREY.g), mix(b, GREY.b), mix(a, GREY.a))
            }
            Self::Out(opacity) => GREY.with_alpha(opacity),
            Self::Gone => Rgba::TRANSPARENT,
        }
    }
}

/// Age of a frame's last transform.
#[derive(Clone, Copy, Debug)]
pub(super) struct Age {
    last_change: Time,
    /// Latest time at which the frame could be placed; zero while unknown or irrelevant.
    last_common_time: Time,
}

impl Age {
    pub(super) fn new(now: Time) -> Self {
        Self { last_change: now, last_common_time: Time::ZERO }
    }

    /// Records the latest time at which the frame can be placed; zero stands for always and for never.
    pub(super) fn update(&mut self, common_time: Time, now: Time) {
        if common_time.is_zero() || common_time != self.last_common_time {
            *self = Self { last_change: now, last_common_time: common_time };
        }
    }

    /// Effect of the age on the frame's colours.
    pub(super) fn fade(&self, now: Time, timeout: Duration) -> Fade {
        let age = now.saturating_since(self.last_change);
        let third = timeout.mul_f64(THIRD);
        let left = |end: Duration| (end.saturating_sub(age).as_secs_f64() / third.as_secs_f64()) as f32;
        if age > timeout {
            Fade::Gone
        } else if age > third * 2 {
            Fade::Out(left(timeout))
        } else if age > third {
            Fade::ToGrey(left(third * 2))
        } else {
            Fade::Fresh
        }
    }

    /// Time at which the colours change without a new transform.
    pub(super) fn next_change(&self, now: Time, timeout: Duration) -> Option<Time> {
        if self.last_common_time.is_zero() {
            return None;
        }
        // At the very end of a third it still holds.
        let after = |age: Duration| self.last_change.saturating_add(age.saturating_add(Duration::from_nanos(1)));
        let third = timeout.mul_f64(THIRD);
        match self.fade(now, timeout) {
            Fade::Fresh => Some(after(third)),
            Fade::ToGrey(_) | Fade::Out(_) => {
                let step = FADE_STEP.max(third / LEVELS);
                Some(now.saturating_add(step).min(after(timeout)))
            }
            Fade::Gone => None,
        }
    }
}
