//! A published topic, with a queue and a thread for each subscriber.
//!
//! A message is encoded once and shared by all subscribers. A slow subscriber's oldest queued message is dropped; the
//! one being written is finished, because half a message cannot be taken back. A connection is closed only when the
//! peer has closed it or does not answer TCP's keep-alive, never for being slow.

use std::collections::VecDeque;
use std::io::{self, IoSlice, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, Weak};

use rustix::event::{eventfd, poll, EventfdFlags, PollFd, PollFlags};
use rustix::net::sockopt;

use rcs_messages::SharedBytes;
use rcs_process::lock;

use super::header::Header;
use crate::socket::{keep_alive, IDLE_TIMEOUT};

/// Send buffer, small because its content is old when a subscriber that was stopped reads on.
const SEND_BUFFER_BYTES: usize = 512 * 1024;

/// Description of a published topic.
#[derive(Clone, Debug)]
pub(crate) struct Description {
    /// Whole name.
    pub(crate) topic: String,
    /// Type, `package/Name`.
    pub(crate) ros_type: String,
    /// Checksum of the definition.
    pub(crate) md5sum: String,
    /// Text of the definition.
    pub(crate) definition: String,
    /// `true` if later subscribers get the last message.
    pub(crate) is_latching: bool,
    /// Queue size of each subscriber, at least 1.
    pub(crate) queue_size: usize,
    /// Number of the registration.
    pub(crate) number: u64,
}

impl Description {
    /// Checks that a subscriber wants this topic's type.
    pub(super) fn check(&self, wanted: &Header) -> Result<(), String> {
        if wanted.get("callerid").is_none() {
            return Err("the header has no callerid".to_owned());
        }
        // As for roscpp, the checksum counts and not the name of the type.
        match wanted.get("md5sum") {
            Some("*") => Ok(()),
            Some(theirs) if theirs == self.md5sum => Ok(()),
            theirs => {
                let Self { topic, ros_type, md5sum, .. } = self;
                let (theirs, their_type) = (theirs.unwrap_or("none"), wanted.get("type").unwrap_or("unknown type"));
                Err(format!("topic [{topic}] is {ros_type} with md5sum {md5sum}, not {their_type} with {theirs}"))
            }
        }
    }

    /// Header of the answer to a subscriber.
    pub(super) fn answer(&self, node_name: &str) -> Header {
        Header::new([
            ("callerid", node_name),
            ("topic", &self.topic),
            ("type", &self.ros_type),
            ("md5sum", &self.md5sum),
            ("message_definition", &self.definition),
            ("latching", if self.is_latching { "1" } else { "0" }),
        ])
    }
}

/// An encoded message, shared by all subscribers.
#[derive(Clone)]
pub(crate) struct EncodedMessage {
    /// Length and beginning of the message.
    head: Arc<[u8]>,
    /// Rest of the message, such as shared pixels.
    body: SharedBytes,
}

impl EncodedMessage {
    /// A message in two parts, of which the second is shared and not copied.
    ///
    /// # Errors
    /// `InvalidInput` for more than 4 GB.
    pub(crate) fn new(beginning: &[u8], body: SharedBytes) -> io::Result<Self> {
        let len = u32::try_from(beginning.len() + (*body).as_ref().len())
            .map_err(|_| io::Error::new(io::ErrorKind::InvalidInput, "a message of more than 4 GB"))?;
        let mut head = Vec::with_capacity(4 + beginning.len());
        head.extend_from_slice(&len.to_le_bytes());
        head.extend_from_slice(beginning);
        Ok(Self { head: head.into(), body })
    }

    fn len(&self) -> usize {
        self.head.len() + (*self.body).as_ref().len()
    }

    /// The message after the first `written` bytes.
    fn rest(&self, written: usize) -> [IoSlice<'_>; 2] {
        let head = self.head.get(written..).unwrap_or_default();
        let body = (*self.body).as_ref().get(written.saturating_sub(self.head.len())..).unwrap_or_default();
        [IoSlice::new(head), IoSlice::new(body)]
    }
}

/// Change of a topic's subscribers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// A node subscribed.
    Joined,
    /// A node's connection ended.
    Left,
}

/// Called with the change and the subscriber's name, on the subscriber's thread.
pub(crate) type Observer = Arc<dyn Fn(Change, &str) + Send + Sync>;

/// A published topic.
pub(crate) struct Publication {
    description: Description,
    subscribers: Mutex<Vec<Arc<Subscriber>>>,
    latched: Mutex<Option<EncodedMessage>>,
    is_closed: AtomicBool,
    /// Observers with their ids.
    observers: Mutex<Vec<(u64, Observer)>>,
    next_observer: AtomicU64,
}

/// A connection with a subscriber.
pub(crate) struct Subscriber {
    /// Name of the node.
    pub(crate) name: String,
    /// Address of the peer.
    pub(crate) peer: SocketAddr,
    /// Numbers of written bytes and messages.
    pub(crate) sent_bytes: AtomicU64,
    pub(crate) sent_messages: AtomicU64,
    queue: Mutex<VecDeque<EncodedMessage>>,
    /// Readable when a message is queued or the connection is to end.
    wake: OwnedFd,
    stream: TcpStream,
}

impl Subscriber {
    fn wake(&self) {
        // Fails only at the highest value, which wakes as well.
        let _ = rustix::io::write(&self.wake, &1_u64.to_ne_bytes());
    }

    /// `true` if no message is queued.
    pub(crate) fn is_idle(&self) -> bool {
        lock(&self.queue).is_empty()
    }

    fn push(&self, message: EncodedMessage, queue_size: usize) {
        {
            let mut queue = lock(&self.queue);
            while queue.len() >= queue_size {
                queue.pop_front();
            }
            queue.push_back(message);
        }
        self.wake();
    }
}

impl Publication {
    /// A topic without subscribers.
    pub(crate) fn new(description: Description) -> Arc<Self> {
        Arc::new(Self {
            description,
            subscribers: Mutex::default(),
            latched: Mutex::default(),
            is_closed: AtomicBool::new(false),
            observers: Mutex::default(),
            next_observer: AtomicU64::new(0),
        })
    }

    /// Description of the topic.
    pub(crate) fn description(&self) -> &Description {
        &self.description
    }

    /// Adds an observer of later changes. Returns its id.
    pub(crate) fn observe(&self, observer: &Observer) -> u64 {
        let id = self.next_observer.fetch_add(1, Ordering::Relaxed);
        lock(&self.observers).push((id, Arc::clone(observer)));
        id
    }

    /// Calls an observer for the present subscribers. One that joins meanwhile may be reported twice.
    pub(crate) fn report_present(&self, observer: &Observer) {
        self.subscribers().iter().for_each(|subscriber| observer(Change::Joined, &subscriber.name));
    }

    /// Removes an observer; `true` if none is left.
    pub(crate) fn forget(&self, id: u64) -> bool {
        let mut observers = lock(&self.observers);
        observers.retain(|(known, _)| *known != id);
        observers.is_empty()
    }

    fn report(&self, change: Change, name: &str) {
        // Without the lock, because an observer may publish.
        let observers: Vec<Observer> = lock(&self.observers).iter().map(|(_, observer)| Arc::clone(observer)).collect();
        observers.iter().for_each(|observer| observer(change, name));
    }

    /// Present subscribers.
    pub(crate) fn subscribers(&self) -> Vec<Arc<Subscriber>> {
        lock(&self.subscribers).clone()
    }

    /// Sends a message to all subscribers. Never waits.
    pub(crate) fn send(&self, message: &EncodedMessage) {
        if self.description.is_latching {
            // Locked, or a subscriber that joins now would get it twice or not at all.
            let mut latched = lock(&self.latched);
            *latched = Some(message.clone());
            self.push_to_all(message);
        } else {
            self.push_to_all(message);
        }
    }

    fn push_to_all(&self, message: &EncodedMessage) {
        for subscriber in &*lock(&self.subscribers) {
            subscriber.push(message.clone(), self.description.queue_size);
        }
    }

    /// Ends the connections of all subscribers.
    pub(crate) fn close(&self) {
        self.is_closed.store(true, Ordering::Release);
        for subscriber in self.subscribers() {
            // Fails if it has ended.
            let _ = subscriber.stream.shutdown(Shutdown::Both);
            subscriber.wake();
        }
    }

    /// Sends the messages of this topic over a connection until it ends.
    pub(super) fn serve(self: &Arc<Self>, stream: TcpStream, name: &str) -> io::Result<()> {
        keep_alive(&stream)?;
        sockopt::set_socket_send_buffer_size(&stream, SEND_BUFFER_BYTES)?;
        stream.set_nonblocking(true)?;
        let subscriber = Arc::new(Subscriber {
            name: name.to_owned(),
            peer: stream.peer_addr()?,
            sent_bytes: AtomicU64::new(0),
            sent_messages: AtomicU64::new(0),
            queue: Mutex::default(),
            wake: eventfd(0, EventfdFlags::NONBLOCK | EventfdFlags::CLOEXEC)?,
            stream,
        });
        {
            let latched = lock(&self.latched);
            if let Some(message) = &*latched {
                lock(&subscriber.queue).push_back(message.clone());
            }
            lock(&self.subscribers).push(Arc::clone(&subscriber));
        }
        self.report(Change::Joined, name);
        let publication: Weak<Self> = Arc::downgrade(self);
        let result = write_messages(&subscriber, &self.is_closed);
        // Upgraded only now, so that the thread does not keep the publication alive.
        if let Some(publication) = publication.upgrade() {
            lock(&publication.subscribers).retain(|known| !Arc::ptr_eq(known, &subscriber));
            publication.report(Change::Left, name);
        }
        result
    }
}

/// Events of a connection.
struct Woken {
    is_writable: bool,
    /// The peer has sent something or closed.
    is_readable: bool,
}

/// Waits for a message, for room in the socket if `wants_room`, for the connection's end, or for [`IDLE_TIMEOUT`].
fn wait(subscriber: &Subscriber, wants_room: bool) -> io::Result<Woken> {
    let interest = if wants_room { PollFlags::IN | PollFlags::OUT } else { PollFlags::IN };
    let mut descriptors =
        [PollFd::new(&subscriber.stream, interest | PollFlags::RDHUP), PollFd::new(&subscriber.wake, PollFlags::IN)];
    match poll(&mut descriptors, Some(&IDLE_TIMEOUT)) {
        Ok(_) | Err(rustix::io::Errno::INTR) => {}
        Err(error) => return Err(error.into()),
    }
    let [stream, wake] = descriptors.map(|descriptor| descriptor.revents());
    if wake.contains(PollFlags::IN) {
        // Resets it until the next message.
        let _ = rustix::io::read(&subscriber.wake, &mut [0_u8; 8]);
    }
    let ended = PollFlags::RDHUP | PollFlags::HUP | PollFlags::ERR;
    Ok(Woken { is_writable: stream.contains(PollFlags::OUT), is_readable: stream.intersects(ended | PollFlags::IN) })
}

/// Discards what a subscriber sends; an error if it has closed.
fn drain(mut stream: &TcpStream) -> io::Result<()> {
    let mut bytes = [0; 1024];
    loop {
        match stream.read(&mut bytes) {
            Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(_) => {}
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(()),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

fn write_messages(subscriber: &Subscriber, is_closed: &AtomicBool) -> io::Result<()> {
    let mut stream = &subscriber.stream;
    while !is_closed.load(Ordering::Acquire) {
        let message = lock(&subscriber.queue).pop_front();
        let Some(message) = message else {
            if wait(subscriber, false)?.is_readable {
                drain(stream)?;
            }
            continue;
        };
        let mut written = 0;
        while written < message.len() {
            match stream.write_vectored(&message.rest(written)) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(len) => {
                    written += len;
                    subscriber.sent_bytes.fetch_add(len as u64, Ordering::Relaxed);
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                    while !is_closed.load(Ordering::Acquire) {
                        let woken = wait(subscriber, true)?;
                        if woken.is_readable {
                            drain(stream)?;
                        }
                        if woken.is_writable {
                            break;
                        }
                    }
                    if is_closed.load(Ordering::Acquire) {
                        return Ok(());
                    }
                }
                Err(error) => return Err(error),
            }
        }
        subscriber.sent_messages.fetch_add(1, Ordering::Relaxed);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::listener::Listener;
    use super::*;
    use crate::socket::TEST_PATIENCE;
    use std::sync::mpsc::{channel, Receiver};
    use std::time::{Duration, Instant};

    fn description(is_latching: bool) -> Description {
        Description {
            topic: "/view/image".to_owned(),
            ros_type: "sensor_msgs/Image".to_owned(),
            md5sum: "060021388200f6f0f447d0fcd9c64743".to_owned(),
            definition: "uint32 x".to_owned(),
            is_latching,
            queue_size: 1,
            number: 0,
        }
    }

    struct Bench {
        listener: Listener,
        publication: Arc<Publication>,
        changes: Receiver<(Change, String)>,
    }

    impl Bench {
        fn start(is_latching: bool) -> Self {
            let listener = Listener::start("127.0.0.1:0".parse().unwrap(), "/camera_stream").unwrap();
            let (sender, changes) = channel();
            let publication = Publication::new(description(is_latching));
            let sender = Mutex::new(sender);
            let observer: Observer = Arc::new(move |change, name: &str| {
                let _ = lock(&sender).send((change, name.to_owned()));
            });
            publication.observe(&observer);
            listener.add(Arc::clone(&publication));
            Self { listener, publication, changes }
        }

        fn connect(&self, name: &str, md5sum: &str) -> (TcpStream, Header) {
            let mut stream = TcpStream::connect(("127.0.0.1", self.listener.port())).unwrap();
            let fields =
                [("callerid", name), ("topic", "/view/image"), ("md5sum", md5sum), ("type", "sensor_msgs/Image")];
            Header::new(fields).write(&mut stream, TEST_PATIENCE).unwrap();
            let answer = Header::read(&mut stream, Instant::now() + TEST_PATIENCE).unwrap();
            stream.set_read_timeout(Some(TEST_PATIENCE)).unwrap();
            (stream, answer)
        }

        fn subscribe(&self, name: &str) -> TcpStream {
            let stream = self.connect(name, "*").0;
            let joined = self.changes.recv_timeout(TEST_PATIENCE).unwrap();
            assert_eq!(joined, (Change::Joined, name.to_owned()));
            stream
        }

        /// Sends a message of `len` equal bytes.
        fn send(&self, value: u8, len: usize) {
            self.publication.send(&EncodedMessage::new(&[value], Arc::new(vec![value; len - 1])).unwrap());
        }
    }

    fn receive(stream: &mut TcpStream) -> Vec<u8> {
        let mut len = [0; 4];
        stream.read_exact(&mut len).unwrap();
        let mut bytes = vec![0; u32::from_le_bytes(len) as usize];
        stream.read_exact(&mut bytes).unwrap();
        bytes
    }

    #[test]
    fn a_message_reaches_every_subscriber_and_wrong_ones_are_told_why() {
        let bench = Bench::start(false);
        let mut viewers: Vec<TcpStream> = (0..50).map(|index| bench.subscribe(&format!("/viewer{index}"))).collect();
        bench.send(7, 100_000);
        for viewer in &mut viewers {
            assert_eq!(receive(viewer), vec![7; 100_000]);
        }
        let (_, answer) = bench.connect("/wrong", "0123");
        assert!(answer.get("error").unwrap().contains("md5sum"), "{answer:?}");
        let (_, answer) = bench.connect("/right", "060021388200f6f0f447d0fcd9c64743");
        assert_eq!(answer.get("latching"), Some("0"));
    }

    #[test]
    fn the_end_of_a_message_never_waits_for_more() {
        let bench = Bench::start(false);
        // Without `tcp_nodelay=1` in the request, and with it.
        let _plain = bench.subscribe("/plain");
        let mut stream = TcpStream::connect(("127.0.0.1", bench.listener.port())).unwrap();
        let fields = [("callerid", "/quick"), ("topic", "/view/image"), ("md5sum", "*"), ("tcp_nodelay", "1")];
        Header::new(fields).write(&mut stream, TEST_PATIENCE).unwrap();
        assert_eq!(bench.changes.recv_timeout(TEST_PATIENCE).unwrap().1, "/quick");
        let subscribers = bench.publication.subscribers();
        assert_eq!(subscribers.len(), 2);
        assert!(subscribers.iter().all(|subscriber| subscriber.stream.nodelay().unwrap()));
    }

    #[test]
    fn a_subscriber_that_vanished_without_a_word_is_noticed_after_three_minutes_of_silence() {
        let bench = Bench::start(false);
        let _viewer = bench.subscribe("/viewer");
        let stream = &bench.publication.subscribers()[0].stream;
        assert!(sockopt::socket_keepalive(stream).unwrap());
        let idle = sockopt::tcp_keepidle(stream).unwrap();
        let (period, probes) = (sockopt::tcp_keepintvl(stream).unwrap(), sockopt::tcp_keepcnt(stream).unwrap());
        assert_eq!(idle + probes * period, Duration::from_secs(180), "{idle:?} {probes} {period:?}");
        // No earlier timeout than TCP's, because a viewer may be stopped.
        assert_eq!(sockopt::tcp_user_timeout(stream).unwrap(), 0);
    }

    #[test]
    fn one_that_does_not_read_holds_up_nobody_and_then_gets_the_newest() {
        const LEN: usize = 3_000_000;
        let bench = Bench::start(false);
        let (mut stopped, mut good) = (bench.subscribe("/stopped"), bench.subscribe("/good"));
        for value in 0..40 {
            bench.send(value, LEN);
            assert_eq!(receive(&mut good)[0], value);
        }
        // First what the kernel had buffered, and then the newest.
        let values: Vec<u8> =
            std::iter::repeat_with(|| receive(&mut stopped)[0]).take_while(|value| *value != 39).collect();
        assert!(values.len() <= 4, "{values:?}");
    }

    #[test]
    fn a_subscriber_that_leaves_is_noticed_at_once() {
        let bench = Bench::start(false);
        drop(bench.subscribe("/viewer"));
        assert_eq!(bench.changes.recv_timeout(TEST_PATIENCE), Ok((Change::Left, "/viewer".to_owned())));
        assert!(bench.publication.subscribers().is_empty());
        // Also while it is being sent to.
        let viewer = bench.subscribe("/busy");
        bench.send(1, 50_000_000);
        drop(viewer);
        assert_eq!(bench.changes.recv_timeout(TEST_PATIENCE), Ok((Change::Left, "/busy".to_owned())));
    }

    #[test]
    fn a_late_subscriber_gets_what_is_latched() {
        let bench = Bench::start(true);
        bench.send(1, 10);
        bench.send(2, 10);
        let (mut viewer, answer) = bench.connect("/late", "*");
        assert!(answer.is_on("latching"));
        assert_eq!(receive(&mut viewer), [2; 10]);
    }

    #[test]
    fn closing_ends_connections_also_of_those_that_do_not_read() {
        let bench = Bench::start(false);
        let mut stopped = bench.subscribe("/stopped");
        bench.send(1, 50_000_000);
        bench.listener.remove("/view/image");
        assert_eq!(bench.changes.recv_timeout(TEST_PATIENCE).unwrap().0, Change::Left);
        drop(bench.listener);
        while stopped.read(&mut [0; 65536]).is_ok_and(|len| len > 0) {}
    }
}
