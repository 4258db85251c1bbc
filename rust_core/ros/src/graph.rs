//! XML-RPC calls to the master and to other nodes that rosrust does not offer: who publishes what, and unregistering.
//!
//! The XML-RPC client is the one that rosrust uses. It has no timeouts, so every call runs on a thread that may be left
//! behind; a node that has not answered the last call is not called again.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::net::{SocketAddr, ToSocketAddrs};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::time::Duration;
use xml_rpc::{Client, Params, Value};

/// The answer of a node that takes longer is ignored.
const CALL_TIMEOUT: Duration = Duration::from_secs(2);

#[derive(Debug)]
pub(crate) struct Graph {
    master_uri: String,
    node_name: String,
    node_uri: String,
    unanswered: Arc<Mutex<HashSet<String>>>,
}

impl Graph {
    pub(crate) fn new(master_uri: &str, node_name: &str, node_uri: &str) -> Self {
        Self {
            master_uri: master_uri.to_owned(),
            node_name: node_name.to_owned(),
            node_uri: node_uri.to_owned(),
            unanswered: Arc::default(),
        }
    }

    /// The master's state.
    pub(crate) fn state(&self) -> Option<State> {
        let state = self.call(&self.master_uri, "getSystemState", vec![])?;
        let Value::Int(master_pid) = self.call(&self.master_uri, "getPid", vec![])? else {
            return None;
        };
        let [publishers, subscribers, services] = array(&state)? else {
            return None;
        };
        let entries = |list| array(list).unwrap_or_default().iter().filter_map(topic_and_nodes);
        let is_own = |nodes: &[String]| nodes.contains(&self.node_name);
        let own = |list| -> BTreeSet<String> {
            let own = entries(list).filter(|(_, nodes)| is_own(nodes));
            own.map(|(name, _)| name).collect()
        };
        let others = |(topic, mut nodes): (String, Vec<String>)| {
            nodes.retain(|node| *node != self.node_name);
            (topic, nodes)
        };
        Some(State {
            master_pid,
            publishers: entries(publishers).map(others).collect(),
            publications: own(publishers),
            subscriptions: own(subscribers),
            services: own(services),
        })
    }

    /// What the other nodes publish.
    pub(crate) fn publications(&self, state: &State) -> Option<Publications> {
        let types = self.call(&self.master_uri, "getTopicTypes", vec![])?;
        let publication = |pair: &Value| {
            let [topic, ros_type] = array(pair)? else { return None };
            let (topic, ros_type) = (text(topic)?, text(ros_type)?);
            let nodes = state.publishers.get(&topic).filter(|nodes| !nodes.is_empty())?.clone();
            Some((topic, Publication { nodes, ros_type }))
        };
        Some(array(&types)?.iter().filter_map(publication).collect())
    }

    /// Remembers what the node publishes and serves, and registers it again with a master that was restarted.
    pub(crate) fn keep_registered(&self, state: &State, known: &mut Registrations) {
        if known.master_pid.is_some_and(|pid| pid != state.master_pid) {
            log::info!("the ROS master was restarted, registering again");
            for (topic, kind) in &known.publications {
                let params = [topic, kind, &self.node_uri].map(|text| text.as_str().into());
                self.call(&self.master_uri, "registerPublisher", params.into());
            }
            for (service, api) in &known.services {
                let params = [service, api, &self.node_uri].map(|text| text.as_str().into());
                self.call(&self.master_uri, "registerService", params.into());
            }
            // What was registered is in the next state.
            known.master_pid = Some(state.master_pid);
            return;
        }
        known.master_pid = Some(state.master_pid);
        if !state.publications.iter().eq(known.publications.keys()) {
            let types = self.call(&self.master_uri, "getTopicTypes", vec![]);
            let pair = |pair: &Value| {
                let [topic, kind] = array(pair)? else { return None };
                Some((text(topic)?, text(kind)?))
            };
            let types = types.as_ref().and_then(array).unwrap_or_default().iter().filter_map(pair);
            known.publications = types.filter(|(topic, _)| state.publications.contains(topic)).collect();
        }
        if !state.services.iter().eq(known.services.keys()) {
            let with_api = |name: &String| {
                let api = self.call(&self.master_uri, "lookupService", vec![name.as_str().into()])?;
                Some((name.clone(), text(&api)?))
            };
            known.services = state.services.iter().filter_map(with_api).collect();
        }
    }

    /// The address of a node's XML-RPC server.
    pub(crate) fn node_uri(&self, node: &str) -> Option<String> {
        text(&self.call(&self.master_uri, "lookupNode", vec![node.into()])?)
    }

    /// The addresses from which a node sends a topic, as it answers itself. None if it does not answer.
    pub(crate) fn topic_addresses(&self, node_uri: &str, topic: &str) -> Option<Vec<SocketAddr>> {
        let protocols = Value::Array(vec![Value::Array(vec![Value::String("TCPROS".to_owned())])]);
        let answer = self.call(node_uri, "requestTopic", vec![topic.into(), Argument(protocols)])?;
        let [_, host, Value::Int(port), ..] = array(&answer)? else {
            return None;
        };
        let address = (text(host)?, u16::try_from(*port).ok()?);
        Some((address.0.as_str(), address.1).to_socket_addrs().ok()?.collect())
    }

    /// Unregisters whatever the master still has of this node: rosrust never drops its subscriber of `/clock`.
    pub(crate) fn unregister_rest(&self) {
        let Some(state) = self.call(&self.master_uri, "getSystemState", vec![]) else {
            return;
        };
        let methods = ["unregisterPublisher", "unregisterSubscriber", "unregisterService"];
        for (list, method) in array(&state).unwrap_or_default().iter().zip(methods) {
            for (name, nodes) in array(list).unwrap_or_default().iter().filter_map(topic_and_nodes) {
                if !nodes.contains(&self.node_name) {
                    continue;
                }
                let api = if method == "unregisterService" {
                    let found = self.call(&self.master_uri, "lookupService", vec![name.as_str().into()]);
                    found.as_ref().and_then(text).unwrap_or_default()
                } else {
                    self.node_uri.clone()
                };
                // Tried once; the process ends either way.
                let _ = self.call(&self.master_uri, method, vec![name.as_str().into(), api.as_str().into()]);
            }
        }
    }

    /// The value of the answer `[1, text, value]`; none for any other answer, or none in time.
    fn call(&self, uri: &str, method: &'static str, arguments: Vec<Argument>) -> Option<Value> {
        if uri != self.master_uri && !crate::lock(&self.unanswered).insert(uri.to_owned()) {
            return None;
        }
        let mut params: Params = vec![Value::String(self.node_name.clone())];
        params.extend(arguments.into_iter().map(|argument| argument.0));
        let (uri, unanswered) = (uri.to_owned(), Arc::clone(&self.unanswered));
        let (send, answer) = channel();
        let calling = move || {
            let result = uri.parse().ok().and_then(|url| {
                let called = Client::new().ok()?.call_value(&url, method, params).ok()?;
                called.ok()
            });
            crate::lock(&unanswered).remove(&uri);
            // Fails if it took too long and the caller went on.
            let _ = send.send(result);
        };
        std::thread::Builder::new().name("ros-call".to_owned()).spawn(calling).ok()?;
        let answer = answer.recv_timeout(CALL_TIMEOUT).ok()??;
        let mut parts = answer.as_slice();
        while let [Value::Array(inner)] = parts {
            parts = inner;
        }
        match parts {
            [Value::Int(1), _, value] => Some(value.clone()),
            _ => None,
        }
    }
}

/// What other nodes publish, by the topics' whole names.
pub type Publications = HashMap<String, Publication>;

/// Who publishes a topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Publication {
    /// The nodes' names; at least one.
    pub nodes: Vec<String>,
    /// The type as the master has it: that of the node which registered last.
    pub ros_type: String,
}

impl Publication {
    /// Whether its messages can be those of a type.
    pub fn has_type(&self, ros_type: &str) -> bool {
        self.ros_type == ros_type || self.ros_type == "*"
    }
}

/// The master's state: who publishes, subscribes and serves what.
pub(crate) struct State {
    master_pid: i32,
    /// The names of the other nodes that publish each topic.
    pub(crate) publishers: HashMap<String, Vec<String>>,
    /// The topics that this node publishes.
    publications: BTreeSet<String>,
    /// The topics that this node subscribes to.
    pub(crate) subscriptions: BTreeSet<String>,
    /// The services that this node offers.
    services: BTreeSet<String>,
}

/// What is registered again with a restarted master.
#[derive(Debug, Default)]
pub(crate) struct Registrations {
    master_pid: Option<i32>,
    /// Types by topic.
    publications: BTreeMap<String, String>,
    /// Addresses by service.
    services: BTreeMap<String, String>,
}

/// A call's argument.
struct Argument(Value);

impl From<&str> for Argument {
    fn from(text: &str) -> Self {
        Self(Value::String(text.to_owned()))
    }
}

fn array(value: &Value) -> Option<&[Value]> {
    match value {
        Value::Array(values) => Some(values),
        _ => None,
    }
}

fn text(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        _ => None,
    }
}

/// An entry of the master's state.
fn topic_and_nodes(entry: &Value) -> Option<(String, Vec<String>)> {
    let [topic, nodes] = array(entry)? else {
        return None;
    };
    Some((text(topic)?, array(nodes)?.iter().filter_map(text).collect()))
}
