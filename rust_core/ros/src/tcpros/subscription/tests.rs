//! Connections with publishers that a test plays.

use super::*;
use crate::socket::TEST_PATIENCE;
use crate::xmlrpc::{parse_call, Server};
use std::io::Write;
use std::net::TcpListener;
use std::sync::mpsc::{channel, Receiver, Sender};

/// A publisher whose behaviour a test decides: an address to ask, and a port that is accepted from by hand.
struct Publisher {
    server: Server,
    listener: TcpListener,
}

impl Publisher {
    fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = i32::from(listener.local_addr().unwrap().port());
        let server = Server::start("publisher", "127.0.0.1:0".parse().unwrap(), move |text| {
            assert_eq!(parse_call(text).unwrap().0, "requestTopic");
            let place = vec!["TCPROS".into(), "127.0.0.1".into(), Value::Int(port)];
            Value::Array(vec![Value::Int(1), "".into(), Value::Array(place)])
        });
        Self { server: server.unwrap(), listener }
    }

    fn uri(&self) -> String {
        format!("http://{}/", self.server.address())
    }

    fn accept(&self) -> TcpStream {
        self.accept_request().0
    }

    /// A connection, with what the subscriber requested.
    fn accept_request(&self) -> (TcpStream, Header) {
        let (mut stream, _) = self.listener.accept().unwrap();
        let request = Header::read(&mut stream, Instant::now() + TEST_PATIENCE).unwrap();
        Header::new([("callerid", "/talker"), ("md5sum", "abc"), ("type", "a/B"), ("latching", "1")])
            .write(&mut stream, TEST_PATIENCE)
            .unwrap();
        (stream, request)
    }
}

/// Collects messages, and counts reports of failed connections.
struct Collect(Mutex<Sender<(Vec<u8>, Source)>>, Arc<AtomicUsize>);

impl Handler for Collect {
    fn contact_failed(&self, _uri: &str, _reason: &str) {}

    fn connection_failed(&self) {
        self.1.fetch_add(1, Ordering::AcqRel);
    }

    fn contacted(&self, _uri: &str) {}

    fn connected(&self, _source: &Source) {}

    fn message(&self, bytes: Vec<u8>, source: &Source) {
        assert!(bytes != PANICS, "a test's panic");
        let _ = lock(&self.0).send((bytes, source.clone()));
    }

    fn disconnected(&self, _source: &Source) {}
}

fn subscribe() -> (Subscription, Receiver<(Vec<u8>, Source)>) {
    subscribe_counting(&Arc::default())
}

/// As [`subscribe`], with a count of the reports of failed connections.
fn subscribe_counting(failures: &Arc<AtomicUsize>) -> (Subscription, Receiver<(Vec<u8>, Source)>) {
    let (sender, messages) = channel();
    let wanted = Wanted {
        topic: "/a".into(),
        ros_type: "a/B".to_owned(),
        md5sum: "abc".to_owned(),
        definition: String::new(),
        node_name: "/listener".to_owned(),
        number: 0,
    };
    (Subscription::new(wanted, Arc::new(Collect(Mutex::new(sender), Arc::clone(failures)))), messages)
}

fn send(stream: &mut TcpStream, bytes: &[u8]) {
    stream.write_all(&(bytes.len() as u32).to_le_bytes()).unwrap();
    stream.write_all(bytes).unwrap();
}

/// A message at which the handler panics.
const PANICS: &[u8] = b"panics";

/// Subscribes, breaks the connection after each of the first messages, and measures how long each break lasts.
fn breaks(count: usize) -> Vec<Duration> {
    let (publisher, (subscription, messages)) = (Publisher::start(), subscribe());
    subscription.set_publishers(&[publisher.uri()]);
    let (mut lasted, mut broken) = (Vec::new(), None);
    for value in 0..=count {
        let begin = Instant::now();
        drop(broken.take());
        let mut stream = publisher.accept();
        lasted.push(begin.elapsed());
        send(&mut stream, &[value as u8; 3]);
        let (bytes, source) = messages.recv_timeout(TEST_PATIENCE).unwrap();
        assert_eq!((bytes, &*source.name, source.is_latching), (vec![value as u8; 3], "/talker", true));
        broken = Some(stream);
    }
    assert_eq!(subscription.links()[0].received_messages.load(Ordering::Relaxed), 1 + count as u64);
    // The first is no break.
    lasted.split_off(1)
}

#[test]
fn messages_come_with_their_publisher_and_again_after_each_break() {
    let lasted = breaks(6);
    println!("breaks of {lasted:.2?}");
    // After pauses that double up to a limit; what a machine's other work adds does not count.
    let pauses = [1, 2, 4, 8, 8, 8].map(|times| times * FIRST_RETRY);
    assert!(lasted.iter().zip(pauses).all(|(broken, pause)| *broken >= pause), "{lasted:?}");
    assert!(lasted[0] < LONGEST_RETRY && lasted[5] < 4 * LONGEST_RETRY, "{lasted:?}");
}

#[test]
fn a_publisher_that_cannot_be_connected_with_is_reported_once_until_it_is_connected() {
    let failures: Arc<AtomicUsize> = Arc::default();
    let (publisher, (subscription, messages)) = (Publisher::start(), subscribe_counting(&failures));
    let counted = || failures.load(Ordering::Acquire);
    subscription.set_publishers(&[publisher.uri()]);
    for breaks in 0..2 {
        // Two attempts fail.
        for _ in 0..2 {
            drop(publisher.listener.accept().unwrap());
        }
        let mut stream = publisher.accept();
        send(&mut stream, b"x");
        assert_eq!(messages.recv_timeout(TEST_PATIENCE).unwrap().0, b"x");
        assert_eq!(counted(), breaks + 1);
    }
}

#[test]
fn messages_are_requested_without_nagles_delay() {
    let (publisher, (subscription, _messages)) = (Publisher::start(), subscribe());
    subscription.set_publishers(&[publisher.uri()]);
    let (_, request) = publisher.accept_request();
    assert!(request.is_on("tcp_nodelay"), "{request:?}");
    assert_eq!((request.get("topic"), request.get("callerid")), (Some("/a"), Some("/listener")));
}

#[test]
fn publishers_that_hang_hold_up_no_other() {
    let (good, (subscription, messages)) = (Publisher::start(), subscribe());
    // These accept, and then say nothing: the first ones on the way to the topic, the others in its handshake.
    let silent: Vec<TcpListener> = (0..5).map(|_| TcpListener::bind("127.0.0.1:0").unwrap()).collect();
    let hanging: Vec<Publisher> = (0..5).map(|_| Publisher::start()).collect();
    let mut uris: Vec<String> = silent.iter().map(|one| format!("http://{}/", one.local_addr().unwrap())).collect();
    uris.extend(hanging.iter().map(Publisher::uri));
    uris.push(good.uri());
    let begin = Instant::now();
    subscription.set_publishers(&uris);
    let mut stream = good.accept();
    send(&mut stream, b"x");
    assert_eq!(messages.recv_timeout(TEST_PATIENCE).unwrap().0, b"x");
    drop(subscription);
    assert!(begin.elapsed() < ANSWER_TIMEOUT, "something waited for an answer");
}

#[test]
fn a_length_that_no_message_has_ends_the_connection() {
    let (publisher, (subscription, messages)) = (Publisher::start(), subscribe());
    subscription.set_publishers(&[publisher.uri()]);
    publisher.accept().write_all(&[0xff; 8]).unwrap();
    let mut stream = publisher.accept();
    send(&mut stream, b"");
    assert_eq!(messages.recv_timeout(TEST_PATIENCE).unwrap().0, b"");
}

#[test]
fn a_panic_at_a_message_is_a_break_of_the_connection() {
    let (publisher, (subscription, messages)) = (Publisher::start(), subscribe());
    subscription.set_publishers(&[publisher.uri()]);
    let mut broken = publisher.accept();
    send(&mut broken, PANICS);
    let mut stream = publisher.accept();
    send(&mut stream, b"next");
    assert_eq!(messages.recv_timeout(TEST_PATIENCE).unwrap().0, b"next");
}

#[test]
fn publishers_without_a_thread_are_connected_with_as_soon_as_there_is_one() {
    let (publisher, (subscription, messages)) = (Publisher::start(), subscribe());
    subscription.threads.store(MOST_THREADS, Ordering::Release);
    subscription.set_publishers(&[publisher.uri()]);
    assert!(subscription.links().is_empty());
    assert_eq!(subscription.threads.swap(0, Ordering::AcqRel), MOST_THREADS);
    subscription.connect_missing();
    send(&mut publisher.accept(), b"x");
    assert_eq!(messages.recv_timeout(TEST_PATIENCE).unwrap().0, b"x");
}

#[test]
fn a_paused_subscription_has_no_connection_and_a_resumed_one_has_those_that_are_due() {
    let (first, second, (subscription, messages)) = (Publisher::start(), Publisher::start(), subscribe());
    subscription.set_publishers(&[first.uri()]);
    let mut stream = first.accept();
    subscription.set_paused(true);
    stream.set_read_timeout(Some(TEST_PATIENCE)).unwrap();
    assert_eq!(stream.read(&mut [0]).unwrap(), 0);
    subscription.set_publishers(&[second.uri()]);
    assert!(subscription.links().is_empty());
    subscription.set_paused(false);
    send(&mut second.accept(), b"new");
    assert_eq!(messages.recv_timeout(TEST_PATIENCE).unwrap().0, b"new");
}

#[test]
fn a_publisher_that_the_master_names_no_more_is_left() {
    let (publisher, (subscription, _messages)) = (Publisher::start(), subscribe());
    subscription.set_publishers(&[publisher.uri()]);
    let mut stream = publisher.accept();
    subscription.set_publishers(&[]);
    stream.set_read_timeout(Some(TEST_PATIENCE)).unwrap();
    assert_eq!(stream.read(&mut [0]).unwrap(), 0);
}

#[test]
fn a_message_may_come_in_pieces_with_pauses_that_are_longer_than_a_read() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let mut publisher = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
    let mut stream = listener.accept().unwrap().0;
    stream.set_read_timeout(Some(Duration::from_millis(2))).unwrap();
    let sending = std::thread::spawn(move || {
        for piece in [&[6, 0][..], &[0, 0, 1, 2, 3], &[4, 5], &[6]] {
            std::thread::sleep(Duration::from_millis(30));
            publisher.write_all(piece).unwrap();
        }
        publisher
    });
    assert_eq!(read_message(&mut stream, &|| false).unwrap(), [1, 2, 3, 4, 5, 6]);
    let publisher = sending.join().unwrap();
    let ended = read_message(&mut stream, &|| true).unwrap_err();
    assert_eq!(ended.kind(), io::ErrorKind::WouldBlock, "the link has ended");
    drop(publisher);
    let closed = read_message(&mut stream, &|| false).unwrap_err();
    assert_eq!(closed.kind(), io::ErrorKind::UnexpectedEof);
}
