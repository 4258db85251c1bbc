//! The process as a ROS node: its name, its host, the master's address and the remappings, of the process's arguments
//! and environment.
//!
//! Source: the ROS wiki's pages *Names*, *Remapping Arguments* and *ROS/EnvironmentVariables*.

use std::collections::BTreeMap;
use std::env;
use std::path::PathBuf;

use rcs_text::{clean_name, full_name, graph_name};
use rosrust::api::resolve;

use crate::error::NodeError;
use crate::xmlrpc::Value;

/// The node's whole name, and the names that are remapped.
pub(crate) struct Names {
    node: String,
    remappings: BTreeMap<String, String>,
}

impl Names {
    /// The names of this process; `default_name` is the node's unless `__name:=` gives another. `suffix` is added to
    /// either.
    ///
    /// # Errors
    /// [`NodeError::Name`], of a node or a remapping.
    pub(crate) fn of_process(default_name: &str, suffix: &str) -> Result<Self, NodeError> {
        Self::new(&resolve::namespace(), &(resolve::name(default_name) + suffix), &resolve::mappings())
    }

    fn new(namespace: &str, name: &str, mappings: &[(String, String)]) -> Result<Self, NodeError> {
        let invalid = |name: &str| NodeError::Name(name.to_owned());
        let node = full_name(&format!("{namespace}/{name}"));
        if name.contains('/') || graph_name(name).is_err() || graph_name(&node).is_err() {
            return Err(invalid(&node));
        }
        let mut names = Self { node, remappings: BTreeMap::new() };
        for (from, to) in mappings {
            let whole = |name: &str| names.whole_name(name).ok_or_else(|| invalid(name));
            let (from, to) = (whole(from)?, whole(to)?);
            names.remappings.insert(from, to);
        }
        Ok(names)
    }

    /// The node's whole name.
    pub(crate) fn node(&self) -> &str {
        &self.node
    }

    /// The whole name after remapping: `x` is in the node's namespace, `~x` below its name.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub(crate) fn resolve(&self, name: &str) -> Result<String, NodeError> {
        let whole = self.whole_name(name).ok_or_else(|| NodeError::Name(name.to_owned()))?;
        Ok(self.remappings.get(&whole).cloned().unwrap_or(whole))
    }

    /// The whole name before remapping; `None` for one that ROS does not allow.
    fn whole_name(&self, name: &str) -> Option<String> {
        let name = graph_name(name).ok()?;
        let (namespace, _) = self.node.rsplit_once('/')?;
        Some(match name.strip_prefix('~') {
            Some(name) => clean_name(&format!("{}/{name}", self.node)),
            None if name.starts_with('/') => name,
            None => format!("{namespace}/{name}"),
        })
    }
}

/// The ROS master's address.
pub(crate) fn master_uri() -> String {
    resolve::master()
}

/// The host under which others reach this node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Host {
    /// Its name or address.
    pub(crate) name: String,
    /// Whether the user named it, and not the system.
    pub(crate) is_chosen: bool,
}

impl Host {
    /// The host of `__hostname:=`, `__ip:=`, `ROS_HOSTNAME` or `ROS_IP`, else the machine's name.
    pub(crate) fn of_process() -> Self {
        let argument =
            |name: &str| std::env::args().skip(1).find_map(|text| text.strip_prefix(name).map(str::to_owned));
        // A variable that is set to nothing, as container tools do, counts as not set.
        let variable = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
        let chosen = argument("__hostname:=").or_else(|| argument("__ip:="));
        match chosen.or_else(|| variable("ROS_HOSTNAME")).or_else(|| variable("ROS_IP")) {
            Some(name) => Self { name, is_chosen: true },
            None => Self { name: machine_name(), is_chosen: false },
        }
    }
}

/// The names of this machine: the one under which others reach its nodes (`ROS_HOSTNAME`, say), then its own.
pub fn host_names() -> [String; 2] {
    [Host::of_process().name, machine_name()]
}

fn machine_name() -> String {
    rustix::system::uname().nodename().to_string_lossy().into_owned()
}

/// The private parameters among the process's arguments (`_name:=value`), as `~name` and what YAML makes of the value.
///
/// # Errors
/// [`NodeError::Argument`].
pub(crate) fn private_arguments() -> Result<Vec<(String, Value)>, NodeError> {
    let read = |(name, text): (String, String)| {
        let failed = |reason: String| NodeError::Argument { name: name.clone(), value: text.clone(), reason };
        let value = serde_yaml_ng::from_str(&text).map_err(|error| failed(error.to_string()))?;
        let value = from_yaml(value).ok_or_else(|| failed("not a parameter's value".to_owned()))?;
        Ok((name, value))
    };
    resolve::params().into_iter().map(read).collect()
}

/// A parameter's value; `None` for what XML-RPC has no type for.
fn from_yaml(value: serde_yaml_ng::Value) -> Option<Value> {
    Some(match value {
        serde_yaml_ng::Value::Bool(value) => Value::Bool(value),
        serde_yaml_ng::Value::Number(number) => {
            let int = number.as_i64().and_then(|int| i32::try_from(int).ok());
            int.map_or(Value::Double(number.as_f64()?), Value::Int)
        }
        serde_yaml_ng::Value::String(text) => Value::String(text),
        serde_yaml_ng::Value::Sequence(items) => Value::Array(items.into_iter().map(from_yaml).collect::<Option<_>>()?),
        serde_yaml_ng::Value::Mapping(members) => {
            let member = |(name, value)| match from_yaml(name)? {
                Value::String(name) => Some((name, from_yaml(value)?)),
                Value::Bool(name) => Some((name.to_string(), from_yaml(value)?)),
                Value::Int(name) => Some((name.to_string(), from_yaml(value)?)),
                _ => None,
            };
            Value::Struct(members.into_iter().map(member).collect::<Option<_>>()?)
        }
        serde_yaml_ng::Value::Null | serde_yaml_ng::Value::Tagged(_) => return None,
    })
}

/// The right side of the remapping `name:=other` among the program's arguments, if there is one.
pub fn remapping_of(name: &str) -> Option<String> {
    std::env::args_os().skip(1).find_map(|argument| {
        let argument = argument.to_string_lossy().into_owned();
        let (from, to) = argument.split_once(":=")?;
        (full_name(from) == full_name(name)).then(|| to.to_owned())
    })
}

/// The folder in which ROS keeps files of a user: `ROS_HOME`, else `~/.ros`.
pub fn ros_folder() -> Option<PathBuf> {
    let given = env::var_os("ROS_HOME").filter(|folder| !folder.is_empty()).map(PathBuf::from);
    given.or_else(|| env::home_dir().map(|home| home.join(".ros")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(namespace: &str, mappings: &[(&str, &str)]) -> Result<Names, NodeError> {
        let mappings: Vec<(String, String)> =
            mappings.iter().map(|(from, to)| ((*from).to_owned(), (*to).to_owned())).collect();
        Names::new(namespace, "eye", &mappings)
    }

    #[test]
    fn names_are_in_the_namespace_below_the_node_or_absolute() {
        for namespace in ["robot", "/robot", "//robot//"] {
            let names = names(namespace, &[]).unwrap();
            assert_eq!(names.node(), "/robot/eye");
            let resolved = ["image", "~image", "//image", "a//b/", "~/"].map(|name| names.resolve(name).unwrap());
            assert_eq!(resolved, ["/robot/image", "/robot/eye/image", "/image", "/robot/a/b", "/robot/eye"]);
        }
        for wrong in ["", "/", "1st", "a b", "/fo$o", "a~b"] {
            assert_eq!(names("", &[]).unwrap().resolve(wrong), Err(NodeError::Name(wrong.to_owned())), "{wrong}");
        }
    }

    #[test]
    fn whole_names_are_remapped_whichever_way_they_are_written() {
        let names = names("", &[("image/", "/wall//image"), ("~rate", "rate")]).unwrap();
        let resolved = ["image", "/image", "/eye/rate", "/image/compressed"].map(|name| names.resolve(name).unwrap());
        assert_eq!(resolved, ["/wall/image", "/wall/image", "/rate", "/image/compressed"]);
        for (namespace, name) in [("", "a/b"), ("", "a b"), ("", "1st"), ("", "~"), ("a b", "eye")] {
            assert!(Names::new(namespace, name, &[]).is_err(), "{namespace} {name}");
        }
    }

    #[test]
    fn parameters_among_the_arguments_are_yaml() {
        let value = |text: &str| from_yaml(serde_yaml_ng::from_str(text).unwrap());
        assert_eq!(value("30"), Some(Value::Int(30)));
        assert_eq!(value("0.5"), Some(Value::Double(0.5)));
        assert_eq!(value("3000000000"), Some(Value::Double(3e9)));
        assert_eq!(value("true"), Some(Value::Bool(true)));
        assert_eq!(value("/other=never"), Some("/other=never".into()));
        assert_eq!(value("[/a, 1]"), Some(Value::Array(vec!["/a".into(), Value::Int(1)])));
        let radius = [("radius".to_owned(), Value::Double(0.25))];
        assert_eq!(value("[{radius: 0.25}]"), Some(Value::Array(vec![Value::Struct(radius.into())])));
        assert_eq!(value(""), None);
    }
}
