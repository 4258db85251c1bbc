//! Lazy streams: topics that are not received while nobody watches, and how long frames wait for them afterwards.
//!
//! A cloud thirty times a second costs a sixth of a core just to be received, also while no image is drawn of it. So
//! while no camera is watched, a stream is paused if it is periodic, no publisher latches it, and each message replaces
//! all that earlier ones made. With the first subscriber of an image all are resumed, and that image waits a little for
//! a fresh message of each.
//!
//! Only names and times are tracked here; connections and displays are up to `Subscriptions`.

use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_messages::MessageKind;

/// A topic by its whole name and type.
pub(crate) type StreamKey = (Arc<str>, MessageKind);

/// Time without a viewer before streams are paused, so that one that is started again finds everything running.
const PATIENCE: Duration = Duration::from_secs(2);
/// Messages before a topic counts as periodic.
const MESSAGES: usize = 12;
/// Longest interval of a periodic topic: waiting for the next message of a rarer one would take long.
const LONGEST_INTERVAL: Duration = Duration::from_secs(1);
/// Upper bound of the longest interval, in medians.
const MOST_UNEVEN: u32 = 4;
/// Time for the connection, which a frame waits beside the stream's longest interval.
const CONNECTION_TIME: Duration = Duration::from_millis(500);

/// The streams of all topics.
#[derive(Debug, Default)]
pub(crate) struct LazyStreams {
    streams: HashMap<StreamKey, Stream>,
    unwatched_since: Option<Instant>,
    /// Resumed streams without a message since.
    awaited: HashSet<StreamKey>,
    awaited_until: Option<Instant>,
}

#[derive(Debug, Default)]
struct Stream {
    /// Arrivals of the last messages, the newest last.
    arrivals: VecDeque<Instant>,
    /// The longest interval when it was paused; `None` while it is received.
    paused: Option<Duration>,
}

/// Streams to be paused and resumed.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct StreamChanges {
    pub(crate) pause: Vec<StreamKey>,
    pub(crate) resume: Vec<StreamKey>,
}

impl Stream {
    /// The longest interval between the last messages, if the topic is periodic and still published.
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
    pub(crate) fn note_message(&mut self, key: &StreamKey, received: Instant) {
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

    /// Decides which streams are paused and resumed. `may_pause`: pausing the stream loses nothing.
    pub(crate) fn update(
        &mut self,
        is_watched: bool,
        now: Instant,
        may_pause: impl Fn(&StreamKey) -> bool,
    ) -> StreamChanges {
        let mut orders = StreamChanges::default();
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

    /// Forgets topics that are not subscribed to any more.
    pub(crate) fn retain(&mut self, is_subscribed: impl Fn(&StreamKey) -> bool) {
        self.streams.retain(|key, _| is_subscribed(key));
        self.awaited.retain(is_subscribed);
    }

    /// `true` if a topic is paused, by its whole name.
    pub(crate) fn is_paused(&self, topic: &str) -> bool {
        self.streams.iter().any(|((name, _), stream)| &**name == topic && stream.paused.is_some())
    }

    /// Longest time that frames wait for messages of resumed streams; `None` if they need not wait.
    pub(crate) fn awaited_for(&mut self, now: Instant) -> Option<Duration> {
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

    fn key(name: &str) -> StreamKey {
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

        fn update(&mut self, is_watched: bool, millis: u64) -> StreamChanges {
            self.streams.update(is_watched, self.at(millis), |(name, _)| !name.contains("precious"))
        }
    }

    fn pause(name: &str) -> StreamChanges {
        StreamChanges { pause: vec![key(name)], ..StreamChanges::default() }
    }

    fn resume(name: &str) -> StreamChanges {
        StreamChanges { resume: vec![key(name)], ..StreamChanges::default() }
    }

    #[test]
    fn a_stream_is_paused_a_while_after_the_last_viewer_left_and_resumed_with_the_next() {
        let mut bench = Bench::new();
        bench.send("/cloud", (0..60).map(|i| i * 33));
        assert_eq!(bench.update(true, 1950), StreamChanges::default());
        assert_eq!(bench.update(false, 2000), StreamChanges::default());
        bench.send("/cloud", (60..120).map(|i| i * 33));
        assert_eq!(bench.update(false, 3900), StreamChanges::default());
        assert_eq!(bench.update(true, 3950), StreamChanges::default(), "somebody watches again");
        assert_eq!(bench.update(false, 3960), StreamChanges::default());
        bench.send("/cloud", (120..200).map(|i| i * 33));
        assert_eq!(bench.update(false, 6500), pause("/cloud"));
        assert!(bench.streams.is_paused("/cloud") && !bench.streams.is_paused("/other"));
        assert_eq!(bench.update(false, 7000), StreamChanges::default());
        assert_eq!(bench.update(true, 9000), resume("/cloud"));
        let left = bench.streams.awaited_for(bench.at(9010));
        assert_eq!(left, Some(CONNECTION_TIME + Duration::from_millis(33 - 10)));
        bench.send("/cloud", std::iter::once(9040));
        assert_eq!(bench.streams.awaited_for(bench.at(9041)), None);
    }

    #[test]
    fn a_picture_does_not_wait_for_ever() {
        let mut bench = Bench::new();
        bench.update(false, 0);
        bench.send("/cloud", (0..100).map(|i| i * 33));
        assert_eq!(bench.update(false, 3300), pause("/cloud"));
        assert_eq!(bench.update(true, 4000), resume("/cloud"));
        assert!(bench.streams.awaited_for(bench.at(4500)).is_some());
        assert_eq!(bench.streams.awaited_for(bench.at(4600)), None);
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
        assert_eq!(bench.streams.awaited_for(bench.at(3410)), None);
    }
}
