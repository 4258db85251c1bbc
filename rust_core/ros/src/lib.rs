//! ROS 1 node: no other crate opens a connection.
//!
//! ```text
//!   publishers ──► a thread each (read, decode) ──► EventQueue ──► the one thread that owns the scene
//!                                                                        │
//!   subscribers ◄── a thread each ◄── queue of the newest ◄──────────────┘
//! ```
//!
//! Each publisher and subscriber has a thread of its own, each subscription and subscriber a queue of fixed size in
//! which the oldest message is dropped, and every call a time limit. A topic of queue size 1 is therefore always the
//! latest message, however slow the scene or the subscriber is.
//!
//! Only rosrust's message traits and its reading of ROS's arguments and environment are used: its node serves
//! subscribers and publishers one after the other and waits for them and for the master without limit.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod acceptor;
mod clock;
mod contacts;
mod error;
mod events;
#[cfg(any(test, feature = "fuzzing"))]
pub mod fuzzing;
pub mod image_topic;
mod master;
mod names;
mod network;
mod node;
mod node_api;
mod param_writer;
mod parameters;
mod publisher;
mod reconfigure;
mod registrar;
mod rosout;
mod service_call;
pub mod settings;
mod socket;
mod survey;
mod tcpros;
mod topic;
mod waiting;
mod xmlrpc;

pub use clock::RosClock;
pub use contacts::Unreachable;
pub use error::NodeError;
pub use events::{EventQueue, EventSender, NodeEvent, Reply, ServiceCall, TriggerReply};
pub use master::{Publication, Publications};
pub use names::{host_names, remapping_of, ros_folder};
pub use node::{is_asked_to_end, node_time, NodeTime, Parameters, RosNode};
pub use publisher::Publisher;
pub use reconfigure::ReconfigureServer;
pub use rosout::{log_line, LogLine, Loggers};
pub use survey::{address_of_master, is_this_computer};
pub use tcpros::Change;
pub use topic::{Publishing, TopicSubscription};
pub use xmlrpc::Value as ParameterValue;
