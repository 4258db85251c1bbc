//! All that speaks ROS 1: no other crate opens a connection.
//!
//! ```text
//!   publishers ──► a thread each (read, decode) ──► EventQueue ──► the one thread that owns the scene
//!                                                                        │
//!   subscribers ◄── a thread each ◄── queue of the newest ◄──────────────┘
//! ```
//!
//! Nobody waits for anybody else: each publisher and each subscriber has a thread of its own, each subscription and
//! each subscriber a queue of a fixed size in which the oldest message is dropped, and every call has a limit. A topic
//! of queue size 1 is therefore always the latest message, however slow the scene or the subscriber is.
//!
//! Names, namespaces, remappings and ROS's arguments are rosrust's. What the node is to others (its API, its topics and
//! services, and their registration) is done here, because rosrust writes to subscribers one after the other, connects
//! to publishers one after the other, and waits for both and for the master without limit.
//!
//! What is where:
//!
//! | Module | Holds |
//! |---|---|
//! | `startup` | [`init`]: what has to happen before the process has threads |
//! | `waiting` | waiting for a master that is not there yet |
//! | `node` | [`RosNode`]: connecting, subscribing, services, parameters, shutting down |
//! | `events` | [`EventQueue`], [`NodeEvent`] and [`ServiceCall`]: what the node received, in two queues |
//! | `topic` | [`TopicSubscription`]: several subscriptions of one topic in a process, latched messages included |
//! | `publisher` | [`Publisher`]: a topic that the node publishes |
//! | [`image_topic`] | a camera's picture with its CameraInfo |
//! | `rosout` | the log on `/rosout`, and the services that change its level |
//! | `reconfigure` | [`ReconfigureServer`]: dynamic_reconfigure |
//! | `parameters`, `param_writer` | parameters read and written without waiting for the master |
//! | `clock` | [`RosClock`]: the computer's time or `/clock` |
//! | `network` | the node's ports, its API and its registrations, together |
//! | `registrar` | what is registered with the master, and the thread that keeps it so |
//! | `contacts` | publishers that do not answer |
//! | `node_api` | what the master, other nodes and tools ask the node |
//! | `rosrust_master` | what rosrust takes for the master |
//! | `graph` | the master's API, and what it knows of the other nodes |
//! | `acceptor` | a listening socket whose connections have a thread each |
//! | `timed_read` | reading from a connection by a deadline |
//! | `tcpros` | connections with publishers, subscribers and services' callers |
//! | `xmlrpc` | calls to the master and to nodes, and a server of them |
//! | `fuzzing` | the readers of foreign bytes by themselves, for `tests/fuzz_harness` |

#![forbid(unsafe_code)]

mod acceptor;
mod clock;
mod contacts;
mod events;
#[doc(hidden)]
pub mod fuzzing;
mod graph;
pub mod image_topic;
mod network;
mod node;
mod node_api;
mod param_writer;
mod parameters;
mod publisher;
mod reconfigure;
mod registrar;
mod rosout;
mod rosrust_master;
mod startup;
mod tcpros;
mod timed_read;
mod topic;
mod waiting;
mod xmlrpc;

pub use clock::RosClock;
pub use contacts::Unreachable;
pub use events::{EventQueue, EventSender, NodeEvent, Reply, ServiceCall, TriggerReply};
pub use graph::{Publication, Publications};
pub use node::{is_asked_to_end, node_time, plain_args, NodeError, NodeTime, RosNode};
pub use parameters::remapping_of;
pub use publisher::Publisher;
pub use reconfigure::ReconfigureServer;
pub use rosout::{log_line, LogLine, Loggers};
pub use startup::{init, restart};
pub use tcpros::Change;
pub use topic::{Publishing, TopicSubscription};

use rustix::event::Timespec;

/// [`rcs_scene::IDLE_PERIOD`], for `poll`.
const IDLE_TIMEOUT: Timespec = Timespec { tv_sec: rcs_scene::IDLE_PERIOD.as_secs() as i64, tv_nsec: 0 };

/// Timeout of waits in tests: ten times what a slow machine needs.
#[cfg(test)]
const TEST_PATIENCE: std::time::Duration = std::time::Duration::from_secs(60);
