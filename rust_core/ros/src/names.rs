//! Names, namespaces and remappings, and where a node takes them from.
//!
//! The rules are roscpp's: `__name:=`, `__ns:=`, `__master:=`, `__ip:=` and `__hostname:=` before the environment's
//! `ROS_NAMESPACE`, `ROS_MASTER_URI`, `ROS_HOSTNAME` and `ROS_IP`; `_param:=value` sets a private parameter; any other
//! `a:=b` remaps the resolved name of `a` to the resolved name of `b`.

use crate::xmlrpc::Value;
use std::collections::BTreeMap;
use std::net::ToSocketAddrs;

/// A name that ROS does not allow.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// It starts with something else than a letter, `/` or `~`, or has other characters than letters, digits, `_`, `/`.
    #[error("'{0}' is not a valid ROS name")]
    Invalid(String),
    /// A node's own name has no namespace in it.
    #[error("node name '{0}' must not contain '/' or '~': use __ns:= for a namespace")]
    NodeNameWithNamespace(String),
}

/// Everything that a node is told from outside before it starts.
#[derive(Clone, Debug)]
pub struct NodeOptions {
    name: String,
    namespace: String,
    master_uri: String,
    host: String,
    remappings: BTreeMap<String, String>,
    params: Vec<(String, Value)>,
}

impl NodeOptions {
    /// Reads the environment and `args` (without the program's name). Returns what is left of `args`: all without `:=`.
    ///
    /// `default_name` is the node's name unless `__name:=` gives another.
    pub fn from_env(
        default_name: &str,
        args: impl IntoIterator<Item = String>,
    ) -> Result<(Self, Vec<String>), NameError> {
        Self::new(default_name, args, |key| std::env::var(key).ok())
    }

    /// As [`from_env`](Self::from_env), with the environment as a function.
    pub fn new(
        default_name: &str,
        args: impl IntoIterator<Item = String>,
        env: impl Fn(&str) -> Option<String>,
    ) -> Result<(Self, Vec<String>), NameError> {
        let mut rest = Vec::new();
        let mut special = BTreeMap::new();
        let mut params = Vec::new();
        let mut mappings = Vec::new();
        for arg in args {
            match arg.split_once(":=") {
                None => rest.push(arg),
                Some((key, value)) if key.starts_with("__") => {
                    special.insert(key.to_owned(), value.to_owned());
                }
                Some((key, value)) => match key.strip_prefix('_') {
                    Some(param) => params.push((format!("~{param}"), param_value(value))),
                    None => mappings.push((key.to_owned(), value.to_owned())),
                },
            }
        }
        let env = |key: &str| env(key).filter(|value| !value.is_empty());
        let name = special.get("__name").map_or(default_name, String::as_str);
        if name.contains(['/', '~']) {
            return Err(NameError::NodeNameWithNamespace(name.to_owned()));
        }
        validate(name)?;
        let namespace = special.get("__ns").cloned().or_else(|| env("ROS_NAMESPACE"));
        let namespace = clean(&format!("/{}", namespace.unwrap_or_default()));
        validate(&namespace)?;
        let given_host = (special.get("__hostname").or_else(|| special.get("__ip")).cloned())
            .or_else(|| env("ROS_HOSTNAME"))
            .or_else(|| env("ROS_IP"));
        let master_uri = special.get("__master").cloned().or_else(|| env("ROS_MASTER_URI"));
        let mut options = Self {
            name: clean(&format!("{namespace}/{name}")),
            namespace,
            master_uri: master_uri.unwrap_or_else(|| "http://localhost:11311".to_owned()),
            host: given_host.unwrap_or_else(own_host),
            remappings: BTreeMap::new(),
            params: Vec::new(),
        };
        for (from, to) in mappings {
            // roscpp remaps nothing to or from a name that is empty.
            if !from.is_empty() && !to.is_empty() {
                let (from, to) = (options.resolve_unmapped(&from)?, options.resolve_unmapped(&to)?);
                options.remappings.insert(from, to);
            }
        }
        for (name, value) in params {
            options.params.push((options.resolve_unmapped(&name)?, value));
        }
        Ok((options, rest))
    }

    /// The node's whole name, such as `/robot/camera_stream`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The namespace that relative names start from, `/` or such as `/robot`.
    pub fn namespace(&self) -> &str {
        &self.namespace
    }

    /// Where the master is, such as `http://localhost:11311`.
    pub fn master_uri(&self) -> &str {
        &self.master_uri
    }

    /// The name or address under which others reach this node.
    pub fn host(&self) -> &str {
        &self.host
    }

    /// Private parameters to set, by resolved name.
    pub fn params(&self) -> &[(String, Value)] {
        &self.params
    }

    /// The whole name of `name`, after remapping. `~x` is below the node's name, `x` in its namespace.
    pub fn resolve(&self, name: &str) -> Result<String, NameError> {
        let resolved = self.resolve_unmapped(name)?;
        Ok(self.remappings.get(&resolved).cloned().unwrap_or(resolved))
    }

    /// As [`resolve`](Self::resolve), with relative names starting from `namespace`, itself relative to the node's.
    pub fn resolve_in(&self, namespace: &str, name: &str) -> Result<String, NameError> {
        if namespace.is_empty() || name.starts_with(['/', '~']) {
            return self.resolve(name);
        }
        self.resolve(&format!("{namespace}/{name}"))
    }

    fn resolve_unmapped(&self, name: &str) -> Result<String, NameError> {
        validate(name)?;
        Ok(match name.strip_prefix('~') {
            Some(private) => clean(&format!("{}/{private}", self.name)),
            None if name.starts_with('/') => clean(name),
            None => clean(&format!("{}/{name}", self.namespace)),
        })
    }
}

/// Single slashes, none at the end.
fn clean(name: &str) -> String {
    let mut out = String::with_capacity(name.len());
    for part in name.split('/').filter(|part| !part.is_empty()) {
        out.push('/');
        out.push_str(part);
    }
    if out.is_empty() {
        out.push('/');
    }
    out
}

fn validate(name: &str) -> Result<(), NameError> {
    let start = |c: char| c.is_ascii_alphabetic() || c == '/' || c == '~';
    let later = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '/';
    let mut chars = name.chars();
    if chars.next().is_none_or(start) && chars.all(later) {
        Ok(())
    } else {
        Err(NameError::Invalid(name.to_owned()))
    }
}

/// A value as roscpp reads it from the command line: a number, a truth value, or else text.
fn param_value(text: &str) -> Value {
    match text {
        "true" | "True" | "TRUE" => return Value::Bool(true),
        "false" | "False" | "FALSE" => return Value::Bool(false),
        _ => {}
    }
    let number = text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    match (text.parse::<i32>(), text.parse::<f64>()) {
        (Ok(value), _) => Value::Int(value),
        (_, Ok(value)) if number => Value::Double(value),
        _ => Value::String(text.to_owned()),
    }
}

/// This machine's name where it leads back here, the loopback address where it does not.
fn own_host() -> String {
    let name = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let name = name.trim();
    let known = !name.is_empty() && (name, 0).to_socket_addrs().is_ok_and(|mut found| found.next().is_some());
    if known {
        name.to_owned()
    } else {
        "127.0.0.1".to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(args: &[&str], env: &[(&str, &str)]) -> NodeOptions {
        let args = args.iter().map(|arg| (*arg).to_owned());
        let get = |key: &str| env.iter().find(|(k, _)| *k == key).map(|(_, v)| (*v).to_owned());
        NodeOptions::new("camera_stream", args, get).unwrap().0
    }

    #[test]
    fn arguments_come_before_the_environment() {
        let env = [("ROS_NAMESPACE", "outer"), ("ROS_IP", "10.0.0.1"), ("ROS_HOSTNAME", "robot")];
        let from_env = options(&[], &env);
        assert_eq!(from_env.name(), "/outer/camera_stream");
        assert_eq!(from_env.host(), "robot");
        let from_args = options(&["__ns:=/a/b/", "__name:=eye", "__ip:=10.0.0.2", "__log:=/x.log"], &env);
        assert_eq!(from_args.name(), "/a/b/eye");
        assert_eq!(from_args.host(), "10.0.0.2");
    }

    #[test]
    fn an_absolute_name_of_a_config_is_remapped_by_a_relative_rule() {
        let node = options(&["cloud:=/other", "/tf:=tf_old"], &[]);
        assert_eq!(node.resolve("/cloud").unwrap(), "/other");
        assert_eq!(node.resolve("cloud").unwrap(), "/other");
        assert_eq!(node.resolve("/tf").unwrap(), "/tf_old");
        assert_eq!(node.resolve("/cloud2").unwrap(), "/cloud2");
    }

    #[test]
    fn remapping_counts_from_the_namespace_and_the_node() {
        let node = options(&["__ns:=robot", "cloud:=near", "~image:=/picture"], &[]);
        assert_eq!(node.resolve("cloud").unwrap(), "/robot/near");
        assert_eq!(node.resolve("/cloud").unwrap(), "/cloud");
        assert_eq!(node.resolve("~image").unwrap(), "/picture");
        assert_eq!(node.resolve("~other").unwrap(), "/robot/camera_stream/other");
        assert_eq!(node.resolve_in("view", "camera_trigger").unwrap(), "/robot/view/camera_trigger");
        assert_eq!(node.resolve_in("", "camera_trigger").unwrap(), "/robot/camera_trigger");
    }

    #[test]
    fn private_parameters_have_the_types_that_they_look_like() {
        let node = options(&["_rate:=30", "_gain:=0.5", "_on:=true", "_file:=/a:=b", "_nan_name:=nan"], &[]);
        let expected = [
            ("/camera_stream/rate", Value::Int(30)),
            ("/camera_stream/gain", Value::Double(0.5)),
            ("/camera_stream/on", Value::Bool(true)),
            ("/camera_stream/file", Value::String("/a:=b".to_owned())),
            ("/camera_stream/nan_name", Value::String("nan".to_owned())),
        ];
        let expected: Vec<_> = expected.map(|(name, value)| (name.to_owned(), value)).into();
        assert_eq!(node.params(), expected);
    }

    #[test]
    fn other_arguments_are_handed_back_in_order() {
        let args = ["-d", "a.rviz", "x:=y", "--all"].map(str::to_owned);
        let (_, rest) = NodeOptions::new("n", args, |_| None).unwrap();
        assert_eq!(rest, ["-d", "a.rviz", "--all"]);
    }

    #[test]
    fn names_that_ros_does_not_allow_are_errors() {
        let node = options(&[], &[]);
        assert_eq!(node.resolve("1a"), Err(NameError::Invalid("1a".to_owned())));
        assert_eq!(node.resolve("/a b"), Err(NameError::Invalid("/a b".to_owned())));
        let args = ["__name:=a/b".to_owned()];
        assert!(NodeOptions::new("n", args, |_| None).is_err());
    }
}
