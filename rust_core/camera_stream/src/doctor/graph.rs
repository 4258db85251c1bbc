//! Checks of the ROS graph: the master, and the clocks of the computers.

use std::collections::BTreeMap;

use rcs_ros::is_this_computer;

use super::finding::{secs, Finding};
use super::look::Look;

/// Offset of a clock that is a fault, seconds: a part of the usual limit of 1 s, and more than a network's delay.
const MAX_OFFSET_SECS: f64 = 0.25;

/// The offset of a publisher's stamps from this computer's clock.
struct PublisherClock {
    publisher: String,
    host: String,
    is_here: bool,
    /// Positive for stamps in the future.
    offset_secs: f64,
}

/// A master that answers.
pub(super) fn master(look: &Look<'_>) -> Finding {
    Finding::good("master", look.session.ros.master_uri())
}

/// A master that does not answer.
pub(super) fn no_master(error: &anyhow::Error) -> Finding {
    let advice = "start roscore or the robot, or set ROS_MASTER_URI to its master";
    Finding::bad("master", rcs_logging::one_line(error), advice)
}

/// The clocks of the publishers' computers.
pub(super) fn clocks(look: &Look<'_>) -> Vec<Finding> {
    let ros = &look.session.ros;
    if ros.is_simulated() {
        let advice = "start the simulation or rosbag play --clock, or set the parameter /use_sim_time to false";
        if look.session.now().is_zero() {
            return vec![Finding::bad("clocks", "/use_sim_time is set and no /clock was received", advice)];
        }
        return vec![Finding::good("clocks", "simulated time, from /clock")];
    }
    let clock = |(publisher, offset_secs): (&str, f64)| {
        let host = ros.host_of(publisher)?;
        let is_here = is_this_computer(&host);
        Some(PublisherClock { publisher: publisher.to_owned(), host, is_here, offset_secs })
    };
    of_publishers(look.observed.clock_offsets_secs().into_iter().filter_map(clock))
}

/// The clock of each computer, by the publisher whose stamps are nearest to now: data may be late, and some nodes stamp
/// transforms ahead.
fn of_publishers(clocks: impl Iterator<Item = PublisherClock>) -> Vec<Finding> {
    let mut nearest: BTreeMap<String, PublisherClock> = BTreeMap::new();
    for clock in clocks {
        let known = nearest.get(&clock.host).map_or(f64::INFINITY, |known| known.offset_secs.abs());
        if clock.offset_secs.abs() < known {
            nearest.insert(clock.host.clone(), clock);
        }
    }
    if nearest.is_empty() {
        return vec![Finding::unknown("clocks", "no stamped messages came that show a clock", "")];
    }
    let wrong: Vec<Finding> = nearest.values().filter_map(wrong).collect();
    if !wrong.is_empty() {
        return wrong;
    }
    let of_host = |clock: &PublisherClock| format!("{} {}", clock.host, secs(clock.offset_secs));
    let all: Vec<String> = nearest.values().map(of_host).collect();
    vec![Finding::good("clocks", format!("offsets of stamps: {}", all.join(", ")))]
}

/// The fault of a clock, if it has one.
fn wrong(clock: &PublisherClock) -> Option<Finding> {
    let PublisherClock { publisher, host, is_here, offset_secs } = clock;
    if offset_secs.abs() <= MAX_OFFSET_SECS {
        return None;
    }
    let (offset, is_ahead) = (secs(offset_secs.abs()), *offset_secs > 0.0);
    Some(if *is_here {
        let side = if is_ahead { "ahead of" } else { "behind" };
        let text = format!("stamps of {publisher}, on this computer, are {offset} {side} its clock");
        Finding::bad("clocks", text, "correct that node; recorded data need rosbag play --clock and /use_sim_time")
    } else {
        let side = if is_ahead { "ahead" } else { "behind" };
        let text = format!("offset of {host}'s clock: {offset} {side} (by the stamps of {publisher})");
        Finding::bad("clocks", text, "set up chrony or ntp on both computers")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(clocks: &[(&str, &str, bool, f64)]) -> Vec<String> {
        let clocks = clocks.iter().map(|(publisher, host, is_here, offset_secs)| PublisherClock {
            publisher: (*publisher).to_owned(),
            host: (*host).to_owned(),
            is_here: *is_here,
            offset_secs: *offset_secs,
        });
        of_publishers(clocks).iter().map(Finding::to_string).collect()
    }

    #[test]
    fn the_clock_of_each_computer_is_that_of_its_nearest_stamps() {
        let good = lines(&[("/amcl", "robot", false, 0.9), ("/tf", "robot", false, -0.02), ("/cam", "pc", true, -0.1)]);
        assert_eq!(good, ["✓ clocks: offsets of stamps: pc -0.1 s, robot -0.02 s"]);
        assert_eq!(lines(&[]), ["? clocks: no stamped messages came that show a clock"]);
    }

    #[test]
    fn a_wrong_clock_is_named_with_its_computer_and_what_to_do() {
        let bad = lines(&[("/tf", "robot-pc", false, 1.2), ("/cam", "pc", true, -0.1), ("/bag", "here", true, -90.0)]);
        assert_eq!(bad, [
            "✗ clocks: stamps of /bag, on this computer, are 90 s behind its clock; correct that node; recorded data \
             need rosbag play --clock and /use_sim_time",
            "✗ clocks: offset of robot-pc's clock: 1.2 s ahead (by the stamps of /tf); set up chrony or ntp on both \
             computers",
        ]);
    }
}
