//! What the node has registered with the master, and the thread that keeps it so.
//!
//! Publishing, subscribing and serving only note what is wanted, so that whoever asks for it never waits for the
//! master. One thread brings the master's list in line: it registers what is missing and unregisters what is wanted no
//! more, at once where the master answers, and again every second where it does not. Once a second it asks the master
//! for this node's own address: a master that does not know it was restarted, whatever its process id, and is told
//! everything again.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Condvar, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

use crate::graph::{strings, Master, Publications};
use crate::lock;
use crate::tcpros::Subscription;
use crate::xmlrpc::CallError;

/// How often the master is asked whether it still knows the node.
const CHECK_PERIOD: Duration = Duration::from_secs(1);
/// How often the master is asked who publishes what.
const GRAPH_PERIOD: Duration = Duration::from_secs(2);
/// How long a call that is under way and those that unregister may take at the end.
const END_TIMEOUT: Duration = Duration::from_secs(3);

/// A registration: what the master is told.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Entry {
    /// The node publishes a topic of a type.
    Publisher { topic: String, ros_type: String },
    /// The node subscribes to a topic of a type.
    Subscriber { topic: String, ros_type: String },
    /// The node serves at an address `rosrpc://host:port`.
    Service { service: String, api: String },
}

/// Called when a publisher of a subscribed topic has left, with the topic.
type OnPublisherLeft = Box<dyn Fn(&str) + Send + Sync>;

/// The node's registrations.
pub(crate) struct Registrar {
    master: Master,
    state: Mutex<State>,
    changed: Condvar,
    publications: Mutex<Option<Arc<Publications>>>,
    on_publisher_left: OnPublisherLeft,
}

#[derive(Default)]
struct State {
    wanted: BTreeSet<Entry>,
    registered: BTreeSet<Entry>,
    subscriptions: BTreeMap<String, Weak<Subscription>>,
    /// The publishers of each subscribed topic, by the addresses of their nodes.
    publishers: BTreeMap<String, Vec<String>>,
    is_ended: bool,
    /// [`Registrar::run`] has returned.
    is_done: bool,
}

impl Registrar {
    /// Nothing is registered yet. [`run`](Self::run) is to be called on a thread of its own.
    pub(crate) fn new(master: Master, on_publisher_left: impl Fn(&str) + Send + Sync + 'static) -> Arc<Self> {
        Arc::new(Self {
            master,
            state: Mutex::default(),
            changed: Condvar::new(),
            publications: Mutex::default(),
            on_publisher_left: Box::new(on_publisher_left),
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
        if let Entry::Subscriber { topic, .. } = entry {
            state.subscriptions.remove(topic);
            state.publishers.remove(topic);
        }
        drop(state);
        self.changed.notify_all();
    }

    /// Registers a subscription, which is told its publishers for as long as it lives.
    pub(crate) fn subscribe(&self, subscription: &Arc<Subscription>) {
        let wanted = subscription.wanted();
        let (topic, ros_type) = (wanted.topic.to_string(), wanted.ros_type.clone());
        lock(&self.state).subscriptions.insert(topic.clone(), Arc::downgrade(subscription));
        self.add(Entry::Subscriber { topic, ros_type });
    }

    /// Unregisters a subscription, unless another one of the topic has taken its place.
    pub(crate) fn unsubscribe(&self, subscription: &Arc<Subscription>) {
        let wanted = subscription.wanted();
        let is_current = (lock(&self.state).subscriptions.get(&*wanted.topic))
            .is_some_and(|current| std::ptr::eq(current.as_ptr(), Arc::as_ptr(subscription)));
        if is_current {
            let (topic, ros_type) = (wanted.topic.to_string(), wanted.ros_type.clone());
            self.remove(&Entry::Subscriber { topic, ros_type });
        }
    }

    /// The master's word on who publishes a topic: the addresses of their nodes.
    pub(crate) fn set_publishers(&self, topic: &str, mut uris: Vec<String>) {
        // A node that publishes what it subscribes to does not listen to itself.
        uris.retain(|uri| *uri != self.master.node_uri);
        let (subscription, has_left) = {
            let mut state = lock(&self.state);
            let Some(subscription) = state.subscriptions.get(topic).and_then(Weak::upgrade) else { return };
            let before = state.publishers.insert(topic.to_owned(), uris.clone()).unwrap_or_default();
            (subscription, before.iter().any(|uri| !uris.contains(uri)))
        };
        subscription.set_publishers(&uris);
        if has_left {
            (self.on_publisher_left)(topic);
        }
    }

    /// The subscriptions there are.
    pub(crate) fn subscriptions(&self) -> Vec<Arc<Subscription>> {
        lock(&self.state).subscriptions.values().filter_map(Weak::upgrade).collect()
    }

    /// What other nodes published when the master was last asked.
    pub(crate) fn publications(&self) -> Option<Arc<Publications>> {
        lock(&self.publications).clone()
    }

    /// Asks the master what other nodes publish.
    pub(crate) fn query_publications(&self) -> Option<Arc<Publications>> {
        match self.master.publications() {
            Ok(publications) => {
                *lock(&self.publications) = Some(Arc::new(publications));
                self.publications()
            }
            Err(error) => {
                log::debug!("the ROS master's state is not known: {error}");
                None
            }
        }
    }

    /// Unregisters everything, for as long as the master answers, and ends [`run`](Self::run), for which it waits.
    pub(crate) fn end(&self) {
        let mut state = lock(&self.state);
        state.is_ended = true;
        state.wanted.clear();
        self.changed.notify_all();
        let ended = self.changed.wait_timeout_while(state, END_TIMEOUT, |state| !state.is_done);
        drop(ended.unwrap_or_else(PoisonError::into_inner));
    }

    /// Keeps the master's list in line until [`end`](Self::end).
    pub(crate) fn run(&self) {
        let (mut next_check, mut next_graph) = (Instant::now() + CHECK_PERIOD, Instant::now());
        let mut is_silent = false;
        loop {
            let result = self.synchronise();
            let now = Instant::now();
            let mut answers = result.is_ok();
            if answers && now >= next_check {
                answers = self.check_known();
                next_check = now + CHECK_PERIOD;
            }
            if answers && now >= next_graph {
                answers = self.query_publications().is_some();
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
            if self.wait(next_check.min(next_graph).max(now + Duration::from_millis(50)), is_silent) {
                break;
            }
        }
        // Nothing is wanted any more.
        if let Err(error) = self.synchronise() {
            log::debug!("not everything could be unregistered: {error}");
        }
        lock(&self.state).is_done = true;
        self.changed.notify_all();
    }

    /// Waits for a change, unless the master is silent, or until a time; true at the end.
    fn wait(&self, until: Instant, is_silent: bool) -> bool {
        let mut state = lock(&self.state);
        loop {
            if state.is_ended {
                return true;
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() || (!is_silent && state.wanted != state.registered) {
                return false;
            }
            state = self.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Registers what is missing and unregisters what is wanted no more.
    ///
    /// # Errors
    /// That of the first call that the master did not answer. What it refuses is logged and not tried again.
    fn synchronise(&self) -> Result<(), CallError> {
        loop {
            let (missing, surplus) = {
                let state = lock(&self.state);
                let missing = state.wanted.difference(&state.registered).next().cloned();
                (missing, state.registered.difference(&state.wanted).next().cloned())
            };
            // First, because a topic may be wanted with another type.
            if let Some(entry) = surplus {
                self.tolerate(&entry, self.unregister(&entry))?;
                lock(&self.state).registered.remove(&entry);
            } else if let Some(entry) = missing {
                self.tolerate(&entry, self.register(&entry))?;
                lock(&self.state).registered.insert(entry);
            } else {
                return Ok(());
            }
        }
    }

    fn tolerate(&self, entry: &Entry, result: Result<(), CallError>) -> Result<(), CallError> {
        match result {
            Err(error) if error.is_answer() => {
                log::error!("the ROS master refused {entry:?}: {error}");
                Ok(())
            }
            other => other,
        }
    }

    fn register(&self, entry: &Entry) -> Result<(), CallError> {
        let own = self.master.node_uri.as_str();
        match entry {
            Entry::Publisher { topic, ros_type } => {
                self.master.call("registerPublisher", &[topic, ros_type, own]).map(drop)
            }
            Entry::Subscriber { topic, ros_type } => {
                let publishers = self.master.call("registerSubscriber", &[topic, ros_type, own])?;
                self.set_publishers(topic, strings(&publishers));
                Ok(())
            }
            Entry::Service { service, api } => self.master.call("registerService", &[service, api, own]).map(drop),
        }
    }

    fn unregister(&self, entry: &Entry) -> Result<(), CallError> {
        let own = self.master.node_uri.as_str();
        let (method, name, api) = match entry {
            Entry::Publisher { topic, .. } => ("unregisterPublisher", topic, own),
            Entry::Subscriber { topic, .. } => ("unregisterSubscriber", topic, own),
            Entry::Service { service, api } => ("unregisterService", service, api.as_str()),
        };
        self.master.call(method, &[name, api]).map(drop)
    }

    /// Asks the master whether it knows the node; one that does not was restarted. False if it does not answer.
    fn check_known(&self) -> bool {
        let has_registered = !lock(&self.state).registered.is_empty();
        match self.master.call("lookupNode", &[&self.master.node_name]) {
            // Another address is that of a newer node of the same name, which the master has told this one to end for.
            Ok(_) => true,
            Err(error) if error.is_answer() => {
                if has_registered {
                    log::warn!("the ROS master was restarted, registering again");
                    lock(&self.state).registered.clear();
                }
                true
            }
            Err(_) => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::xmlrpc::{parse_call, Answer, Server, Value};
    use std::sync::mpsc::{channel, Receiver};

    /// A master that notes its calls, and may forget everything.
    struct TestMaster {
        _server: Server,
        calls: Receiver<String>,
        known: Arc<Mutex<bool>>,
        registrar: Arc<Registrar>,
    }

    fn start() -> TestMaster {
        let (sender, calls) = channel();
        let (sender, known) = (Mutex::new(sender), Arc::new(Mutex::new(false)));
        let is_known = Arc::clone(&known);
        let server = Server::start("master", "127.0.0.1:0".parse().unwrap(), move |text| {
            let (method, params) = parse_call(text).unwrap();
            let answer = |value| Answer::Value(Value::Array(vec![Value::Int(1), "".into(), value]));
            match method.as_str() {
                "lookupNode" if !*lock(&is_known) => {
                    Answer::Value(Value::Array(vec![Value::Int(-1), "unknown node".into(), "".into()]))
                }
                "lookupNode" | "getSystemState" | "getTopicTypes" => answer(Value::Array(Vec::new())),
                _ => {
                    *lock(&is_known) = true;
                    let line = format!("{method} {}", params[1].as_str().unwrap());
                    lock(&sender).send(line).unwrap();
                    answer(Value::Array(Vec::new()))
                }
            }
        })
        .unwrap();
        let master = Master {
            uri: format!("http://{}/", server.address()),
            node_name: "/node".to_owned(),
            node_uri: "http://127.0.0.1:1/".to_owned(),
        };
        let registrar = Registrar::new(master, |_| {});
        let running = Arc::clone(&registrar);
        std::thread::spawn(move || running.run());
        TestMaster { _server: server, calls, known, registrar }
    }

    fn next(master: &TestMaster) -> String {
        master.calls.recv_timeout(Duration::from_secs(5)).unwrap()
    }

    #[test]
    fn what_is_wanted_is_registered_and_again_with_a_master_that_forgot_it() {
        let master = start();
        let entry = Entry::Publisher { topic: "/image".to_owned(), ros_type: "sensor_msgs/Image".to_owned() };
        master.registrar.add(entry.clone());
        assert_eq!(next(&master), "registerPublisher /image");
        *lock(&master.known) = false;
        let begin = Instant::now();
        assert_eq!(next(&master), "registerPublisher /image");
        assert!(begin.elapsed() < Duration::from_secs(2));
        master.registrar.remove(&entry);
        assert_eq!(next(&master), "unregisterPublisher /image");
        master.registrar.add(Entry::Service { service: "/s".to_owned(), api: "rosrpc://x:1".to_owned() });
        assert_eq!(next(&master), "registerService /s");
        master.registrar.end();
        assert_eq!(next(&master), "unregisterService /s");
    }
}
