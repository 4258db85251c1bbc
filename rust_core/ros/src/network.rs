//! The node's ports, API and registrations.

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, ToSocketAddrs};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rcs_process::lock;

use crate::master::Master;
use crate::names::{master_uri, Host};
use crate::node_api::{self, ApiState};
use crate::registrar::{Entry, Registrar};
use crate::tcpros::{Description, Listener, Observer, Publication, Service};
use crate::xmlrpc::Server;

/// Time for a silent master when the node ends, and for unregistering in all.
const MASTER_PATIENCE: Duration = Duration::from_millis(800);
const UNREGISTER_LIMIT: Duration = Duration::from_millis(1400);

/// The node's listeners and registrations; dropping it closes all connections.
pub(crate) struct Network {
    listener: Arc<Listener>,
    /// Host by which others reach this node.
    host: String,
    registrar: Arc<Registrar>,
    is_asked_to_end: Arc<AtomicBool>,
    /// Held while a publisher is added or removed.
    publishing: Mutex<()>,
    _api: Server,
}

/// The address to listen at, for the host that others are given.
///
/// With an address in ROS_IP or ROS_HOSTNAME, or the name of one that other machines reach, the node listens there
/// only; for `localhost`, at this machine only. It listens at all addresses for a name that leads to a loopback
/// address, or to one that the machine does not have (a router's, a container host's).
fn listening_address(host: &str, is_chosen: bool) -> IpAddr {
    let every = IpAddr::from(Ipv4Addr::UNSPECIFIED);
    if !is_chosen {
        return every;
    }
    if host == "localhost" {
        return Ipv4Addr::LOCALHOST.into();
    }
    let is_own = |ip: &IpAddr| TcpListener::bind((*ip, 0)).is_ok();
    if let Ok(ip) = host.parse::<IpAddr>() {
        return if is_own(&ip) { ip } else { every };
    }
    #[expect(clippy::disallowed_methods, reason = "the resolver has limits, and the start can be cancelled")]
    let addresses = (host, 0).to_socket_addrs().map(Vec::from_iter).unwrap_or_default();
    // Other nodes use version 4.
    let reachable = addresses.iter().map(SocketAddr::ip).filter(|ip| ip.is_ipv4() && !ip.is_loopback());
    reachable.into_iter().find(is_own).unwrap_or(every)
}

impl Network {
    /// Opens the node's ports and starts its threads, without registrations.
    ///
    /// # Errors
    /// No port or thread is available.
    pub(crate) fn start(
        node_name: &str,
        on_publisher_left: impl Fn(&str) + Send + Sync + 'static,
    ) -> io::Result<Arc<Self>> {
        let Host { name: host, is_chosen } = Host::of_process();
        let ip = listening_address(&host, is_chosen);
        if is_chosen && ip.is_unspecified() {
            // Debian's own /etc/hosts leads the machine's name to a loopback address.
            let level = if host.parse::<IpAddr>().is_ok() { log::Level::Warn } else { log::Level::Info };
            log::log!(level, "{host} is no address of this machine that others reach: listening at all addresses");
        }
        let listener = Arc::new(Listener::start((ip, 0).into(), node_name)?);
        let state = Arc::new(Mutex::new(None));
        let api = node_api::serve((ip, 0).into(), Arc::clone(&state))?;
        let master = Master {
            uri: master_uri(),
            node_name: node_name.to_owned(),
            node_uri: format!("http://{}:{}/", bracketed(&host), api.address().port()),
        };
        let is_asked_to_end = Arc::new(AtomicBool::new(false));
        let registrar = Registrar::new(master, Arc::clone(&is_asked_to_end), on_publisher_left);
        *lock(&state) = Some(Arc::new(ApiState {
            host: host.clone(),
            listener: Arc::clone(&listener),
            registrar: Arc::clone(&registrar),
            is_asked_to_end: Arc::clone(&is_asked_to_end),
        }));
        let running = Arc::clone(&registrar);
        std::thread::Builder::new().name("ros-registrar".to_owned()).spawn(move || running.run())?;
        Ok(Arc::new(Self { listener, host, registrar, is_asked_to_end, publishing: Mutex::default(), _api: api }))
    }

    /// Registrations of the node.
    pub(crate) fn registrar(&self) -> &Arc<Registrar> {
        &self.registrar
    }

    /// `true` if the master or a tool has asked the node to end.
    pub(crate) fn is_asked_to_end(&self) -> bool {
        self.is_asked_to_end.load(Ordering::Acquire)
    }

    /// Publishes a topic, sharing a present publication of its type. Returns the observer's id, too.
    pub(crate) fn publish(&self, description: Description, observer: &Observer) -> (Arc<Publication>, u64) {
        let publishing = lock(&self.publishing);
        let shared = self.listener.publication(&description.topic);
        let publication = match shared.filter(|shared| shared.description().ros_type == description.ros_type) {
            Some(shared) => shared,
            None => {
                let publication = Publication::new(description);
                self.listener.add(Arc::clone(&publication));
                self.registrar.add(publisher_entry(publication.description()));
                publication
            }
        };
        let id = publication.observe(observer);
        drop(publishing);
        // Without the lock: an observer may publish.
        publication.report_present(observer);
        (publication, id)
    }

    /// Removes a publisher, and the topic with the last one.
    pub(crate) fn unpublish(&self, publication: &Arc<Publication>, observer: u64) {
        let _publishing = lock(&self.publishing);
        if publication.forget(observer) {
            let description = publication.description();
            self.registrar.remove(&publisher_entry(description));
            if self.listener.publication(&description.topic).is_some_and(|known| Arc::ptr_eq(&known, publication)) {
                self.listener.remove(&description.topic);
            }
        }
    }

    /// Whole names of the published topics.
    pub(crate) fn topics(&self) -> Vec<String> {
        self.listener.publications().iter().map(|publication| publication.description().topic.clone()).collect()
    }

    /// `true` if a topic has subscribers and no message is queued for any of them.
    pub(crate) fn has_sent_all(&self, topic: &str) -> bool {
        let subscribers = self.listener.publication(topic).map(|publication| publication.subscribers());
        subscribers.is_some_and(|all| !all.is_empty() && all.iter().all(|subscriber| subscriber.is_idle()))
    }

    /// Offers a service until [`stop_serving`](Self::stop_serving).
    pub(crate) fn serve(&self, service: Arc<Service>) {
        let entry = self.service_entry(&service);
        // Served before it is registered.
        self.listener.add_service(service);
        self.registrar.add(entry);
    }

    /// Withdraws a service.
    pub(crate) fn stop_serving(&self, name: &str) {
        if let Some(service) = self.listener.remove_service(name) {
            self.registrar.remove(&self.service_entry(&service));
        }
    }

    fn service_entry(&self, service: &Service) -> Entry {
        let api = format!("rosrpc://{}:{}", bracketed(&self.host), self.listener.port());
        Entry::Service { service: service.name.clone(), api, number: service.number }
    }

    /// `true` once [`end`](Self::end) was called.
    pub(crate) fn is_ended(&self) -> bool {
        self.registrar.is_ended()
    }

    /// Unregisters everything and closes all connections.
    pub(crate) fn end(&self) {
        self.registrar.end(MASTER_PATIENCE, UNREGISTER_LIMIT);
        for publication in self.listener.publications() {
            publication.close();
        }
    }
}

/// The registration of a publication.
fn publisher_entry(Description { topic, ros_type, number, .. }: &Description) -> Entry {
    Entry::Publisher { topic: topic.clone(), ros_type: ros_type.clone(), number: *number }
}

/// A host as part of an address, with brackets for IPv6.
fn bracketed(host: &str) -> String {
    if host.contains(':') {
        format!("[{host}]")
    } else {
        host.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_node_listens_where_the_hosts_name_says_if_the_machine_has_that_address() {
        let every = IpAddr::from(Ipv4Addr::UNSPECIFIED);
        let local = IpAddr::from(Ipv4Addr::LOCALHOST);
        assert_eq!(listening_address("127.0.0.1", false), every);
        assert_eq!(listening_address("127.0.0.1", true), local);
        assert_eq!(listening_address("127.0.0.2", true), IpAddr::from([127, 0, 0, 2]));
        assert_eq!(listening_address("localhost", true), local);
        // An address of a documentation network, and an unknown name.
        assert_eq!(listening_address("192.0.2.1", true), every);
        assert_eq!(listening_address("no-such-host.invalid", true), every);
    }
}
