//! A ROS 1 node: it registers with the master, publishes, subscribes and serves.
//!
//! ```text
//!   master ◄── Master (XML-RPC client) ──┐
//!   nodes  ◄── requestTopic ─────────────┤
//!   nodes  ──► slave API (tiny_http) ──► Node ──► publications, subscriptions, services
//!   nodes  ◄─► one TCPROS port ──────────┘
//! ```
//!
//! Why a client library of our own: the existing one (rosrust) writes to a topic's subscribers one after the other from
//! one thread, so that a stopped viewer freezes the projection; waits without limit for publishers, under one lock for
//! all topics; does not come back to a publisher whose connection broke; and rests on an HTTP library that has been
//! unmaintained for years and that coming compilers reject. None of that can be repaired from outside.
//!
//! Here every connection has a thread of its own, everything that waits for another process has a time limit, and
//! nothing that the caller does waits for another process except registering:
//!
//! - a [`Publisher`] gives each subscriber its own queue and writer; a stalled one loses messages, the others do not
//!   notice;
//! - a subscription connects to each publisher separately, and again after the connection broke, for as long as the
//!   master lists that publisher;
//! - a master that was restarted is told again of all that the node publishes, subscribes to and serves;
//! - a node is not connected to itself.

mod header;
mod link;
mod listener;
mod master;
mod names;
mod node;
mod publication;
mod service;
mod slave;
mod subscription;
pub mod xmlrpc;

pub use names::{NameError, NodeOptions};
pub use node::{Node, NodeError};
pub use publication::{Frame, Publisher, PublisherOptions};
pub use service::ServiceServer;
pub use subscription::{Incoming, Subscription};

/// What both ends of a connection must agree on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TypeInfo {
    /// `package/Name`.
    pub name: String,
    /// The definition's checksum, in hexadecimal; `*` agrees with every type.
    pub md5sum: String,
    /// The definition's text.
    pub definition: String,
}
