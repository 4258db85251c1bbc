//! ROS time of a bag: its `/clock`, as for a node with `use_sim_time`; without one, the times of recording.
//!
//! A bag may be recorded years after its messages were stamped, from a simulation or a bag that was played.

use anyhow::{bail, Result};
use rcs_bag::{Bag, BagMessage, Connection};
use rcs_displays::time_from_stamp;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_text::full_name;
use rcs_transforms::Time;

use super::moments::BagTimes;

/// `true` for the connection of `/clock`.
pub(super) fn is_clock(connection: &Connection) -> bool {
    full_name(&connection.topic) == "/clock" && connection.holds(MessageKind::Clock)
}

/// ROS time while a bag is played.
#[derive(Clone, Copy, Debug)]
pub(super) enum RosTime {
    /// The time of recording.
    Recorded,
    /// The last `/clock`; before its first message, that one.
    Clock(Time),
}

impl RosTime {
    /// Before the first message of a bag.
    pub(super) fn new(times: BagTimes) -> Self {
        if times.has_clock {
            Self::Clock(times.start)
        } else {
            Self::Recorded
        }
    }

    /// The time of the next message.
    pub(super) fn of(self, message: &BagMessage) -> Time {
        match self {
            Self::Recorded => time_from_stamp(message.time),
            Self::Clock(now) => clock_of(message).unwrap_or(now),
        }
    }
}

impl BagTimes {
    /// The times of a bag; `None` if it is empty.
    ///
    /// # Errors
    /// [`clock_jumps_back`].
    pub(super) fn of(bag: &Bag) -> Result<Option<Self>> {
        let Some((recorded_start, recorded_end)) = bag.time_range() else { return Ok(None) };
        let [start, end] = [recorded_start, recorded_end].map(time_from_stamp);
        let recorded = Self { start, end, has_clock: false };
        let clock_from = |from| bag.messages_from(from, is_clock).filter_map(|message| clock_of(&message.ok()?));
        let Some(start) = clock_from(recorded_start).next() else { return Ok(Some(recorded)) };
        // The clock mostly ticks up to the end, so that the last chunks have its last time.
        let mut secs = 1;
        let end = loop {
            let from = recorded_end.nanos().saturating_sub(secs * 1_000_000_000).max(recorded_start.nanos());
            match clock_from(rcs_messages::Time::from_nanos(from)).last() {
                Some(end) => break end,
                None if from == recorded_start.nanos() => break start,
                None => secs *= 4,
            }
        };
        if end < start {
            return clock_jumps_back(start, end);
        }
        Ok(Some(Self { start, end, has_clock: true }))
    }
}

/// The error of a clock that jumps back: one time would occur twice.
pub(super) fn clock_jumps_back<T>(from: Time, to: Time) -> Result<T> {
    bail!(
        "/clock jumps back from {from} to {to}: cut the bag there (rosbag filter), or take the times of recording \
         (/clock:=/unused)"
    )
}

/// The time in a message of the clock; `None` for other messages.
pub(super) fn clock_of(message: &BagMessage) -> Option<Time> {
    match is_clock(&message.connection).then(|| MessageKind::Clock.decode(&message.bytes))? {
        Ok(AnyMessage::Clock(clock)) => Some(time_from_stamp(clock.clock)),
        _ => None,
    }
}
