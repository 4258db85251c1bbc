//! The process's node: connecting, subscribing, services, parameters, shutting down.
//!
//! What rosrust lacks is added from outside: several subscriptions of one topic ([`crate::topic`]), coming back to
//! publishers whose connection broke and to a restarted master ([`crate::watchdog`]), and unregistering all of the
//! node, also what rosrust never lets go of ([`RosNode::shutdown`]).

use crate::clock::RosClock;
use crate::events::{EventQueue, EventSender, NodeEvent, TriggerReply};
use crate::graph::{self, Graph, Publications};
use crate::lock;
use crate::master::{check_master, wait_for_master};
use crate::param_writer::ParamWriter;
use crate::topic::{Received, Topic, TopicSubscription};
use crate::watchdog::{self, Watchdog};
use rcs_messages::rosgraph_msgs::Clock;
use rcs_messages::std_srvs::{Trigger, TriggerRes};
use rcs_messages::{AnyMessage, MessageKind, Time};
use std::collections::BTreeMap;
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

/// Queue size of `/tf`. Robots send some hundred messages a second.
const TF_QUEUE_SIZE: usize = 1000;
/// How long a caller of a service waits for the scene's thread.
pub(crate) const REPLY_TIMEOUT: Duration = Duration::from_secs(5);
/// By how much rosrust's own threads may wake up late.
const WAKE_SLACK: Duration = Duration::from_millis(20);
/// How long the node may take to unregister before the process ends without that.
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
    /// The address of the master cannot be parsed.
    #[error("'{0}' is not the address of a ROS master")]
    MasterUri(String),
    /// The name is not one that ROS allows.
    #[error("'{0}' is not a valid ROS name")]
    Name(String),
    /// The node subscribes to the topic with another type already.
    #[error("{topic} is subscribed to as {subscribed}, not {wanted}")]
    TypeMismatch {
        /// The topic's whole name.
        topic: String,
        /// Its type so far.
        subscribed: &'static str,
        /// The other type.
        wanted: &'static str,
    },
    /// rosrust reports an error.
    #[error("{what}: {reason}")]
    Ros {
        /// What was tried, with the name of the topic or service.
        what: String,
        /// rosrust's error.
        reason: String,
    },
}

impl NodeError {
    pub(crate) fn ros(what: impl Into<String>, error: &rosrust::api::error::Error) -> Self {
        let reasons: Vec<String> = error.iter().map(ToString::to_string).collect();
        Self::Ros { what: what.into(), reason: reasons.join(": ") }
    }
}

/// The process's node, which turns what it receives into [`NodeEvent`]s.
///
/// rosrust has one node in a process; a second `RosNode` is an error.
///
/// ```no_run
/// use rcs_messages::MessageKind;
/// use rcs_ros::{NodeEvent, RosNode};
/// use std::time::Duration;
///
/// let node = RosNode::connect("listener", &|| false)?;
/// // Keeps the topic subscribed until it is dropped.
/// let _subscription = node.subscribe("cloud", MessageKind::PointCloud2, 1)?;
/// while !node.is_asked_to_end() {
///     for event in node.events().wait(Duration::from_millis(100)) {
///         if let NodeEvent::Message { topic, publisher, .. } = event {
///             println!("a cloud of {publisher} on {topic}");
///         }
///     }
/// }
/// node.shutdown();
/// # Ok::<(), rcs_ros::NodeError>(())
/// ```
pub struct RosNode {
    pub(crate) shared: Arc<Shared>,
    services: Mutex<BTreeMap<Arc<str>, rosrust::Service>>,
    pub(crate) param_writer: ParamWriter,
    /// Subscriptions that last as long as the node.
    own_subscriptions: Mutex<Vec<TopicSubscription>>,
}

/// What the node's threads share.
pub(crate) struct Shared {
    name: String,
    pub(crate) graph: Graph,
    pub(crate) events: Arc<EventQueue>,
    clock: RosClock,
    topics: Mutex<BTreeMap<String, Arc<Topic>>>,
    pub(crate) watchdog: Watchdog,
    publications: Mutex<Option<Arc<Publications>>>,
}

impl Shared {
    pub(crate) fn topics(&self) -> MutexGuard<'_, BTreeMap<String, Arc<Topic>>> {
        lock(&self.topics)
    }

    pub(crate) fn update_publications(&self, state: &graph::State) {
        if let Some(publications) = self.graph.publications(state) {
            *lock(&self.publications) = Some(Arc::new(publications));
        }
    }
}

/// The process's arguments without those that are for ROS (`a:=b`), and without the program's name.
pub fn plain_args() -> Vec<String> {
    rosrust::args().into_iter().skip(1).collect()
}

/// Whether the process's node was asked from outside to end, as [`RosNode::is_asked_to_end`]; false while there is
/// none.
pub fn is_asked_to_end() -> bool {
    rosrust::is_initialized() && !rosrust::is_ok()
}

impl RosNode {
    /// Waits for a master, however long that takes, and starts the node.
    ///
    /// `default_name` is the node's name unless `__name:=` gives another. `cancelled` is polled a few times a second,
    /// and ends the waiting when it returns true. That there is no master yet is logged once. With the parameter
    /// `/use_sim_time` set, the node's time is that of `/clock`. Signals are left to the caller.
    pub fn connect(default_name: &str, cancelled: &dyn Fn() -> bool) -> Result<Self, NodeError> {
        let master_uri = rosrust::api::resolve::master();
        wait_for_master(&master_uri, cancelled)?;
        Self::start(&master_uri, default_name)
    }

    /// Starts the node as [`connect`](Self::connect) does, at a master that is there now.
    ///
    /// # Errors
    /// [`NodeError::NoMaster`] if nothing listens at its address.
    pub fn connect_now(default_name: &str) -> Result<Self, NodeError> {
        let master_uri = rosrust::api::resolve::master();
        check_master(&master_uri)?;
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
            own_subscriptions: Mutex::default(),
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

    /// The queue of what was received.
    pub fn events(&self) -> &Arc<EventQueue> {
        &self.shared.events
    }

    /// The present time: that of `/clock` under `/use_sim_time`, else the computer's.
    pub fn now(&self) -> Time {
        self.shared.clock.now()
    }

    /// Whether the present time is that of `/clock`.
    pub fn is_simulated(&self) -> bool {
        self.shared.clock.is_simulated()
    }

    /// The whole name of a topic, service or parameter, after remapping: `x` is in the node's namespace, `~x` below its
    /// name.
    pub fn resolve(&self, name: &str) -> Result<String, NodeError> {
        let param = rosrust::param(name).ok_or_else(|| NodeError::Name(name.to_owned()))?;
        Ok(param.name().to_owned())
    }

    /// Subscribes to a topic. Its messages are queued as [`NodeEvent::Message`], at most `queue_size` of them at a time
    /// (0: any number). Messages of this node itself are ignored. If a message cannot be decoded, a warning names the
    /// topic and the publisher.
    pub fn subscribe(&self, topic: &str, kind: MessageKind, queue_size: usize) -> Result<TopicSubscription, NodeError> {
        let sender = self.shared.events.sender(queue_size);
        let queued = sender.clone();
        self.subscribe_with(topic, kind, Some(queued), move |topic, received| {
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
        // A static transform is sent once, so none may be dropped.
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
            // Also if the reply was dropped unused.
            let (success, message) =
                answer.recv_timeout(REPLY_TIMEOUT).map_err(|_| format!("{name_of_handler}: the node is busy"))?;
            Ok(TriggerRes { success, message })
        })
        .map_err(|error| NodeError::ros(format!("cannot offer service {service}"), &error))?;
        lock(&self.services).insert(Arc::clone(&service), server);
        Ok(service)
    }

    /// Ends the service of this whole name, if there is one.
    pub fn stop_serving(&self, service: &str) {
        // Dropped without the lock: it waits for the master.
        let server = lock(&self.services).remove(service);
        drop(server);
    }

    /// What other nodes published when the master was last asked, which is every two seconds; `None` before the first
    /// time.
    pub fn publications(&self) -> Option<Arc<Publications>> {
        lock(&self.shared.publications).clone()
    }

    /// Asks the master what other nodes publish. `None` if it does not answer within seconds.
    pub fn query_publications(&self) -> Option<Arc<Publications>> {
        let state = self.shared.graph.state()?;
        self.shared.update_publications(&state);
        self.publications()
    }

    /// A string parameter; none if it is not set or not a string.
    pub fn string_param(&self, name: &str) -> Option<String> {
        rosrust::param(name)?.get::<String>().ok()
    }

    /// A boolean parameter; none if it is not set or not a boolean.
    pub fn bool_param(&self, name: &str) -> Option<bool> {
        rosrust::param(name)?.get::<bool>().ok()
    }

    /// Whether the node was asked from outside to end (`rosnode kill`, or another node that took its name).
    pub fn is_asked_to_end(&self) -> bool {
        !rosrust::is_ok()
    }

    /// Unregisters everything and closes all connections, within a second even if the master does not answer. The node
    /// cannot be used after that.
    pub fn shutdown(&self) {
        let (done, is_done) = channel();
        let shared = Arc::clone(&self.shared);
        let subscriptions = std::mem::take(&mut *lock(&self.own_subscriptions));
        let services = std::mem::take(&mut *lock(&self.services));
        self.shared.watchdog.stop();
        let spawned = std::thread::Builder::new().name("ros-shutdown".to_owned()).spawn(move || {
            drop((subscriptions, services));
            for topic in std::mem::take(&mut *shared.topics()).values() {
                topic.close();
            }
            rosrust::shutdown();
            shared.graph.unregister_rest();
            // Fails if it took too long and the caller went on.
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
        lock(&self.own_subscriptions).push(subscription);
    }
}

/// Calls `start`; the threads that it starts may wake up late by [`WAKE_SLACK`].
///
/// rosrust polls for calls from other nodes every five milliseconds, whether there are any or not, which costs a third
/// of a percent of a core for as long as the node lives. Threads inherit the slack of their timers from the one that
/// starts them, so it is set for that moment. If the system refuses, nothing changes.
fn with_wake_slack<T>(start: impl FnOnce() -> T) -> T {
    let slack_ns = u64::try_from(WAKE_SLACK.as_nanos()).ok().and_then(std::num::NonZeroU64::new);
    let before = rustix::thread::current_timer_slack().ok().and_then(std::num::NonZeroU64::new);
    let _ = rustix::thread::set_current_timer_slack(slack_ns);
    let started = start();
    let _ = rustix::thread::set_current_timer_slack(before);
    started
}
