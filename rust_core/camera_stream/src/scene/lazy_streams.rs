//! Streams that nobody watches: which are not received, and until when pictures wait for those that are again.
//!
//! A cloud thirty times a second costs a sixth of a core just to be received, also while no picture is made of it. So
//! while no camera is watched, a stream is paused: one that has proven itself periodic, that no publisher latches, and
//! of which each message replaces all that earlier ones made. With the first subscriber of a picture all are resumed,
//! and that picture waits a little for a fresh message of each, because what they sent before is old.
//!
//! This knows only names and moments; connections and displays are up to `Subscriptions`.

use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_messages::MessageKind;

/// A topic by its whole name and type.
pub(crate) type Key = (Arc<str>, MessageKind);

/// How long nobody watches before streams are paused: a viewer that is started again finds everything running.
const PATIENCE: Duration = Duration::from_secs(2);
/// So many messages prove a stream.
const MESSAGES: usize = 12;
/// What comes more rarely is no stream: to wait for its next message would take long.
const LONGEST_INTERVAL: Duration = Duration::from_secs(1);
/// The longest interval is at most so many times the median.
const MOST_UNEVEN: u32 = 4;
/// How long a picture waits for fresh messages, beside the stream's longest interval: for the connection.
const CONNECTION_TIME: Duration = Duration::from_millis(500);

/// What is known of each stream.
#[derive(Debug, Default)]
pub(crate) struct LazyStreams {
    streams: HashMap<Key, Stream>,
    unwatched_since: Option<Instant>,
    /// Resumed, and without a message since.
    awaited: HashSet<Key>,
    awaited_until: Option<Instant>,
}

#[derive(Debug, Default)]
struct Stream {
    /// Of the last messages, the newest last.
    arrivals: VecDeque<Instant>,
    /// The longest interval when it was paused; `None` while it is received.
    paused: Option<Duration>,
}

/// What is to be done.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Orders {
    /// Not to be received from now on.
    pub(crate) pause: Vec<Key>,
    /// To be received again.
    pub(crate) resume: Vec<Key>,
}

impl Stream {
    /// The longest interval between its last messages, if they are those of a stream that is still coming.
    fn period(&self, now: Instant) -> Option<Duration> {
        if self.arrivals.len() < MESSAGES {
            return None;
        }
        let next = self.arrivals.iter().skip(1);
        let mut intervals: Vec<Duration> =
            self.arrivals.iter().zip(next).map(|(a, b)| b.saturating_duration_since(*a)).collect();
        intervals.sort_unstable();
        let (median, longest) = (*intervals.get(intervals.len() / 2)?, *intervals.last()?);
        let is_coming = now.saturating_duration_since(*self.arrivals.back()?) <= LONGEST_INTERVAL;
        let is_even = longest <= median.saturating_mul(MOST_UNEVEN).max(Duration::from_millis(100));
        (is_coming && is_even && longest <= LONGEST_INTERVAL).then_some(longest)
    }
}

impl LazyStreams {
    /// Records a message.
    pub(crate) fn note_message(&mut self, key: &Key, received: Instant) {
        self.awaited.remove(key);
        if !self.streams.contains_key(key) {
            self.streams.insert(key.clone(), Stream::default());
        }
        if let Some(stream) = self.streams.get_mut(key) {
            if stream.arrivals.len() >= MESSAGES {
                stream.arrivals.pop_front();
            }
            stream.arrivals.push_back(received);
        }
    }

    /// Decides what is paused and resumed. `may_pause`: whether that loses nothing.
    pub(crate) fn update(&mut self, is_watched: bool, now: Instant, may_pause: impl Fn(&Key) -> bool) -> Orders {
        let mut orders = Orders::default();
        let unwatched_since = match is_watched {
            true => None,
            false => Some(self.unwatched_since.unwrap_or(now)),
        };
        self.unwatched_since = unwatched_since;
        let is_time = unwatched_since.is_some_and(|since| now.saturating_duration_since(since) >= PATIENCE);
        for (key, stream) in &mut self.streams {
            match stream.paused {
                Some(interval) if is_watched || !may_pause(key) => {
                    stream.paused = None;
                    self.awaited.insert(key.clone());
                    let until = now + CONNECTION_TIME + interval;
                    self.awaited_until = self.awaited_until.max(Some(until));
                    orders.resume.push(key.clone());
                }
                None if is_time => {
                    let Some(interval) = stream.period(now).filter(|_| may_pause(key)) else { continue };
                    stream.paused = Some(interval);
                    stream.arrivals.clear();
                    orders.pause.push(key.clone());
                }
                _ => {}
            }
        }
        orders
    }

    /// Forgets all other topics: they are not subscribed to any more.
    pub(crate) fn retain(&mut self, is_subscribed: impl Fn(&Key) -> bool) {
        self.streams.retain(|key, _| is_subscribed(key));
        self.awaited.retain(is_subscribed);
    }

    /// Whether a topic is paused, by its whole name.
    pub(crate) fn is_paused(&self, topic: &str) -> bool {
        self.streams.iter().any(|((name, _), stream)| &**name == topic && stream.paused.is_some())
    }

    /// How long a picture waits at most for messages of streams that were resumed; `None` if it need not wait.
    pub(crate) fn waits(&mut self, now: Instant) -> Option<Duration> {
        let left = self.awaited_until.map(|until| until.saturating_duration_since(now)).filter(|left| !left.is_zero());
        if self.awaited.is_empty() || left.is_none() {
            self.awaited.clear();
            self.awaited_until = None;
            return None;
        }
        left
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Streams and moments in milliseconds after a start.
    struct Bench {
        start: Instant,
        streams: LazyStreams,
    }

    fn key(name: &str) -> Key {
        (name.into(), MessageKind::PointCloud2)
    }

    impl Bench {
        fn new() -> Self {
            Self { start: Instant::now(), streams: LazyStreams::default() }
        }

        fn at(&self, millis: u64) -> Instant {
            self.start + Duration::from_millis(millis)
        }

        /// Messages at these times.
        fn send(&mut self, name: &str, times: impl Iterator<Item = u64>) {
            times.for_each(|millis| self.streams.note_message(&key(name), self.at(millis)));
        }

        fn update(&mut self, is_watched: bool, millis: u64) -> Orders {
            self.streams.update(is_watched, self.at(millis), |(name, _)| !name.contains("precious"))
        }
    }

    fn pause(name: &str) -> Orders {
        Orders { pause: vec![key(name)], ..Orders::default() }
    }

    fn resume(name: &str) -> Orders {
        Orders { resume: vec![key(name)], ..Orders::default() }
    }

    #[test]
    fn a_stream_is_paused_a_while_after_the_last_viewer_left_and_resumed_with_the_next() {
        let mut bench = Bench::new();
        bench.send("/cloud", (0..60).map(|i| i * 33));
        assert_eq!(bench.update(true, 1950), Orders::default());
        assert_eq!(bench.update(false, 2000), Orders::default());
        bench.send("/cloud", (60..120).map(|i| i * 33));
        assert_eq!(bench.update(false, 3900), Orders::default());
        assert_eq!(bench.update(true, 3950), Orders::default(), "somebody watches again");
        assert_eq!(bench.update(false, 3960), Orders::default());
        bench.send("/cloud", (120..200).map(|i| i * 33));
        assert_eq!(bench.update(false, 6500), pause("/cloud"));
        assert!(bench.streams.is_paused("/cloud") && !bench.streams.is_paused("/other"));
        assert_eq!(bench.update(false, 7000), Orders::default());
        assert_eq!(bench.update(true, 9000), resume("/cloud"));
        let left = bench.streams.waits(bench.at(9010));
        assert_eq!(left, Some(CONNECTION_TIME + Duration::from_millis(33 - 10)));
        bench.send("/cloud", std::iter::once(9040));
        assert_eq!(bench.streams.waits(bench.at(9041)), None);
    }

    #[test]
    fn a_picture_does_not_wait_for_ever() {
        let mut bench = Bench::new();
        bench.update(false, 0);
        bench.send("/cloud", (0..100).map(|i| i * 33));
        assert_eq!(bench.update(false, 3300), pause("/cloud"));
        assert_eq!(bench.update(true, 4000), resume("/cloud"));
        assert!(bench.streams.waits(bench.at(4500)).is_some());
        assert_eq!(bench.streams.waits(bench.at(4600)), None);
    }

    #[test]
    fn what_is_rare_or_uneven_or_has_ended_or_must_not_be_lost_is_received() {
        let paused = |name: &str, times: Vec<u64>, at: u64| {
            let mut bench = Bench::new();
            bench.update(false, 0);
            bench.send(name, times.into_iter());
            !bench.update(false, at).pause.is_empty()
        };
        assert!(paused("/stream", (0..40).map(|i| i * 100).collect(), 3950));
        assert!(paused("/slow stream", (0..20).map(|i| i * 1000).collect(), 19_500));
        assert!(!paused("/rare", (0..20).map(|i| i * 1100).collect(), 20_950));
        assert!(!paused("/bursts", (0..40).map(|i| i * 5 + i / 8 * 800).collect(), 3500));
        assert!(!paused("/ended", (0..40).map(|i| i * 100).collect(), 5000));
        assert!(!paused("/few", (0..11).map(|i| 3000 + i * 50).collect(), 3600));
        assert!(!paused("/precious", (0..40).map(|i| i * 100).collect(), 3950));
    }

    #[test]
    fn a_stream_that_must_not_be_lost_any_more_is_resumed_unwatched() {
        let mut bench = Bench::new();
        bench.update(false, 0);
        bench.send("/cloud", (0..100).map(|i| i * 33));
        assert_eq!(bench.update(false, 3300), pause("/cloud"));
        let orders = bench.streams.update(false, bench.at(3400), |_| false);
        assert_eq!(orders, resume("/cloud"));
        bench.streams.retain(|_| false);
        assert_eq!(bench.streams.waits(bench.at(3410)), None);
    }
}
