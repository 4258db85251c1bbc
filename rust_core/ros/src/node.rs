//! The process's node: connecting, subscribing, services, parameters, shutting down.

use crate::clock::RosClock;
use crate::contacts::Unreachable;
use crate::error::NodeError;
use crate::events::{EventQueue, EventSender, NodeEvent, Reply, ServiceCall};
use crate::master::Publications;
use crate::names::{master_uri, private_arguments, Names};
use crate::network::Network;
use crate::param_writer::ParamWriter;
use crate::tcpros::Service;
use crate::topic::{MessageCallback, Received, TopicSubscription, Topics};
use crate::waiting::{ask_until_answered, check_master, wait_for_master};
use crate::xmlrpc::Value;
use rcs_messages::rosgraph_msgs::Clock;
use rcs_messages::rviz::{SendFilePath, SendFilePathRes};
use rcs_messages::std_srvs::{Empty, EmptyRes, SetBool, SetBoolRes, Trigger, TriggerRes};
use rcs_messages::{AnyMessage, MessageKind, ServicePair, Time};
use rcs_process::lock;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{sync_channel, RecvTimeoutError};
use std::sync::{Arc, Mutex, Weak};
use std::time::{Duration, Instant};

/// Queue size of `/tf`. Robots send some hundred messages a second.
const TF_QUEUE_SIZE: usize = 1000;
/// Calls of a service that may wait for an answer; the oldest get an error.
const MOST_QUEUED_CALLS: usize = 64;
/// Time that a caller of a service waits for the scene's thread.
const REPLY_TIMEOUT: Duration = Duration::from_secs(5);
/// Time for the node to end. Unregistering has limits of its own.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(4);

/// Parameters by name; a namespace is a struct.
pub type Parameters = BTreeMap<String, Value>;

/// The process's node, which receives [`NodeEvent`]s.
///
/// A process has one node at a time.
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
    pub(crate) param_writer: ParamWriter,
    /// Private parameters when the node started.
    private: Parameters,
    /// Subscriptions that last as long as the node.
    own_subscriptions: Mutex<Vec<TopicSubscription>>,
}

/// The node's state that its threads share.
pub(crate) struct Shared {
    pub(crate) names: Names,
    pub(crate) network: Arc<Network>,
    pub(crate) events: Arc<EventQueue>,
    pub(crate) calls: Arc<EventQueue<ServiceCall>>,
    clock: Arc<RosClock>,
    topics: Arc<Topics>,
    /// Polled parameters, each with `true` if it was reported as not set.
    pub(crate) followed_parameters: Mutex<BTreeMap<String, bool>>,
}

/// Name and time of the process's node, for a line of the log.
#[derive(Clone, Debug)]
pub struct NodeTime {
    /// Whole name of the node.
    pub name: String,
    /// Present time.
    pub stamp: Time,
    /// `true` if the time is simulated.
    pub is_simulated: bool,
}

/// The process's node, if there is one.
static NODE: Mutex<Weak<Shared>> = Mutex::new(Weak::new());

/// [`RosNode::is_asked_to_end`] of the process's node; `false` without one.
pub fn is_asked_to_end() -> bool {
    lock(&NODE).upgrade().is_some_and(|shared| shared.network.is_asked_to_end())
}

/// Name and time of the process's node, if there is one.
pub fn node_time() -> Option<NodeTime> {
    let shared = lock(&NODE).upgrade()?;
    let (stamp, is_simulated) = (shared.clock.now(), shared.clock.is_simulated());
    Some(NodeTime { name: shared.names.node().to_owned(), stamp, is_simulated })
}

impl RosNode {
    /// Waits for a master without limit and starts the node.
    ///
    /// `default_name` is the node's name unless `__name:=` gives another. `cancelled` is polled a few times a second
    /// and ends the wait when it returns `true`. A missing master is logged once. Under `/use_sim_time` the node's time
    /// is that of `/clock`.
    ///
    /// # Errors
    /// [`NodeError::Cancelled`], or why the node cannot start.
    pub fn connect(default_name: &str, cancelled: &dyn Fn() -> bool) -> Result<Self, NodeError> {
        let default_name = default_name.to_owned();
        unless_cancelled(cancelled, move |given_up| {
            wait_for_master(&master_uri(), given_up)?;
            Self::start(&default_name, "", given_up)
        })
    }

    /// Starts the node as [`connect`](Self::connect) does, at a master that is there now.
    ///
    /// # Errors
    /// [`NodeError::NoMaster`] if no master answers at its address, else as [`connect`](Self::connect).
    pub fn connect_now(default_name: &str, cancelled: &dyn Fn() -> bool) -> Result<Self, NodeError> {
        Self::connect_beside(default_name, "", cancelled)
    }

    /// Starts the node as [`connect_now`](Self::connect_now) does, with `suffix` after its name: for a launch line
    /// whose own node may be running, which the master would end if another took its name.
    ///
    /// # Errors
    /// As [`connect_now`](Self::connect_now).
    pub fn connect_beside(default_name: &str, suffix: &str, cancelled: &dyn Fn() -> bool) -> Result<Self, NodeError> {
        let (default_name, suffix) = (default_name.to_owned(), suffix.to_owned());
        unless_cancelled(cancelled, move |given_up| {
            check_master(&master_uri())?;
            Self::start(&default_name, &suffix, given_up)
        })
    }

    fn start(default_name: &str, suffix: &str, cancelled: &dyn Fn() -> bool) -> Result<Self, NodeError> {
        let (names, arguments) = (Names::of_process(default_name, suffix)?, private_arguments()?);
        let events: Arc<EventQueue> = Arc::default();
        let sender = events.sender(0);
        let on_publisher_left = move |topic: &str| sender.push(NodeEvent::PublisherLeft { topic: topic.into() });
        let network = Network::start(names.node(), on_publisher_left)
            .map_err(|error| NodeError::Start { what: "the node's ports", reason: error.to_string() })?;
        let master = network.registrar().master();
        for (name, value) in arguments {
            let name = names.resolve(&name)?;
            ask_until_answered(&master.uri, cancelled, || master.set_param(&name, value.clone()))?;
        }
        let param = |name: &str| ask_until_answered(&master.uri, cancelled, || master.param(name));
        let simulated = param("/use_sim_time")? == Some(Value::Bool(true));
        let private = struct_of(param(&master.node_name)?);
        let shared = Arc::new(Shared {
            names,
            network,
            events,
            calls: Arc::default(),
            clock: Arc::new(RosClock::new(simulated)),
            topics: Arc::default(),
            followed_parameters: Mutex::default(),
        });
        *lock(&NODE) = Arc::downgrade(&shared);
        let node = Self { shared, private, param_writer: ParamWriter::default(), own_subscriptions: Mutex::default() };
        if simulated {
            node.follow_clock()?;
        }
        Ok(node)
    }

    /// Ports and registrations.
    pub(crate) fn network(&self) -> &Arc<Network> {
        &self.shared.network
    }

    /// Clock of the node.
    pub(crate) fn clock(&self) -> &Arc<RosClock> {
        &self.shared.clock
    }

    /// Whole name of the node.
    pub fn name(&self) -> &str {
        self.shared.names.node()
    }

    /// Queue of received events.
    pub fn events(&self) -> &Arc<EventQueue> {
        &self.shared.events
    }

    /// Queue of service calls.
    pub fn calls(&self) -> &Arc<EventQueue<ServiceCall>> {
        &self.shared.calls
    }

    /// Present time: that of `/clock` under `/use_sim_time`, else the computer's.
    pub fn now(&self) -> Time {
        self.shared.clock.now()
    }

    /// `true` if the time is that of `/clock`.
    pub fn is_simulated(&self) -> bool {
        self.shared.clock.is_simulated()
    }

    /// Whole name of a topic, service or parameter after remapping: `x` is in the node's namespace, `~x` below its
    /// name.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub fn resolve(&self, name: &str) -> Result<String, NodeError> {
        self.shared.names.resolve(name)
    }

    /// Subscribes to a topic, whose messages are queued as [`NodeEvent::Message`], at most `queue_size` of them (0:
    /// 10,000, the largest). This node's own messages are ignored. Messages that cannot be decoded are logged.
    ///
    /// # Errors
    /// [`NodeError::Name`] or [`NodeError::TypeMismatch`].
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

    /// Subscribes to a topic of texts for as long as the node lives. `take` is called with each text and the name of
    /// the sending node, on the thread of its connection.
    ///
    /// # Errors
    /// [`NodeError::Name`] or [`NodeError::TypeMismatch`].
    pub fn follow_texts(
        &self,
        topic: &str,
        take: impl Fn(&str, &str) + Send + Sync + 'static,
    ) -> Result<(), NodeError> {
        let subscription = self.subscribe_with(topic, MessageKind::Text, None, move |_, received| {
            if let AnyMessage::Text(text) = received.message {
                take(&text.data, received.publisher);
            }
        })?;
        self.keep(subscription);
        Ok(())
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

    /// Offers a service of type `std_srvs/Trigger`, whose calls are [`ServiceCall::Trigger`]s, until
    /// [`stop_serving`](Self::stop_serving) or the node's end. Returns the service's whole name.
    pub fn serve_trigger(&self, name: &str) -> Result<Arc<str>, NodeError> {
        let service: Arc<str> = self.resolve(name)?.into();
        let own_name = Arc::clone(&service);
        self.serve_queued::<Trigger, _>(
            &service,
            move |caller, _, reply| ServiceCall::Trigger { service: Arc::clone(&own_name), caller, reply },
            |(success, message)| TriggerRes { success, message },
        );
        Ok(service)
    }

    /// Offers a service of type `std_srvs/SetBool`, whose calls are [`ServiceCall::SetBool`]s, until
    /// [`stop_serving`](Self::stop_serving) or the node's end. Returns the service's whole name.
    pub fn serve_set_bool(&self, name: &str) -> Result<Arc<str>, NodeError> {
        let service: Arc<str> = self.resolve(name)?.into();
        let own_name = Arc::clone(&service);
        self.serve_queued::<SetBool, _>(
            &service,
            move |caller, request, reply| ServiceCall::SetBool {
                service: Arc::clone(&own_name),
                value: request.data,
                caller,
                reply,
            },
            |(success, message)| SetBoolRes { success, message },
        );
        Ok(service)
    }

    /// Offers a service of type `rviz/SendFilePath`, whose calls are [`ServiceCall::FilePath`]s, until
    /// [`stop_serving`](Self::stop_serving) or the node's end. Returns the service's whole name.
    pub fn serve_file_path(&self, name: &str) -> Result<Arc<str>, NodeError> {
        let service: Arc<str> = self.resolve(name)?.into();
        let own_name = Arc::clone(&service);
        self.serve_queued::<SendFilePath, _>(
            &service,
            move |caller, request, reply| ServiceCall::FilePath {
                service: Arc::clone(&own_name),
                path: request.path.into(),
                caller,
                reply,
            },
            |success| SendFilePathRes { success },
        );
        Ok(service)
    }

    /// Offers a service of type `std_srvs/Empty` that succeeds and does nothing, until the node's end.
    pub fn serve_nothing(&self, name: &str) -> Result<(), NodeError> {
        self.serve::<Empty>(&self.resolve(name)?, |_, _| Ok(EmptyRes {}));
        Ok(())
    }

    /// Offers a service by its whole name, whose calls are queued. `queued` makes the call of a caller, `response` what
    /// is answered.
    pub(crate) fn serve_queued<T: ServicePair, A: Send + 'static>(
        &self,
        service: &str,
        queued: impl Fn(Arc<str>, T::Request, Reply<A>) -> ServiceCall + Send + Sync + 'static,
        response: impl Fn(A) -> T::Response + Send + Sync + 'static,
    ) {
        let (sender, name) = (self.shared.calls.sender(MOST_QUEUED_CALLS), service.to_owned());
        self.serve::<T>(service, move |caller, request| {
            let (reply, answer) = Reply::new();
            sender.push(queued(caller.into(), request, reply));
            // Also if the reply was dropped unused.
            answer.recv_timeout(REPLY_TIMEOUT).map(&response).map_err(|_| format!("{name}: the node is busy"))
        });
    }

    /// Offers a service by its whole name. `handler` is called on the threads of its callers, with the caller's name.
    pub(crate) fn serve<T: ServicePair>(
        &self,
        service: &str,
        handler: impl Fn(&str, T::Request) -> Result<T::Response, String> + Send + Sync + 'static,
    ) {
        let answer = move |caller: &str, request: &[u8]| {
            let request = rcs_messages::decode(request).map_err(|error| format!("not a request: {error}"))?;
            handler(caller, request).map(|response| rcs_messages::encode(&response))
        };
        self.network().serve(Service::new(service, T::msg_type(), T::md5sum(), Box::new(answer)));
    }

    /// Withdraws a service by its whole name.
    pub fn stop_serving(&self, service: &str) {
        self.network().stop_serving(service);
    }

    /// Other nodes' publications, which are read every two seconds; `None` before the first time.
    pub fn publications(&self) -> Option<Arc<Publications>> {
        self.dated_publications().map(|(_, publications)| publications)
    }

    /// Other nodes' publications, and when the master was asked for them.
    pub fn dated_publications(&self) -> Option<(Instant, Arc<Publications>)> {
        self.network().registrar().publications()
    }

    /// Restarts of the master that were noticed: its parameters are lost then.
    pub fn master_restarts(&self) -> u64 {
        self.network().registrar().restarts()
    }

    /// Reads other nodes' publications from the master. `None` if it does not answer within seconds.
    pub fn query_publications(&self) -> Option<Arc<Publications>> {
        self.network().registrar().query_publications()
    }

    /// Publishers of a subscribed topic, by its whole name, whose nodes do not answer.
    pub fn unreachable_publishers(&self, topic: &str) -> Vec<Unreachable> {
        self.network().registrar().unreachable(topic)
    }

    /// The node's private parameters, as they were when it started.
    pub fn parameters(&self) -> &Parameters {
        &self.private
    }

    /// Another node's private parameters. Waits for the master for some seconds at most; empty if it does not answer.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub fn parameters_of(&self, node: &str) -> Result<Parameters, NodeError> {
        let whole_name = self.resolve(node)?;
        Ok(struct_of(self.network().registrar().master().param(&whole_name).ok().flatten()))
    }

    /// Sets a parameter soon, unless it is set to another value before. Never waits; failures are logged.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub fn set_parameter(&self, name: &str, value: Value) -> Result<(), NodeError> {
        self.param_writer.set(self.network(), self.resolve(name)?, value);
        Ok(())
    }

    /// `true` if the node was asked to end: by `rosnode kill`, or because another node took its name.
    pub fn is_asked_to_end(&self) -> bool {
        self.network().is_asked_to_end()
    }

    /// Unregisters everything and closes all connections, within a second if the master does not answer. A second call
    /// does nothing.
    pub fn shutdown(&self) {
        if self.network().is_ended() {
            return;
        }
        let (done, is_done) = sync_channel(1);
        let shared = Arc::clone(&self.shared);
        let subscriptions = std::mem::take(&mut *lock(&self.own_subscriptions));
        let ending = move || {
            drop(subscriptions);
            shared.topics.clear();
            shared.network.end();
            // Fails if it took too long and the caller went on.
            let _ = done.send(());
        };
        let spawned = std::thread::Builder::new().name("ros-shutdown".to_owned()).spawn(ending);
        if spawned.is_err() || is_done.recv_timeout(SHUTDOWN_TIMEOUT).is_err() {
            log::warn!("the node did not end in time");
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
        let listener: MessageCallback = Box::new(on_message);
        self.shared.topics.subscribe(self.network(), self.resolve(name)?, kind, sender, listener)
    }

    fn keep(&self, subscription: TopicSubscription) {
        lock(&self.own_subscriptions).push(subscription);
    }
}

impl Drop for RosNode {
    /// Also unregisters a node that fails.
    fn drop(&mut self) {
        self.shutdown();
    }
}

/// Starts the node on a thread of its own, because the master may stop answering at any time. The argument of `start`
/// returns `true` when the caller has given up.
fn unless_cancelled(
    cancelled: &dyn Fn() -> bool,
    start: impl FnOnce(&dyn Fn() -> bool) -> Result<RosNode, NodeError> + Send + 'static,
) -> Result<RosNode, NodeError> {
    let (started, is_started) = sync_channel(1);
    let is_abandoned = Arc::new(AtomicBool::new(false));
    let given_up = Arc::clone(&is_abandoned);
    let starting = move || {
        // Fails if the caller has given up.
        let _ = started.send(start(&|| given_up.load(Ordering::Acquire)));
    };
    let spawned = std::thread::Builder::new().name("ros-start".to_owned()).spawn(starting);
    spawned.map_err(|error| NodeError::Start { what: "the node", reason: error.to_string() })?;
    loop {
        match is_started.recv_timeout(Duration::from_millis(50)) {
            Ok(result) => return result,
            Err(RecvTimeoutError::Timeout) if !cancelled() => {}
            Err(_) => {
                is_abandoned.store(true, Ordering::Release);
                return Err(NodeError::Cancelled(master_uri()));
            }
        }
    }
}

/// The members of a struct; none of other values.
fn struct_of(value: Option<Value>) -> Parameters {
    match value {
        Some(Value::Struct(values)) => values,
        _ => Parameters::new(),
    }
}
