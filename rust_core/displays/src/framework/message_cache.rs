//! Cache of the last messages of each topic, for displays that are recreated.
//!
//! A display is recreated when its settings change, while its topics stay subscribed, so that no publisher sends it its
//! latched message again. So the last message of each topic is kept, and of markers, map updates
//! and interactive markers all those that later ones do not replace, within limits. The messages share their memory
//! with the displays that draw them.

use std::cell::OnceCell;
use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::Arc;

use rcs_messages::visualization_msgs::{InteractiveMarkerUpdate, Marker, MarkerArray};
use rcs_messages::{AnyMessage, MessageKind};
use rcs_transforms::Time;

use crate::TopicRequest;

#[derive(Debug, Default)]
pub(crate) struct MessageCache {
    topics: HashMap<(String, MessageKind), VecDeque<CacheEntry>>,
    parameters: HashMap<String, Option<Arc<str>>>,
    next: u64,
}

#[derive(Clone, Debug)]
struct CacheEntry {
    /// Counts all messages, so that those of several topics keep their order.
    number: u64,
    message: AnyMessage,
    received: Time,
}

/// Largest number of cached messages of a topic, those that a later one replaces not counted.
fn most_kept(kind: MessageKind) -> usize {
    match kind {
        MessageKind::Marker | MessageKind::OccupancyGridUpdate => 1000,
        MessageKind::MarkerArray => 100,
        // A missing one makes the others useless.
        MessageKind::InteractiveMarkerUpdate => 10_000,
        _ => 1,
    }
}

impl MessageCache {
    /// Adds a message of a topic, by its name in the config.
    pub(crate) fn keep(&mut self, topic: &str, message: &AnyMessage, received: Time) {
        self.forget_replaced(topic, message);
        let kept = self.topics.entry((topic.to_owned(), message.kind())).or_default();
        if kept.len() >= most_kept(message.kind()) {
            kept.pop_front();
        }
        kept.push_back(CacheEntry { number: self.next, message: message.clone(), received });
        self.next += 1;
    }

    /// Removes the messages that this one replaces.
    fn forget_replaced(&mut self, topic: &str, message: &AnyMessage) {
        match message {
            AnyMessage::Marker(new) => self.retain(topic, message.kind(), |old| match old {
                AnyMessage::Marker(old) => !deletes_all(new) && key(old) != key(new),
                _ => true,
            }),
            AnyMessage::MarkerArray(new) => {
                let clears = new.markers.iter().any(deletes_all);
                let keys: OnceCell<HashSet<_>> = OnceCell::new();
                let keys = || keys.get_or_init(|| new.markers.iter().map(key).collect());
                self.retain(topic, message.kind(), |old| match old {
                    AnyMessage::MarkerArray(old) if clears || begins_with(new, old) => false,
                    AnyMessage::MarkerArray(old) => old.markers.iter().any(|marker| !keys().contains(&key(marker))),
                    _ => true,
                });
            }
            AnyMessage::OccupancyGrid(_) => {
                self.topics.remove(&(format!("{topic}_updates"), MessageKind::OccupancyGridUpdate));
            }
            AnyMessage::InteractiveMarkerInit(init) => {
                let older = |update: &InteractiveMarkerUpdate| {
                    update.server_id == init.server_id && update.seq_num <= init.seq_num
                };
                for kept in self.topics.values_mut() {
                    kept.retain(|kept| match &kept.message {
                        AnyMessage::InteractiveMarkerUpdate(update) => !older(update),
                        _ => true,
                    });
                }
            }
            _ => {}
        }
    }

    fn retain(&mut self, topic: &str, kind: MessageKind, stays: impl Fn(&AnyMessage) -> bool) {
        if let Some(kept) = self.topics.get_mut(&(topic.to_owned(), kind)) {
            kept.retain(|kept| stays(&kept.message));
        }
    }

    /// Messages of these topics, each with its topic, in the order of arrival and without expired markers.
    pub(crate) fn messages<'a>(&self, requests: &'a [TopicRequest], now: Time) -> Vec<(&'a str, AnyMessage)> {
        let of = |request: &'a TopicRequest| {
            let kept = self.topics.get(&(request.topic.clone(), request.kind));
            kept.into_iter().flatten().map(|kept| (request.topic.as_str(), kept))
        };
        let mut kept: Vec<(&str, &CacheEntry)> = requests.iter().flat_map(of).collect();
        kept.sort_by_key(|(_, kept)| kept.number);
        let alive = |(topic, kept): (&'a str, &CacheEntry)| {
            Some((topic, still_alive(&kept.message, now.secs_since(kept.received))?))
        };
        kept.into_iter().filter_map(alive).collect()
    }

    /// Stores the text of a parameter; `None` while it is unset.
    pub(crate) fn keep_parameter(&mut self, name: &str, text: Option<&Arc<str>>) {
        self.parameters.insert(name.to_owned(), text.cloned());
    }

    /// Text of a parameter. The outer `None` is for one that no display reads.
    pub(crate) fn parameter(&self, name: &str) -> Option<Option<&Arc<str>>> {
        self.parameters.get(name).map(Option::as_ref)
    }

    /// Removes all other topics and parameters.
    pub(crate) fn limit_to(&mut self, is_taken: impl Fn(&str, MessageKind) -> bool, parameters: &[String]) {
        self.topics.retain(|(topic, kind), _| is_taken(topic, *kind));
        self.parameters.retain(|name, _| parameters.contains(name));
    }

    /// Removes all messages; parameters stay.
    pub(crate) fn forget_messages(&mut self) {
        self.topics.clear();
    }
}

/// `true` if the first markers of an array have the ids of another array's, in order: mostly the same ones are sent
/// again.
fn begins_with(array: &MarkerArray, other: &MarkerArray) -> bool {
    let mut pairs = array.markers.iter().zip(&other.markers);
    array.markers.len() >= other.markers.len() && pairs.all(|(a, b)| key(a) == key(b))
}

fn key(marker: &Marker) -> (i32, &str) {
    (marker.id, &marker.ns)
}

fn deletes_all(marker: &Marker) -> bool {
    marker.action == i32::from(Marker::DELETEALL)
}

/// The message without the markers that are expired at `age_secs`; `None` if that is all of them.
fn still_alive(message: &AnyMessage, age_secs: f64) -> Option<AnyMessage> {
    let lives = |marker: &Marker| {
        let lifetime_secs = f64::from(marker.lifetime.sec) + f64::from(marker.lifetime.nsec) * 1e-9;
        lifetime_secs <= 0.0 || age_secs < lifetime_secs
    };
    match message {
        AnyMessage::Marker(marker) => lives(marker).then(|| message.clone()),
        AnyMessage::MarkerArray(array) if !array.markers.iter().all(lives) => {
            let markers: Vec<Marker> = array.markers.iter().filter(|marker| lives(marker)).cloned().collect();
            (!markers.is_empty()).then(|| AnyMessage::MarkerArray(Arc::new(MarkerArray { markers })))
        }
        _ => Some(message.clone()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rcs_messages::nav_msgs::Path;

    fn at(secs: f64) -> Time {
        Time::from_secs_f64(secs)
    }

    fn marker(ns: &str, id: i32, action: u8) -> Marker {
        Marker { ns: ns.to_owned(), id, action: action.into(), ..Marker::default() }
    }

    fn array(markers: &[(&str, i32)]) -> AnyMessage {
        let markers = markers.iter().map(|(ns, id)| marker(ns, *id, Marker::ADD)).collect();
        AnyMessage::MarkerArray(Arc::new(MarkerArray { markers }))
    }

    fn request(topic: &str, kind: MessageKind) -> TopicRequest {
        TopicRequest { topic: topic.to_owned(), kind, queue_size: 1 }
    }

    /// Number of cached messages of a topic.
    fn count(cache: &MessageCache, topic: &str, kind: MessageKind, now: Time) -> usize {
        cache.messages(&[request(topic, kind)], now).len()
    }

    #[test]
    fn of_most_topics_the_last_message_counts() {
        let mut cache = MessageCache::default();
        for seq in 0..3 {
            let mut path = Path::default();
            path.header.seq = seq;
            cache.keep("/p", &AnyMessage::Path(Arc::new(path)), at(1.0));
        }
        let requests = [request("/p", MessageKind::Path)];
        let messages = cache.messages(&requests, at(2.0));
        let [("/p", AnyMessage::Path(path))] = &messages[..] else { panic!("{messages:?}") };
        assert_eq!(path.header.seq, 2);
        cache.limit_to(|topic, _| topic == "/other", &[]);
        assert_eq!(count(&cache, "/p", MessageKind::Path, at(2.0)), 0);
    }

    #[test]
    fn of_markers_all_count_that_are_not_replaced() {
        let mut cache = MessageCache::default();
        let mut keep = |marker: Marker| cache.keep("/m", &AnyMessage::Marker(Arc::new(marker)), at(1.0));
        keep(marker("a", 1, Marker::ADD));
        keep(marker("a", 2, Marker::ADD));
        keep(marker("a", 1, Marker::DELETE));
        let mut short = marker("b", 1, Marker::ADD);
        short.lifetime.sec = 2;
        keep(short);
        assert_eq!(count(&cache, "/m", MessageKind::Marker, at(2.0)), 3);
        assert_eq!(count(&cache, "/m", MessageKind::Marker, at(4.0)), 2, "one has lived its time");
        cache.keep("/m", &AnyMessage::Marker(Arc::new(marker("", 0, Marker::DELETEALL))), at(5.0));
        assert_eq!(count(&cache, "/m", MessageKind::Marker, at(5.0)), 1);
    }

    #[test]
    fn an_array_replaces_those_whose_markers_it_has() {
        let mut cache = MessageCache::default();
        cache.keep("/m", &array(&[("a", 1), ("a", 2)]), at(1.0));
        cache.keep("/m", &array(&[("a", 1)]), at(1.0));
        assert_eq!(count(&cache, "/m", MessageKind::MarkerArray, at(1.0)), 2);
        cache.keep("/m", &array(&[("a", 2), ("a", 1), ("b", 1)]), at(1.0));
        assert_eq!(count(&cache, "/m", MessageKind::MarkerArray, at(1.0)), 1);
        for id in 0..500 {
            cache.keep("/m", &array(&[("many", id)]), at(1.0));
        }
        assert_eq!(count(&cache, "/m", MessageKind::MarkerArray, at(1.0)), 100, "within limits");
    }

    #[test]
    fn a_map_comes_with_its_updates_and_in_their_order() {
        let mut cache = MessageCache::default();
        let update = || AnyMessage::OccupancyGridUpdate(Arc::default());
        let grid = || AnyMessage::OccupancyGrid(Arc::default());
        cache.keep("/map", &grid(), at(1.0));
        cache.keep("/map_updates", &update(), at(1.0));
        cache.keep("/map", &grid(), at(2.0));
        cache.keep("/map_updates", &update(), at(3.0));
        cache.keep("/map_updates", &update(), at(4.0));
        let requests =
            [request("/map_updates", MessageKind::OccupancyGridUpdate), request("/map", MessageKind::OccupancyGrid)];
        let messages = cache.messages(&requests, at(5.0));
        let kinds: Vec<MessageKind> = messages.iter().map(|(_, message)| message.kind()).collect();
        let updated = MessageKind::OccupancyGridUpdate;
        assert_eq!(kinds, [MessageKind::OccupancyGrid, updated, updated]);
    }
}
