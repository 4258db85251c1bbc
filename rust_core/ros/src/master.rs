//! The calls that a node makes to the master, and the one that it makes to other nodes.

use crate::xmlrpc::{call, CallError, Value};

/// Long enough for a busy master, short enough to notice a dead one.
const TIMEOUT_SECS: u64 = 5;

/// The master, as seen by one node.
#[derive(Clone, Debug)]
pub(crate) struct Master {
    uri: String,
    caller_id: String,
    caller_api: String,
}

impl Master {
    pub(crate) fn new(uri: &str, caller_id: &str, caller_api: &str) -> Self {
        Self { uri: uri.to_owned(), caller_id: caller_id.to_owned(), caller_api: caller_api.to_owned() }
    }

    pub(crate) fn uri(&self) -> &str {
        &self.uri
    }

    /// Calls with the caller's name before `params`.
    pub(crate) fn call(&self, method: &str, params: &[&str]) -> Result<Value, CallError> {
        self.call_within(TIMEOUT_SECS, method, params)
    }

    pub(crate) fn call_within(&self, timeout_secs: u64, method: &str, params: &[&str]) -> Result<Value, CallError> {
        let mut values = vec![Value::from(self.caller_id.as_str())];
        values.extend(params.iter().copied().map(Value::from));
        call(&self.uri, method, &values, timeout_secs)
    }

    pub(crate) fn is_there(&self) -> bool {
        self.call_within(2, "getPid", &[]).is_ok()
    }

    /// Returns the publishers' slave URIs.
    pub(crate) fn register_subscriber(&self, topic: &str, type_name: &str) -> Result<Vec<String>, CallError> {
        let value = self.call("registerSubscriber", &[topic, type_name, &self.caller_api])?;
        value.as_strings().ok_or_else(|| self.bad_answer("registerSubscriber"))
    }

    pub(crate) fn register_publisher(&self, topic: &str, type_name: &str) -> Result<(), CallError> {
        self.call("registerPublisher", &[topic, type_name, &self.caller_api]).map(drop)
    }

    pub(crate) fn register_service(&self, name: &str, service_api: &str) -> Result<(), CallError> {
        self.call("registerService", &[name, service_api, &self.caller_api]).map(drop)
    }

    pub(crate) fn unregister_subscriber(&self, topic: &str) -> Result<(), CallError> {
        self.call_within(1, "unregisterSubscriber", &[topic, &self.caller_api]).map(drop)
    }

    pub(crate) fn unregister_publisher(&self, topic: &str) -> Result<(), CallError> {
        self.call_within(1, "unregisterPublisher", &[topic, &self.caller_api]).map(drop)
    }

    pub(crate) fn unregister_service(&self, name: &str, service_api: &str) -> Result<(), CallError> {
        self.call_within(1, "unregisterService", &[name, service_api]).map(drop)
    }

    /// Whether the master knows this node by its present address. An error when the master does not answer.
    pub(crate) fn knows_us(&self) -> Result<bool, CallError> {
        match self.call("lookupNode", &[&self.caller_id]) {
            Ok(uri) => Ok(uri.as_str() == Some(&self.caller_api)),
            Err(CallError::Refused { .. }) => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// The parameter's value, none if it is not set.
    pub(crate) fn param(&self, name: &str) -> Result<Option<Value>, CallError> {
        match self.call("getParam", &[name]) {
            Ok(value) => Ok(Some(value)),
            Err(CallError::Refused { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    pub(crate) fn set_param(&self, name: &str, value: &Value) -> Result<(), CallError> {
        let params = [Value::from(self.caller_id.as_str()), Value::from(name), value.clone()];
        call(&self.uri, "setParam", &params, TIMEOUT_SECS).map(drop)
    }

    fn bad_answer(&self, method: &str) -> CallError {
        CallError::Answer {
            uri: self.uri.clone(),
            method: method.to_owned(),
            reason: "unexpected type of value".to_owned(),
        }
    }
}

/// Asks the node at `node_uri` where `topic` can be had over TCPROS: host and port.
pub(crate) fn request_topic(node_uri: &str, caller_id: &str, topic: &str) -> Result<(String, u16), CallError> {
    let protocols = Value::Array(vec![Value::Array(vec![Value::from("TCPROS")])]);
    let params = [Value::from(caller_id), Value::from(topic), protocols];
    let answer = call(node_uri, "requestTopic", &params, TIMEOUT_SECS)?;
    let port = |number: &i32| u16::try_from(*number).ok();
    match answer.as_array() {
        Some([Value::String(protocol), Value::String(host), Value::Int(number), ..]) if protocol == "TCPROS" => {
            port(number).map(|port| (host.clone(), port))
        }
        _ => None,
    }
    .ok_or_else(|| CallError::Answer {
        uri: node_uri.to_owned(),
        method: "requestTopic".to_owned(),
        reason: format!("no TCPROS address for {topic}"),
    })
}
