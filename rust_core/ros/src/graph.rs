//! The ROS master's API as a node uses it, and what the master knows of the other nodes.

use std::collections::HashMap;
use std::time::Duration;

use crate::xmlrpc::{call, CallError, Value};

/// A master that takes longer is treated as one that does not answer.
const CALL_TIMEOUT: Duration = Duration::from_millis(1500);

/// Calls the master in this node's name.
#[derive(Clone, Debug)]
pub(crate) struct Master {
    /// Such as `http://localhost:11311/`.
    pub(crate) uri: String,
    /// This node's whole name.
    pub(crate) node_name: String,
    /// The address of this node's own API.
    pub(crate) node_uri: String,
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

impl Master {
    /// Calls a method with the node's name and these parameters.
    ///
    /// # Errors
    /// [`CallError`]; a call takes a second and a half at most.
    pub(crate) fn call(&self, method: &str, params: &[&str]) -> Result<Value, CallError> {
        let own = std::iter::once(self.node_name.as_str());
        let params: Vec<Value> = own.chain(params.iter().copied()).map(Value::from).collect();
        call(&self.uri, method, &params, CALL_TIMEOUT)
    }

    /// Sets a parameter by its whole name.
    ///
    /// # Errors
    /// [`CallError`], as [`call`](Self::call).
    pub(crate) fn set_param(&self, name: &str, value: Value) -> Result<(), CallError> {
        call(&self.uri, "setParam", &[self.node_name.as_str().into(), name.into(), value], CALL_TIMEOUT).map(drop)
    }

    /// What the other nodes publish.
    ///
    /// # Errors
    /// [`CallError`].
    pub(crate) fn publications(&self) -> Result<Publications, CallError> {
        let state = self.call("getSystemState", &[])?;
        let types = self.call("getTopicTypes", &[])?;
        let entry = |entry: &Value| match entry.as_array() {
            Some([Value::String(topic), Value::String(ros_type)]) => Some((topic.clone(), ros_type.clone())),
            _ => None,
        };
        let types: HashMap<String, String> = types.as_array().unwrap_or_default().iter().filter_map(entry).collect();
        let publishers = state.as_array().and_then(|lists| lists.first()?.as_array()).unwrap_or_default();
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

/// Whether a ROS master answers at an address.
///
/// # Errors
/// Why not.
pub(crate) fn ping(uri: &str) -> Result<(), CallError> {
    call(uri, "getPid", &["/rviz_camera_stream".into()], CALL_TIMEOUT).map(drop)
}

/// The strings of an array.
pub(crate) fn strings(value: &Value) -> Vec<String> {
    value.as_array().unwrap_or_default().iter().filter_map(Value::as_str).map(str::to_owned).collect()
}
