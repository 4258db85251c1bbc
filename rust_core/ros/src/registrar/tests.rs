//! Registering with a master that answers as a test wants it.

use super::*;
use crate::socket::TEST_PATIENCE;
use crate::tcpros::{Handler, Source, Wanted};
use crate::xmlrpc::{parse_call, Server, Value};
use std::sync::mpsc::{channel, Receiver};

/// A master that notes its calls, and may forget everything.
struct TestMaster {
    _server: Server,
    calls: Receiver<String>,
    known: Arc<Mutex<bool>>,
    /// The publishers of every topic.
    publishers: Arc<Mutex<Vec<String>>>,
    registrar: Arc<Registrar>,
}

fn start() -> TestMaster {
    start_with(no_list, |_| {})
}

fn no_list() -> Value {
    Value::Array(vec![Value::Int(0), "".into(), Value::Int(0)])
}

/// A master whose list `system_state` answers.
fn start_with(
    system_state: impl Fn() -> Value + Send + Sync + 'static,
    on_publisher_left: impl Fn(&str) + Send + Sync + 'static,
) -> TestMaster {
    let (sender, calls) = channel();
    let (sender, known) = (Mutex::new(sender), Arc::new(Mutex::new(false)));
    let is_known = Arc::clone(&known);
    let publishers: Arc<Mutex<Vec<String>>> = Arc::default();
    let named = Arc::clone(&publishers);
    let server = Server::start("master", "127.0.0.1:0".parse().unwrap(), move |text| {
        let (method, params) = parse_call(text).unwrap();
        let answer = |value| Value::Array(vec![Value::Int(1), "".into(), value]);
        match method.as_str() {
            "lookupNode" if !*lock(&is_known) => Value::Array(vec![Value::Int(-1), "unknown node".into(), "".into()]),
            // This node's own address.
            "lookupNode" => answer("http://127.0.0.1:1/".into()),
            "getSystemState" => system_state(),
            "getTopicTypes" => answer(Value::Array(Vec::new())),
            _ => {
                *lock(&is_known) = true;
                let line = format!("{method} {}", params[1].as_str().unwrap());
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
    TestMaster { _server: server, calls, known, publishers, registrar }
}

/// Registers `/a`, with what the master names as its publishers.
fn subscribed(master: &TestMaster) -> Arc<Subscription> {
    let subscription = subscription();
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
    let master = start_with(no_list, |_| panic!("a test's panic"));
    let subscription = subscription();
    master.registrar.subscribe(&subscription);
    assert_eq!(next(&master), "registerSubscriber /a");
    // A master that was restarted names nobody, so that this publisher has left.
    master.registrar.set_publishers("/a", vec![NOBODY.to_owned()]);
    *lock(&master.known) = false;
    assert_eq!(next(&master), "registerSubscriber /a");
    master.registrar.add(Entry::Service { service: "/s".to_owned(), api: "rosrpc://x:1".to_owned(), number: 1 });
    while next(&master) != "registerService /s" {}
}

/// The list of a master that knows `/talker` as the publisher of `/a` and `/node` as its subscriber.
fn talker_and_node() -> Value {
    let list = |nodes: &str| {
        let topic = vec!["/a".into(), Value::Array(vec![nodes.into()])];
        Value::Array(vec![Value::Array(topic)])
    };
    Value::Array(vec![list("/talker"), list("/node"), Value::Array(Vec::new())])
}

/// A subscription of `/a`.
fn subscription() -> Arc<Subscription> {
    let wanted = Wanted {
        topic: "/a".into(),
        ros_type: "a/B".to_owned(),
        md5sum: "abc".to_owned(),
        definition: String::new(),
        node_name: "/node".to_owned(),
        number: 0,
    };
    Arc::new(Subscription::new(wanted, Arc::new(NoHandler)))
}

struct NoHandler;

impl Handler for NoHandler {
    fn contact_failed(&self, _uri: &str, _reason: &str) {}

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
fn what_is_removed_while_the_master_answers_with_its_list_is_unregistered() {
    let entry = Entry::Subscriber { topic: "/a".to_owned(), ros_type: "a/B".to_owned(), number: 1 };
    let state = talker_and_node();
    let registrar: Arc<Mutex<Option<Arc<Registrar>>>> = Arc::default();
    let (shared, removed) = (Arc::clone(&registrar), entry.clone());
    let system_state = move || {
        let registrar = lock(&shared).clone();
        if let Some(registrar) = registrar.filter(|one| lock(&one.state).registered.contains(&removed)) {
            registrar.remove(&removed);
        }
        Value::Array(vec![Value::Int(1), "".into(), state.clone()])
    };
    let master = start_with(system_state, |_| {});
    *lock(&registrar) = Some(Arc::clone(&master.registrar));
    master.registrar.add(entry);
    assert_eq!(next(&master), "registerSubscriber /a");
    assert_eq!(next(&master), "unregisterSubscriber /a");
    master.registrar.end(TEST_PATIENCE, TEST_PATIENCE);
}

#[test]
fn a_subscription_whose_publishers_may_be_stale_is_registered_again_once() {
    let list = || Value::Array(vec![Value::Int(1), "".into(), talker_and_node()]);
    let master = start_with(list, |_| {});
    let talker = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let talker_uri = format!("http://{}/", talker.local_addr().unwrap());
    *lock(&master.publishers) = vec![talker_uri.clone()];
    let subscription = subscribed(&master);
    // As many as the master names, but nobody answers there: what it told last was lost.
    let begin = Instant::now();
    master.registrar.set_publishers("/a", vec![NOBODY.to_owned()]);
    assert_eq!(next(&master), "registerSubscriber /a");
    while subscription.links().iter().all(|link| link.uri != talker_uri) {
        assert!(begin.elapsed() < TEST_PATIENCE);
        std::thread::sleep(Duration::from_millis(5));
    }
    // One that was killed is still on the master's list, and asked for once.
    *lock(&master.publishers) = vec![NOBODY.to_owned()];
    master.registrar.set_publishers("/a", vec![NOBODY.to_owned()]);
    assert_eq!(next(&master), "registerSubscriber /a");
    assert!(master.calls.recv_timeout(3 * GRAPH_PERIOD).is_err());
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
