//! The history of one frame: its poses in its parent over time.
//!
//! The first transform published for a frame decides for good whether it is static, as in tf2. A static frame holds one
//! transform, valid at all times and replaced by the next one from either topic. A moving frame holds samples, oldest
//! first, as far back as the cache length before the newest. Between two samples the pose is interpolated; where the
//! parent changed, the older sample holds until the newer. Outside the samples nothing is known, and a lone sample is
//! known at its own instant only; a prediction may go beyond the newest.

use std::collections::VecDeque;
use std::time::Duration;

use nalgebra::Isometry3;

use crate::motion::Motion;
use crate::sample::{interpolate, FrameId, PoseSample};
use crate::{Prediction, Time};

/// Static transform of a frame, or samples of a moving one.
#[derive(Clone, Debug)]
pub(crate) enum History {
    Static(PoseSample),
    /// Ordered by strictly rising stamps.
    Moving(VecDeque<PoseSample>),
}

/// Treatment of a new sample by its stamp.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Admission {
    /// No sample of that stamp yet: it is stored.
    New,
    /// This sample of that stamp is kept.
    Known(PoseSample),
    /// Older than the cache, whose newest sample is at `latest`.
    TooOld { latest: Time },
}

impl History {
    pub(crate) fn new(first: PoseSample, is_static: bool) -> Self {
        if is_static {
            History::Static(first)
        } else {
            History::Moving(VecDeque::from([first]))
        }
    }

    /// Decides by its stamp whether a sample may be [inserted](Self::insert). A static transform is always replaced.
    pub(crate) fn admits(&self, stamp: Time, cache_length: Duration) -> Admission {
        let History::Moving(samples) = self else { return Admission::New };
        match samples.back().map(|newest| newest.stamp) {
            Some(latest) if latest > stamp.saturating_add(cache_length) => Admission::TooOld { latest },
            // Stamps out of order are rare, so the search is kept for them.
            Some(latest) if latest >= stamp => {
                let known = samples.binary_search_by_key(&stamp, |known| known.stamp).ok();
                known.and_then(|place| samples.get(place)).map_or(Admission::New, |known| Admission::Known(*known))
            }
            _ => Admission::New,
        }
    }

    /// Stores an [admitted](Self::admits) sample and drops those that are too old then. Returns whether that changed
    /// anything.
    pub(crate) fn insert(&mut self, sample: PoseSample, cache_length: Duration) -> bool {
        let samples = match self {
            History::Static(known) => {
                let is_same = known.parent == sample.parent && known.parent_from_child == sample.parent_from_child;
                *known = sample;
                return !is_same;
            }
            History::Moving(samples) => samples,
        };
        if samples.back().is_some_and(|newest| newest.stamp > sample.stamp) {
            samples.insert(samples.partition_point(|known| known.stamp < sample.stamp), sample);
        } else {
            samples.push_back(sample);
        }
        let newest = samples.back().map_or(sample.stamp, |newest| newest.stamp);
        while samples.front().is_some_and(|oldest| oldest.stamp.saturating_add(cache_length) < newest) {
            samples.pop_front();
        }
        true
    }

    /// Parent and `parent_from_child` at `time`; at time zero the newest. `None` where unknown.
    pub(crate) fn at(&self, time: Time) -> Option<(FrameId, Isometry3<f64>)> {
        let samples = match self {
            History::Static(known) => return Some((known.parent, known.parent_from_child)),
            History::Moving(samples) => samples,
        };
        let newest = samples.back()?;
        if time.is_zero() || newest.stamp == time {
            return Some((newest.parent, newest.parent_from_child));
        }
        let after = samples.partition_point(|known| known.stamp <= time);
        let older = samples.get(after.checked_sub(1)?)?;
        let newer = samples.get(after)?;
        if older.stamp == time || older.parent != newer.parent {
            return Some((older.parent, older.parent_from_child));
        }
        let ratio = time.secs_since(older.stamp) / newer.stamp.secs_since(older.stamp);
        Some((older.parent, interpolate(&older.parent_from_child, &newer.parent_from_child, ratio)))
    }

    /// Parent and predicted `parent_from_child`: interpolated where samples reach that far, else extrapolated by the
    /// motion up to the limit. Without a motion the newest sample holds. `None` where nothing is known.
    pub(crate) fn predicted(&self, prediction: &Prediction) -> Option<(FrameId, Isometry3<f64>)> {
        let samples = match self {
            History::Static(known) => return Some((known.parent, known.parent_from_child)),
            History::Moving(samples) => samples,
        };
        let newest = samples.back()?;
        let time = prediction.time();
        if newest.stamp >= time {
            return self.at(time).or(Some((newest.parent, newest.parent_from_child)));
        }
        let silence = prediction.now.saturating_since(newest.stamp);
        let motion = Motion::of(samples).filter(|motion| silence <= prediction.limit + motion.period * 2);
        let ahead = time.saturating_since(newest.stamp).min(prediction.limit);
        let place = motion.map(|motion| motion.extrapolate(&newest.parent_from_child, ahead.as_secs_f64()));
        Some((newest.parent, place.unwrap_or(newest.parent_from_child)))
    }

    /// The newest sample; a static one has stamp zero, since it bounds no common time.
    pub(crate) fn newest(&self) -> Option<PoseSample> {
        match self {
            History::Static(known) => Some(PoseSample { stamp: Time::ZERO, ..*known }),
            History::Moving(samples) => samples.back().copied(),
        }
    }

    /// First and last known instant of a moving frame.
    pub(crate) fn span(&self) -> Option<(Time, Time)> {
        match self {
            History::Static(_) => None,
            History::Moving(samples) => Some((samples.front()?.stamp, samples.back()?.stamp)),
        }
    }

    /// Removes all samples of a moving frame; a static transform stays.
    pub(crate) fn clear(&mut self) {
        if let History::Moving(samples) = self {
            samples.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CACHE: Duration = Duration::from_secs(10);

    fn sample(secs: f64, parent: u32, x: f64) -> PoseSample {
        PoseSample {
            stamp: Time::from_secs_f64(secs),
            parent: FrameId(parent),
            parent_from_child: Isometry3::translation(x, 0.0, 0.0),
        }
    }

    fn moving(samples: &[PoseSample]) -> History {
        let mut history = History::Moving(VecDeque::new());
        for &one in samples {
            assert_eq!(history.admits(one.stamp, CACHE), Admission::New);
            assert!(history.insert(one, CACHE));
        }
        history
    }

    fn x_at(history: &History, secs: f64) -> Option<f64> {
        let (_, at) = history.at(Time::from_secs_f64(secs))?;
        Some(at.translation.x)
    }

    #[test]
    fn a_lone_sample_is_known_at_its_own_instant_only() {
        let history = moving(&[sample(5.0, 0, 1.0)]);
        assert_eq!(x_at(&history, 5.0), Some(1.0));
        assert_eq!(x_at(&history, 0.0), Some(1.0), "time zero is the latest");
        assert_eq!(x_at(&history, 4.999), None);
        assert_eq!(x_at(&history, 5.001), None);
    }

    #[test]
    fn the_history_reaches_the_cache_length_back_from_its_newest_sample() {
        let mut history = moving(&[sample(1.0, 0, 1.0), sample(2.0, 0, 2.0), sample(11.0, 0, 3.0)]);
        assert_eq!(x_at(&history, 1.0), Some(1.0), "just ten seconds old");
        assert!(history.insert(sample(12.0, 0, 4.0), CACHE));
        assert_eq!(x_at(&history, 1.5), None);
        assert_eq!(x_at(&history, 2.0), Some(2.0));
        let latest = Time::from_secs_f64(12.0);
        assert_eq!(history.admits(Time::from_secs_f64(1.999), CACHE), Admission::TooOld { latest });
    }

    #[test]
    fn a_stamp_that_has_a_sample_already_is_not_new() {
        let history = moving(&[sample(5.0, 0, 1.0), sample(6.0, 0, 2.0)]);
        for known in [sample(5.0, 0, 1.0), sample(6.0, 0, 2.0)] {
            assert_eq!(history.admits(known.stamp, CACHE), Admission::Known(known));
        }
    }

    #[test]
    fn a_static_frame_is_known_at_all_times_and_the_newest_transform_replaces_it() {
        let mut history = History::new(sample(5.0, 0, 1.0), true);
        assert_eq!(x_at(&history, 1e9), Some(1.0));
        assert_eq!(history.admits(Time::from_secs_f64(6.0), CACHE), Admission::New);
        assert!(!history.insert(sample(6.0, 0, 1.0), CACHE));
        assert!(history.insert(sample(2.0, 3, 4.0), CACHE));
        assert_eq!(x_at(&history, 1.0), Some(4.0));
        assert_eq!(history.newest().map(|s| s.stamp), Some(Time::ZERO));
        history.clear();
        assert_eq!(x_at(&history, 1.0), Some(4.0));
    }
}
