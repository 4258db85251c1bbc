//! All that speaks ROS 1, through rosrust: no other crate uses its connections.
//!
//! ```text
//!   publishers ──► rosrust's threads (decode) ──► EventQueue ──► the one thread that owns the scene ──► publishers
//! ```
//!
//! rosrust's threads never wait for the scene: each subscription has a queue of a fixed size, and the oldest message is
//! dropped. A topic of queue size 1 is therefore always the latest message, however slow the scene is.
//!
//! Names, namespaces and remappings are rosrust's, which reads the process's arguments and environment as roscpp does.
//!
//! What is where:
//!
//! | Module | Holds |
//! |---|---|
//! | `node` | [`RosNode`]: connecting, subscribing, services, parameters, shutting down |
//! | `events` | [`EventQueue`] and [`NodeEvent`]: what the node received, in one queue |
//! | `topic` | [`TopicSubscription`]: several subscriptions of one topic in a process, latched messages included |
//! | [`image_topic`] | a camera's picture with its CameraInfo |
//! | `latched_publisher` | [`LatchedPublisher`]: a topic whose last message late subscribers get |
//! | [`diagnostics_topic`] | `/diagnostics` |
//! | `reconfigure` | [`ReconfigureServer`]: dynamic_reconfigure |
//! | `parameters`, `param_writer` | parameters read and written without waiting for the master |
//! | `clock` | [`RosClock`]: the computer's time or `/clock` |
//! | `master` | waiting for a master that is not there yet |
//! | `graph` | XML-RPC calls to the master and to other nodes |
//! | `watchdog` | repairs: broken connections, a restarted master, nodes that do not answer |
//! | `connections`, `listeners` | the process's TCP connections and ports, which rosrust does not expose |
//! | `foreign_sockets` | the one module with `unsafe` code: duplicates of sockets that rosrust owns |

#![deny(unsafe_code)]

mod clock;
mod connections;
pub mod diagnostics_topic;
mod events;
mod foreign_sockets;
mod graph;
pub mod image_topic;
mod latched_publisher;
mod listeners;
mod master;
mod node;
mod param_writer;
mod parameters;
mod reconfigure;
mod topic;
mod watchdog;

pub use clock::RosClock;
pub use events::{EventQueue, EventSender, NodeEvent, Reply, TriggerReply};
pub use graph::{Publication, Publications};
pub use latched_publisher::LatchedPublisher;
pub use node::{is_asked_to_end, plain_args, NodeError, RosNode};
pub use reconfigure::ReconfigureServer;
pub use topic::TopicSubscription;

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Locks, also after a panic of another thread: what these locks protect is whole at any time.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
