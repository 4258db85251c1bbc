//! The node's place in the network: its ports, its API, its registrations.

use std::io;
use std::net::{IpAddr, SocketAddr, TcpListener, ToSocketAddrs};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use crate::graph::Master;
use crate::lock;
use crate::node_api::{self, NodeState};
use crate::publisher;
use crate::registrar::{Entry, Registrar};
use crate::rosrust_master;
use crate::startup::Startup;
use crate::tcpros::{Description, Listener, Observer, Publication, Service};
use crate::xmlrpc::Server;

/// Everything that listens and everything that is registered. Dropped, it closes all connections.
pub(crate) struct Network {
    listener: Arc<Listener>,
    /// The host under which others reach this node.
    host: String,
    registrar: Arc<Registrar>,
    is_asked_to_end: Arc<AtomicBool>,
    /// One publisher at a time comes or goes.
    publishing: Mutex<()>,
    _servers: [Server; 2],
}

/// The address to listen at: the one of the host name that others are given, where it is this machine's.
///
/// So with ROS_IP or ROS_HOSTNAME set, the node listens there and nowhere else. A name of an address that is not this
/// machine's own (a router's, a container's host's) leaves all of them.
fn listening_address(host: &str, is_chosen: bool) -> IpAddr {
    let every = IpAddr::from(std::net::Ipv4Addr::UNSPECIFIED);
    if !is_chosen {
        return every;
    }
    let addresses = (host, 0).to_socket_addrs().map(Vec::from_iter).unwrap_or_default();
    let is_own = |address: &SocketAddr| TcpListener::bind((address.ip(), 0)).is_ok();
    match addresses.iter().find(|address| is_own(address)) {
        Some(address) => address.ip(),
        None => {
            log::warn!("{host} is not an address of this machine, listening at all of its addresses");
            every
        }
    }
}

impl Network {
    /// Opens the node's ports and starts its threads; nothing is registered yet.
    ///
    /// # Errors
    /// The system's, where a port or a thread cannot be had.
    pub(crate) fn start(
        startup: &Startup,
        rosrust_listener: TcpListener,
        node_name: &str,
        on_publisher_left: impl Fn(&str) + Send + Sync + 'static,
    ) -> io::Result<Arc<Self>> {
        let Startup { master_uri, host, is_host_chosen, .. } = startup;
        let ip = listening_address(host, *is_host_chosen);
        let listener = Arc::new(Listener::start((ip, 0).into(), node_name)?);
        let state = Arc::new(Mutex::new(None));
        let api = node_api::serve((ip, 0).into(), Arc::clone(&state))?;
        let master = Master {
            uri: master_uri.clone(),
            node_name: node_name.to_owned(),
            node_uri: format!("http://{}:{}/", bracketed(host), api.address().port()),
        };
        let registrar = Registrar::new(master, on_publisher_left);
        let (rosrust_uri, is_asked_to_end) = (Arc::new(Mutex::new(None)), Arc::new(AtomicBool::new(false)));
        *lock(&state) = Some(Arc::new(NodeState {
            host: host.clone(),
            listener: Arc::clone(&listener),
            registrar: Arc::clone(&registrar),
            rosrust_uri: Arc::clone(&rosrust_uri),
            is_asked_to_end: Arc::clone(&is_asked_to_end),
        }));
        let rosrust_master = rosrust_master::start(rosrust_listener, Arc::clone(&registrar), rosrust_uri)?;
        let running = Arc::clone(&registrar);
        std::thread::Builder::new().name("ros-registrar".to_owned()).spawn(move || running.run())?;
        Ok(Arc::new(Self {
            listener,
            host: host.clone(),
            registrar,
            is_asked_to_end,
            publishing: Mutex::default(),
            _servers: [api, rosrust_master],
        }))
    }

    /// The node's registrations.
    pub(crate) fn registrar(&self) -> &Arc<Registrar> {
        &self.registrar
    }

    /// Whether the master or a tool has asked the node to end.
    pub(crate) fn is_asked_to_end(&self) -> bool {
        self.is_asked_to_end.load(Ordering::Acquire)
    }

    /// Publishes a topic, together with those who publish it already. Returns the observer's number, too.
    pub(crate) fn publish(&self, description: Description, observer: &Observer) -> (Arc<Publication>, u64) {
        let _publishing = lock(&self.publishing);
        let shared = self.listener.publication(&description.topic);
        let publication = match shared.filter(|shared| shared.description().ros_type == description.ros_type) {
            Some(shared) => shared,
            None => {
                let publication = Publication::new(description);
                self.listener.add(Arc::clone(&publication));
                self.registrar.add(publisher::entry(publication.description()));
                publication
            }
        };
        let id = publication.observe(observer);
        (publication, id)
    }

    /// Takes a publisher away, and the topic with the last of them.
    pub(crate) fn unpublish(&self, publication: &Arc<Publication>, observer: u64) {
        let _publishing = lock(&self.publishing);
        if publication.forget(observer) {
            let description = publication.description();
            self.registrar.remove(&publisher::entry(description));
            if self.listener.publication(&description.topic).is_some_and(|known| Arc::ptr_eq(&known, publication)) {
                self.listener.remove(&description.topic);
            }
        }
    }

    /// Offers a service until [`stop_serving`](Self::stop_serving).
    pub(crate) fn serve(&self, service: Arc<Service>) {
        self.registrar.add(self.service_entry(&service.name));
        self.listener.add_service(service);
    }

    /// Offers a service no more.
    pub(crate) fn stop_serving(&self, name: &str) {
        self.registrar.remove(&self.service_entry(name));
        self.listener.remove_service(name);
    }

    fn service_entry(&self, name: &str) -> Entry {
        let api = format!("rosrpc://{}:{}", bracketed(&self.host), self.listener.port());
        Entry::Service { service: name.to_owned(), api }
    }

    /// Unregisters everything, for as long as the master answers, and closes all connections.
    pub(crate) fn end(&self) {
        for publication in self.listener.publications() {
            publication.close();
        }
        self.registrar.end();
    }
}

/// A host as it stands in an address: that of IP version 6 in brackets.
fn bracketed(host: &str) -> String {
    if host.contains(':') {
        format!("[{host}]")
    } else {
        host.to_owned()
    }
}
