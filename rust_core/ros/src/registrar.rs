//! What the node has registered with the master, and the thread that keeps it so.
//!
//! Publishing, subscribing and serving only note what is wanted, so that whoever asks for it never waits for the
//! master. One thread brings the master's list in line: it registers what is missing and unregisters what is wanted no
//! more, at once where the master answers, and again every second where it does not.
//!
//! The master may forget the node, and the node may miss what the master tells. Once a second it asks for this node's
//! own address: a master that does not know it was restarted, whatever its process id, and is told everything again.
//! Every other second it asks for the whole list, and registers again what is not on it.

mod batches;
mod comparison;
mod entry;

pub(crate) use entry::Entry;

use std::collections::{BTreeMap, BTreeSet};
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, Weak};
use std::time::{Duration, Instant};

use self::comparison::Compared;
use crate::contacts::{list_of, Contacts, Unreachable};
use crate::graph::{strings, Master, Publications, SystemState};
use crate::tcpros::{Link, Subscription};
use crate::xmlrpc::CallError;
use rcs_scene::{lock, wait_timeout};

/// How often the master is asked whether it still knows the node, and how often one that is silent is tried.
const CHECK_PERIOD: Duration = Duration::from_secs(1);
/// How often the master is asked who publishes what.
const GRAPH_PERIOD: Duration = Duration::from_secs(2);

/// With so many publishers of a topic the node is connected: a message of a stranger may name any number.
const MOST_PUBLISHERS: usize = 256;

/// Called when a publisher of a subscribed topic has left, with the topic.
type OnPublisherLeft = Box<dyn Fn(&str) + Send + Sync>;

/// The node's registrations.
pub(crate) struct Registrar {
    master: Master,
    state: Mutex<State>,
    changed: Condvar,
    /// One list of publishers is handed on at a time.
    updating: Mutex<()>,
    publications: Mutex<Option<Arc<Publications>>>,
    contacts: Contacts,
    on_publisher_left: OnPublisherLeft,
    /// Set when the node is to end because another has its name.
    is_asked_to_end: Arc<AtomicBool>,
}

#[derive(Default)]
struct State {
    wanted: BTreeSet<Entry>,
    registered: BTreeSet<Entry>,
    /// What the master does not want; not tried again.
    refused: BTreeSet<Entry>,
    subscriptions: BTreeMap<String, (u64, Weak<Subscription>)>,
    /// The publishers of each subscribed topic, by the addresses of their nodes.
    publishers: BTreeMap<String, Vec<String>>,
    /// Those that the master named when the topic was registered.
    registered_publishers: BTreeMap<String, Vec<String>>,
    /// The publishers that a master named which was then restarted, until the new one names others.
    named_before_restart: BTreeMap<String, Vec<String>>,
    /// What has led to registering a topic again.
    compared: BTreeMap<String, Compared>,
    /// Topics with more publishers than [`MOST_PUBLISHERS`].
    crowded: BTreeSet<String>,
    /// The master does not take several calls at once.
    has_no_batches: bool,
    /// How often the master has named the publishers of some topic.
    updates: u64,
    /// When the master answered last.
    answered: Option<Instant>,
    is_ended: bool,
    /// [`Registrar::run`] has returned.
    is_done: bool,
}

/// What is to be done next.
enum Step {
    Unregister(Entry),
    Register(Entry),
}

impl State {
    /// Unregistering goes first: a topic may be wanted with another type, and what took the place of another of its
    /// name is to be registered after that was unregistered.
    fn next_step(&self) -> Option<Step> {
        if let Some(surplus) = self.registered.difference(&self.wanted).next() {
            return Some(Step::Unregister(surplus.clone()));
        }
        let mut missing = self.wanted.difference(&self.registered).filter(|entry| !self.refused.contains(entry));
        missing.next().map(|entry| Step::Register(entry.clone()))
    }
}

impl Registrar {
    /// Nothing is registered yet. [`run`](Self::run) is to be called on a thread of its own.
    pub(crate) fn new(
        master: Master,
        is_asked_to_end: Arc<AtomicBool>,
        on_publisher_left: impl Fn(&str) + Send + Sync + 'static,
    ) -> Arc<Self> {
        Arc::new(Self {
            master,
            state: Mutex::default(),
            changed: Condvar::new(),
            updating: Mutex::default(),
            publications: Mutex::default(),
            contacts: Contacts::default(),
            on_publisher_left: Box::new(on_publisher_left),
            is_asked_to_end,
        })
    }

    /// The master.
    pub(crate) fn master(&self) -> &Master {
        &self.master
    }

    /// Registers something, soon.
    pub(crate) fn add(&self, entry: Entry) {
        let mut state = lock(&self.state);
        if !state.is_ended {
            state.wanted.insert(entry);
        }
        drop(state);
        self.changed.notify_all();
    }

    /// Unregisters something, soon.
    pub(crate) fn remove(&self, entry: &Entry) {
        let mut state = lock(&self.state);
        state.wanted.remove(entry);
        state.refused.remove(entry);
        if let Entry::Subscriber { topic, number, .. } = entry {
            if state.subscriptions.get(topic).is_some_and(|(current, _)| current == number) {
                state.subscriptions.remove(topic);
                state.publishers.remove(topic);
                state.registered_publishers.remove(topic);
                state.compared.remove(topic);
                state.crowded.remove(topic);
            }
        }
        drop(state);
        self.changed.notify_all();
    }

    /// Registers a subscription, which is told its publishers for as long as it lives.
    pub(crate) fn subscribe(&self, subscription: &Arc<Subscription>) {
        let wanted = subscription.wanted();
        let topic = wanted.topic.to_string();
        lock(&self.state).subscriptions.insert(topic, (wanted.number, Arc::downgrade(subscription)));
        self.add(subscriber_entry(subscription));
    }

    /// Unregisters a subscription.
    pub(crate) fn unsubscribe(&self, subscription: &Arc<Subscription>) {
        self.remove(&subscriber_entry(subscription));
    }

    /// The master's word on who publishes a topic: the addresses of their nodes.
    pub(crate) fn set_publishers(&self, topic: &str, uris: Vec<String>) {
        let _updating = lock(&self.updating);
        let mut state = lock(&self.state);
        state.updates += 1;
        state.compared.remove(topic);
        state.named_before_restart.remove(topic);
        drop(state);
        self.hand_on(topic, uris);
    }

    /// Passes a list of publishers on to the subscription. To be called with `updating` locked.
    fn hand_on(&self, topic: &str, uris: Vec<String>) {
        let named = uris.len();
        let uris = self.bounded(topic, uris);
        let (subscription, has_left) = {
            let mut state = lock(&self.state);
            let known = state.subscriptions.get(topic).and_then(|(_, subscription)| subscription.upgrade());
            let Some(subscription) = known else { return };
            if named <= MOST_PUBLISHERS {
                state.crowded.remove(topic);
            } else if state.crowded.insert(topic.to_owned()) {
                log::warn!("{topic}: {named} publishers are named, connecting with {MOST_PUBLISHERS} at most");
            }
            let before = state.publishers.insert(topic.to_owned(), uris.clone()).unwrap_or_default();
            self.contacts.retain(|uri| state.publishers.values().flatten().any(|named| named == uri));
            (subscription, before.iter().any(|uri| !uris.contains(uri)))
        };
        subscription.set_publishers(&uris);
        if has_left {
            (self.on_publisher_left)(topic);
        }
    }

    /// A publisher's node does not answer: logged once for each node, in roscpp's words and with its name. Waits for
    /// the master, to be called on the publisher's own thread.
    pub(crate) fn contact_failed(&self, topic: &str, uri: &str, reason: &str) {
        if !self.contacts.fail(uri, reason) {
            return;
        }
        let is_it =
            |name: &String| self.master.call("lookupNode", &[name]).is_ok_and(|found| found.as_str() == Some(uri));
        let publications = self.query_publications().unwrap_or_default();
        let nodes = publications.get(topic).map(|publication| publication.nodes.as_slice()).unwrap_or_default();
        let node = match nodes.iter().find(|name| is_it(name)) {
            Some(name) => {
                self.contacts.set_name(uri, name);
                format!("[{name}] at {uri}")
            }
            None => format!("[{uri}]"),
        };
        let named = lock(&self.state).publishers.clone();
        let topics = named.into_iter().filter(|(_, uris)| uris.iter().any(|known| known == uri));
        let topics: Vec<String> = topics.map(|(topic, _)| topic).collect();
        if !topics.is_empty() {
            log::warn!("Failed to contact publisher {node} for {}: {reason}", list_of(&topics));
        }
    }

    /// A publisher's node has answered.
    pub(crate) fn contacted(&self, uri: &str) {
        self.contacts.succeed(uri);
    }

    /// The publishers of a topic whose nodes do not answer.
    pub(crate) fn unreachable(&self, topic: &str) -> Vec<Unreachable> {
        let uris = lock(&self.state).publishers.get(topic).cloned().unwrap_or_default();
        self.contacts.among(&uris)
    }

    /// The publishers of a list with which the node is to be connected. Connections that stand go first.
    fn bounded(&self, topic: &str, mut uris: Vec<String>) -> Vec<String> {
        let mut known = BTreeSet::new();
        // A node that publishes what it subscribes to does not listen to itself.
        uris.retain(|uri| *uri != self.master.node_uri && known.insert(uri.clone()));
        if uris.len() > MOST_PUBLISHERS {
            let standing = self.links(topic).into_iter().filter(|link| link.connected().is_some());
            let connected: BTreeSet<String> = standing.map(|link| link.uri.clone()).collect();
            uris.sort_by_key(|uri| !connected.contains(uri));
            uris.truncate(MOST_PUBLISHERS);
        }
        uris
    }

    /// The subscriptions there are.
    pub(crate) fn subscriptions(&self) -> Vec<Arc<Subscription>> {
        lock(&self.state).subscriptions.values().filter_map(|(_, subscription)| subscription.upgrade()).collect()
    }

    /// What other nodes published when the master was last asked.
    pub(crate) fn publications(&self) -> Option<Arc<Publications>> {
        lock(&self.publications).clone()
    }

    /// Asks the master what other nodes publish.
    pub(crate) fn query_publications(&self) -> Option<Arc<Publications>> {
        self.query().map(|_| self.publications())?
    }

    fn query(&self) -> Option<SystemState> {
        match self.master.system_state() {
            Ok(mut state) => {
                *lock(&self.publications) = Some(Arc::new(std::mem::take(&mut state.publications)));
                Some(state)
            }
            Err(error) => {
                log::debug!("the ROS master's state is not known: {error}");
                None
            }
        }
    }

    /// Whether [`end`](Self::end) was called.
    pub(crate) fn is_ended(&self) -> bool {
        lock(&self.state).is_ended
    }

    /// Unregisters everything, for as long as the master answers, and ends [`run`](Self::run), for which it waits:
    /// until the master has been silent for `patience`, and no longer than `limit` in all.
    pub(crate) fn end(&self, patience: Duration, limit: Duration) {
        let begin = Instant::now();
        let mut state = lock(&self.state);
        state.is_ended = true;
        state.wanted.clear();
        self.changed.notify_all();
        while !state.is_done {
            let heard = state.answered.unwrap_or(begin).max(begin);
            let left = (heard + patience).min(begin + limit).saturating_duration_since(Instant::now());
            if left.is_zero() {
                log::warn!("could not unregister from the ROS master in time");
                return;
            }
            state = wait_timeout(&self.changed, state, left);
        }
    }

    /// Keeps the master's list in line until [`end`](Self::end). After a panic, which is logged where panics are, it
    /// goes on.
    pub(crate) fn run(&self) {
        while catch_unwind(AssertUnwindSafe(|| self.keep_in_line())).is_err() && !self.is_ended() {
            self.wait(Instant::now() + CHECK_PERIOD, true);
        }
        lock(&self.state).is_done = true;
        self.changed.notify_all();
    }

    fn keep_in_line(&self) {
        let (mut next_check, mut next_graph) = (Instant::now() + CHECK_PERIOD, Instant::now());
        let mut is_silent = false;
        loop {
            let now = Instant::now();
            let mut answers = true;
            // First, because one that was restarted is to be told everything, not only what is new.
            if is_silent || now >= next_check {
                self.subscriptions().iter().for_each(|subscription| subscription.connect_missing());
                answers = self.check_known();
                next_check = now + CHECK_PERIOD;
            }
            answers = answers && self.synchronise().is_ok();
            if answers && now >= next_graph {
                self.repair();
                next_graph = now + GRAPH_PERIOD;
            }
            if answers == is_silent {
                is_silent = !answers;
                if is_silent {
                    log::warn!("the ROS master at {} does not answer, going on without it", self.master.uri);
                } else {
                    log::info!("the ROS master at {} answers again", self.master.uri);
                }
            }
            let until = if is_silent { Instant::now() + CHECK_PERIOD } else { next_check.min(next_graph) };
            if self.wait(until, is_silent) {
                break;
            }
        }
        // Nothing is wanted any more.
        if let Err(error) = self.synchronise() {
            log::debug!("not everything could be unregistered: {error}");
        }
    }

    /// Waits for something to do, unless the master is silent, or until a time; true at the end.
    fn wait(&self, until: Instant, is_silent: bool) -> bool {
        let mut state = lock(&self.state);
        loop {
            if state.is_ended {
                return true;
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() || (!is_silent && state.next_step().is_some()) {
                return false;
            }
            state = wait_timeout(&self.changed, state, left);
        }
    }

    /// Registers what is missing and unregisters what is wanted no more.
    ///
    /// # Errors
    /// That of the first call that the master did not answer. What it refuses is logged and not tried again.
    fn synchronise(&self) -> Result<(), CallError> {
        loop {
            self.unregister_together()?;
            let Some(step) = lock(&self.state).next_step() else { return Ok(()) };
            let result = match &step {
                Step::Unregister(entry) => self.unregister(entry),
                Step::Register(entry) => self.register(entry),
            };
            let is_refused = match result {
                Ok(()) => false,
                Err(error) if error.is_answer() => {
                    let (Step::Unregister(entry) | Step::Register(entry)) = &step;
                    log::error!("the ROS master refused {entry:?}: {error}");
                    true
                }
                Err(error) => return Err(error),
            };
            let mut state = lock(&self.state);
            state.answered = Some(Instant::now());
            match step {
                Step::Unregister(entry) => state.registered.retain(|other| !other.shares_place(&entry)),
                Step::Register(entry) if is_refused => drop(state.refused.insert(entry)),
                Step::Register(entry) => drop(state.registered.insert(entry)),
            }
            drop(state);
            self.changed.notify_all();
        }
    }

    fn register(&self, entry: &Entry) -> Result<(), CallError> {
        let own = self.master.node_uri.as_str();
        match entry {
            Entry::Publisher { topic, ros_type, .. } => {
                self.master.call("registerPublisher", &[topic, ros_type, own]).map(drop)
            }
            Entry::Subscriber { topic, ros_type, .. } => {
                let (named, _updating) = loop {
                    let before = lock(&self.state).updates;
                    let answer = self.master.call("registerSubscriber", &[topic, ros_type, own])?;
                    let updating = lock(&self.updating);
                    if lock(&self.state).updates == before {
                        break (strings(&answer), updating);
                    }
                    // The master has named publishers since it answered, perhaps of this topic: asked again.
                };
                // A master that was restarted knows nobody yet; connections that stand or are being made are kept.
                let before = lock(&self.state).named_before_restart.get(topic).cloned().unwrap_or_default();
                let is_kept = |link: &Arc<Link>| {
                    link.connected().is_some() || (link.is_promising() && before.contains(&link.uri))
                };
                let kept = self.links(topic).into_iter().filter(is_kept);
                let mut publishers = named.clone();
                publishers.extend(kept.map(|link| link.uri.clone()));
                publishers.sort();
                publishers.dedup();
                self.hand_on(topic, publishers);
                lock(&self.state).registered_publishers.insert(topic.clone(), self.bounded(topic, named));
                Ok(())
            }
            Entry::Service { service, api, .. } => self.master.call("registerService", &[service, api, own]).map(drop),
        }
    }

    /// The connections with publishers of a topic that there are or should be.
    fn links(&self, topic: &str) -> Vec<Arc<Link>> {
        let known = lock(&self.state).subscriptions.get(topic).and_then(|(_, subscription)| subscription.upgrade());
        known.map(|subscription| subscription.links()).unwrap_or_default()
    }

    fn unregister(&self, entry: &Entry) -> Result<(), CallError> {
        let (method, params) = self.unregistration(entry);
        self.master.call(method, &params).map(drop)
    }

    /// The call that takes a registration back, with its parameters behind the node's name.
    fn unregistration<'a>(&'a self, entry: &'a Entry) -> (&'static str, [&'a str; 2]) {
        let own = self.master.node_uri.as_str();
        match entry {
            Entry::Publisher { topic, .. } => ("unregisterPublisher", [topic, own]),
            Entry::Subscriber { topic, .. } => ("unregisterSubscriber", [topic, own]),
            Entry::Service { service, api, .. } => ("unregisterService", [service, api]),
        }
    }

    /// Asks the master whether it knows the node; one that does not was restarted. False if it does not answer.
    fn check_known(&self) -> bool {
        let answer = self.master.call("lookupNode", &[&self.master.node_name]);
        let mut state = lock(&self.state);
        match answer {
            Ok(uri) => {
                if uri.as_str().is_some_and(|uri| uri != self.master.node_uri) && !state.registered.is_empty() {
                    // The master asks the older one to end, but only once, which it may have missed.
                    log::warn!("another node has the name {}, ending", self.master.node_name);
                    self.is_asked_to_end.store(true, Ordering::Release);
                }
            }
            Err(error) if error.is_answer() => {
                if !state.registered.is_empty() {
                    log::warn!("the ROS master was restarted, registering again");
                    state.named_before_restart = state.publishers.clone();
                    state.registered.clear();
                    state.refused.clear();
                }
            }
            Err(_) => return false,
        }
        state.answered = Some(Instant::now());
        true
    }
}

/// The registration of a subscription.
fn subscriber_entry(subscription: &Subscription) -> Entry {
    let wanted = subscription.wanted();
    Entry::Subscriber { topic: wanted.topic.to_string(), ros_type: wanted.ros_type.clone(), number: wanted.number }
}

#[cfg(test)]
mod tests;
