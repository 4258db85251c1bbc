//! What rosrust takes for the ROS master: a server in this process, between rosrust and the real one.
//!
//! rosrust is the node to its own process: it resolves names and reads ROS's arguments. To others it would have an API
//! that answers neither `getBusInfo` nor `getBusStats` and ports that serve one subscriber after the other, and it
//! waits for the master without limit. So rosrust is started with the address of this server in `ROS_MASTER_URI`
//! ([`crate::startup`]). What it would register is not passed on: the node registers topics and services of its own
//! ([`Registrar`]). Everything else, such as private parameters among the arguments, is passed on as it is, with a time
//! limit.

use std::collections::BTreeMap;
use std::io;
use std::net::TcpListener;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rcs_scene::lock;

use crate::registrar::Registrar;
use crate::xmlrpc::{client, parse_call, Answer, Server, Value};

/// How long the real master may take for a call.
const FORWARD_TIMEOUT: Duration = Duration::from_millis(1500);
/// For so long after a call without an answer the master is not asked again: a caller with many calls waits once.
const SILENCE: Duration = Duration::from_secs(1);

/// Starts the server on the port that rosrust was given.
///
/// # Errors
/// The system's, where there is no thread left.
pub(crate) fn start(listener: TcpListener, registrar: Arc<Registrar>) -> io::Result<Server> {
    let silent_since = Mutex::new(None);
    Server::serve("rosrust-master", listener, move |text| answer(text, &registrar, &silent_since))
}

fn succeed(value: Value) -> Answer {
    Answer::Value(Value::Array(vec![Value::Int(1), "".into(), value]))
}

fn answer(text: &str, registrar: &Registrar, silent_since: &Mutex<Option<Instant>>) -> Answer {
    let (method, mut params) = match parse_call(text) {
        Ok(call) => call,
        Err(error) => return fail(&error.to_string()),
    };
    // rosrust puts all parameters into one array.
    if let [Value::Array(inner)] = params.as_slice() {
        params = inner.clone();
    }
    match (method.as_str(), params.as_slice()) {
        // What rosrust publishes, subscribes to and serves by itself: /rosout and /clock, which the node has beside it.
        // The master would take rosrust for another node of the same name.
        ("registerPublisher" | "registerSubscriber", _) => succeed(Value::Array(Vec::new())),
        ("registerService" | "unregisterPublisher" | "unregisterSubscriber" | "unregisterService", _) => {
            succeed(Value::Int(1))
        }
        // Nor does it need its cache of parameters.
        ("subscribeParam" | "unsubscribeParam", _) => succeed(Value::Struct(BTreeMap::new())),
        _ => forward(registrar, silent_since, text),
    }
}

fn forward(registrar: &Registrar, silent_since: &Mutex<Option<Instant>>, text: &str) -> Answer {
    let uri = &registrar.master().uri;
    let silent = |error: &str| fail(&format!("the ROS master at {uri} does not answer: {error}"));
    if lock(silent_since).is_some_and(|since| since.elapsed() < SILENCE) {
        return silent("not asked again so soon");
    }
    match client::post(uri, text, FORWARD_TIMEOUT) {
        Ok(xml) => {
            *lock(silent_since) = None;
            Answer::Xml(xml)
        }
        Err(error) => {
            *lock(silent_since) = Some(Instant::now());
            silent(&error.to_string())
        }
    }
}

fn fail(reason: &str) -> Answer {
    Answer::Value(Value::Array(vec![Value::Int(0), reason.into(), Value::Int(0)]))
}
