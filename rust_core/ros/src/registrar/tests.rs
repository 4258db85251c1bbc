//! Registering with a master that answers as a test wants it.

use super::*;
use crate::socket::TEST_PATIENCE;
use crate::tcpros::{Handler, Source, Wanted};
use crate::xmlrpc::{parse_call, Server, Value};
use std::sync::mpsc::{channel, Receiver, RecvTimeoutError};
use std::sync::Weak;

/// A master that notes its calls, may forget everything and may be silent.
struct TestMaster {
    _server: Server,
    calls: Receiver<String>,
    known: Arc<Mutex<bool>>,
    is_silent: Arc<AtomicBool>,
    /// Number of lookups of the node to which it was silent.
    unanswered: Arc<AtomicU64>,
    /// The publishers of every topic.
    publishers: Arc<Mutex<Vec<String>>>,
    registrar: Arc<Registrar>,
}

fn start() -> TestMaster {
    start_with(|_| {}, |_| {})
}

/// A master that calls `on_call` with each call that it notes, before it answers.
fn start_with(
    on_call: impl Fn(&str) + Send + Sync + 'static,
    on_publisher_left: impl Fn(&str) + Send + Sync + 'static,
) -> TestMaster {
    let (sender, calls) = channel();
    let (sender, known) = (Mutex::new(sender), Arc::new(Mutex::new(false)));
    let is_known = Arc::clone(&known);
    let (is_silent, unanswered): (Arc<AtomicBool>, Arc<AtomicU64>) = Default::default();
    let (silent, count) = (Arc::clone(&is_silent), Arc::clone(&unanswered));
    let publishers: Arc<Mutex<Vec<String>>> = Arc::default();
    let named = Arc::clone(&publishers);
    let server = Server::start("master", "127.0.0.1:0".parse().unwrap(), move |text| {
        let (method, params) = parse_call(text).unwrap();
        let answer = |value| Value::Array(vec![Value::Int(1), "".into(), value]);
        match method.as_str() {
            _ if silent.load(Ordering::Acquire) => {
                count.fetch_add(u64::from(method == "lookupNode"), Ordering::AcqRel);
                Value::Other("no answer", String::new())
            }
            "lookupNode" if !*lock(&is_known) => Value::Array(vec![Value::Int(-1), "unknown node".into(), "".into()]),
            // This node's own address.
            "lookupNode" => answer("http://127.0.0.1:1/".into()),
            "getSystemState" | "getTopicTypes" => answer(Value::Array(Vec::new())),
            _ => {
                *lock(&is_known) = true;
                let line = format!("{method} {}", params[1].as_str().unwrap());
                on_call(&line);
                lock(&sender).send(line).unwrap();
                answer(Value::Array(lock(&named).iter().map(|uri| uri.as_str().into()).collect()))
            }
        }
    })
    .unwrap();
    let master = Master {
        uri: format!("http://{}/", server.address()),
        node_name: "/node".to_owned(),
        node_uri: "http://127.0.0.1:1/".to_owned(),
    };
    let registrar = Registrar::new(master, Arc::default(), on_publisher_left);
    let running = Arc::clone(&registrar);
    std::thread::spawn(move || running.run());
    TestMaster { _server: server, calls, known, is_silent, unanswered, publishers, registrar }
}

/// Registers `/a`, with what the master names as its publishers.
fn subscribed(master: &TestMaster) -> Arc<Subscription> {
    let subscription = subscription(&master.registrar);
    master.registrar.subscribe(&subscription);
    let begin = Instant::now();
    while lock(&master.registrar.state).registered.is_empty() {
        assert!(begin.elapsed() < TEST_PATIENCE);
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(next(master), "registerSubscriber /a");
    subscription
}

/// Nobody answers on port 9 (discard).
const NOBODY: &str = "http://127.0.0.1:9/";

fn next(master: &TestMaster) -> String {
    master.calls.recv_timeout(TEST_PATIENCE).unwrap()
}

#[test]
fn after_a_panic_registering_goes_on() {
    let master = start_with(|_| {}, |_| panic!("a test's panic"));
    let subscription = subscription(&master.registrar);
    master.registrar.subscribe(&subscription);
    assert_eq!(next(&master), "registerSubscriber /a");
    // A master that was restarted names nobody, so that this publisher has left.
    master.registrar.set_publishers("/a", vec![NOBODY.to_owned()]);
    *lock(&master.known) = false;
    assert_eq!(next(&master), "registerSubscriber /a");
    master.registrar.add(Entry::Service { service: "/s".to_owned(), api: "rosrpc://x:1".to_owned(), number: 1 });
    while next(&master) != "registerService /s" {}
}

/// A subscription of `/a`.
fn subscription(registrar: &Arc<Registrar>) -> Arc<Subscription> {
    let wanted = Wanted {
        topic: "/a".into(),
        ros_type: "a/B".to_owned(),
        md5sum: "abc".to_owned(),
        definition: String::new(),
        node_name: "/node".to_owned(),
        number: 0,
    };
    Arc::new(Subscription::new(wanted, Arc::new(SubscribeAgain(Arc::downgrade(registrar)))))
}

struct SubscribeAgain(Weak<Registrar>);

impl Handler for SubscribeAgain {
    fn contact_failed(&self, _uri: &str, _reason: &str) {}

    fn connection_failed(&self) {
        self.0.upgrade().unwrap().subscribe_again("/a");
    }

    fn contacted(&self, _uri: &str) {}

    fn connected(&self, _source: &Source) {}

    fn message(&self, _bytes: Vec<u8>, _source: &Source) {}

    fn disconnected(&self, _source: &Source) {}
}

#[test]
fn what_is_wanted_is_registered_and_again_with_a_master_that_forgot_it() {
    let master = start();
    let entry = Entry::Publisher { topic: "/image".to_owned(), ros_type: "sensor_msgs/Image".to_owned(), number: 1 };
    master.registrar.add(entry.clone());
    assert_eq!(next(&master), "registerPublisher /image");
    *lock(&master.known) = false;
    assert_eq!(next(&master), "registerPublisher /image");
    master.registrar.remove(&entry);
    assert_eq!(next(&master), "unregisterPublisher /image");
    master.registrar.add(Entry::Service { service: "/s".to_owned(), api: "rosrpc://x:1".to_owned(), number: 2 });
    assert_eq!(next(&master), "registerService /s");
    master.registrar.end(TEST_PATIENCE, TEST_PATIENCE);
    assert_eq!(next(&master), "unregisterService /s");
}

#[test]
fn what_is_removed_while_it_is_registered_is_unregistered() {
    let entry = Entry::Subscriber { topic: "/a".to_owned(), ros_type: "a/B".to_owned(), number: 1 };
    let registrar: Arc<Mutex<Option<Arc<Registrar>>>> = Arc::default();
    let (shared, removed) = (Arc::clone(&registrar), entry.clone());
    let on_call = move |_: &str| {
        if let Some(registrar) = &*lock(&shared) {
            registrar.remove(&removed);
        }
    };
    let master = start_with(on_call, |_| {});
    *lock(&registrar) = Some(Arc::clone(&master.registrar));
    master.registrar.add(entry);
    assert_eq!(next(&master), "registerSubscriber /a");
    assert_eq!(next(&master), "unregisterSubscriber /a");
    master.registrar.end(TEST_PATIENCE, TEST_PATIENCE);
}

#[test]
fn a_subscription_is_registered_again_once_when_a_publisher_cannot_be_connected_with() {
    let master = start();
    let talker = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let talker_uri = format!("http://{}/", talker.local_addr().unwrap());
    *lock(&master.publishers) = vec![talker_uri.clone()];
    let subscription = subscribed(&master);
    // What the master told last was lost: nobody answers there any more.
    let begin = Instant::now();
    master.registrar.set_publishers("/a", vec![NOBODY.to_owned()]);
    assert_eq!(next(&master), "registerSubscriber /a");
    while subscription.links().iter().any(|link| link.uri != talker_uri) {
        assert!(begin.elapsed() < TEST_PATIENCE);
        std::thread::sleep(Duration::from_millis(5));
    }
    // One that was killed is still on the master's list, and asked for once.
    *lock(&master.publishers) = vec![NOBODY.to_owned()];
    master.registrar.set_publishers("/a", vec![NOBODY.to_owned()]);
    assert_eq!(next(&master), "registerSubscriber /a");
    assert_eq!(master.calls.recv_timeout(3 * CHECK_PERIOD), Err(RecvTimeoutError::Timeout));
}

#[test]
fn subscriptions_are_registered_again_with_a_master_that_was_silent() {
    let master = start();
    master.registrar.add(Entry::Service { service: "/s".to_owned(), api: "rosrpc://x:1".to_owned(), number: 1 });
    assert_eq!(next(&master), "registerService /s");
    let subscription = subscribed(&master);
    master.is_silent.store(true, Ordering::Release);
    let begin = Instant::now();
    while master.unanswered.load(Ordering::Acquire) == 0 {
        assert!(begin.elapsed() < TEST_PATIENCE);
        std::thread::sleep(Duration::from_millis(5));
    }
    // A publisher of which the node was not told.
    *lock(&master.publishers) = vec![NOBODY.to_owned()];
    master.is_silent.store(false, Ordering::Release);
    assert_eq!(next(&master), "registerSubscriber /a");
    while subscription.links().is_empty() {
        assert!(begin.elapsed() < TEST_PATIENCE);
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(master.registrar.restarts(), 0);
}

#[test]
fn publishers_that_answer_late_are_kept_when_the_master_is_restarted() {
    let master = start();
    let late = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let late_uri = format!("http://{}/", late.local_addr().unwrap());
    *lock(&master.publishers) = vec![late_uri.clone(), NOBODY.to_owned()];
    let subscription = subscribed(&master);
    let uris = || -> Vec<String> { subscription.links().iter().map(|link| link.uri.clone()).collect() };
    let begin = Instant::now();
    while uris().len() < 2 || subscription.links().iter().all(|link| link.is_promising()) {
        assert!(begin.elapsed() < TEST_PATIENCE);
        std::thread::sleep(Duration::from_millis(5));
    }
    lock(&master.publishers).clear();
    *lock(&master.known) = false;
    assert_eq!(next(&master), "registerSubscriber /a");
    while uris() != [late_uri.clone()] {
        assert!(begin.elapsed() < TEST_PATIENCE, "{:?}", uris());
        std::thread::sleep(Duration::from_millis(5));
    }
    // What the new master names counts.
    master.registrar.set_publishers("/a", Vec::new());
    assert!(uris().is_empty());
}
