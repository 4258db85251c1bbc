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
//! Of rosrust only the traits of messages, and what reads ROS's arguments and environment, are used: its node writes to
//! subscribers one after the other, connects to publishers one after the other, and waits for both and for the master
//! without limit.
//!
//! What is where:
//!
//! | Module | Holds |
//! |---|---|
//! | `names` | the process's arguments and environment: names, host, private parameters |
//! | `restart` | [`restart()`]: starting the program again |
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
//! | `graph` | the master's API, and what it knows of the other nodes |
//! | `acceptor` | a listening socket whose connections have a thread each |
//! | `socket` | deadlines and keep-alive of connections |
//! | `tcpros` | connections with publishers, subscribers and services' callers |
//! | `xmlrpc` | calls to the master and to nodes, and a server of them |
//! | `fuzzing` | the readers of foreign bytes by themselves, for `tests/fuzz_harness` |

#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod acceptor;
mod clock;
mod contacts;
mod error;
mod events;
#[doc(hidden)]
pub mod fuzzing;
mod graph;
pub mod image_topic;
mod names;
mod network;
mod node;
mod node_api;
mod param_writer;
mod parameters;
mod publisher;
mod reconfigure;
mod registrar;
mod restart;
mod rosout;
mod socket;
mod tcpros;
mod topic;
mod waiting;
mod xmlrpc;

pub use clock::RosClock;
pub use contacts::Unreachable;
pub use error::NodeError;
pub use events::{EventQueue, EventSender, NodeEvent, Reply, ServiceCall, TriggerReply};
pub use graph::{Publication, Publications};
pub use names::{plain_args, remapping_of};
pub use node::{is_asked_to_end, node_time, NodeTime, Parameters, RosNode};
pub use publisher::Publisher;
pub use reconfigure::ReconfigureServer;
pub use restart::restart;
pub use rosout::{log_line, LogLine, Loggers};
pub use tcpros::Change;
pub use topic::{Publishing, TopicSubscription};
pub use xmlrpc::Value as ParameterValue;
