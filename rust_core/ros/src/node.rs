//! The node itself: what it publishes, subscribes to and serves, and its life between registering and unregistering.

use crate::master::Master;
use crate::names::{NameError, NodeOptions};
use crate::publication::{Publication, Publisher, PublisherOptions};
use crate::service::{ServiceServer, ServiceState};
use crate::subscription::{Incoming, Subscription, Topic};
use crate::xmlrpc::{CallError, Value};
use crate::{listener, slave, TypeInfo};
use std::collections::BTreeMap;
use std::io;
use std::net::{Ipv4Addr, TcpListener};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{channel, RecvTimeoutError};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// How often the node looks whether the master still knows it.
const CHECK_PERIOD: Duration = Duration::from_secs(3);
/// How often it looks for a master that is not there yet.
const WAIT_PERIOD: Duration = Duration::from_millis(300);

/// Why a node could not do something.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// A name is not valid.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The master or the way to it.
    #[error(transparent)]
    Master(#[from] CallError),
    /// No port could be had.
    #[error("cannot listen for other nodes: {0}")]
    Listen(io::Error),
    /// A thread could not be started.
    #[error("cannot start a thread: {0}")]
    Thread(io::Error),
    /// The node publishes this topic already.
    #[error("{0} is published by this node already")]
    AlreadyPublished(String),
    /// The node offers this service already.
    #[error("service {0} is offered by this node already")]
    AlreadyServed(String),
    /// Waiting for the master was cancelled.
    #[error("gave up waiting for the ROS master at {0}")]
    Cancelled(String),
    /// The node was shut down.
    #[error("the node is shut down")]
    ShutDown,
}

/// A running node. Clones are the same node; it is shut down when the last is dropped.
#[derive(Clone)]
pub struct Node {
    inner: Arc<Inner>,
    _guard: Arc<Guard>,
}

struct Guard(Arc<Inner>);

impl Drop for Guard {
    fn drop(&mut self) {
        self.0.shutdown();
    }
}

/// What the node's threads share.
pub(crate) struct Inner {
    options: NodeOptions,
    master: Master,
    uri: String,
    tcpros_port: u16,
    server: tiny_http::Server,
    registered: Mutex<Registered>,
    closed: AtomicBool,
    woken: Condvar,
    shutdown_request: Mutex<Option<String>>,
}

#[derive(Default)]
struct Registered {
    publications: BTreeMap<String, Arc<Publication>>,
    services: BTreeMap<String, Arc<ServiceState>>,
    subscriptions: Vec<Arc<Topic>>,
}

impl Node {
    /// Starts the node and waits until the master answers, however long that takes.
    ///
    /// `cancelled` is asked a few times a second whether to give up. A master that is not there is logged once.
    pub fn connect(options: NodeOptions, cancelled: &dyn Fn() -> bool) -> Result<Self, NodeError> {
        let listener = TcpListener::bind((Ipv4Addr::UNSPECIFIED, 0)).map_err(NodeError::Listen)?;
        let tcpros_port = listener.local_addr().map_err(NodeError::Listen)?.port();
        let server = tiny_http::Server::http((Ipv4Addr::UNSPECIFIED, 0))
            .map_err(|error| NodeError::Listen(io::Error::other(error)))?;
        let slave_port = server.server_addr().to_ip().map_or(0, |address| address.port());
        let uri = format!("http://{}:{slave_port}/", options.host());
        let master = Master::new(options.master_uri(), options.name(), &uri);
        wait_for_master(&master, cancelled)?;
        for (name, value) in options.params() {
            master.set_param(name, value)?;
        }
        let inner = Arc::new(Inner {
            options,
            master,
            uri,
            tcpros_port,
            server,
            registered: Mutex::default(),
            closed: AtomicBool::new(false),
            woken: Condvar::new(),
            shutdown_request: Mutex::default(),
        });
        // From here on an early return shuts down what was started.
        let node = Self { _guard: Arc::new(Guard(Arc::clone(&inner))), inner };
        let weak = Arc::downgrade(&node.inner);
        spawn("ros-listen", move || listener::run(&listener, &weak))?;
        let (weak, inner) = (Arc::downgrade(&node.inner), Arc::clone(&node.inner));
        spawn("ros-slave-api", move || slave::run(&inner.server, &weak))?;
        let inner = Arc::clone(&node.inner);
        spawn("ros-check", move || inner.keep_registered())?;
        Ok(node)
    }

    /// The node's whole name.
    pub fn name(&self) -> &str {
        self.inner.name()
    }

    /// Names, remappings and addresses.
    pub fn options(&self) -> &NodeOptions {
        &self.inner.options
    }

    /// The whole name of `name`, after remapping.
    pub fn resolve(&self, name: &str) -> Result<String, NameError> {
        self.inner.options.resolve(name)
    }

    /// Subscribes to a topic. `on_message` is called on the thread that reads from the publisher, so it must not wait.
    pub fn subscribe(
        &self,
        topic: &str,
        type_info: TypeInfo,
        on_message: impl Fn(Incoming<'_>) + Send + Sync + 'static,
    ) -> Result<Subscription, NodeError> {
        let name = self.resolve(topic)?;
        let inner = &self.inner;
        let topic = Arc::new(Topic::new(name, type_info, inner.name(), &inner.uri, Box::new(on_message)));
        {
            let mut registered = inner.open()?;
            registered.subscriptions.push(Arc::clone(&topic));
        }
        let subscription = Subscription { topic: Arc::clone(&topic), node: Arc::downgrade(inner) };
        let publishers = inner.master.register_subscriber(&topic.name, &topic.type_info.name)?;
        topic.add_publishers(&publishers);
        Ok(subscription)
    }

    /// Publishes a topic.
    pub fn advertise(
        &self,
        topic: &str,
        type_info: TypeInfo,
        options: PublisherOptions,
    ) -> Result<Publisher, NodeError> {
        let name = self.resolve(topic)?;
        let inner = &self.inner;
        let publication = Arc::new(Publication::new(name.clone(), type_info, options));
        {
            let mut registered = inner.open()?;
            if registered.publications.contains_key(&name) {
                return Err(NodeError::AlreadyPublished(name));
            }
            registered.publications.insert(name, Arc::clone(&publication));
        }
        let publisher = Publisher { publication: Arc::clone(&publication), node: Arc::downgrade(inner) };
        inner.master.register_publisher(&publication.topic, &publication.type_info.name)?;
        Ok(publisher)
    }

    /// Offers a service. `handler` gets the request's bytes and returns the response's, or says why it failed; it is
    /// called on the thread of the client's connection.
    pub fn advertise_service(
        &self,
        name: &str,
        type_name: &str,
        md5sum: &str,
        handler: impl Fn(&[u8]) -> Result<Vec<u8>, String> + Send + Sync + 'static,
    ) -> Result<ServiceServer, NodeError> {
        let name = self.resolve(name)?;
        let inner = &self.inner;
        let service = Arc::new(ServiceState {
            name: name.clone(),
            type_name: type_name.to_owned(),
            md5sum: md5sum.to_owned(),
            handler: Box::new(handler),
        });
        {
            let mut registered = inner.open()?;
            if registered.services.contains_key(&name) {
                return Err(NodeError::AlreadyServed(name));
            }
            registered.services.insert(name, Arc::clone(&service));
        }
        let server = ServiceServer { service: Arc::clone(&service), node: Arc::downgrade(inner) };
        inner.master.register_service(&service.name, &inner.service_api())?;
        Ok(server)
    }

    /// A parameter's value; none if it is not set. The name is resolved and remapped.
    pub fn param(&self, name: &str) -> Result<Option<Value>, NodeError> {
        Ok(self.inner.master.param(&self.resolve(name)?)?)
    }

    /// Sets a parameter.
    pub fn set_param(&self, name: &str, value: &Value) -> Result<(), NodeError> {
        Ok(self.inner.master.set_param(&self.resolve(name)?, value)?)
    }

    /// Why this node was asked to end (`rosnode kill`, or another node that took its name), if it was.
    pub fn shutdown_request(&self) -> Option<String> {
        lock(&self.inner.shutdown_request).clone()
    }

    /// Unregisters everything and closes all connections. Takes about a second when the master does not answer, much
    /// less when it does. Later calls do nothing.
    pub fn shutdown(&self) {
        self.inner.shutdown();
    }
}

impl Inner {
    pub(crate) fn name(&self) -> &str {
        self.options.name()
    }

    pub(crate) fn host(&self) -> &str {
        self.options.host()
    }

    pub(crate) fn master_uri(&self) -> &str {
        self.master.uri()
    }

    pub(crate) fn tcpros_port(&self) -> u16 {
        self.tcpros_port
    }

    pub(crate) fn is_closed(&self) -> bool {
        self.closed.load(Ordering::Acquire)
    }

    pub(crate) fn publication(&self, topic: &str) -> Option<Arc<Publication>> {
        lock(&self.registered).publications.get(topic).cloned()
    }

    pub(crate) fn service(&self, name: &str) -> Option<Arc<ServiceState>> {
        lock(&self.registered).services.get(name).cloned()
    }

    pub(crate) fn publication_types(&self) -> Vec<(String, String)> {
        let registered = lock(&self.registered);
        let each = registered.publications.values();
        each.map(|one| (one.topic.clone(), one.type_info.name.clone())).collect()
    }

    pub(crate) fn subscription_types(&self) -> Vec<(String, String)> {
        let registered = lock(&self.registered);
        let each = registered.subscriptions.iter();
        each.map(|one| (one.name.clone(), one.type_info.name.clone())).collect()
    }

    /// The other end, whether messages go out, and the topic, of each connection.
    pub(crate) fn connections(&self) -> Vec<(String, bool, String)> {
        let registered = lock(&self.registered);
        let outwards = registered.publications.values().flat_map(|publication| {
            let subscribers = publication.subscribers().into_iter();
            subscribers.map(|name| (name, true, publication.topic.clone()))
        });
        let inwards = registered.subscriptions.iter().flat_map(|topic| {
            let publishers = topic.publishers().into_iter();
            publishers.map(|name| (name.to_string(), false, topic.name.clone()))
        });
        outwards.chain(inwards).collect()
    }

    pub(crate) fn publisher_update(&self, topic: &str, publishers: &[String]) {
        for subscription in self.subscriptions_of(topic) {
            subscription.set_publishers(publishers);
        }
    }

    pub(crate) fn request_shutdown(&self, reason: &str) {
        lock(&self.shutdown_request).get_or_insert_with(|| reason.to_owned());
    }

    pub(crate) fn remove_publication(&self, publication: &Arc<Publication>) {
        publication.close();
        let mut registered = lock(&self.registered);
        let ours = registered.publications.get(&publication.topic);
        if ours.is_some_and(|ours| Arc::ptr_eq(ours, publication)) {
            registered.publications.remove(&publication.topic);
            drop(registered);
            self.tell(|master| master.unregister_publisher(&publication.topic));
        }
    }

    pub(crate) fn remove_subscription(&self, topic: &Arc<Topic>) {
        topic.close();
        let mut registered = lock(&self.registered);
        let before = registered.subscriptions.len();
        registered.subscriptions.retain(|other| !Arc::ptr_eq(other, topic));
        let removed = registered.subscriptions.len() < before;
        let last = registered.subscriptions.iter().all(|other| other.name != topic.name);
        drop(registered);
        if removed && last {
            self.tell(|master| master.unregister_subscriber(&topic.name));
        }
    }

    pub(crate) fn remove_service(&self, service: &Arc<ServiceState>) {
        let mut registered = lock(&self.registered);
        let ours = registered.services.get(&service.name);
        if ours.is_some_and(|ours| Arc::ptr_eq(ours, service)) {
            registered.services.remove(&service.name);
            drop(registered);
            self.tell(|master| master.unregister_service(&service.name, &self.service_api()));
        }
    }

    fn open(&self) -> Result<MutexGuard<'_, Registered>, NodeError> {
        let registered = lock(&self.registered);
        if self.is_closed() {
            return Err(NodeError::ShutDown);
        }
        Ok(registered)
    }

    fn subscriptions_of(&self, topic: &str) -> Vec<Arc<Topic>> {
        let registered = lock(&self.registered);
        registered.subscriptions.iter().filter(|one| one.name == topic).cloned().collect()
    }

    fn service_api(&self) -> String {
        format!("rosrpc://{}:{}", self.host(), self.tcpros_port)
    }

    /// Tells the master something that it can do without.
    fn tell(&self, call: impl FnOnce(&Master) -> Result<(), CallError>) {
        if let Err(error) = call(&self.master) {
            log::debug!("{error}");
        }
    }

    fn shutdown(&self) {
        let registered = {
            let mut registered = lock(&self.registered);
            if self.closed.swap(true, Ordering::AcqRel) {
                return;
            }
            std::mem::take(&mut *registered)
        };
        self.woken.notify_all();
        for publication in registered.publications.values() {
            publication.close();
        }
        for topic in &registered.subscriptions {
            topic.close();
        }
        if let Err(error) = self.unregister(&registered) {
            log::warn!("could not unregister: {error}");
        }
        self.server.unblock();
        listener::wake(self.tcpros_port);
    }

    /// Stops at the first call without an answer: the others would have none either, and each takes its time.
    fn unregister(&self, registered: &Registered) -> Result<(), CallError> {
        let heard = |result: Result<(), CallError>| match result {
            Err(CallError::Refused { .. }) => Ok(()),
            other => other,
        };
        for service in registered.services.values() {
            heard(self.master.unregister_service(&service.name, &self.service_api()))?;
        }
        for topic in registered.publications.keys() {
            heard(self.master.unregister_publisher(topic))?;
        }
        for topic in &registered.subscriptions {
            heard(self.master.unregister_subscriber(&topic.name))?;
        }
        Ok(())
    }

    /// Registers everything again whenever the master has forgotten this node, as one that was restarted has.
    fn keep_registered(&self) {
        let mut answered = true;
        loop {
            {
                let registered = lock(&self.registered);
                let waited = self.woken.wait_timeout_while(registered, CHECK_PERIOD, |_| !self.is_closed());
                let registered = waited.unwrap_or_else(PoisonError::into_inner).0;
                if self.is_closed() {
                    return;
                }
                if registered.is_empty() {
                    continue;
                }
            }
            let result = self.master.knows_us().and_then(|known| match known {
                true => Ok(()),
                false => self.register_again(),
            });
            match &result {
                Ok(()) if !answered => log::info!("the ROS master at {} answers again", self.master.uri()),
                Err(error) if answered && !self.is_closed() => log::warn!("{error}"),
                _ => {}
            }
            answered = result.is_ok();
        }
    }

    fn register_again(&self) -> Result<(), CallError> {
        let (publications, services, subscriptions) = {
            let registered = lock(&self.registered);
            let publications: Vec<_> = registered.publications.values().cloned().collect();
            let services: Vec<_> = registered.services.values().cloned().collect();
            (publications, services, registered.subscriptions.clone())
        };
        log::info!("registering again with the ROS master at {}", self.master.uri());
        for (name, value) in self.options.params() {
            self.master.set_param(name, value)?;
        }
        for publication in publications {
            self.master.register_publisher(&publication.topic, &publication.type_info.name)?;
        }
        for service in services {
            self.master.register_service(&service.name, &self.service_api())?;
        }
        for topic in subscriptions {
            let publishers = self.master.register_subscriber(&topic.name, &topic.type_info.name)?;
            topic.add_publishers(&publishers);
        }
        Ok(())
    }
}

impl Registered {
    fn is_empty(&self) -> bool {
        self.publications.is_empty() && self.services.is_empty() && self.subscriptions.is_empty()
    }
}

/// Asks on a thread of its own, so that giving up never waits for the network.
fn wait_for_master(master: &Master, cancelled: &dyn Fn() -> bool) -> Result<(), NodeError> {
    let (found, is_found) = channel();
    let (asked, uri) = (master.clone(), master.uri().to_owned());
    spawn("ros-find-master", move || {
        let mut said = false;
        loop {
            let there = asked.is_there();
            // Nobody waits any more.
            if found.send(there).is_err() || there {
                return;
            }
            if !said {
                log::warn!("no ROS master at {} yet, waiting for it", asked.uri());
                said = true;
            }
            std::thread::sleep(WAIT_PERIOD);
        }
    })?;
    loop {
        match is_found.recv_timeout(Duration::from_millis(50)) {
            Ok(true) => return Ok(()),
            Ok(false) | Err(RecvTimeoutError::Timeout) if !cancelled() => {}
            _ => return Err(NodeError::Cancelled(uri)),
        }
    }
}

fn spawn(name: &str, run: impl FnOnce() + Send + 'static) -> Result<(), NodeError> {
    let thread = std::thread::Builder::new().name(name.to_owned());
    thread.spawn(run).map(drop).map_err(NodeError::Thread)
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
