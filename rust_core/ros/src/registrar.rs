//! The node's registrations with the master, and the thread that maintains them.
//!
//! Publishing, subscribing and serving only note what is wanted, so that no caller waits for the master. One thread
//! registers and unregisters, at once if the master answers, and again every second if it does not.
//!
//! Before that, and once a second, the thread looks up this node's own address: a master that does not know it was
//! restarted and is told everything again. A subscription is registered again, which returns its publishers, when one
//! of them cannot be connected with, and when the master was silent: what it named meanwhile was lost.

mod batches;
mod entry;
mod state;

pub(crate) use entry::Entry;

use std::collections::BTreeSet;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

use self::state::{RegistrarState, RegistrarStep, SubscribedTopic, MOST_PUBLISHERS};
use crate::contacts::{list_of, Contacts, Unreachable};
use crate::master::{strings, Master, Publications};
use crate::tcpros::{Link, Subscription};
use crate::xmlrpc::CallError;
use rcs_process::{lock, wait_timeout};

/// How often the node is looked up at the master, and how often a silent master is tried.
const CHECK_PERIOD: Duration = Duration::from_secs(1);
/// How often other nodes' publications are read.
const GRAPH_PERIOD: Duration = Duration::from_secs(2);

/// Called with a subscribed topic that a publisher has left.
type OnPublisherLeft = Box<dyn Fn(&str) + Send + Sync>;

/// The node's registrations.
pub(crate) struct Registrar {
    master: Master,
    state: Mutex<RegistrarState>,
    changed: Condvar,
    /// Held while a list of publishers is applied, so that none overtakes another.
    updating: Mutex<()>,
    /// The master's last list, and when it was asked for.
    publications: Mutex<Option<(Instant, Arc<Publications>)>>,
    contacts: Contacts,
    on_publisher_left: OnPublisherLeft,
    /// Restarts of the master so far.
    restarts: AtomicU64,
    /// Set when another node has taken the name.
    is_asked_to_end: Arc<AtomicBool>,
}

impl Registrar {
    /// Without registrations. [`run`](Self::run) is to be called on a thread of its own.
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
            restarts: AtomicU64::new(0),
            is_asked_to_end,
        })
    }

    pub(crate) fn master(&self) -> &Master {
        &self.master
    }

    /// Restarts of the master that were noticed.
    pub(crate) fn restarts(&self) -> u64 {
        self.restarts.load(Ordering::Acquire)
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
        state.again.remove(entry);
        if let Entry::Subscriber { topic, number, .. } = entry {
            if state.topics.get(topic).is_some_and(|current| current.number == *number) {
                state.topics.remove(topic);
            }
        }
        drop(state);
        self.changed.notify_all();
    }

    /// Registers a subscription and tells it its publishers for as long as it lives.
    pub(crate) fn subscribe(&self, subscription: &Arc<Subscription>) {
        let wanted = subscription.wanted();
        let topic = SubscribedTopic::new(wanted.number, subscription);
        lock(&self.state).topics.insert(wanted.topic.to_string(), topic);
        self.add(subscriber_entry(subscription));
    }

    /// Unregisters a subscription.
    pub(crate) fn unsubscribe(&self, subscription: &Arc<Subscription>) {
        self.remove(&subscriber_entry(subscription));
    }

    /// Registers a subscription again, soon: a publisher of the topic cannot be connected with, so the master may have
    /// named others.
    pub(crate) fn subscribe_again(&self, topic: &str) {
        let mut state = lock(&self.state);
        if let Some(subscription) = state.subscription(topic) {
            log::debug!("registering again: {topic}");
            state.again.insert(subscriber_entry(&subscription));
        }
        drop(state);
        self.changed.notify_all();
    }

    /// Takes the master's list of a topic's publishers, as addresses of their nodes.
    pub(crate) fn set_publishers(&self, topic: &str, uris: Vec<String>) {
        let _updating = lock(&self.updating);
        lock(&self.state).updates += 1;
        self.apply_publishers(topic, uris);
    }

    /// Passes a list of publishers to the subscription. To be called with `updating` locked.
    fn apply_publishers(&self, topic: &str, uris: Vec<String>) {
        let named = uris.len();
        let uris = self.bounded(topic, uris);
        let (subscription, has_left) = {
            let mut state = lock(&self.state);
            let Some(known) = state.topics.get_mut(topic) else { return };
            let Some(subscription) = known.subscription.upgrade() else { return };
            if named > MOST_PUBLISHERS && !known.has_too_many {
                log::warn!("{topic}: {named} publishers are named, connecting with {MOST_PUBLISHERS} at most");
            }
            known.has_too_many = named > MOST_PUBLISHERS;
            let before = std::mem::replace(&mut known.publishers, uris.clone());
            self.contacts
                .retain(|uri| state.topics.values().flat_map(|topic| &topic.publishers).any(|named| named == uri));
            (subscription, before.iter().any(|uri| !uris.contains(uri)))
        };
        subscription.set_publishers(&uris);
        if has_left {
            (self.on_publisher_left)(topic);
        }
    }

    /// Notes that a publisher's node does not answer, and logs it once for each node, in roscpp's words. Waits for the
    /// master, so it is to be called on the publisher's own thread.
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
        let state = lock(&self.state);
        let named = state.topics.iter().filter(|(_, topic)| topic.publishers.iter().any(|known| known == uri));
        let topics: Vec<String> = named.map(|(topic, _)| topic.clone()).collect();
        drop(state);
        if !topics.is_empty() {
            log::warn!("Failed to contact publisher {node} for {}: {reason}", list_of(&topics));
        }
    }

    /// Notes that a publisher's node has answered.
    pub(crate) fn contacted(&self, uri: &str) {
        self.contacts.succeed(uri);
    }

    /// Publishers of a topic whose nodes do not answer.
    pub(crate) fn unreachable(&self, topic: &str) -> Vec<Unreachable> {
        let uris = lock(&self.state).publishers(topic);
        self.contacts.among(&uris)
    }

    /// The publishers of a list to connect with, present connections first.
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

    /// All subscriptions.
    pub(crate) fn subscriptions(&self) -> Vec<Arc<Subscription>> {
        lock(&self.state).topics.values().filter_map(|topic| topic.subscription.upgrade()).collect()
    }

    /// Other nodes' publications on the master's last list, and when that was asked for.
    pub(crate) fn publications(&self) -> Option<(Instant, Arc<Publications>)> {
        lock(&self.publications).clone()
    }

    /// Reads other nodes' publications from the master.
    pub(crate) fn query_publications(&self) -> Option<Arc<Publications>> {
        let asked = Instant::now();
        match self.master.publications() {
            Ok(publications) => {
                let publications = Arc::new(publications);
                *lock(&self.publications) = Some((asked, Arc::clone(&publications)));
                Some(publications)
            }
            Err(error) => {
                log::debug!("cannot read the ROS master's list: {error}");
                None
            }
        }
    }

    /// `true` once [`end`](Self::end) was called.
    pub(crate) fn is_ended(&self) -> bool {
        lock(&self.state).is_ended
    }

    /// Unregisters everything and waits for the end of [`run`](Self::run), until the master has been silent for
    /// `patience` or `limit` is over.
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

    /// Maintains the registrations until [`end`](Self::end), also after a panic, which the panic hook logs.
    pub(crate) fn run(&self) {
        while catch_unwind(AssertUnwindSafe(|| self.maintain())).is_err() && !self.is_ended() {
            self.wait(Instant::now() + CHECK_PERIOD, true);
        }
        lock(&self.state).is_done = true;
        self.changed.notify_all();
    }

    fn maintain(&self) {
        let mut next_graph = Instant::now();
        let mut is_silent = false;
        loop {
            let subscriptions = self.subscriptions();
            subscriptions.iter().for_each(|subscription| subscription.connect_missing());
            // First, because a master that was restarted is to be told everything, not only what is new.
            let is_heard = self.check_known();
            if is_heard && is_silent {
                subscriptions.iter().for_each(|subscription| self.subscribe_again(&subscription.wanted().topic));
            }
            let answers = is_heard && self.synchronise().is_ok();
            if answers && Instant::now() >= next_graph {
                self.query_publications();
                next_graph = Instant::now() + GRAPH_PERIOD;
            }
            if answers == is_silent {
                is_silent = !answers;
                if is_silent {
                    log::warn!("the ROS master at {} does not answer, going on without it", self.master.uri);
                } else {
                    log::info!("the ROS master at {} answers again", self.master.uri);
                }
            }
            if self.wait(Instant::now() + CHECK_PERIOD, is_silent) {
                break;
            }
        }
        // Nothing is wanted any more.
        if let Err(error) = self.synchronise() {
            log::debug!("not everything could be unregistered: {error}");
        }
    }

    /// Waits until a time, or for a step if the master is not silent. Returns `true` at the end.
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

    /// Registers and unregisters until the master's list is as wanted. Refusals are logged and not tried again.
    ///
    /// # Errors
    /// The first call that the master does not answer.
    fn synchronise(&self) -> Result<(), CallError> {
        loop {
            self.unregister_together()?;
            let Some(step) = lock(&self.state).take_step() else { return Ok(()) };
            let result = match &step {
                RegistrarStep::Unregister(entry) => self.unregister(entry),
                RegistrarStep::Register(entry) => self.register(entry),
            };
            let is_refused = match result {
                Ok(()) => false,
                Err(error) if error.is_answer() => {
                    let (RegistrarStep::Unregister(entry) | RegistrarStep::Register(entry)) = &step;
                    log::error!("the ROS master refused {entry:?}: {error}");
                    true
                }
                Err(error) => return Err(error),
            };
            let mut state = lock(&self.state);
            state.answered = Some(Instant::now());
            match step {
                RegistrarStep::Unregister(entry) => state.registered.retain(|other| !other.shares_place(&entry)),
                RegistrarStep::Register(entry) if is_refused => drop(state.refused.insert(entry)),
                RegistrarStep::Register(entry) => drop(state.registered.insert(entry)),
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
            Entry::Subscriber { topic, ros_type, .. } => self.register_subscriber(topic, ros_type),
            Entry::Service { service, api, .. } => self.master.call("registerService", &[service, api, own]).map(drop),
        }
    }

    fn register_subscriber(&self, topic: &str, ros_type: &str) -> Result<(), CallError> {
        let (named, _updating) = loop {
            let before = lock(&self.state).updates;
            let answer = self.master.call("registerSubscriber", &[topic, ros_type, &self.master.node_uri])?;
            let updating = lock(&self.updating);
            if lock(&self.state).updates == before {
                break (strings(&answer), updating);
            }
            // The master has named publishers since it answered, perhaps of this topic: asked again.
        };
        // A master that was restarted knows nobody yet; connections that stand or are being made are kept.
        let kept = self.links(topic).into_iter().filter(|link| link.connected().is_some() || link.is_promising());
        let publishers = named.into_iter().chain(kept.map(|link| link.uri.clone())).collect();
        self.apply_publishers(topic, publishers);
        Ok(())
    }

    /// Connections with publishers of a topic, made or attempted.
    fn links(&self, topic: &str) -> Vec<Arc<Link>> {
        let subscription = lock(&self.state).subscription(topic);
        subscription.map(|subscription| subscription.links()).unwrap_or_default()
    }

    fn unregister(&self, entry: &Entry) -> Result<(), CallError> {
        let (method, params) = self.unregistration(entry);
        self.master.call(method, &params).map(drop)
    }

    /// The call that unregisters an entry, with its parameters after the node's name.
    fn unregistration<'a>(&'a self, entry: &'a Entry) -> (&'static str, [&'a str; 2]) {
        let own = self.master.node_uri.as_str();
        match entry {
            Entry::Publisher { topic, .. } => ("unregisterPublisher", [topic, own]),
            Entry::Subscriber { topic, .. } => ("unregisterSubscriber", [topic, own]),
            Entry::Service { service, api, .. } => ("unregisterService", [service, api]),
        }
    }

    /// Looks the node up at the master; one that does not know it was restarted. Returns `false` if it does not answer.
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
                    self.restarts.fetch_add(1, Ordering::AcqRel);
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
