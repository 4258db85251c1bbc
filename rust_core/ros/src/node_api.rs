//! The node's own XML-RPC API: what the master, other nodes and tools (`rosnode`, `roswtf`) ask it.

use std::io;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use rcs_process::lock;

use crate::master::{strings, Master};
use crate::registrar::Registrar;
use crate::tcpros::Listener;
use crate::xmlrpc::{parse_call, Server, Value};

/// State that the API answers from.
pub(crate) struct ApiState {
    /// Host by which others reach this node.
    pub(crate) host: String,
    /// The node's TCPROS port.
    pub(crate) listener: Arc<Listener>,
    /// Registrations of the node.
    pub(crate) registrar: Arc<Registrar>,
    /// Set when the node is asked to end.
    pub(crate) is_asked_to_end: Arc<AtomicBool>,
}

/// Serves the API until it is dropped.
///
/// `state` is set later, because it needs the address.
///
/// # Errors
/// The address cannot be used.
pub(crate) fn serve(address: SocketAddr, state: Arc<Mutex<Option<Arc<ApiState>>>>) -> io::Result<Server> {
    Server::start("ros-api", address, move |text| {
        let state = lock(&state).clone();
        let Some(state) = state else { return refuse("the node is just starting") };
        match parse_call(text) {
            Ok((method, params)) => state.answer(&method, &params),
            Err(error) => refuse(&error.to_string()),
        }
    })
}

fn succeed(value: Value) -> Value {
    Value::Array(vec![Value::Int(1), "".into(), value])
}

fn refuse(reason: &str) -> Value {
    Value::Array(vec![Value::Int(-1), reason.into(), Value::Int(0)])
}

/// A counter as the API's 32 bits, which wrap.
fn count(count: u64) -> Value {
    Value::Int((count & 0x7fff_ffff) as i32)
}

impl ApiState {
    fn answer(&self, method: &str, params: &[Value]) -> Value {
        match (method, params) {
            ("getPid", _) => succeed(Value::Int(std::process::id() as i32)),
            ("getMasterUri", _) => succeed(self.registrar.master().uri.as_str().into()),
            ("getBusInfo", _) => succeed(self.bus_info()),
            ("getBusStats", _) => succeed(self.bus_stats()),
            ("getPublications", _) => {
                let publications = self.listener.publications();
                let pairs = publications.iter().map(|publication| {
                    let description = publication.description();
                    Value::Array(vec![description.topic.as_str().into(), description.ros_type.as_str().into()])
                });
                succeed(Value::Array(pairs.collect()))
            }
            ("getSubscriptions", _) => {
                let subscriptions = self.registrar.subscriptions();
                let pairs = subscriptions.iter().map(|subscription| {
                    let wanted = subscription.wanted();
                    Value::Array(vec![(&*wanted.topic).into(), wanted.ros_type.as_str().into()])
                });
                succeed(Value::Array(pairs.collect()))
            }
            ("requestTopic", [_, Value::String(topic), Value::Array(protocols), ..]) => {
                let is_tcpros =
                    |protocol: &Value| protocol.as_array().and_then(|parts| parts.first()?.as_str()) == Some("TCPROS");
                if self.listener.publication(topic).is_none() {
                    refuse(&format!("topic [{topic}] is not published by this node"))
                } else if protocols.iter().any(is_tcpros) {
                    let port = Value::Int(i32::from(self.listener.port()));
                    succeed(Value::Array(vec!["TCPROS".into(), self.host.as_str().into(), port]))
                } else {
                    refuse("only TCPROS is supported")
                }
            }
            ("publisherUpdate", [_, Value::String(topic), uris, ..]) => {
                self.registrar.set_publishers(topic, strings(uris));
                succeed(Value::Int(0))
            }
            // No parameter is subscribed to.
            ("paramUpdate", _) => succeed(Value::Int(0)),
            ("shutdown", _) => {
                let reason = params.get(1).and_then(Value::as_str).unwrap_or_default();
                log::warn!("asked to end{}{reason}", if reason.is_empty() { "" } else { ": " });
                self.is_asked_to_end.store(true, Ordering::Release);
                succeed(Value::Int(0))
            }
            _ => refuse(&format!("no method {method} with these parameters")),
        }
    }

    /// The connections: id, other end, direction, transport, topic, whether it stands, a description.
    ///
    /// A topic that the node both publishes and subscribes to is listed as connected with itself, as by roscpp, because
    /// roswtf expects such a connection.
    fn bus_info(&self) -> Value {
        const TCP: &str = "TCPROS";
        const OWN: &str = "INTRAPROCESS";
        let mut connections = Vec::new();
        let mut add = |transport: &str, node: &str, direction: &str, topic: &str, description: String| {
            let id = Value::Int(connections.len() as i32);
            let parts = vec![id, node.into(), direction.into(), transport.into(), topic.into(), Value::Bool(true)];
            connections.push(Value::Array(parts.into_iter().chain([description.into()]).collect()));
        };
        for publication in self.listener.publications() {
            for subscriber in publication.subscribers() {
                let (topic, peer) = (&publication.description().topic, subscriber.peer);
                let description = format!("TCPROS connection on port {} to [{peer}]", self.listener.port());
                add(TCP, &subscriber.name, "o", topic, description);
            }
        }
        for subscription in self.registrar.subscriptions() {
            for link in subscription.links() {
                if let Some((_, peer)) = link.connected() {
                    let description = format!("TCPROS connection to [{peer}]");
                    add(TCP, &link.uri, "i", &subscription.wanted().topic, description);
                }
            }
            let topic = &subscription.wanted().topic;
            if self.listener.publication(topic).is_some() {
                let Master { node_name, node_uri, .. } = self.registrar.master();
                for (node, direction) in [(node_name, "o"), (node_uri, "i")] {
                    add(OWN, node, direction, topic, "within the node".to_owned());
                }
            }
        }
        Value::Array(connections)
    }

    fn bus_stats(&self) -> Value {
        let publish = self.listener.publications().into_iter().map(|publication| {
            let mut total = 0;
            let connections = publication.subscribers().into_iter().enumerate().map(|(id, subscriber)| {
                let bytes = subscriber.sent_bytes.load(Ordering::Relaxed);
                total += bytes;
                let messages = subscriber.sent_messages.load(Ordering::Relaxed);
                Value::Array(vec![Value::Int(id as i32), count(bytes), count(messages), Value::Bool(true)])
            });
            let connections = Value::Array(connections.collect());
            Value::Array(vec![publication.description().topic.as_str().into(), count(total), connections])
        });
        let publish = Value::Array(publish.collect());
        let subscribe = self.registrar.subscriptions().into_iter().map(|subscription| {
            let connections = subscription.links().into_iter().enumerate().map(|(id, link)| {
                let bytes = link.received_bytes.load(Ordering::Relaxed);
                let connected = Value::Bool(link.connected().is_some());
                // The number of dropped messages is unknown.
                Value::Array(vec![Value::Int(id as i32), count(bytes), Value::Int(-1), connected])
            });
            let connections = Value::Array(connections.collect());
            Value::Array(vec![(&*subscription.wanted().topic).into(), connections])
        });
        let services = Value::Array(vec![Value::Int(0), Value::Int(0), Value::Int(0)]);
        Value::Array(vec![publish, Value::Array(subscribe.collect()), services])
    }
}
