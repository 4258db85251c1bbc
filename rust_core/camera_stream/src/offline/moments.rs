//! The times of a bag that are rendered.

use std::time::Duration;

use anyhow::{bail, Result};
use rcs_transforms::Time;

/// Most images of a sequence: their numbers have six digits.
const MAX_IMAGES: u64 = 1_000_000;

/// The part of a bag to render. Times are seconds after the bag's first message, or ROS times that lie within the bag.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BagSection {
    /// This time alone.
    pub at_secs: Option<f64>,
    /// From this time on.
    pub start_secs: Option<f64>,
    /// Up to this time, or the bag's end if that is earlier.
    pub end_secs: Option<f64>,
}

/// Evenly spaced times, one at least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RenderTimes {
    first: Time,
    rate_hz: f64,
    count: u64,
}

/// The times of a bag's first and last message, or of its clock.
#[derive(Clone, Copy, Debug)]
pub(super) struct BagTimes {
    pub(super) start: Time,
    pub(super) end: Time,
    /// `true` if they are of the bag's clock.
    pub(super) has_clock: bool,
}

impl BagTimes {
    /// Converts a time that lies within the bag.
    fn moment(self, option: &str, secs: f64) -> Result<Time> {
        let Self { start, end, .. } = self;
        let absolute = secs >= start.as_secs_f64() && secs <= end.as_secs_f64();
        let moment = if absolute { Time::from_secs_f64(secs) } else { after(start, secs) };
        let lasts = end.secs_since(start);
        if moment < start {
            bail!("{option} {secs}: the bag begins at {start} and lasts {lasts} s");
        }
        // A time that was printed with fewer digits than it has is not beyond the end.
        if moment > end.saturating_add(Duration::from_millis(1)) {
            bail!("{option} {secs}: the bag ends {lasts} s after its first message, at {end}");
        }
        Ok(moment)
    }
}

impl BagSection {
    /// One time, by default the last.
    pub(super) fn single(&self, bag: BagTimes) -> Result<RenderTimes> {
        let first = self.at_secs.map_or(Ok(bag.end), |secs| bag.moment("--at", secs))?;
        Ok(RenderTimes { first, rate_hz: 1.0, count: 1 })
    }

    /// Beginning and end of a sequence. It begins later if its camera appears later.
    pub(super) fn bounds(&self, bag: BagTimes) -> Result<[Time; 2]> {
        if let Some(secs) = self.at_secs {
            let moment = bag.moment("--at", secs)?;
            return Ok([moment; 2]);
        }
        let first = self.start_secs.map_or(Ok(bag.start), |secs| bag.moment("--start", secs))?;
        let last = match self.end_secs {
            Some(secs) if secs.is_sign_positive() => bag.moment("--end", secs).unwrap_or(bag.end),
            Some(secs) => bag.moment("--end", secs)?,
            None => bag.end,
        };
        if last < first {
            bail!("--end is before --start: {last} and {first}");
        }
        Ok([first, last])
    }
}

impl RenderTimes {
    /// Evenly spaced times from the first to the last.
    pub(super) fn between([first, last]: [Time; 2], rate_hz: f64) -> Result<Self> {
        let length_secs = last.secs_since(first);
        // The last one is drawn although its time is rounded.
        let count = (length_secs * rate_hz + 1e-9).floor() + 1.0;
        if !(count >= 1.0 && count <= MAX_IMAGES as f64) {
            bail!("--rate {rate_hz}: {count} pictures of {length_secs} s, more than {MAX_IMAGES}");
        }
        Ok(Self { first, rate_hz, count: count as u64 })
    }

    pub(super) fn count(&self) -> u64 {
        self.count
    }

    fn at(&self, index: u64) -> Time {
        after(self.first, index as f64 / self.rate_hz)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Time> + '_ {
        (0..self.count).map(|index| self.at(index))
    }

    pub(super) fn last(&self) -> Time {
        self.at(self.count.saturating_sub(1))
    }
}

/// The time this many seconds after another, saturating.
fn after(start: Time, secs: f64) -> Time {
    let duration = Duration::try_from_secs_f64(secs.abs()).unwrap_or(Duration::MAX);
    if secs < 0.0 {
        start.saturating_sub(duration)
    } else {
        start.saturating_add(duration)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(secs: u32) -> Time {
        Time::from_secs_nanos(secs, 0)
    }

    const BAG: BagTimes =
        BagTimes { start: Time::from_secs_nanos(100, 0), end: Time::from_secs_nanos(103, 0), has_clock: false };

    #[test]
    fn a_moment_is_within_the_bag() {
        let single = |secs| BagSection { at_secs: Some(secs), ..BagSection::default() }.single(BAG);
        let first = |secs| single(secs).unwrap().first.as_secs_f64();
        assert_eq!([0.0, 1.5, 102.0, 3.0].map(first), [100.0, 101.5, 102.0, 103.0]);
        assert_eq!(BagSection::default().single(BAG).unwrap().first, at(103));
        for secs in [3.1, 99.0, 104.0, 1e9, 1e20, 1e300] {
            assert!(single(secs).unwrap_err().to_string().contains("the bag ends 3 s after"), "{secs}");
            assert!(single(-secs).unwrap_err().to_string().contains("the bag begins at 100"), "{secs}");
        }
    }

    #[test]
    fn a_sequence_is_a_part_of_the_bag() {
        let bounds = |start_secs, end_secs| BagSection { at_secs: None, start_secs, end_secs }.bounds(BAG);
        assert_eq!(bounds(None, None).unwrap(), [at(100), at(103)]);
        assert_eq!(bounds(Some(1.0), Some(102.0)).unwrap(), [at(101), at(102)]);
        assert_eq!(bounds(Some(2.0), Some(99.0)).unwrap(), [at(102), at(103)], "to the end at most");
        for (start, end) in [(Some(4.0), None), (Some(-1.0), None), (None, Some(-1.0)), (Some(2.0), Some(1.0))] {
            assert!(bounds(start, end).is_err(), "{start:?} {end:?}");
        }
        let one = BagSection { at_secs: Some(1.0), ..BagSection::default() }.bounds(BAG).unwrap();
        assert_eq!(RenderTimes::between(one, 30.0).unwrap().iter().collect::<Vec<_>>(), [at(101)]);
    }

    #[test]
    fn a_sequence_is_evenly_spaced_and_has_a_limit() {
        let moments = |rate_hz, end| RenderTimes::between([at(100), at(end)], rate_hz);
        let times: Vec<f64> = moments(2.0, 102).unwrap().iter().map(Time::as_secs_f64).collect();
        assert_eq!(times, [100.0, 100.5, 101.0, 101.5, 102.0]);
        assert_eq!(moments(2.0, 102).unwrap().last(), at(102));
        assert_eq!(moments(30.0, 100).unwrap().count, 1);
        assert_eq!(moments(1000.0, 1099).unwrap().count, 999_001);
        for (rate_hz, end) in [(1000.0, 1101), (1e300, 101), (f64::NAN, 101), (1e11, 4_000_000_000)] {
            let error = moments(rate_hz, end).unwrap_err().to_string();
            assert!(error.contains("1000000"), "{error}");
        }
    }
}
