//! XML-RPC between a node, the master and other nodes: [`value`]s as XML, [`http`] messages within limits, a [`client`]
//! with deadlines, and a [`server`].
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
