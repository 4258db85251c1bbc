//! Live topics: a rosrust node, and one queue into which everything that it receives goes.
//!
//! ```text
//!   publishers ──► rosrust's threads (decode) ──► EventQueue ──► the one thread that owns the scene
//! ```
//!
//! rosrust's threads never wait for the scene: each subscriber has room for so many messages in the queue, and the oldest
//! gives way. A topic of queue size 1 is therefore always the latest message, however slow the scene is.
//!
//! Names, namespaces and remappings are rosrust's, which reads the process's arguments and environment as roscpp does.
//! What rosrust lacks is added from outside:
//!
//! - waiting for a master that is not there yet ([`connect`](RosNode::connect));
//! - several subscribers of one topic in a process ([`topic`]);
//! - coming back to publishers whose connection broke, and to a restarted master ([`watchdog`]);
//! - unregistering all of the node, also what rosrust never lets go of ([`shutdown`](RosNode::shutdown)).

mod clock;
mod connections;
pub mod diagnostics_topic;
mod events;
mod graph;
pub mod image_topic;
mod listeners;
mod param_writer;
mod parameters;
mod reconfigure;
mod topic;
mod watchdog;

pub use clock::RosClock;
pub use events::{EventQueue, EventSender, NodeEvent, Reply, TriggerReply};
pub use graph::{Publication, Publications};
pub use listeners::tune_listeners;
pub use reconfigure::ReconfigureServer;
pub use topic::TopicSubscription;

use graph::Graph;
use param_writer::ParamWriter;
use rcs_messages::rosgraph_msgs::Clock;
use rcs_messages::std_srvs::{Trigger, TriggerRes};
use rcs_messages::{AnyMessage, MessageKind, Time};
use std::collections::BTreeMap;
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::sync::mpsc::{channel, RecvTimeoutError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use topic::{Received, Topic};
use watchdog::Watchdog;

/// How many messages of `/tf` wait at most. Robots send some hundred a second.
const TF_QUEUE_SIZE: usize = 1000;
/// How long a caller of a service waits for the scene's thread.
const REPLY_TIMEOUT: Duration = Duration::from_secs(5);
/// How often a node looks for a master that is not there yet.
const WAIT_PERIOD: Duration = Duration::from_millis(300);
/// How much later than asked for rosrust's own threads may wake up.
const WAKE_SLACK: Duration = Duration::from_millis(20);
/// How long the node may take to unregister, before the process ends all the same.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_millis(800);

/// Why the node could not do something.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NodeError {
    /// Waiting for the master was cancelled.
    #[error("gave up waiting for the ROS master at {0}")]
    Cancelled(String),
    /// There is no master.
    #[error("no ROS master at {0}")]
    NoMaster(String),
    /// The master's address is none.
    #[error("'{0}' is not the address of a ROS master")]
    MasterUri(String),
    /// The name is not one that ROS allows.
    #[error("'{0}' is not a valid ROS name")]
    Name(String),
    /// The node subscribes to the topic with another type.
    #[error("{topic} is subscribed to as {subscribed}, not {wanted}")]
    TypeMismatch {
        /// The topic's whole name.
        topic: String,
        /// Its type so far.
        subscribed: &'static str,
        /// The other type.
        wanted: &'static str,
    },
    /// rosrust could not do it.
    #[error("{what}: {reason}")]
    Ros {
        /// What was tried, with the name of the topic or service.
        what: String,
        /// What rosrust says.
        reason: String,
    },
}

impl NodeError {
    fn ros(what: impl Into<String>, error: &rosrust::api::error::Error) -> Self {
        let reasons: Vec<String> = error.iter().map(ToString::to_string).collect();
        Self::Ros { what: what.into(), reason: reasons.join(": ") }
    }
}

/// The process's node, which turns what it receives into [`NodeEvent`]s.
///
/// rosrust has one node in a process; a second `RosNode` is an error.
pub struct RosNode {
    shared: Arc<Shared>,
    services: Mutex<BTreeMap<Arc<str>, rosrust::Service>>,
    param_writer: ParamWriter,
    kept: Mutex<Vec<TopicSubscription>>,
}

/// What the node's threads share.
struct Shared {
    name: String,
    graph: Graph,
    events: Arc<EventQueue>,
    clock: RosClock,
    topics: Mutex<BTreeMap<String, Arc<Topic>>>,
    watchdog: Watchdog,
    publications: Mutex<Option<Arc<Publications>>>,
}

impl Shared {
    fn topics(&self) -> MutexGuard<'_, BTreeMap<String, Arc<Topic>>> {
        self.topics.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn look_at_publications(&self, state: &graph::State) {
        if let Some(publications) = self.graph.publications(state) {
            *lock(&self.publications) = Some(Arc::new(publications));
        }
    }
}

/// The process's arguments without those that are for ROS (`a:=b`), and without the program's name.
pub fn plain_args() -> Vec<String> {
    rosrust::args().into_iter().skip(1).collect()
}

impl RosNode {
    /// Waits for a master, however long that takes, and starts the node.
    ///
    /// `default_name` is the node's name unless `__name:=` gives another. `cancelled` is asked a few times a second
    /// whether to give up. A master that is not there is logged once. With the parameter `/use_sim_time` set, the
    /// node's time is that of `/clock`. Signals stay the caller's.
    pub fn connect(default_name: &str, cancelled: &dyn Fn() -> bool) -> Result<Self, NodeError> {
        let master_uri = rosrust::api::resolve::master();
        wait_for_master(&master_uri, cancelled)?;
        Self::start(&master_uri, default_name)
    }

    /// Starts the node as [`connect`](Self::connect) does, at a master that is there now.
    ///
    /// # Errors
    /// [`NodeError::NoMaster`] when nobody listens at its address.
    pub fn connect_now(default_name: &str) -> Result<Self, NodeError> {
        let master_uri = rosrust::api::resolve::master();
        let address = host_and_port(&master_uri).ok_or_else(|| NodeError::MasterUri(master_uri.clone()))?;
        if !is_listening(&address) {
            return Err(NodeError::NoMaster(master_uri));
        }
        Self::start(&master_uri, default_name)
    }

    fn start(master_uri: &str, default_name: &str) -> Result<Self, NodeError> {
        with_wake_slack(|| rosrust::try_init_with_options(default_name, false))
            .map_err(|error| NodeError::ros(format!("cannot start node {default_name}"), &error))?;
        let simulated = rosrust::param("/use_sim_time").is_some_and(|param| param.get().unwrap_or(false));
        let name = rosrust::name();
        let shared = Arc::new(Shared {
            graph: Graph::new(master_uri, &name, &rosrust::uri()),
            name,
            events: Arc::default(),
            clock: RosClock::new(simulated),
            topics: Mutex::default(),
            watchdog: Watchdog::default(),
            publications: Mutex::default(),
        });
        let node = Self {
            shared: Arc::clone(&shared),
            services: Mutex::default(),
            param_writer: ParamWriter::default(),
            kept: Mutex::default(),
        };
        if simulated {
            node.follow_clock()?;
        }
        let spawned = std::thread::Builder::new().name("ros-watchdog".to_owned()).spawn(move || watchdog::run(&shared));
        if let Err(error) = spawned {
            log::warn!("broken connections will not be repaired: {error}");
        }
        Ok(node)
    }

    /// The node's whole name.
    pub fn name(&self) -> &str {
        &self.shared.name
    }

    /// What was received.
    pub fn events(&self) -> &Arc<EventQueue> {
        &self.shared.events
    }

    /// The present time, the simulation's if there is one.
    pub fn now(&self) -> Time {
        self.shared.clock.now()
    }

    /// Whether the present time is a simulation's.
    pub fn is_simulated(&self) -> bool {
        self.shared.clock.is_simulated()
    }

    /// The whole name of a topic, service or parameter, after remapping: `x` is in the node's namespace, `~x` below its
    /// name.
    pub fn resolve(&self, name: &str) -> Result<String, NodeError> {
        let param = rosrust::param(name).ok_or_else(|| NodeError::Name(name.to_owned()))?;
        Ok(param.name().to_owned())
    }

    /// Subscribes to a topic; its messages come as [`NodeEvent::Message`], at most `queue_size` of them waiting (0: any
    /// number). The node's own messages do not come. A message that cannot be decoded is a warning that names the topic
    /// and the publisher.
    pub fn subscribe(&self, topic: &str, kind: MessageKind, queue_size: usize) -> Result<TopicSubscription, NodeError> {
        let sender = self.shared.events.sender(queue_size);
        let waiting = sender.clone();
        self.subscribe_with(topic, kind, Some(waiting), move |topic, received| {
            sender.push(NodeEvent::Message {
                topic: Arc::clone(topic),
                message: received.message.clone(),
                publisher: Arc::clone(received.publisher),
                received: received.at,
            });
        })
    }

    /// Subscribes to `/tf` and `/tf_static` for as long as the node lives.
    pub fn subscribe_transforms(&self) -> Result<(), NodeError> {
        // A static transform is sent once, so none may be lost.
        for (topic, is_static, queue_size) in [("/tf", false, TF_QUEUE_SIZE), ("/tf_static", true, 0)] {
            let sender = self.shared.events.sender(queue_size);
            let subscription = self.subscribe_with(topic, MessageKind::TFMessage, None, move |_, received| {
                if let AnyMessage::TFMessage(message) = received.message {
                    sender.push(NodeEvent::Transforms {
                        message: Arc::clone(message),
                        is_static,
                        authority: Arc::clone(received.publisher),
                        received: received.at,
                    });
                }
            })?;
            self.keep(subscription);
        }
        Ok(())
    }

    /// Offers a service of type `std_srvs/Trigger` until [`stop_serving`](Self::stop_serving) or the node's end; each
    /// call is a [`NodeEvent::Trigger`] to be answered. Returns the service's whole name.
    pub fn serve_trigger(&self, name: &str) -> Result<Arc<str>, NodeError> {
        let service: Arc<str> = self.resolve(name)?.into();
        let (sender, name_of_handler) = (self.shared.events.sender(0), Arc::clone(&service));
        let server = rosrust::service::<Trigger, _>(name, move |_| {
            let (reply, answer) = TriggerReply::new();
            sender.push(NodeEvent::Trigger { service: Arc::clone(&name_of_handler), reply });
            // Also when the reply was dropped unused, which is no answer either.
            let (success, message) =
                answer.recv_timeout(REPLY_TIMEOUT).map_err(|_| format!("{name_of_handler}: the node is busy"))?;
            Ok(TriggerRes { success, message })
        })
        .map_err(|error| NodeError::ros(format!("cannot offer service {service}"), &error))?;
        lock(&self.services).insert(Arc::clone(&service), server);
        Ok(service)
    }

    /// Takes back a service of this whole name, if there is one.
    pub fn stop_serving(&self, service: &str) {
        // Dropped without the lock: it waits for the master.
        let server = lock(&self.services).remove(service);
        drop(server);
    }

    /// What other nodes published when it was last looked at, which is every other second; `None` before the first look.
    pub fn publications(&self) -> Option<Arc<Publications>> {
        lock(&self.shared.publications).clone()
    }

    /// Asks the master what other nodes publish. `None` when it does not answer within seconds.
    pub fn look_at_publications(&self) -> Option<Arc<Publications>> {
        let state = self.shared.graph.state()?;
        self.shared.look_at_publications(&state);
        self.publications()
    }

    /// The text of a string parameter; none if it is not set or no string.
    pub fn string_param(&self, name: &str) -> Option<String> {
        rosrust::param(name)?.get::<String>().ok()
    }

    /// A parameter that is true or false; none if it is not set or something else.
    pub fn bool_param(&self, name: &str) -> Option<bool> {
        rosrust::param(name)?.get::<bool>().ok()
    }

    /// Whether the node was asked from outside to end (`rosnode kill`, or another node that took its name).
    pub fn is_asked_to_end(&self) -> bool {
        !rosrust::is_ok()
    }

    /// Unregisters everything and closes all connections, within a second even when the master does not answer. The
    /// node cannot be used after that.
    pub fn shutdown(&self) {
        let (done, is_done) = channel();
        let shared = Arc::clone(&self.shared);
        let kept = std::mem::take(&mut *lock(&self.kept));
        let services = std::mem::take(&mut *lock(&self.services));
        self.shared.watchdog.stop();
        let spawned = std::thread::Builder::new().name("ros-shutdown".to_owned()).spawn(move || {
            drop((kept, services));
            for topic in std::mem::take(&mut *shared.topics()).values() {
                topic.close();
            }
            rosrust::shutdown();
            shared.graph.unregister_rest();
            // Nobody waits any more if it took too long.
            let _ = done.send(());
        });
        if spawned.is_err() || is_done.recv_timeout(SHUTDOWN_TIMEOUT).is_err() {
            log::warn!("could not unregister from the ROS master in time");
        }
    }

    fn follow_clock(&self) -> Result<(), NodeError> {
        let (shared, sender) = (Arc::downgrade(&self.shared), self.shared.events.sender(0));
        let subscription = self.subscribe_with("/clock", MessageKind::Clock, None, move |_, received| {
            let (AnyMessage::Clock(tick), Some(shared)) = (received.message, shared.upgrade()) else {
                return;
            };
            let Clock { clock } = **tick;
            if let Some((from, to)) = shared.clock.set(clock) {
                sender.push(NodeEvent::TimeJumpedBack { from, to });
            }
        })?;
        self.keep(subscription);
        Ok(())
    }

    fn subscribe_with(
        &self,
        name: &str,
        kind: MessageKind,
        sender: Option<EventSender>,
        on_message: impl Fn(&Arc<str>, &Received<'_>) + Send + Sync + 'static,
    ) -> Result<TopicSubscription, NodeError> {
        let whole_name = self.resolve(name)?;
        let topic = {
            let mut topics = self.shared.topics();
            let new = || Arc::new(Topic::new(&whole_name, name, kind, &self.shared.name));
            Arc::clone(topics.entry(whole_name.clone()).or_insert_with(new))
        };
        topic.check_kind(kind)?;
        let listener = topic.add_listener(Box::new(on_message));
        topic.open()?;
        Ok(TopicSubscription::new(topic, listener, sender, &self.shared))
    }

    fn keep(&self, subscription: TopicSubscription) {
        lock(&self.kept).push(subscription);
    }
}

/// Calls `start`; the threads that it starts wake up at ease.
///
/// rosrust looks for calls from other nodes every five milliseconds, whether there are any or not, which costs a third of
/// a percent of a core for as long as the node lives. Threads inherit the slack of their timers from the one that starts
/// them, so it is set for that moment. Where the system refuses, all is as it was.
fn with_wake_slack<T>(start: impl FnOnce() -> T) -> T {
    let slack_ns = u64::try_from(WAKE_SLACK.as_nanos()).ok().and_then(std::num::NonZeroU64::new);
    let before = rustix::thread::current_timer_slack().ok().and_then(std::num::NonZeroU64::new);
    let _ = rustix::thread::set_current_timer_slack(slack_ns);
    let started = start();
    let _ = rustix::thread::set_current_timer_slack(before);
    started
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Host and port of a URI such as `http://localhost:11311/`.
fn host_and_port(uri: &str) -> Option<(String, u16)> {
    let rest = uri.strip_prefix("http://")?;
    let rest = rest.split_once('/').map_or(rest, |(authority, _)| authority);
    let (host, port) = rest.rsplit_once(':')?;
    Some((host.trim_matches(['[', ']']).to_owned(), port.parse().ok()?))
}

/// The addresses of a URI.
fn address_of(uri: &str) -> impl Iterator<Item = SocketAddr> {
    let address = host_and_port(uri);
    address.and_then(|(host, port)| (host.as_str(), port).to_socket_addrs().ok()).into_iter().flatten()
}

/// rosrust gives up at once when there is no master, so it is started when somebody listens there.
///
/// Looks on a thread of its own, so that giving up never waits for the network.
fn wait_for_master(uri: &str, cancelled: &dyn Fn() -> bool) -> Result<(), NodeError> {
    let address = host_and_port(uri).ok_or_else(|| NodeError::MasterUri(uri.to_owned()))?;
    let (found, is_found) = channel();
    let uri_of_thread = uri.to_owned();
    std::thread::spawn(move || {
        let mut said = false;
        loop {
            let there = is_listening(&address);
            // Nobody waits any more.
            if found.send(there).is_err() || there {
                return;
            }
            if !said {
                log::warn!("no ROS master at {uri_of_thread} yet, waiting for it");
                said = true;
            }
            std::thread::sleep(WAIT_PERIOD);
        }
    });
    loop {
        match is_found.recv_timeout(Duration::from_millis(50)) {
            Ok(true) => return Ok(()),
            Ok(false) | Err(RecvTimeoutError::Timeout) if !cancelled() => {}
            _ => return Err(NodeError::Cancelled(uri.to_owned())),
        }
    }
}

fn is_listening(address: &(String, u16)) -> bool {
    let Ok(mut addresses) = (address.0.as_str(), address.1).to_socket_addrs() else {
        return false;
    };
    addresses.any(|address| TcpStream::connect_timeout(&address, Duration::from_secs(1)).is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_master_uri_gives_host_and_port() {
        let robot = Some(("robot".to_owned(), 11311));
        assert_eq!(host_and_port("http://robot:11311/"), robot);
        assert_eq!(host_and_port("http://robot:11311"), robot);
        assert_eq!(host_and_port("http://[::1]:5/"), Some(("::1".to_owned(), 5)));
        assert_eq!(host_and_port("robot:11311"), None);
        assert_eq!(host_and_port("http://robot/"), None);
    }

    #[test]
    fn waiting_for_a_master_can_be_cancelled_at_once() {
        let started = std::time::Instant::now();
        // Port 1 of this machine: nobody listens there.
        let result = wait_for_master("http://127.0.0.1:1/", &|| started.elapsed() > Duration::from_millis(100));
        assert_eq!(result, Err(NodeError::Cancelled("http://127.0.0.1:1/".to_owned())));
        assert!(started.elapsed() < Duration::from_secs(1));
    }
}
