//! XML-RPC as ROS 1 uses it between a node, the master and other nodes.
//!
//! [`value`] is what a call carries, [`http`] reads and writes one HTTP message within limits, [`client`] makes a call
//! with a deadline, [`server`] answers calls. `rosrust` brings an XML-RPC of its own, without time limits: a master or
//! node that accepts a connection and then stays silent blocks its caller for good, and each such call leaves a thread.
//!
//! Source: the XML-RPC specification (1999) and the ROS wiki's pages *Master_API*, *Slave_API* and *Parameter Server
//! API*.

pub(crate) mod client;
pub(crate) mod http;
pub(crate) mod server;
pub(crate) mod value;

pub(crate) use client::{call, CallError};
pub(crate) use server::Server;
pub(crate) use value::parse_call;
pub use value::Value;
