//! The history of one frame: its poses in its parent over time.
//!
//! A frame is static or it moves; the first transform published for it decides, for good, as in tf2. Static
//! frames hold one transform that is valid at all times and is replaced by the next one, whichever topic
//! that comes from. Frames that move hold samples in the order of their stamps, oldest first, as far back
//! as the cache length before the newest. Between two samples translation is interpolated linearly and
//! rotation along the shorter arc; where the parent changed between them the older sample holds until the
//! newer. Outside the samples nothing is known, and a lone sample is known at its own instant only; a prediction may go
//! beyond the newest.

use std::collections::VecDeque;
use std::time::Duration;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use crate::motion::Motion;
use crate::tree::FrameId;
use crate::{Prediction, Time};

/// Where a frame was in its parent at one instant.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Sample {
    pub(crate) stamp: Time,
    pub(crate) parent: FrameId,
    pub(crate) parent_from_child: Isometry3<f64>,
}

/// All that is known of one frame.
#[derive(Clone, Debug)]
pub(crate) enum History {
    Static(Sample),
    /// Ordered by strictly rising stamps.
    Moving(VecDeque<Sample>),
}

/// How a moving history treats a sample of a stamp.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Admission {
    /// It has none of that stamp, and takes one.
    New,
    /// It has one of that stamp, which holds.
    Known(Sample),
    /// It reaches only that far back from its newest sample at `latest`.
    TooOld { latest: Time },
}

impl History {
    pub(crate) fn new(first: Sample, is_static: bool) -> Self {
        if is_static {
            History::Static(first)
        } else {
            History::Moving(VecDeque::from([first]))
        }
    }

    /// What [`insert`](Self::insert) will do with a sample of that stamp. A static transform is always replaced.
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

    /// Stores a sample that is [admitted](Self::admits), and drops what is too old then. Returns whether that changed
    /// anything.
    pub(crate) fn insert(&mut self, sample: Sample, cache_length: Duration) -> bool {
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

    /// The parent and `parent_from_child` at `time`; at time zero the newest. `None` where it is not known.
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

    /// The parent and the predicted `parent_from_child`: where known samples reach, as they say; beyond the newest as
    /// its motion leads, but no further than the limit. Without a motion the newest sample holds. `None` where nothing
    /// is known.
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
        let place = motion.map(|motion| motion.lead(&newest.parent_from_child, ahead.as_secs_f64()));
        Some((newest.parent, place.unwrap_or(newest.parent_from_child)))
    }

    /// The newest sample; that of a static frame has stamp zero, since it does not bound any common time.
    pub(crate) fn newest(&self) -> Option<Sample> {
        match self {
            History::Static(known) => Some(Sample { stamp: Time::ZERO, ..*known }),
            History::Moving(samples) => samples.back().copied(),
        }
    }

    /// The first and last instant that is known of a moving frame.
    pub(crate) fn span(&self) -> Option<(Time, Time)> {
        match self {
            History::Static(_) => None,
            History::Moving(samples) => Some((samples.front()?.stamp, samples.back()?.stamp)),
        }
    }

    /// The parents of all samples, some of them several times.
    pub(crate) fn parents(&self) -> impl Iterator<Item = FrameId> + '_ {
        let (one, many) = match self {
            History::Static(known) => (Some(known.parent), None),
            History::Moving(samples) => (None, Some(samples.iter().map(|sample| sample.parent))),
        };
        one.into_iter().chain(many.into_iter().flatten())
    }

    /// With other ids of the parents; samples whose parent has none are dropped. `None` if a static frame's parent is
    /// gone.
    pub(crate) fn with_parents(self, new_id: impl Fn(FrameId) -> Option<FrameId>) -> Option<Self> {
        let renamed = |sample: Sample| Some(Sample { parent: new_id(sample.parent)?, ..sample });
        match self {
            History::Static(known) => renamed(known).map(History::Static),
            History::Moving(samples) => Some(History::Moving(samples.into_iter().filter_map(renamed).collect())),
        }
    }

    /// Forgets all samples of a moving frame. A static transform is kept.
    pub(crate) fn clear(&mut self) {
        if let History::Moving(samples) = self {
            samples.clear();
        }
    }
}

/// The transform at `ratio` of the way from `a` (0) to `b` (1): straight in translation, the shorter way in rotation.
pub fn interpolate(a: &Isometry3<f64>, b: &Isometry3<f64>, ratio: f64) -> Isometry3<f64> {
    // Not `lerp` of the difference: `b - a` may overflow where both are finite.
    let translation = a.translation.vector * (1.0 - ratio) + b.translation.vector * ratio;
    Isometry3::from_parts(Translation3::from(translation), slerp(&a.rotation, &b.rotation, ratio))
}

/// The rotation at `ratio` of the way along the shorter arc from `a` to `b`.
///
/// nalgebra's own takes the angle from the cosine and loses half the digits between rotations that are
/// nearly equal, which successive samples usually are.
fn slerp(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>, ratio: f64) -> UnitQuaternion<f64> {
    let a = a.into_inner();
    // q and -q are one rotation; of the two the nearer to `a` is the shorter way.
    let b = if a.coords.dot(&b.coords) < 0.0 { -b.into_inner() } else { b.into_inner() };
    let angle = 2.0 * (b - a).norm().atan2((b + a).norm());
    let (weight_a, weight_b) = if angle < STRAIGHT_ANGLE {
        (1.0 - ratio, ratio)
    } else {
        // Both would be divided by the angle's sine, but the sum is normalised.
        (((1.0 - ratio) * angle).sin(), (ratio * angle).sin())
    };
    UnitQuaternion::from_quaternion(a * weight_a + b * weight_b)
}

/// Two quaternions nearer than this (radians) are joined by a straight line, which then misses the arc by
/// less than the numbers resolve.
const STRAIGHT_ANGLE: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    const CACHE: Duration = Duration::from_secs(10);

    fn sample(secs: f64, parent: u32, x: f64) -> Sample {
        Sample {
            stamp: Time::from_secs_f64(secs),
            parent: FrameId(parent),
            parent_from_child: Isometry3::translation(x, 0.0, 0.0),
        }
    }

    fn moving(samples: &[Sample]) -> History {
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
    fn between_samples_the_place_is_on_the_line_and_outside_it_is_unknown() {
        let history = moving(&[sample(5.0, 0, 1.0), sample(6.0, 0, 3.0), sample(8.0, 0, 7.0)]);
        for (secs, x) in [(5.0, 1.0), (5.5, 2.0), (6.0, 3.0), (7.0, 5.0), (8.0, 7.0)] {
            assert_eq!(x_at(&history, secs), Some(x), "at {secs}");
        }
        assert_eq!(x_at(&history, 4.9), None);
        assert_eq!(x_at(&history, 8.1), None);
    }

    #[test]
    fn samples_out_of_order_find_their_place() {
        let history = moving(&[sample(8.0, 0, 7.0), sample(5.0, 0, 1.0), sample(6.0, 0, 3.0)]);
        assert_eq!(x_at(&history, 5.5), Some(2.0));
        assert_eq!(x_at(&history, 0.0), Some(7.0));
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
    fn the_older_parent_holds_until_the_newer_sample() {
        let history = moving(&[sample(5.0, 1, 1.0), sample(6.0, 2, 3.0)]);
        let at = |secs| history.at(Time::from_secs_f64(secs)).map(|(parent, at)| (parent, at.translation.x));
        assert_eq!(at(5.9), Some((FrameId(1), 1.0)));
        assert_eq!(at(6.0), Some((FrameId(2), 3.0)));
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

    #[test]
    fn rotation_follows_the_shorter_arc_whatever_the_signs() {
        let a = UnitQuaternion::from_scaled_axis(Vector3::z() * 0.2);
        let b = UnitQuaternion::from_scaled_axis(Vector3::z() * 1.0);
        let minus_b = UnitQuaternion::new_unchecked(-b.into_inner());
        for end in [b, minus_b] {
            let middle = slerp(&a, &end, 0.25);
            assert!((middle.scaled_axis() - Vector3::z() * 0.4).norm() < 1e-12);
        }
    }

    /// nalgebra's `angle_to` does not resolve small angles.
    fn angle_between(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> f64 {
        let (a, b) = (a.into_inner(), b.into_inner());
        4.0 * (b - a).norm().atan2((b + a).norm())
    }

    #[test]
    fn rotation_between_nearly_equal_and_opposite_ends_stays_a_rotation() {
        let a = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -0.4, 1.0));
        for angle in [0.0, 1e-12, 1e-8, 1e-5, 1e-3, std::f64::consts::PI] {
            let b = a * UnitQuaternion::from_scaled_axis(Vector3::x() * angle);
            let middle = slerp(&a, &b, 0.5);
            assert!((middle.norm() - 1.0).abs() < 1e-12, "angle {angle}");
            assert!((angle_between(&a, &middle) - angle / 2.0).abs() < 1e-12, "angle {angle}");
        }
    }
}
