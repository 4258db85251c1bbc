//! A subscribed topic, with a thread for each publisher.
//!
//! A publisher is known by the address of its node. Its thread requests the topic from the node, connects and reads.
//! Failures are retried after a quarter of a second and then less often, at least every other second, as long as the
//! master names the publisher.

use std::collections::BTreeMap;
use std::io::{self, Read};
use std::net::{Shutdown, SocketAddr, TcpStream, ToSocketAddrs};
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use rcs_process::{lock, IDLE_PERIOD};

use super::header::Header;
use crate::acceptor::Counted;
use crate::socket::keep_alive;
use crate::xmlrpc::client::{connect, in_order};
use crate::xmlrpc::{call, CallError, Value};

/// Timeout of another node's answer. rospy accepts one connection after the other, so a busy node takes seconds.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(10);
const FIRST_RETRY: Duration = Duration::from_millis(250);
const LONGEST_RETRY: Duration = Duration::from_secs(2);
/// Retry period of a publisher that refuses, because each try is an error in its log.
const REFUSED_RETRY: Duration = Duration::from_secs(60);
/// Age from which a connection counts as good, so that its next break is retried at once.
const SETTLED: Duration = Duration::from_secs(5);
/// Longest message, as in roscpp.
const MAX_MESSAGE_BYTES: u32 = 1_000_000_000;
/// Most memory allocated for an announced length before its bytes have come.
const FIRST_ROOM_BYTES: usize = 16 << 20;
const STACK_BYTES: usize = 1 << 20;
/// Most threads of a topic, those of former publishers that wait for an answer included.
const MOST_THREADS: usize = 512;

/// Description of a subscription.
#[derive(Clone, Debug)]
pub(crate) struct Wanted {
    /// Whole name of the topic.
    pub(crate) topic: Arc<str>,
    /// Type, `package/Name`.
    pub(crate) ros_type: String,
    /// Checksum of the definition.
    pub(crate) md5sum: String,
    /// Text of the definition.
    pub(crate) definition: String,
    /// Name of the subscribing node.
    pub(crate) node_name: String,
    /// Number of the registration.
    pub(crate) number: u64,
}

/// A publisher by its connection header.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Source {
    /// Name of the node.
    pub(crate) name: Arc<str>,
    /// `true` if it latches.
    pub(crate) is_latching: bool,
    /// Number of the connection.
    pub(crate) connection: u64,
}

/// Receiver of a topic's messages, called on the publisher's thread.
pub(crate) trait Handler: Send + Sync {
    /// Reports, once until it answers, that a publisher's node does not answer. May wait for the master.
    fn contact_failed(&self, uri: &str, reason: &str);

    /// Reports, once until it is connected, that a publisher cannot be connected with.
    fn connection_failed(&self);

    /// Reports that a publisher's node has answered.
    fn contacted(&self, uri: &str);

    /// Reports a new connection.
    fn connected(&self, source: &Source);

    /// Takes the bytes of a message, without its length.
    fn message(&self, bytes: Vec<u8>, source: &Source);

    /// Reports the end of a connection.
    fn disconnected(&self, source: &Source);
}

/// A subscribed topic, until it is dropped.
pub(crate) struct Subscription {
    wanted: Arc<Wanted>,
    handler: Arc<dyn Handler>,
    links: Mutex<Links>,
    /// Number of threads, those of ending links included.
    threads: Arc<AtomicUsize>,
}

/// Publishers of a topic.
#[derive(Default)]
struct Links {
    /// Links by the addresses of the nodes.
    by_uri: BTreeMap<String, Arc<Link>>,
    /// Publishers named by the master.
    named: Vec<String>,
    /// No connections are wanted.
    is_paused: bool,
}

/// The connection with a publisher, or the attempts to connect.
pub(crate) struct Link {
    /// Address of the publisher's node.
    pub(crate) uri: String,
    /// Numbers of received bytes and messages.
    pub(crate) received_bytes: AtomicU64,
    pub(crate) received_messages: AtomicU64,
    /// Connection and publisher, while connected.
    connection: Mutex<Option<(TcpStream, Source)>>,
    /// The last attempt to connect failed, or the connection broke.
    has_failed: AtomicBool,
    is_ended: AtomicBool,
    ended: Condvar,
    waiting: Mutex<()>,
}

/// A publisher cannot be connected with.
#[derive(Debug, thiserror::Error)]
enum LinkError {
    #[error("its node at {uri} does not say where it publishes: {error}")]
    Ask { uri: String, error: CallError },
    #[error("cannot connect to {address}: {error}")]
    Connect { address: String, error: io::Error },
    #[error("no connection header from {address}: {error}")]
    Header { address: String, error: io::Error },
    #[error("{0}")]
    Refused(String),
    #[error("the connection broke: {0}")]
    Broken(io::Error),
}

impl Link {
    /// Name and address of the publisher, while connected.
    pub(crate) fn connected(&self) -> Option<(Arc<str>, SocketAddr)> {
        let connection = lock(&self.connection);
        let (stream, source) = connection.as_ref()?;
        Some((Arc::clone(&source.name), stream.peer_addr().ok()?))
    }

    /// `true` if connected, or if the first attempt has not failed.
    pub(crate) fn is_promising(&self) -> bool {
        !self.has_failed.load(Ordering::Acquire)
    }

    fn is_ended(&self) -> bool {
        self.is_ended.load(Ordering::Acquire)
    }

    fn end(&self) {
        self.is_ended.store(true, Ordering::Release);
        if let Some((stream, _)) = &*lock(&self.connection) {
            // Fails if it has ended.
            let _ = stream.shutdown(Shutdown::Both);
        }
        drop(lock(&self.waiting));
        self.ended.notify_all();
    }

    /// Sleeps until the link ends, at most for `duration`.
    fn sleep(&self, duration: Duration) {
        let waited = self.ended.wait_timeout_while(lock(&self.waiting), duration, |()| !self.is_ended());
        drop(waited.unwrap_or_else(PoisonError::into_inner));
    }
}

impl Subscription {
    /// A topic without publishers.
    pub(crate) fn new(wanted: Wanted, handler: Arc<dyn Handler>) -> Self {
        Self { wanted: Arc::new(wanted), handler, links: Mutex::default(), threads: Arc::default() }
    }

    /// Topic and type.
    pub(crate) fn wanted(&self) -> &Wanted {
        &self.wanted
    }

    /// All links.
    pub(crate) fn links(&self) -> Vec<Arc<Link>> {
        lock(&self.links).by_uri.values().cloned().collect()
    }

    /// Connects with these publishers and ends all other connections.
    pub(crate) fn set_publishers(&self, uris: &[String]) {
        let mut links = lock(&self.links);
        links.named = uris.to_vec();
        self.connect(&mut links);
    }

    /// Ends all connections until it is called with `false`; the registration stays.
    pub(crate) fn set_paused(&self, is_paused: bool) {
        let mut links = lock(&self.links);
        links.is_paused = is_paused;
        self.connect(&mut links);
    }

    /// Retries publishers for which no thread was available.
    pub(crate) fn connect_missing(&self) {
        self.connect(&mut lock(&self.links));
    }

    /// Starts and ends links, so that there is one for each wanted publisher.
    fn connect(&self, Links { by_uri, named, is_paused }: &mut Links) {
        let wanted = if *is_paused { &[] } else { named.as_slice() };
        by_uri.retain(|uri, link| {
            let stays = wanted.contains(uri);
            if !stays {
                link.end();
            }
            stays
        });
        for uri in wanted {
            if !by_uri.contains_key(uri) {
                if let Some(link) = self.start(uri) {
                    by_uri.insert(uri.clone(), link);
                }
            }
        }
    }

    fn start(&self, uri: &str) -> Option<Arc<Link>> {
        let counted = Counted::new(&self.threads, MOST_THREADS)?;
        let link = Arc::new(Link {
            uri: uri.to_owned(),
            received_bytes: AtomicU64::new(0),
            received_messages: AtomicU64::new(0),
            connection: Mutex::default(),
            has_failed: AtomicBool::new(false),
            is_ended: AtomicBool::new(false),
            ended: Condvar::new(),
            waiting: Mutex::default(),
        });
        let (own, wanted, handler) = (Arc::clone(&link), Arc::clone(&self.wanted), Arc::clone(&self.handler));
        let reading = move || {
            let _counted = counted;
            read_until_ended(&own, &wanted, &*handler);
        };
        let builder = std::thread::Builder::new().name("tcpros-pub".to_owned()).stack_size(STACK_BYTES);
        match builder.spawn(reading) {
            Ok(_) => Some(link),
            Err(error) => {
                log::error!("{}: no thread to read from {uri}: {error}", self.wanted.topic);
                None
            }
        }
    }
}

impl Drop for Subscription {
    fn drop(&mut self) {
        for link in self.links() {
            link.end();
        }
    }
}

/// A panic, which the panic hook logs, counts as a broken connection.
fn read_until_ended(link: &Link, wanted: &Wanted, handler: &dyn Handler) {
    while catch_unwind(AssertUnwindSafe(|| keep_connected(link, wanted, handler))).is_err() {
        link.has_failed.store(true, Ordering::Release);
        let connection = lock(&link.connection).take();
        if let Some((_, source)) = connection {
            // The handler may panic as well.
            let _ = catch_unwind(AssertUnwindSafe(|| handler.disconnected(&source)));
        }
        link.sleep(LONGEST_RETRY);
    }
}

fn keep_connected(link: &Link, wanted: &Wanted, handler: &dyn Handler) {
    let mut retry = FIRST_RETRY;
    let (mut is_logged, mut is_reported) = (false, false);
    while !link.is_ended() {
        let (result, stood_for) = match connect_to(link, wanted, handler) {
            Ok((stream, source)) => {
                let begin = Instant::now();
                let result = read_messages(link, stream, &source, wanted, handler, &mut is_logged);
                lock(&link.connection).take();
                handler.disconnected(&source);
                (result, begin.elapsed())
            }
            Err(error) => (Err(error), Duration::ZERO),
        };
        let Err(error) = result else { return };
        link.has_failed.store(true, Ordering::Release);
        if link.is_ended() {
            return;
        }
        if stood_for >= SETTLED {
            retry = FIRST_RETRY;
        }
        let was_connected = matches!(error, LinkError::Broken(_));
        if !was_connected && !is_reported {
            handler.connection_failed();
        }
        is_reported = !was_connected;
        let is_refusal = matches!(&error, LinkError::Refused(_) | LinkError::Ask { error: CallError::Refused(_), .. });
        match &error {
            // The publisher may be ending, which the master will report.
            LinkError::Broken(_) => log::debug!("{}: {error}", wanted.topic),
            // The whole node does not answer.
            LinkError::Ask { uri, error } if !error.is_answer() && retry > FIRST_RETRY && !is_logged => {
                handler.contact_failed(uri, &error.to_string());
                is_logged = true;
            }
            _ if retry > FIRST_RETRY && !is_logged => {
                log::warn!("{}: no connection with the publisher: {error}", wanted.topic);
                is_logged = true;
            }
            _ => log::debug!("{}: {error}", wanted.topic),
        }
        link.sleep(if is_refusal && is_logged { REFUSED_RETRY } else { retry });
        retry = (retry * 2).min(LONGEST_RETRY);
    }
}

/// Requests a topic from a node; host and port.
fn ask(uri: &str, wanted: &Wanted) -> Result<(String, u16), CallError> {
    let protocols = Value::Array(vec![Value::Array(vec!["TCPROS".into()])]);
    let params = [wanted.node_name.as_str().into(), (&*wanted.topic).into(), protocols];
    let answer = call(uri, "requestTopic", &params, ANSWER_TIMEOUT)?;
    match answer.as_array() {
        Some([Value::String(protocol), Value::String(host), Value::Int(port)]) if protocol == "TCPROS" => {
            match u16::try_from(*port) {
                Ok(port) => Ok((host.clone(), port)),
                Err(_) => Err(CallError::Refused(format!("port {port}"))),
            }
        }
        _ => Err(CallError::Refused("it offers no TCPROS".to_owned())),
    }
}

fn connect_to(link: &Link, wanted: &Wanted, handler: &dyn Handler) -> Result<(TcpStream, Source), LinkError> {
    let (host, port) = ask(&link.uri, wanted).map_err(|error| LinkError::Ask { uri: link.uri.clone(), error })?;
    handler.contacted(&link.uri);
    let address = format!("{host}:{port}");
    let failed = |error| LinkError::Connect { address: address.clone(), error };
    #[expect(clippy::disallowed_methods, reason = "the resolver has limits, and the caller is a thread of its own")]
    let addresses = in_order((host.as_str(), port).to_socket_addrs().map_err(failed)?);
    let mut stream = connect(&addresses, Instant::now() + ANSWER_TIMEOUT).map_err(failed)?;
    let request = Header::new([
        ("callerid", wanted.node_name.as_str()),
        ("topic", &wanted.topic),
        ("type", &wanted.ros_type),
        ("md5sum", &wanted.md5sum),
        ("message_definition", &wanted.definition),
        ("tcp_nodelay", "1"),
    ]);
    let failed = |error| LinkError::Header { address: address.clone(), error };
    request.write(&mut stream, ANSWER_TIMEOUT).map_err(failed)?;
    let answer = Header::read(&mut stream, Instant::now() + ANSWER_TIMEOUT).map_err(failed)?;
    if let Some(error) = answer.get("error") {
        return Err(LinkError::Refused(error.to_owned()));
    }
    // As for roscpp, the checksum counts and not the name of the type.
    if let Some(theirs) = answer.get("md5sum").filter(|theirs| *theirs != "*" && *theirs != wanted.md5sum) {
        let publisher = answer.get("callerid").unwrap_or(&address);
        let their_type = answer.get("type").unwrap_or("unknown type");
        let Wanted { ros_type, md5sum, .. } = wanted;
        let reason = format!("{publisher} publishes {their_type} with md5sum {theirs}, not {ros_type} with {md5sum}");
        return Err(LinkError::Refused(reason));
    }
    let name = answer.get("callerid").unwrap_or_default().into();
    static NEXT: AtomicU64 = AtomicU64::new(0);
    let connection = NEXT.fetch_add(1, Ordering::Relaxed);
    Ok((stream, Source { name, is_latching: answer.is_on("latching"), connection }))
}

/// Reads until the connection or the link ends, of which the latter is no error.
fn read_messages(
    link: &Link,
    mut stream: TcpStream,
    source: &Source,
    wanted: &Wanted,
    handler: &dyn Handler,
    is_logged: &mut bool,
) -> Result<(), LinkError> {
    stream.set_read_timeout(Some(IDLE_PERIOD)).map_err(LinkError::Broken)?;
    keep_alive(&stream).map_err(LinkError::Broken)?;
    let shared = stream.try_clone().map_err(LinkError::Broken)?;
    *lock(&link.connection) = Some((shared, source.clone()));
    link.has_failed.store(false, Ordering::Release);
    if std::mem::take(is_logged) {
        log::info!("{}: connected with {}", wanted.topic, source.name);
    }
    handler.connected(source);
    while !link.is_ended() {
        let bytes = match read_message(&mut stream, &|| link.is_ended()) {
            Ok(bytes) => bytes,
            Err(_) if link.is_ended() => return Ok(()),
            Err(error) => return Err(LinkError::Broken(error)),
        };
        link.received_bytes.fetch_add(bytes.len() as u64 + 4, Ordering::Relaxed);
        link.received_messages.fetch_add(1, Ordering::Relaxed);
        // A message that was in transit when its publisher left is dropped.
        if !link.is_ended() {
            handler.message(bytes, source);
        }
    }
    Ok(())
}

/// Reads a message without a time limit. After each timeout of a read, `is_ended` is checked.
fn read_message(stream: &mut impl Read, is_ended: &dyn Fn() -> bool) -> io::Result<Vec<u8>> {
    let mut head = Vec::with_capacity(4);
    read_up_to(stream, 4, &mut head, is_ended)?;
    let len = head.try_into().map_or(0, u32::from_le_bytes);
    if len > MAX_MESSAGE_BYTES {
        return Err(io::Error::new(io::ErrorKind::InvalidData, format!("a message of {len} bytes is announced")));
    }
    let mut bytes = Vec::with_capacity((len as usize).min(FIRST_ROOM_BYTES));
    read_up_to(stream, len as usize, &mut bytes, is_ended)?;
    Ok(bytes)
}

/// Reads until there are `len` bytes.
fn read_up_to(stream: &mut impl Read, len: usize, bytes: &mut Vec<u8>, is_ended: &dyn Fn() -> bool) -> io::Result<()> {
    while bytes.len() < len {
        let rest = (len - bytes.len()) as u64;
        match stream.take(rest).read_to_end(bytes) {
            Ok(read) if (read as u64) < rest => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(_) => {}
            // The bytes read so far are kept.
            Err(error) if error.kind() == io::ErrorKind::WouldBlock && !is_ended() => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
