//! The node's TCPROS port: it takes connections, reads what each is about, and hands it to the topic's publication.

use std::collections::BTreeMap;
use std::io;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::header::Header;
use super::publication::Publication;
use super::service::Service;
use crate::lock;

/// How long a subscriber may take to say what it wants.
const HANDSHAKE_TIMEOUT: Duration = Duration::from_secs(5);
/// Connections beyond these are turned away, those of subscribers included.
const MAX_CONNECTIONS: usize = 512;
const STACK_BYTES: usize = 256 * 1024;

/// What the port serves, by whole names.
#[derive(Default)]
struct Served {
    publications: Mutex<BTreeMap<String, Arc<Publication>>>,
    services: Mutex<BTreeMap<String, Arc<Service>>>,
}

/// The node's port for topics, until it is dropped.
pub(crate) struct Listener {
    address: SocketAddr,
    listener: Arc<TcpListener>,
    served: Arc<Served>,
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Listener {
    /// Listens at an address (port 0: a free one).
    ///
    /// # Errors
    /// The system's, where the address cannot be had or there is no thread left.
    pub(crate) fn start(address: SocketAddr, node_name: &str) -> io::Result<Self> {
        let listener = Arc::new(TcpListener::bind(address)?);
        let address = listener.local_addr()?;
        let (served, ended) = (Arc::<Served>::default(), Arc::new(AtomicBool::new(false)));
        let (known, end, node_name) = (Arc::clone(&served), Arc::clone(&ended), Arc::from(node_name));
        let accepted = Arc::clone(&listener);
        let accepting = move || accept(&accepted, &end, &known, &node_name);
        let thread = std::thread::Builder::new().name("tcpros".to_owned()).spawn(accepting)?;
        Ok(Self { address, listener, served, ended, thread: Some(thread) })
    }

    /// The port that `requestTopic` answers with.
    pub(crate) fn port(&self) -> u16 {
        self.address.port()
    }

    /// Serves a publication from now on, in place of one of the same topic.
    pub(crate) fn add(&self, publication: Arc<Publication>) {
        let topic = publication.description().topic.clone();
        let replaced = lock(&self.served.publications).insert(topic, publication);
        if let Some(replaced) = replaced {
            replaced.close();
        }
    }

    /// Serves a topic no more, and ends the connections of its subscribers.
    pub(crate) fn remove(&self, topic: &str) {
        let removed = lock(&self.served.publications).remove(topic);
        if let Some(removed) = removed {
            removed.close();
        }
    }

    /// Answers calls of a service from now on, in place of one of the same name.
    pub(crate) fn add_service(&self, service: Arc<Service>) {
        let replaced = lock(&self.served.services).insert(service.name.clone(), service);
        if let Some(replaced) = replaced {
            replaced.close();
        }
    }

    /// Answers no more calls of a service, which is returned if there was one.
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
        self.ended.store(true, Ordering::Release);
        crate::xmlrpc::server::end(&self.listener);
        if let Some(thread) = self.thread.take() {
            // A panic there was reported by its own thread.
            let _ = thread.join();
        }
        for publication in self.publications() {
            publication.close();
        }
        for service in lock(&self.served.services).values() {
            service.close();
        }
    }
}

/// Counts a connection for as long as it lives.
struct Counted(Arc<AtomicUsize>);

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}

fn accept(listener: &TcpListener, ended: &AtomicBool, served: &Arc<Served>, node_name: &Arc<str>) {
    let open = Arc::new(AtomicUsize::new(0));
    loop {
        let accepted = listener.accept();
        if ended.load(Ordering::Acquire) {
            return;
        }
        let stream = match accepted {
            Ok((stream, _)) => stream,
            Err(error) => {
                log::debug!("a subscriber's connection failed: {error}");
                // No descriptor is left, say; others may be closed soon.
                std::thread::sleep(Duration::from_millis(20));
                continue;
            }
        };
        if open.fetch_add(1, Ordering::AcqRel) >= MAX_CONNECTIONS {
            open.fetch_sub(1, Ordering::AcqRel);
            continue;
        }
        let (counted, served, node_name) = (Counted(Arc::clone(&open)), Arc::clone(served), Arc::clone(node_name));
        let serving = move || {
            let _counted = counted;
            if let Err(error) = serve(stream, &served, &node_name) {
                log::debug!("a subscriber's connection ended: {error}");
            }
        };
        let spawned = std::thread::Builder::new().name("tcpros-sub".to_owned()).stack_size(STACK_BYTES).spawn(serving);
        if let Err(error) = spawned {
            log::warn!("a subscriber cannot be served: {error}");
        }
    }
}

fn refuse(stream: &mut TcpStream, wanted: &Header, reason: &str) -> io::Result<()> {
    log::debug!("{} refused: {reason}", wanted.get("callerid").unwrap_or("a connection"));
    Header::new([("error", reason)]).write(stream, HANDSHAKE_TIMEOUT)
}

/// Shakes hands with a subscriber or a service's caller, and serves it until either side ends that.
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
    // A picture is whole when its last bytes are there: these must not wait for more.
    stream.set_nodelay(true)?;
    publication.serve(stream, wanted.get("callerid").unwrap_or_default())
}
