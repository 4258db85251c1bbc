//! The slave API: what the master and other nodes ask this node by XML-RPC.

use crate::node::Inner;
use crate::xmlrpc::{parse_call, response_document, Value};
use std::sync::{Arc, Weak};
use tiny_http::{Request, Response, Server};

/// Longer requests are not read.
const MAX_REQUEST_LEN: usize = 4 << 20;

/// Answers requests until the server is told to stop.
pub(crate) fn run(server: &Server, node: &Weak<Inner>) {
    while let Ok(request) = server.recv() {
        let Some(node) = node.upgrade().filter(|node| !node.is_closed()) else {
            return;
        };
        // Each on its own thread: a client that is slow to send its request keeps nobody else waiting.
        let spawned = std::thread::Builder::new().name("ros-slave".to_owned()).spawn(move || answer(&node, request));
        if let Err(error) = spawned {
            log::error!("cannot answer a request: {error}");
        }
    }
}

fn answer(node: &Arc<Inner>, mut request: Request) {
    let mut body = String::new();
    let read = if request.body_length().is_some_and(|len| len > MAX_REQUEST_LEN) {
        None
    } else {
        request.as_reader().read_to_string(&mut body).ok()
    };
    let called = read.and_then(|_| parse_call(&body).ok());
    let sent = match called {
        None => request.respond(Response::empty(400)),
        Some((method, params)) => {
            let document = response_document(&dispatch(node, &method, &params));
            let response = Response::from_string(document);
            match "Content-Type: text/xml".parse::<tiny_http::Header>() {
                Ok(kind) => request.respond(response.with_header(kind)),
                Err(()) => request.respond(response),
            }
        }
    };
    if let Err(error) = sent {
        log::debug!("slave API: {error}");
    }
}

fn dispatch(node: &Arc<Inner>, method: &str, params: &[Value]) -> Value {
    match (method, params) {
        ("publisherUpdate", [_, Value::String(topic), publishers, ..]) => {
            if let Some(publishers) = publishers.as_strings() {
                node.publisher_update(topic, &publishers);
            }
            success("publishers updated", Value::Int(0))
        }
        ("requestTopic", [_, Value::String(topic), protocols, ..]) => {
            let tcpros = protocols.as_array().is_some_and(|protocols| {
                (protocols.iter()).any(|one| one.as_array().and_then(|p| p.first()?.as_str()) == Some("TCPROS"))
            });
            match node.publication(topic) {
                None => failure(&format!("{} does not publish {topic}", node.name())),
                Some(_) if !tcpros => failure("only TCPROS is spoken here"),
                Some(_) => {
                    let address = vec![
                        Value::from("TCPROS"),
                        Value::from(node.host()),
                        Value::Int(i32::from(node.tcpros_port())),
                    ];
                    success("ready", Value::Array(address))
                }
            }
        }
        ("paramUpdate", _) => success("parameter noted", Value::Int(0)),
        ("getPid", _) => success("pid", Value::Int(std::process::id().try_into().unwrap_or(i32::MAX))),
        ("getMasterUri", _) => success("master", Value::from(node.master_uri())),
        ("getPublications", _) => success("publications", pairs(node.publication_types())),
        ("getSubscriptions", _) => success("subscriptions", pairs(node.subscription_types())),
        ("getBusStats", _) => success("not counted", Value::Array(vec![Value::Array(Vec::new()); 3])),
        ("getBusInfo", _) => success("connections", bus_info(node)),
        ("shutdown", rest) => {
            let reason = rest.get(1).and_then(Value::as_str).unwrap_or("no reason given");
            node.request_shutdown(reason);
            success("shutting down", Value::Int(0))
        }
        _ => failure(&format!("no method {method} with {} parameters", params.len())),
    }
}

/// Rows of id, other end, direction, transport, topic, connected.
fn bus_info(node: &Arc<Inner>) -> Value {
    let connections = node.connections();
    let row = |(id, (other, outwards, topic)): (usize, (String, bool, String))| {
        Value::Array(vec![
            Value::Int(id.try_into().unwrap_or(i32::MAX)),
            Value::String(other),
            Value::from(if outwards { "o" } else { "i" }),
            Value::from("TCPROS"),
            Value::String(topic),
            Value::Bool(true),
        ])
    };
    Value::Array(connections.into_iter().enumerate().map(row).collect())
}

fn pairs(list: Vec<(String, String)>) -> Value {
    let pair = |(name, kind)| Value::Array(vec![Value::String(name), Value::String(kind)]);
    Value::Array(list.into_iter().map(pair).collect())
}

fn success(text: &str, value: Value) -> Value {
    Value::Array(vec![Value::Int(1), Value::from(text), value])
}

fn failure(text: &str) -> Value {
    Value::Array(vec![Value::Int(0), Value::from(text), Value::Int(0)])
}
