//! ROS's time and duration, as they travel in messages.

use crate::wire::{DecodeError, Reader, Wire};

const NANOS_PER_SEC: i64 = 1_000_000_000;

/// A moment: seconds and nanoseconds since the epoch, or of the simulation. Zero means "not set", or "latest" to tf.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Time {
    /// Whole seconds.
    pub sec: u32,
    /// Nanoseconds of the running second.
    pub nsec: u32,
}

impl Time {
    /// The moment `nanos` nanoseconds after zero; what does not fit 32 bits of seconds is clamped to them.
    pub fn from_nanos(nanos: i64) -> Self {
        let nanos = nanos.clamp(0, i64::from(u32::MAX) * NANOS_PER_SEC);
        Self {
            sec: u32::try_from(nanos / NANOS_PER_SEC).unwrap_or(u32::MAX),
            nsec: u32::try_from(nanos % NANOS_PER_SEC).unwrap_or(0),
        }
    }

    /// Nanoseconds since zero.
    pub fn nanos(self) -> i64 {
        i64::from(self.sec) * NANOS_PER_SEC + i64::from(self.nsec)
    }

    /// Seconds since zero.
    pub fn seconds(self) -> f64 {
        f64::from(self.sec) + f64::from(self.nsec) * 1e-9
    }
}

/// A span of time, of either sign; both parts have the sign or `nsec` is positive, as in ROS.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Duration {
    /// Whole seconds.
    pub sec: i32,
    /// Nanoseconds, added to the seconds.
    pub nsec: i32,
}

impl Duration {
    /// The span in nanoseconds.
    pub fn nanos(self) -> i64 {
        i64::from(self.sec) * NANOS_PER_SEC + i64::from(self.nsec)
    }

    /// The span in seconds.
    pub fn seconds(self) -> f64 {
        f64::from(self.sec) + f64::from(self.nsec) * 1e-9
    }
}

macro_rules! two_words {
    ($type:ty, $word:ty, $ros:literal) => {
        impl Wire for $type {
            const MIN_LEN: usize = 8;

            fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
                Ok(Self { sec: <$word>::read(reader)?, nsec: <$word>::read(reader)? })
            }

            fn write(&self, out: &mut Vec<u8>) {
                self.sec.write(out);
                self.nsec.write(out);
            }

            fn ros_type() -> String {
                $ros.to_owned()
            }
        }
    };
}

two_words!(Time, u32, "time");
two_words!(Duration, i32, "duration");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nanoseconds_there_and_back() {
        let time = Time { sec: 1_700_000_000, nsec: 123_456_789 };
        assert_eq!(Time::from_nanos(time.nanos()), time);
        assert_eq!(Time::from_nanos(-5), Time::default());
    }
}
