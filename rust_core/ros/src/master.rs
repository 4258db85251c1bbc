//! The ROS master's API.

use std::collections::HashMap;
use std::time::Duration;

use crate::xmlrpc::{call, client, value, CallError, Value};

/// Timeout of calls.
const CALL_TIMEOUT: Duration = Duration::from_millis(1500);
/// Timeout of a parameter, which may be a robot description.
const PARAM_TIMEOUT: Duration = Duration::from_secs(10);

/// Client of the master in this node's name.
#[derive(Clone, Debug)]
pub(crate) struct Master {
    /// Address, such as `http://localhost:11311/`.
    pub(crate) uri: String,
    /// Whole name of this node.
    pub(crate) node_name: String,
    /// Address of this node's own API.
    pub(crate) node_uri: String,
}

/// Publications of other nodes, by the topics' whole names.
pub type Publications = HashMap<String, Publication>;

/// The publishers of a topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Publication {
    /// Names of the nodes, at least one.
    pub nodes: Vec<String>,
    /// Type by the master: that of the node that registered last.
    pub ros_type: String,
}

impl Publication {
    /// `true` if its messages may be of a type.
    pub fn has_type(&self, ros_type: &str) -> bool {
        self.ros_type == ros_type || self.ros_type == "*"
    }
}

impl Master {
    /// Calls a method with the node's name and these parameters, within 1.5 s.
    ///
    /// # Errors
    /// [`CallError`].
    pub(crate) fn call(&self, method: &str, params: &[&str]) -> Result<Value, CallError> {
        let own = std::iter::once(self.node_name.as_str());
        let params: Vec<Value> = own.chain(params.iter().copied()).map(Value::from).collect();
        call(&self.uri, method, &params, CALL_TIMEOUT)
    }

    /// Makes several calls as one and ignores what they return.
    ///
    /// # Errors
    /// [`CallError`]; a fault from a master that takes one call at a time.
    pub(crate) fn call_together(&self, calls: &[(&str, [&str; 2])]) -> Result<(), CallError> {
        let own = self.node_name.as_str();
        let calls = calls.iter().map(|(method, params)| {
            let params = std::iter::once(own).chain(*params).map(Value::from).collect();
            let fields = [("methodName", Value::from(*method)), ("params", Value::Array(params))];
            Value::Struct(fields.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
        });
        let request = value::request("system.multicall", &[Value::Array(calls.collect())]);
        let answer = client::post(&self.uri, &request, CALL_TIMEOUT)?;
        value::parse_response(&answer).map(drop).map_err(CallError::Answer)
    }

    /// Sets a parameter by its whole name.
    ///
    /// # Errors
    /// [`CallError`].
    pub(crate) fn set_param(&self, name: &str, value: Value) -> Result<(), CallError> {
        call(&self.uri, "setParam", &[self.node_name.as_str().into(), name.into(), value], CALL_TIMEOUT).map(drop)
    }

    /// A parameter's value by its whole name; `None` if it is not set.
    ///
    /// # Errors
    /// [`CallError`] if the master does not answer within 10 s.
    pub(crate) fn param(&self, name: &str) -> Result<Option<Value>, CallError> {
        match call(&self.uri, "getParam", &[self.node_name.as_str().into(), name.into()], PARAM_TIMEOUT) {
            Ok(value) => Ok(Some(value)),
            Err(error) if error.is_answer() => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Publications of other nodes.
    ///
    /// # Errors
    /// [`CallError`].
    pub(crate) fn publications(&self) -> Result<Publications, CallError> {
        let state = self.call("getSystemState", &[])?;
        let types = self.call("getTopicTypes", &[])?;
        let Some([Value::Array(publishers), _subscribers, _services]) = state.as_array() else {
            return Err(CallError::Refused("its state is not three lists".to_owned()));
        };
        let entry = |entry: &Value| match entry.as_array() {
            Some([Value::String(topic), Value::String(ros_type)]) => Some((topic.clone(), ros_type.clone())),
            _ => None,
        };
        let types: HashMap<String, String> = types.as_array().unwrap_or_default().iter().filter_map(entry).collect();
        let publication = |entry: &Value| {
            let Some([Value::String(topic), Value::Array(nodes)]) = entry.as_array() else { return None };
            let nodes = nodes.iter().filter_map(Value::as_str).filter(|node| *node != self.node_name);
            let nodes: Vec<String> = nodes.map(str::to_owned).collect();
            let ros_type = types.get(topic).cloned().unwrap_or_else(|| "*".to_owned());
            (!nodes.is_empty()).then(|| (topic.clone(), Publication { nodes, ros_type }))
        };
        Ok(publishers.iter().filter_map(publication).collect())
    }
}

/// Checks that a ROS master answers at an address.
///
/// # Errors
/// [`CallError`].
pub(crate) fn ping(uri: &str) -> Result<(), CallError> {
    call(uri, "getPid", &["/rviz_camera_stream".into()], CALL_TIMEOUT).map(drop)
}

/// Strings of an array.
pub(crate) fn strings(value: &Value) -> Vec<String> {
    value.as_array().unwrap_or_default().iter().filter_map(Value::as_str).map(str::to_owned).collect()
}
