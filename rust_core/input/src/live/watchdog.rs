//! Comes back to publishers whose connection broke.
//!
//! rosrust connects to a publisher once, when the master names it. When that fails, or the connection breaks later while
//! the publisher lives on, the topic stays silent. So every few seconds the addresses of all publishers of the subscribed
//! topics are asked for and compared with the connections that the process has: a topic with a publisher that answers and
//! has no connection, twice in a row, is unsubscribed and subscribed again. If that does not help, the next try waits
//! twice as long, as each costs the topic's other connections a moment.

use super::topic::Topic;
use super::{lock, sockets, Shared};
use std::collections::{BTreeMap, HashMap};
use std::net::SocketAddr;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

const PERIOD: Duration = Duration::from_secs(2);
const LONGEST_WAIT: Duration = Duration::from_secs(60);

/// Stops the thread.
#[derive(Debug, Default)]
pub(super) struct Watchdog {
    stopped: Mutex<bool>,
    changed: Condvar,
}

impl Watchdog {
    pub(super) fn stop(&self) {
        *lock(&self.stopped) = true;
        self.changed.notify_all();
    }

    fn is_stopped(&self) -> bool {
        *lock(&self.stopped)
    }

    /// Waits; true when stopped.
    fn wait(&self) -> bool {
        let waited = self.changed.wait_timeout_while(lock(&self.stopped), PERIOD, |stopped| !*stopped);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }
}

/// What is known of a topic that was found without a connection.
struct Suspect {
    since: Instant,
    /// When to try again, after a first try.
    next_try: Option<Instant>,
    wait: Duration,
}

/// Runs until the node is shut down.
pub(super) fn run(shared: &Arc<Shared>) {
    let mut suspects: BTreeMap<Arc<str>, Suspect> = BTreeMap::new();
    while !shared.watchdog.wait() {
        let topics: Vec<_> = shared.topics().values().cloned().collect();
        let Some(broken) = broken_topics(shared, &topics) else {
            continue;
        };
        suspects.retain(|name, _| broken.iter().any(|topic| topic.name() == name));
        for topic in broken {
            let now = Instant::now();
            let suspect = suspects.entry(Arc::clone(topic.name())).or_insert(Suspect {
                since: now,
                next_try: None,
                wait: PERIOD * 2,
            });
            let due = suspect.next_try.unwrap_or(suspect.since + PERIOD / 2);
            if now < due || shared.watchdog.is_stopped() {
                continue;
            }
            log::info!("{}: a publisher is not connected, subscribing again", topic.name());
            topic.close();
            if let Err(error) = topic.open() {
                log::warn!("{error}");
            }
            suspect.next_try = Some(Instant::now() + suspect.wait);
            suspect.wait = (suspect.wait * 2).min(LONGEST_WAIT);
        }
    }
    // A topic that was opened while the node shut down.
    for topic in shared.topics().values() {
        topic.close();
    }
}

/// The topics with a publisher that answers but has no connection. None when the master does not answer.
fn broken_topics(shared: &Shared, topics: &[Arc<Topic>]) -> Option<Vec<Arc<Topic>>> {
    // A topic that could not be subscribed to again the last time.
    let mut broken: Vec<_> = topics.iter().filter(|topic| !topic.is_open()).cloned().collect();
    let publishers: HashMap<_, _> = shared.graph.publishers()?.into_iter().collect();
    let mut uris: HashMap<&str, Option<String>> = HashMap::new();
    // Nodes send all their topics from one port, so connections are counted.
    let mut wanted: HashMap<SocketAddr, Vec<&Arc<Topic>>> = HashMap::new();
    for topic in topics {
        for node in publishers.get(&**topic.name()).into_iter().flatten() {
            let uri = uris.entry(node).or_insert_with(|| shared.graph.node_uri(node));
            let Some(addresses) = uri.as_ref().and_then(|uri| shared.graph.topic_addresses(uri, topic.name())) else {
                continue;
            };
            // rosrust connects to every address of the host; one is enough.
            if let Some(address) = addresses.into_iter().find(SocketAddr::is_ipv4) {
                wanted.entry(address).or_default().push(topic);
            }
        }
    }
    let peers = sockets::connected_peers();
    for (address, topics) in wanted {
        let connected = peers.iter().filter(|peer| **peer == address).count();
        if connected < topics.len() {
            broken.extend(topics.into_iter().cloned());
        }
    }
    broken.sort_by(|a, b| a.name().cmp(b.name()));
    broken.dedup_by(|a, b| a.name() == b.name());
    Some(broken)
}
