//! Repairs what rosrust leaves broken. Every two seconds the master and the publishers of the subscribed topics are
//! queried, and their answers are compared with the connections that the process has.
//!
//! - rosrust connects to a publisher once, when the master names it. If that fails, or the connection breaks later
//!   while the publisher lives on, the topic stays silent. So a topic with a publisher that answers and has no
//!   connection, twice in a row, is unsubscribed and subscribed again. If that does not help, the next try waits twice
//!   as long, because each interrupts the topic's other connections.
//! - rosrust asks a publisher for its address and waits without limit, under a lock for all topics, so one stopped
//!   node would freeze this one. The connection of such a call is ended after [`CALL_LIMIT`] without an answer.
//! - A master that was restarted knows nothing of this node: what the node publishes and serves is registered again,
//!   and the topics are subscribed again.

use crate::connections::{self, Connection};
use crate::graph::{Registrations, State};
use crate::node::Shared;
use crate::topic::Topic;
use crate::{lock, NodeEvent};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::net::SocketAddr;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

const PERIOD: Duration = Duration::from_secs(2);
const LONGEST_WAIT: Duration = Duration::from_secs(60);
/// How long another node may take to answer rosrust's `requestTopic`.
const CALL_LIMIT: Duration = Duration::from_millis(1500);

/// Stops the thread.
#[derive(Debug, Default)]
pub(crate) struct Watchdog {
    stopped: Mutex<bool>,
    changed: Condvar,
}

impl Watchdog {
    pub(crate) fn stop(&self) {
        *lock(&self.stopped) = true;
        self.changed.notify_all();
    }

    fn is_stopped(&self) -> bool {
        *lock(&self.stopped)
    }

    /// Waits for the next round; true if stopped.
    fn wait(&self) -> bool {
        let waited = self.changed.wait_timeout_while(lock(&self.stopped), PERIOD, |stopped| !*stopped);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }
}

/// What is known from earlier rounds.
#[derive(Default)]
struct Memory {
    suspects: BTreeMap<Arc<str>, Suspect>,
    /// Connections to other nodes' XML-RPC servers, with when they were first seen.
    calls: HashMap<Connection, Instant>,
    registrations: Registrations,
    /// Where nodes send their topics from by their own answers, by the node's address and the topic.
    addresses: HashMap<(String, Arc<str>), SocketAddr>,
    /// The publishers of each subscribed topic by the master's list.
    sources: HashMap<Arc<str>, HashSet<String>>,
}

/// A topic that was found without a connection.
struct Suspect {
    next_try: Instant,
    wait: Duration,
}

/// Where the publishers of the subscribed topics are.
#[derive(Default)]
struct Publishers<'a> {
    /// Their XML-RPC servers.
    nodes: HashSet<SocketAddr>,
    /// Where they send the topics from. Nodes send all their topics from one port, so there may be several.
    topics: HashMap<SocketAddr, Vec<&'a Arc<Topic>>>,
}

/// Runs until the node is shut down.
pub(crate) fn run(shared: &Arc<Shared>) {
    let mut memory = Memory::default();
    while !shared.watchdog.wait() {
        let topics: Vec<_> = shared.topics().values().cloned().collect();
        let Some(state) = shared.graph.state() else {
            continue;
        };
        shared.graph.keep_registered(&state, &mut memory.registrations);
        shared.update_publications(&state);
        memory.report_lost_publishers(shared, &state, &topics);
        let publishers = memory.publishers(shared, &state, &topics);
        memory.end_unanswered_calls(&publishers.nodes);
        let broken = broken_topics(&state, &topics, &publishers);
        memory.repair(shared, &broken);
    }
}

/// The topics that the master or a publisher that answers is not connected with.
fn broken_topics<'a>(state: &State, topics: &'a [Arc<Topic>], publishers: &Publishers<'a>) -> Vec<&'a Arc<Topic>> {
    let unknown = |topic: &&Arc<Topic>| !topic.is_open() || !state.subscriptions.contains(&**topic.name());
    let mut broken: Vec<_> = topics.iter().filter(unknown).collect();
    let connections = connections::connections();
    for (address, topics) in &publishers.topics {
        if connections.iter().filter(|connection| connection.peer == *address).count() < topics.len() {
            broken.extend(topics.iter().copied());
        }
    }
    broken.retain(|topic| !topic.is_busy());
    broken.sort_by(|a, b| a.name().cmp(b.name()));
    broken.dedup_by(|a, b| a.name() == b.name());
    broken
}

impl Memory {
    /// Who publishes the topics. A node is asked for the address that it sends a topic from only if there is no
    /// connection with the address that it gave before, because every call costs both nodes time.
    fn publishers<'a>(&mut self, shared: &Shared, state: &State, topics: &'a [Arc<Topic>]) -> Publishers<'a> {
        let mut found = Publishers::default();
        let mut uris: HashMap<&str, Option<String>> = HashMap::new();
        let known = self.connected_addresses();
        for topic in topics {
            for node in state.publishers.get(&**topic.name()).into_iter().flatten() {
                let uri = uris.entry(node).or_insert_with(|| shared.graph.node_uri(node));
                let Some(uri) = uri else {
                    continue;
                };
                found.nodes.extend(crate::master::addresses_of(uri));
                let key = (uri.clone(), Arc::clone(topic.name()));
                let ask = || {
                    // rosrust connects to every address of the host; one is enough.
                    let addresses = shared.graph.topic_addresses(uri, topic.name()).unwrap_or_default();
                    addresses.into_iter().find(SocketAddr::is_ipv4)
                };
                if let Some(address) = known.get(&key).copied().or_else(ask) {
                    found.topics.entry(address).or_default().push(topic);
                    self.addresses.insert(key, address);
                }
            }
        }
        found
    }

    /// The known addresses that have as many connections as topics; the others are dropped.
    fn connected_addresses(&mut self) -> HashMap<(String, Arc<str>), SocketAddr> {
        let mut connections: HashMap<SocketAddr, usize> = HashMap::new();
        for connection in connections::connections() {
            *connections.entry(connection.peer).or_default() += 1;
        }
        let mut topics: HashMap<SocketAddr, usize> = HashMap::new();
        for address in self.addresses.values() {
            *topics.entry(*address).or_default() += 1;
        }
        let mut known = std::mem::take(&mut self.addresses);
        known.retain(|_, address| connections.get(address) >= topics.get(address));
        known
    }

    /// Ends the calls to `nodes` that have had no answer for too long.
    fn end_unanswered_calls(&mut self, nodes: &HashSet<SocketAddr>) {
        let now = Instant::now();
        let open: Vec<_> = connections::connections().into_iter().filter(|open| nodes.contains(&open.peer)).collect();
        self.calls.retain(|call, _| open.contains(call));
        for call in open {
            let since = *self.calls.entry(call).or_insert(now);
            if now - since >= CALL_LIMIT {
                log::info!("the node at {} does not answer, going on without it", call.peer);
                connections::end(call);
                self.calls.remove(&call);
            }
        }
    }

    /// Reports publishers that the master listed and lists no more. A master that does not know this node's topics was
    /// restarted, and its list means nothing yet.
    fn report_lost_publishers(&mut self, shared: &Shared, state: &State, topics: &[Arc<Topic>]) {
        self.sources.retain(|name, _| topics.iter().any(|topic| topic.name() == name));
        for topic in topics.iter().filter(|topic| state.subscriptions.contains(&**topic.name())) {
            let now: HashSet<String> = state.publishers.get(&**topic.name()).into_iter().flatten().cloned().collect();
            let before = self.sources.insert(Arc::clone(topic.name()), now.clone());
            if before.is_some_and(|before| !before.is_subset(&now)) {
                shared.events.sender(0).push(NodeEvent::PublisherLeft { topic: Arc::clone(topic.name()) });
            }
        }
    }

    /// Subscribes again to topics that were broken in the last round, too, and whose next try is due.
    fn repair(&mut self, shared: &Arc<Shared>, broken: &[&Arc<Topic>]) {
        let now = Instant::now();
        self.suspects.retain(|name, _| broken.iter().any(|topic| topic.name() == name));
        for topic in broken {
            let suspect = (self.suspects.entry(Arc::clone(topic.name())))
                .or_insert(Suspect { next_try: now + PERIOD / 2, wait: PERIOD * 2 });
            if now < suspect.next_try || shared.watchdog.is_stopped() {
                continue;
            }
            suspect.next_try = now + suspect.wait;
            suspect.wait = (suspect.wait * 2).min(LONGEST_WAIT);
            let topic = Arc::clone(topic);
            // On a thread of its own: it may wait for another node, and only this thread ends such a call.
            let spawned = std::thread::Builder::new().name("ros-resubscribe".to_owned()).spawn(move || {
                log::info!("{}: a connection is missing, subscribing again", topic.name());
                topic.close();
                if let Err(error) = topic.open() {
                    log::warn!("{error}");
                }
            });
            if let Err(error) = spawned {
                log::warn!("cannot subscribe again: {error}");
            }
        }
    }
}
