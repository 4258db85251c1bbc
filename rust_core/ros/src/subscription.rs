//! A topic that the node subscribes to: one thread for each publisher that the master lists.
//!
//! A thread asks its publisher for an address, connects, reads messages, and starts again when the connection breaks,
//! waiting a little longer each time, until the master no longer lists the publisher.

use crate::header::Header;
use crate::master::request_topic;
use crate::node::Inner;
use crate::TypeInfo;
use std::collections::BTreeMap;
use std::io::{self, BufReader, Read};
use std::net::{Shutdown, TcpStream, ToSocketAddrs};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

/// For connecting and for the other side's header.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);
const FIRST_RETRY: Duration = Duration::from_millis(100);
const LAST_RETRY: Duration = Duration::from_secs(5);
/// roscpp takes a longer message for lost synchronisation, and so do we.
const MAX_MESSAGE_LEN: u32 = 1_000_000_000;
/// How much is allocated on the word of a length alone.
const TRUSTED_LEN: usize = 32 << 20;

/// A received message.
#[derive(Debug)]
pub struct Incoming<'a> {
    /// The message's bytes, without the length before them.
    pub bytes: Vec<u8>,
    /// Name of the publishing node.
    pub publisher: &'a Arc<str>,
    /// Whether the publisher latches its messages.
    pub latching: bool,
}

pub(crate) type MessageHandler = Box<dyn Fn(Incoming<'_>) + Send + Sync>;

pub(crate) struct Topic {
    pub(crate) name: String,
    pub(crate) type_info: TypeInfo,
    node_name: String,
    node_uri: String,
    on_message: MessageHandler,
    sources: Mutex<BTreeMap<String, Arc<Source>>>,
}

/// One publisher of a topic.
#[derive(Debug, Default)]
struct Source {
    state: Mutex<SourceState>,
    stopped: Condvar,
}

#[derive(Debug, Default)]
struct SourceState {
    stop: bool,
    stream: Option<TcpStream>,
    publisher: Option<Arc<str>>,
}

impl Topic {
    pub(crate) fn new(
        name: String,
        type_info: TypeInfo,
        node_name: &str,
        node_uri: &str,
        on_message: MessageHandler,
    ) -> Self {
        Self {
            name,
            type_info,
            node_name: node_name.to_owned(),
            node_uri: node_uri.to_owned(),
            on_message,
            sources: Mutex::default(),
        }
    }

    /// Takes the master's list of publishers: connects to new ones and leaves those that are not in it.
    pub(crate) fn set_publishers(self: &Arc<Self>, uris: &[String]) {
        let mut sources = self.lock();
        sources.retain(|uri, source| {
            let listed = uris.contains(uri);
            if !listed {
                source.stop();
            }
            listed
        });
        drop(sources);
        self.add_publishers(uris);
    }

    /// Connects to those publishers that are new.
    pub(crate) fn add_publishers(self: &Arc<Self>, uris: &[String]) {
        let mut sources = self.lock();
        for uri in uris {
            // A node that publishes what it subscribes to does not listen to itself.
            if *uri == self.node_uri || sources.contains_key(uri) {
                continue;
            }
            let source = Arc::new(Source::default());
            let (topic, uri_of_thread, source_of_thread) = (Arc::clone(self), uri.clone(), Arc::clone(&source));
            let spawned = std::thread::Builder::new()
                .name("ros-subscribe".to_owned())
                .spawn(move || topic.follow(&uri_of_thread, &source_of_thread));
            match spawned {
                Ok(_) => {
                    sources.insert(uri.clone(), source);
                }
                Err(error) => log::error!("cannot subscribe to {} of {uri}: {error}", self.name),
            }
        }
    }

    pub(crate) fn close(self: &Arc<Self>) {
        self.set_publishers(&[]);
    }

    /// The names of the publishers that are connected now.
    pub(crate) fn publishers(&self) -> Vec<Arc<str>> {
        let sources: Vec<_> = self.lock().values().cloned().collect();
        sources.iter().filter_map(|source| source.lock().publisher.clone()).collect()
    }

    /// Stays with one publisher until told to stop.
    fn follow(&self, uri: &str, source: &Source) {
        let mut retry = FIRST_RETRY;
        let mut said = String::new();
        loop {
            let result = self.connect(uri, source).and_then(|connection| {
                retry = FIRST_RETRY;
                said.clear();
                self.read_messages(connection, source)
            });
            {
                let mut state = source.lock();
                state.stream = None;
                state.publisher = None;
            }
            if let Err(error) = result {
                let text = error.to_string();
                // A publisher that ends is no news, one that cannot be reached or agreed with is, once.
                if error.kind() != io::ErrorKind::UnexpectedEof && text != said && !source.lock().stop {
                    log::warn!("{}: publisher {uri}: {text}", self.name);
                    said = text;
                }
            }
            if source.wait(retry) {
                return;
            }
            retry = (retry * 2).min(LAST_RETRY);
        }
    }

    fn connect(&self, uri: &str, source: &Source) -> io::Result<Connection> {
        let (host, port) = request_topic(uri, &self.node_name, &self.name).map_err(io::Error::other)?;
        let mut stream = connect_to(&host, port)?;
        let request = Header::new([
            ("callerid", self.node_name.as_str()),
            ("md5sum", &self.type_info.md5sum),
            ("message_definition", &self.type_info.definition),
            ("tcp_nodelay", "1"),
            ("topic", &self.name),
            ("type", &self.type_info.name),
        ]);
        request.write(&mut stream)?;
        let answer = Header::read(&mut stream)?;
        if let Some(error) = answer.get("error") {
            return Err(io::Error::other(error.to_owned()));
        }
        answer.check_type(&self.type_info).map_err(io::Error::other)?;
        stream.set_read_timeout(None)?;
        let publisher: Arc<str> = answer.get("callerid").unwrap_or_default().into();
        let mut state = source.lock();
        if state.stop {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        state.stream = Some(stream.try_clone()?);
        state.publisher = Some(Arc::clone(&publisher));
        Ok(Connection {
            reader: BufReader::with_capacity(64 << 10, stream),
            publisher,
            latching: answer.is_set("latching"),
        })
    }

    fn read_messages(&self, mut connection: Connection, source: &Source) -> io::Result<()> {
        loop {
            let bytes = read_message(&mut connection.reader)?;
            if source.lock().stop {
                return Ok(());
            }
            (self.on_message)(Incoming { bytes, publisher: &connection.publisher, latching: connection.latching });
        }
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, Arc<Source>>> {
        self.sources.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

struct Connection {
    reader: BufReader<TcpStream>,
    publisher: Arc<str>,
    latching: bool,
}

impl Source {
    fn stop(&self) {
        let mut state = self.lock();
        state.stop = true;
        if let Some(stream) = state.stream.take() {
            // Fails only when the connection is gone already.
            let _ = stream.shutdown(Shutdown::Both);
        }
        drop(state);
        self.stopped.notify_all();
    }

    /// Waits; true when told to stop.
    fn wait(&self, time: Duration) -> bool {
        let waited = self.stopped.wait_timeout_while(self.lock(), time, |state| !state.stop);
        waited.unwrap_or_else(PoisonError::into_inner).0.stop
    }

    fn lock(&self) -> MutexGuard<'_, SourceState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Tries each address of `host` in turn.
fn connect_to(host: &str, port: u16) -> io::Result<TcpStream> {
    let mut last = io::Error::new(io::ErrorKind::NotFound, format!("{host} has no address"));
    let addresses =
        (host, port).to_socket_addrs().map_err(|error| io::Error::new(error.kind(), format!("{host}: {error}")))?;
    for address in addresses {
        match TcpStream::connect_timeout(&address, CONNECT_TIMEOUT) {
            Ok(stream) => {
                stream.set_nodelay(true)?;
                stream.set_read_timeout(Some(CONNECT_TIMEOUT))?;
                stream.set_write_timeout(Some(CONNECT_TIMEOUT))?;
                // A machine that was switched off sends no end; this finds out within two minutes.
                let keepalive = socket2::TcpKeepalive::new()
                    .with_time(Duration::from_secs(60))
                    .with_interval(Duration::from_secs(10));
                socket2::SockRef::from(&stream).set_tcp_keepalive(&keepalive)?;
                return Ok(stream);
            }
            Err(error) => last = io::Error::new(error.kind(), format!("{address}: {error}")),
        }
    }
    Err(last)
}

/// Reads one message, its length first.
fn read_message(reader: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut len = [0; 4];
    reader.read_exact(&mut len)?;
    let len = u32::from_le_bytes(len);
    if len > MAX_MESSAGE_LEN {
        let text = format!("message of {len} bytes announced: connection out of step");
        return Err(io::Error::new(io::ErrorKind::InvalidData, text));
    }
    let mut bytes = Vec::with_capacity((len as usize).min(TRUSTED_LEN));
    reader.take(u64::from(len)).read_to_end(&mut bytes)?;
    if bytes.len() == len as usize {
        Ok(bytes)
    } else {
        Err(io::ErrorKind::UnexpectedEof.into())
    }
}

/// Keeps a topic subscribed until it is dropped.
pub struct Subscription {
    pub(crate) topic: Arc<Topic>,
    pub(crate) node: Weak<Inner>,
}

impl Subscription {
    /// The topic's whole name.
    pub fn topic(&self) -> &str {
        &self.topic.name
    }

    /// The names of the publishers that are connected now.
    pub fn publishers(&self) -> Vec<Arc<str>> {
        self.topic.publishers()
    }
}

impl Drop for Subscription {
    fn drop(&mut self) {
        if let Some(node) = self.node.upgrade() {
            node.remove_subscription(&self.topic);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_longer_than_announced_is_left_for_the_next() {
        let mut stream = [2, 0, 0, 0, 1, 2, 1, 0, 0, 0, 9].as_slice();
        assert_eq!(read_message(&mut stream).unwrap(), [1, 2]);
        assert_eq!(read_message(&mut stream).unwrap(), [9]);
    }

    #[test]
    fn a_giant_length_ends_the_connection_and_allocates_little() {
        let error = read_message(&mut [0xff, 0xff, 0xff, 0xff, 1].as_slice()).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidData);
        let error = read_message(&mut [0, 0, 0, 0x30, 1].as_slice()).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
    }
}
