//! What arrives while a session listens: the topics' rates, the publishers' clocks, the age of lenses' transforms.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_displays::time_from_stamp;
use rcs_messages::{header, AnyMessage, Image};
use rcs_ros::NodeEvent;
use rcs_transforms::Time;

use crate::scene::SceneState;

/// Arrivals of a topic's messages.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Arrivals {
    pub(crate) count: usize,
    pub(crate) first: Instant,
    pub(crate) last: Instant,
    /// Longest time between two messages.
    pub(crate) longest_gap: Duration,
    /// Longest time between a message's stamp and its arrival; zero without stamps.
    pub(crate) longest_delay: Duration,
    /// Age of the last message when it arrived, seconds; `None` without a stamp.
    pub(crate) last_age_secs: Option<f64>,
}

impl Arrivals {
    fn new(at: Instant) -> Self {
        let (longest_gap, longest_delay) = (Duration::ZERO, Duration::ZERO);
        Self { count: 0, first: at, last: at, longest_gap, longest_delay, last_age_secs: None }
    }

    /// Notes a message. The first of a publisher may have waited for a subscriber: it says nothing about the delay.
    fn note(&mut self, at: Instant, age_secs: Option<f64>, is_publishers_first: bool) {
        self.longest_gap = self.longest_gap.max(at.saturating_duration_since(self.last));
        let delay = Duration::try_from_secs_f64(age_secs.unwrap_or_default()).unwrap_or_default();
        if !is_publishers_first {
            self.longest_delay = self.longest_delay.max(delay);
        }
        (self.count, self.last, self.last_age_secs) = (self.count + 1, at, age_secs);
    }

    /// Mean time between messages; `None` for fewer than two.
    pub(crate) fn period(&self) -> Option<Duration> {
        let gaps = u32::try_from(self.count).ok()?.checked_sub(1).filter(|gaps| *gaps > 0)?;
        Some(self.last.saturating_duration_since(self.first) / gaps)
    }
}

/// Stamps of a publisher on a topic, compared with this computer's clock.
#[derive(Clone, Copy, Debug)]
struct Stamps {
    first: Time,
    /// `true` once another stamp has come: a single one says when something was, not what time it is.
    is_going: bool,
    /// Time from now to a stamp, seconds, of the one nearest to now; negative for the past.
    offset_secs: f64,
}

/// Topics and images received while a session listens.
#[derive(Debug, Default)]
pub(crate) struct Observed {
    /// By whole name.
    pub(crate) topics: HashMap<Arc<str>, Arrivals>,
    /// The last image of each topic, by whole name.
    pub(crate) images: HashMap<Arc<str>, Arc<Image>>,
    /// Greatest age of the newest transform between a lens and the fixed frame, by the CameraInfo topic's name in the
    /// config. None for a lens that does not move.
    pub(crate) lens_ages_secs: HashMap<String, f64>,
    stamps: BTreeMap<(Arc<str>, Arc<str>), Stamps>,
}

impl Observed {
    /// The publishers whose stamps go on, each with the offset of the topic on which that is the smallest.
    pub(crate) fn clock_offsets_secs(&self) -> BTreeMap<&str, f64> {
        let mut offsets: BTreeMap<&str, f64> = BTreeMap::new();
        for ((publisher, _), stamps) in self.stamps.iter().filter(|(_, stamps)| stamps.is_going) {
            let nearest = offsets.entry(publisher).or_insert(stamps.offset_secs);
            *nearest = nearer(*nearest, stamps.offset_secs);
        }
        offsets
    }

    fn note_stamp(&mut self, publisher: &Arc<str>, topic: &Arc<str>, stamp: Time, now: Time) {
        if stamp.is_zero() || now.is_zero() {
            return;
        }
        let offset_secs = stamp.secs_since(now);
        let new = Stamps { first: stamp, is_going: false, offset_secs };
        let stamps = self.stamps.entry((Arc::clone(publisher), Arc::clone(topic))).or_insert(new);
        // The first may have waited for a subscriber.
        stamps.offset_secs = if stamps.is_going { nearer(stamps.offset_secs, offset_secs) } else { offset_secs };
        stamps.is_going |= stamps.first != stamp;
    }

    /// Notes an event before it is applied. `now` is ROS time.
    pub(super) fn event(&mut self, event: &NodeEvent, now: Time) {
        match event {
            NodeEvent::Message { topic, message, publisher, received } => {
                let now = now.saturating_sub(received.elapsed());
                let stamp = header(message).map(|header| time_from_stamp(header.stamp)).unwrap_or(Time::ZERO);
                let age_secs = (!stamp.is_zero() && !now.is_zero()).then(|| now.secs_since(stamp));
                let is_publishers_first = !self.stamps.contains_key(&(Arc::clone(publisher), Arc::clone(topic)));
                self.topics.entry(Arc::clone(topic)).or_insert_with(|| Arrivals::new(*received)).note(
                    *received,
                    age_secs,
                    is_publishers_first,
                );
                self.note_stamp(publisher, topic, stamp, now);
                if let AnyMessage::Image(image) = message {
                    self.images.insert(Arc::clone(topic), Arc::clone(image));
                }
            }
            NodeEvent::Transforms { message, is_static: false, authority, received } => {
                let stamps = message.transforms.iter().map(|transform| time_from_stamp(transform.header.stamp));
                if let Some(stamp) = stamps.max() {
                    self.note_stamp(authority, &"/tf".into(), stamp, now.saturating_sub(received.elapsed()));
                }
            }
            NodeEvent::TimeJumpedBack { .. } => self.stamps.clear(),
            NodeEvent::Transforms { .. } | NodeEvent::Parameter { .. } | NodeEvent::PublisherLeft { .. } => {}
        }
    }

    /// Notes how old the transforms of the lenses are, after an update of the scene.
    pub(super) fn updated(&mut self, scene: &SceneState, now: Time) {
        for topic in scene.camera_info_topics().filter(|_| !now.is_zero()) {
            let frame = scene.received_camera_info(topic).map(|(frame, _)| frame);
            let Some(stamp) = frame.and_then(|frame| scene.known_until(frame)).filter(|stamp| !stamp.is_zero()) else {
                continue;
            };
            let age_secs = now.secs_since(stamp);
            let greatest = self.lens_ages_secs.entry(topic.to_owned()).or_insert(age_secs);
            *greatest = greatest.max(age_secs);
        }
    }
}

/// The one nearer to zero.
fn nearer(a: f64, b: f64) -> f64 {
    if b.abs() < a.abs() {
        b
    } else {
        a
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use rcs_messages::sensor_msgs::CameraInfo;

    use super::*;

    /// Arrivals at these times, seconds.
    pub(crate) fn arrivals(start: Instant, times_secs: &[f64], delay_secs: f64) -> Arrivals {
        let at = |secs: f64| start + Duration::from_secs_f64(secs);
        let mut arrivals = Arrivals::new(at(times_secs[0]));
        times_secs.iter().for_each(|secs| arrivals.note(at(*secs), Some(delay_secs), false));
        arrivals
    }

    #[test]
    fn arrivals_have_a_period_and_a_longest_gap() {
        let seen = arrivals(Instant::now(), &[0.0, 1.0, 4.0], 0.5);
        assert_eq!((seen.count, seen.period()), (3, Some(Duration::from_secs(2))));
        assert_eq!((seen.longest_gap, seen.longest_delay), (Duration::from_secs(3), Duration::from_millis(500)));
        assert_eq!(arrivals(Instant::now(), &[1.0], 0.0).period(), None);
    }

    #[test]
    fn a_clock_is_read_from_stamps_that_go_on() {
        let mut observed = Observed::default();
        let now = Time::from_secs_nanos(100, 0);
        let mut send = |publisher: &str, topic: &str, stamp: u32| {
            let mut info = CameraInfo::default();
            info.header.stamp.sec = stamp;
            let message = AnyMessage::CameraInfo(Arc::new(info));
            let (topic, publisher) = (topic.into(), publisher.into());
            observed.event(&NodeEvent::Message { topic, message, publisher, received: Instant::now() }, now);
        };
        send("/latched", "/info", 10);
        send("/latched", "/info", 10);
        send("/unstamped", "/info", 0);
        for stamp in [60, 98] {
            send("/slow", "/a", stamp);
            send("/slow", "/b", stamp - 5);
        }
        let offsets = observed.clock_offsets_secs();
        assert_eq!(offsets.keys().copied().collect::<Vec<_>>(), ["/slow"]);
        assert!((offsets["/slow"] + 2.0).abs() < 0.1, "{offsets:?}");
        assert_eq!(observed.topics["/info"].count, 3);
        let delay = observed.topics["/a"].longest_delay;
        assert!((1..3).contains(&delay.as_secs()), "{delay:?}: the first message may have waited for a subscriber");
    }
}
