//! Questions to the master about other nodes: on which computer they run, and what parameters there are.

use std::net::UdpSocket;

use crate::names::master_uri;
use crate::node::RosNode;
use crate::xmlrpc::client::host_and_port;
use crate::xmlrpc::Value;

impl RosNode {
    /// Address of the master.
    pub fn master_uri(&self) -> &str {
        &self.network().registrar().master().uri
    }

    /// The host of a node's address; `None` for a node that is not registered or a master that does not answer.
    pub fn host_of(&self, node: &str) -> Option<String> {
        let name = self.resolve(node).ok()?;
        let uri = self.network().registrar().master().call("lookupNode", &[&name]).ok()?;
        Some(host_and_port(uri.as_str()?)?.0)
    }

    /// Whole names of all parameters; empty if the master does not answer.
    pub fn parameter_names(&self) -> Vec<String> {
        let names = self.network().registrar().master().call("getParamNames", &[]);
        names.map(|names| crate::master::strings(&names)).unwrap_or_default()
    }

    /// A parameter by its whole name; `None` if it is not set or the master does not answer.
    pub fn parameter(&self, whole_name: &str) -> Option<Value> {
        self.network().registrar().master().param(whole_name).ok().flatten()
    }

    /// Deletes this node's private parameters, for a node whose name nobody uses again.
    pub fn delete_parameters(&self) {
        if !self.parameters().is_empty() {
            // A master that does not answer keeps them.
            let _ = self.network().registrar().master().call("deleteParam", &[self.name()]);
        }
    }
}

/// Address of the master by this process's environment and arguments.
pub fn address_of_master() -> String {
    master_uri()
}

/// `true` if a host is this computer: one of its own addresses, or a name of one.
pub fn is_this_computer(host: &str) -> bool {
    // The system binds a socket to own addresses only.
    UdpSocket::bind((host, 0)).is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_own_addresses_are_this_computer() {
        assert!(is_this_computer("localhost") && is_this_computer("127.0.0.1"));
        // Reserved for documentation (RFC 5737).
        assert!(!is_this_computer("192.0.2.1"));
    }
}
