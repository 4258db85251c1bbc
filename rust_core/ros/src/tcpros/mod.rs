//! TCPROS: connections for topics and services. Every connection has a thread of its own, so that none waits for
//! another.
//!
//! - [`header`]: the connection header;
//! - [`listener`]: the node's port;
//! - [`publication`]: a published topic, with a queue and a thread for each subscriber;
//! - [`service`]: a service, and [`service_client`]: calls of others;
//! - [`subscription`]: a subscribed topic, with a thread for each publisher.
//!
//! Source: the ROS wiki's pages *ROS/TCPROS* and *ROS/Connection Header*.

pub(crate) mod header;
mod listener;
mod publication;
mod service;
mod service_client;
mod subscription;

pub(crate) use header::Header;
pub(crate) use listener::Listener;
pub use publication::Change;
pub(crate) use publication::{Description, EncodedMessage, Observer, Publication};
pub(crate) use service::Service;
pub(crate) use service_client::call as call_service;
pub(crate) use subscription::{Handler, Link, Source, Subscription, Wanted};
