//! The node's TCPROS port: reads each connection's header and passes it to the topic's publication or the service.

use std::collections::BTreeMap;
use std::io;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rcs_process::lock;

use super::header::Header;
use super::publication::Publication;
use super::service::Service;
use crate::acceptor::{Acceptor, Limits};

/// Timeout of a connection header.
const HANDSHAKE_TIMEOUT: Duration = Duration::from_secs(5);
/// Limits of all connections.
const LIMITS: Limits = Limits { connections: 512, stack_bytes: 256 * 1024 };

/// Publications and services of the port, by whole names.
#[derive(Default)]
struct Served {
    publications: Mutex<BTreeMap<String, Arc<Publication>>>,
    services: Mutex<BTreeMap<String, Arc<Service>>>,
}

/// The node's TCPROS port, until it is dropped.
pub(crate) struct Listener {
    acceptor: Acceptor,
    served: Arc<Served>,
}

impl Listener {
    /// Listens at an address (port 0: a free one).
    ///
    /// # Errors
    /// No address or thread is available.
    pub(crate) fn start(address: SocketAddr, node_name: &str) -> io::Result<Self> {
        let (served, node_name) = (Arc::<Served>::default(), node_name.to_owned());
        let known = Arc::clone(&served);
        let serving = move |stream| serve(stream, &known, &node_name);
        let acceptor = Acceptor::start("tcpros", TcpListener::bind(address)?, LIMITS, serving)?;
        Ok(Self { acceptor, served })
    }

    /// Port for the answer to `requestTopic`.
    pub(crate) fn port(&self) -> u16 {
        self.acceptor.address().port()
    }

    /// Adds a publication, or replaces one of the same topic.
    pub(crate) fn add(&self, publication: Arc<Publication>) {
        let topic = publication.description().topic.clone();
        let replaced = lock(&self.served.publications).insert(topic, publication);
        if let Some(replaced) = replaced {
            replaced.close();
        }
    }

    /// Removes a publication and ends its connections.
    pub(crate) fn remove(&self, topic: &str) {
        let removed = lock(&self.served.publications).remove(topic);
        if let Some(removed) = removed {
            removed.close();
        }
    }

    /// Adds a service, or replaces one of the same name.
    pub(crate) fn add_service(&self, service: Arc<Service>) {
        let replaced = lock(&self.served.services).insert(service.name.clone(), service);
        if let Some(replaced) = replaced {
            replaced.close();
        }
    }

    /// Removes a service and ends its connections.
    pub(crate) fn remove_service(&self, name: &str) -> Option<Arc<Service>> {
        let removed = lock(&self.served.services).remove(name)?;
        removed.close();
        Some(removed)
    }

    /// All publications.
    pub(crate) fn publications(&self) -> Vec<Arc<Publication>> {
        lock(&self.served.publications).values().cloned().collect()
    }

    /// The publication of a topic.
    pub(crate) fn publication(&self, topic: &str) -> Option<Arc<Publication>> {
        lock(&self.served.publications).get(topic).cloned()
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        // First, so that no connection is accepted meanwhile.
        self.acceptor.end();
        for publication in self.publications() {
            publication.close();
        }
        for service in lock(&self.served.services).values() {
            service.close();
        }
    }
}

fn refuse(stream: &mut TcpStream, wanted: &Header, reason: &str) -> io::Result<()> {
    log::debug!("{} refused: {reason}", wanted.get("callerid").unwrap_or("a connection"));
    Header::new([("error", reason)]).write(stream, HANDSHAKE_TIMEOUT)
}

/// Serves a subscriber or a service's caller until either side ends the connection.
fn serve(mut stream: TcpStream, served: &Served, node_name: &str) -> io::Result<()> {
    let wanted = Header::read(&mut stream, Instant::now() + HANDSHAKE_TIMEOUT)?;
    if let Some(name) = wanted.get("service") {
        let service = lock(&served.services).get(name).cloned();
        return match service {
            Some(service) => service.serve(stream, &wanted, node_name),
            None => refuse(&mut stream, &wanted, &format!("service [{name}] is not offered by {node_name}")),
        };
    }
    let topic = wanted.get("topic").unwrap_or_default();
    let publication = lock(&served.publications).get(topic).cloned();
    let Some(publication) = publication else {
        return refuse(&mut stream, &wanted, &format!("topic [{topic}] is not published by {node_name}"));
    };
    if let Err(reason) = publication.description().check(&wanted) {
        return refuse(&mut stream, &wanted, &reason);
    }
    publication.description().answer(node_name).write(&mut stream, HANDSHAKE_TIMEOUT)?;
    // The last bytes of a message must not wait for more, also for subscribers without tcp_nodelay=1.
    stream.set_nodelay(true)?;
    publication.serve(stream, wanted.get("callerid").unwrap_or_default())
}
