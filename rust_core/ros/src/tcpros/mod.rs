//! TCPROS: the connections over which nodes send each other topics.
//!
//! `rosrust` writes to the subscribers of a topic one after the other and waits for each, and it connects to publishers
//! one after the other without time limits. Here every connection has a thread of its own, so that nobody waits for
//! anybody else:
//!
//! - [`header`]: the fields that both sides send first;
//! - [`listener`]: the node's one port; it finds out what a connection is about and hands it to the publication;
//! - [`publication`]: a topic that the node publishes, and a queue and a thread for each of its subscribers;
//! - [`service`]: a service that the node offers;
//! - [`subscription`]: a topic that the node subscribes to, and a thread for each of its publishers.
//!
//! Source: the ROS wiki's pages *ROS/TCPROS* and *ROS/Connection Header*.

pub(crate) mod header;
mod listener;
mod publication;
mod service;
mod subscription;

pub(crate) use listener::Listener;
pub use publication::Change;
pub(crate) use publication::{Description, Frame, Observer, Publication};
pub(crate) use service::Service;
pub(crate) use subscription::{Handler, Link, Source, Subscription, Wanted};
