//! ROS time: nanoseconds since the epoch of the ROS clock (the Unix epoch, or the start of a simulation).
//!
//! Messages carry it as unsigned seconds and nanoseconds. One signed count of nanoseconds orders and subtracts without
//! carries; all arithmetic saturates, because stamps come from outside.

use std::fmt;
use std::time::Duration;

const NANOS_PER_SEC: i64 = 1_000_000_000;

/// A ROS time in nanoseconds. [`Time::ZERO`] means "the latest common time" where a time is looked up.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Debug)]
pub struct Time {
    nanos: i64,
}

impl Time {
    /// The epoch; in lookups, the latest common time of the two frames.
    pub const ZERO: Time = Time { nanos: 0 };

    /// From a message's `secs` and `nsecs`. `nanos` of a second or more carry over, as malformed stamps may.
    pub const fn from_secs_nanos(secs: u32, nanos: u32) -> Self {
        // The largest value is about 4.3e18, which an i64 holds.
        Time { nanos: secs as i64 * NANOS_PER_SEC + nanos as i64 }
    }

    /// From nanoseconds since the epoch.
    pub const fn from_nanos(nanos: i64) -> Self {
        Time { nanos }
    }

    /// From seconds since the epoch, to the nearest nanosecond. NaN gives zero, values out of range saturate.
    pub fn from_secs_f64(secs: f64) -> Self {
        // Whole seconds are split off first: their product with 1e9 would cost the fraction its last digits.
        let whole = secs.trunc();
        let fraction_nanos = ((secs - whole) * NANOS_PER_SEC as f64).round();
        Time { nanos: (whole as i64).saturating_mul(NANOS_PER_SEC).saturating_add(fraction_nanos as i64) }
    }

    /// Nanoseconds since the epoch.
    pub const fn as_nanos(self) -> i64 {
        self.nanos
    }

    /// Seconds since the epoch; a double holds today's times to about 0.2 microseconds.
    pub fn as_secs_f64(self) -> f64 {
        self.nanos as f64 / NANOS_PER_SEC as f64
    }

    /// Seconds and nanoseconds, as in a message; clamped to what a message can hold.
    pub fn as_secs_nanos(self) -> (u32, u32) {
        let nanos = self.nanos.max(0);
        match u32::try_from(nanos / NANOS_PER_SEC) {
            Ok(secs) => (secs, (nanos % NANOS_PER_SEC) as u32),
            Err(_) => (u32::MAX, NANOS_PER_SEC as u32 - 1),
        }
    }

    /// `true` for [`Time::ZERO`].
    pub const fn is_zero(self) -> bool {
        self.nanos == 0
    }

    /// This time plus `duration`, saturating.
    pub fn saturating_add(self, duration: Duration) -> Self {
        Time { nanos: self.nanos.saturating_add(saturated_nanos(duration)) }
    }

    /// This time minus `duration`, saturating.
    pub fn saturating_sub(self, duration: Duration) -> Self {
        Time { nanos: self.nanos.saturating_sub(saturated_nanos(duration)) }
    }

    /// The time since `earlier`, or zero where that lies later.
    pub fn saturating_since(self, earlier: Time) -> Duration {
        u64::try_from(i128::from(self.nanos) - i128::from(earlier.nanos)).map_or(Duration::ZERO, Duration::from_nanos)
    }

    /// Seconds from `other` to this time, negative where `other` lies later.
    pub fn secs_since(self, other: Time) -> f64 {
        (i128::from(self.nanos) - i128::from(other.nanos)) as f64 / NANOS_PER_SEC as f64
    }
}

/// Seconds with nine decimals, as ROS prints a stamp.
impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let nanos = self.nanos.unsigned_abs();
        let per_sec = NANOS_PER_SEC.unsigned_abs();
        let sign = if self.nanos < 0 { "-" } else { "" };
        write!(f, "{sign}{}.{:09}", nanos / per_sec, nanos % per_sec)
    }
}

fn saturated_nanos(duration: Duration) -> i64 {
    i64::try_from(duration.as_nanos()).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_stamp_keeps_every_nanosecond() {
        let stamp = Time::from_secs_nanos(1_700_000_000, 123_456_789);
        assert_eq!(stamp.as_nanos(), 1_700_000_000_123_456_789);
        assert_eq!(stamp.as_secs_nanos(), (1_700_000_000, 123_456_789));
        assert_eq!(stamp.to_string(), "1700000000.123456789");
    }

    #[test]
    fn nanoseconds_of_more_than_a_second_carry_over() {
        let stamp = Time::from_secs_nanos(1, u32::MAX);
        assert_eq!(stamp.as_secs_nanos(), (5, 294_967_295));
        assert!(Time::from_secs_nanos(u32::MAX, u32::MAX) > stamp);
    }

    #[test]
    fn seconds_as_a_double_round_to_nanoseconds_and_never_panic() {
        assert_eq!(Time::from_secs_f64(1.5).as_nanos(), 1_500_000_000);
        assert_eq!(Time::from_secs_f64(-0.25).as_nanos(), -250_000_000);
        assert_eq!(Time::from_secs_f64(f64::NAN), Time::ZERO);
        assert_eq!(Time::from_secs_f64(f64::INFINITY).as_nanos(), i64::MAX);
        assert_eq!(Time::from_secs_f64(-1e300).as_nanos(), i64::MIN);
        assert_eq!(Time::from_secs_nanos(3, 250_000_000).as_secs_f64(), 3.25);
    }

    #[test]
    fn arithmetic_saturates() {
        let late = Time::from_nanos(i64::MAX - 1);
        assert_eq!(late.saturating_add(Duration::MAX).as_nanos(), i64::MAX);
        let early = Time::from_nanos(i64::MIN + 1);
        assert_eq!(early.saturating_sub(Duration::from_secs(1)).as_nanos(), i64::MIN);
        assert_eq!(early.saturating_since(late), Duration::ZERO);
        assert_eq!(Time::from_nanos(7).saturating_since(Time::from_nanos(5)), Duration::from_nanos(2));
        assert!(late.secs_since(early) > 1.8e10);
    }

    #[test]
    fn times_before_the_epoch_print_with_their_sign() {
        assert_eq!(Time::from_nanos(-1_500_000_000).to_string(), "-1.500000000");
        assert_eq!(Time::from_nanos(-1).to_string(), "-0.000000001");
    }

    #[test]
    fn times_that_no_message_can_hold_are_clamped() {
        assert_eq!(Time::from_nanos(-5).as_secs_nanos(), (0, 0));
        assert_eq!(Time::from_nanos(i64::MAX).as_secs_nanos(), (u32::MAX, 999_999_999));
    }
}
