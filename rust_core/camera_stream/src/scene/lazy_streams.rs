//! Lazy streams: topics that are not received while nobody watches.
//!
//! A cloud thirty times a second costs a sixth of a core just to be received, also while no image is drawn of it. So
//! while no camera is watched, a topic is paused if it comes at least once a second, no publisher latches it, and each
//! message replaces all that earlier ones made; its displays keep the last message. With the first subscriber of an
//! image all are resumed, and that image waits a little for a fresh message of each.
//!
//! Only names and times are tracked here; connections and displays are up to `Subscriptions`.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_messages::MessageKind;

/// A topic by its whole name and type.
pub(crate) type StreamKey = (Arc<str>, MessageKind);

/// Time without a viewer before streams are paused, so that one that is started again finds everything running. Also
/// the time for which a topic has to come before: a change that is sent once must not be missed.
const PATIENCE: Duration = Duration::from_secs(2);
/// Longest time between two messages of a stream.
const LONGEST_GAP: Duration = Duration::from_secs(1);
/// Longest time that an image waits for fresh messages.
const LONGEST_WAIT: Duration = Duration::from_millis(500);

/// The streams of all topics.
#[derive(Debug, Default)]
pub(crate) struct LazyStreams {
    streams: HashMap<StreamKey, Stream>,
    unwatched_since: Option<Instant>,
    awaited_until: Option<Instant>,
}

#[derive(Debug)]
struct Stream {
    /// Arrivals of the first and last message since the last gap.
    begun: Instant,
    last: Instant,
    state: StreamState,
}

/// Reception of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StreamState {
    /// It is received.
    Received,
    /// It is not received, because nobody watches.
    Paused,
    /// It is received again, but no message has come since.
    Resumed,
}

/// Streams to be paused and resumed.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct StreamChanges {
    pub(crate) pause: Vec<StreamKey>,
    pub(crate) resume: Vec<StreamKey>,
}

impl Stream {
    fn is_running(&self, now: Instant) -> bool {
        self.last.saturating_duration_since(self.begun) >= PATIENCE
            && now.saturating_duration_since(self.last) <= LONGEST_GAP
    }
}

impl LazyStreams {
    /// Records a message.
    pub(crate) fn note_message(&mut self, key: &StreamKey, received: Instant) {
        let new = || Stream { begun: received, last: received, state: StreamState::Received };
        let stream = self.streams.entry(key.clone()).or_insert_with(new);
        if received.saturating_duration_since(stream.last) > LONGEST_GAP {
            stream.begun = received;
        }
        stream.last = received;
        if stream.state == StreamState::Resumed {
            stream.state = StreamState::Received;
        }
    }

    /// Decides which streams are paused and resumed. `may_pause`: pausing the stream loses nothing.
    pub(crate) fn update(
        &mut self,
        is_watched: bool,
        now: Instant,
        may_pause: impl Fn(&StreamKey) -> bool,
    ) -> StreamChanges {
        let mut changes = StreamChanges::default();
        let unwatched_since = self.unwatched_since.unwrap_or(now);
        self.unwatched_since = (!is_watched).then_some(unwatched_since);
        let is_time = !is_watched && now.saturating_duration_since(unwatched_since) >= PATIENCE;
        for (key, stream) in &mut self.streams {
            match stream.state {
                StreamState::Paused if is_watched || !may_pause(key) => {
                    stream.state = StreamState::Resumed;
                    self.awaited_until = Some(now + LONGEST_WAIT);
                    changes.resume.push(key.clone());
                }
                StreamState::Received if is_time && stream.is_running(now) && may_pause(key) => {
                    stream.state = StreamState::Paused;
                    changes.pause.push(key.clone());
                }
                _ => {}
            }
        }
        changes
    }

    /// Forgets topics that are not subscribed to any more.
    pub(crate) fn retain(&mut self, is_subscribed: impl Fn(&StreamKey) -> bool) {
        self.streams.retain(|key, _| is_subscribed(key));
    }

    /// State of a topic; one that never came is received.
    pub(crate) fn state(&self, key: &StreamKey) -> StreamState {
        self.streams.get(key).map_or(StreamState::Received, |stream| stream.state)
    }

    /// Longest time that frames wait for messages of resumed streams; `None` if they need not wait.
    pub(crate) fn awaited_for(&self, now: Instant) -> Option<Duration> {
        let left = self.awaited_until?.saturating_duration_since(now);
        let is_awaited = self.streams.values().any(|stream| stream.state == StreamState::Resumed);
        (is_awaited && !left.is_zero()).then_some(left)
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
        fn send(&mut self, name: &str, times: impl IntoIterator<Item = u64>) {
            times.into_iter().for_each(|millis| self.streams.note_message(&key(name), self.at(millis)));
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
        bench.send("/cloud", (0..70).map(|i| i * 33));
        for (is_watched, millis) in [(true, 2300), (false, 2310), (true, 2320), (false, 2330)] {
            assert_eq!(bench.update(is_watched, millis), StreamChanges::default());
        }
        bench.send("/cloud", (70..131).map(|i| i * 33));
        assert_eq!(bench.update(false, 4320), StreamChanges::default(), "somebody watched meanwhile");
        assert_eq!(bench.update(false, 4330), pause("/cloud"));
        let states = ["/cloud", "/other"].map(|name| bench.streams.state(&key(name)));
        assert_eq!(states, [StreamState::Paused, StreamState::Received]);
        bench.send("/cloud", [4340]);
        assert_eq!(bench.update(false, 7000), StreamChanges::default(), "paused, also after a straggler");
        assert_eq!(bench.streams.awaited_for(bench.at(7000)), None);
        assert_eq!(bench.update(true, 9000), resume("/cloud"));
        assert_eq!(bench.streams.state(&key("/cloud")), StreamState::Resumed);
        assert_eq!(bench.streams.awaited_for(bench.at(9010)), Some(Duration::from_millis(490)));
        bench.send("/cloud", [9040]);
        assert_eq!(bench.streams.state(&key("/cloud")), StreamState::Received);
        assert_eq!(bench.streams.awaited_for(bench.at(9041)), None);
    }

    #[test]
    fn an_image_waits_for_all_streams_and_not_for_ever() {
        let mut bench = Bench::new();
        bench.update(false, 0);
        ["/a", "/b"].into_iter().for_each(|name| bench.send(name, (0..100).map(|i| i * 33)));
        assert_eq!(bench.update(false, 3300).pause.len(), 2);
        assert_eq!(bench.update(true, 4000).resume.len(), 2);
        bench.send("/a", [4010]);
        assert!(bench.streams.awaited_for(bench.at(4499)).is_some());
        assert_eq!(bench.streams.awaited_for(bench.at(4500)), None);
        assert_eq!(bench.streams.state(&key("/b")), StreamState::Resumed, "what it shows is old");
    }

    #[test]
    fn what_is_rare_or_new_or_has_ended_or_must_not_be_lost_is_received() {
        let is_paused = |name: &str, times: Vec<u64>, at: u64| {
            let mut bench = Bench::new();
            bench.update(false, 0);
            bench.send(name, times);
            !bench.update(false, at).pause.is_empty()
        };
        assert!(is_paused("/stream", (0..40).map(|i| i * 100).collect(), 3950));
        assert!(is_paused("/slow stream", (0..20).map(|i| i * 1000).collect(), 19_500));
        assert!(!is_paused("/rare", (0..20).map(|i| i * 1100).collect(), 20_950));
        assert!(!is_paused("/once", vec![3000], 3001));
        assert!(!is_paused("/burst", (0..40).map(|i| 3000 + i * 50).collect(), 4960));
        assert!(!is_paused("/ended", (0..40).map(|i| i * 100).collect(), 5000));
        assert!(!is_paused("/precious", (0..40).map(|i| i * 100).collect(), 3950));
    }

    #[test]
    fn a_stream_that_must_not_be_lost_any_more_is_resumed_unwatched() {
        let mut bench = Bench::new();
        bench.update(false, 0);
        bench.send("/cloud", (0..100).map(|i| i * 33));
        assert_eq!(bench.update(false, 3300), pause("/cloud"));
        let changes = bench.streams.update(false, bench.at(3400), |_| false);
        assert_eq!(changes, resume("/cloud"));
        bench.streams.retain(|_| false);
        assert_eq!(bench.streams.awaited_for(bench.at(3410)), None);
    }
}
