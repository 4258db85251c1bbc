//! Errors of the node.

/// Why the node could not do something.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NodeError {
    /// Waiting for the master was cancelled.
    #[error("gave up waiting for the ROS master at {0}")]
    Cancelled(String),
    /// There is no master.
    #[error("no ROS master at {uri}: {reason}")]
    NoMaster {
        /// Where it should be.
        uri: String,
        /// What is there instead.
        reason: String,
    },
    /// A port or a thread cannot be had.
    #[error("cannot start {what}: {reason}")]
    Start {
        /// What was to be started.
        what: &'static str,
        /// The system's reason.
        reason: String,
    },
    /// The address of the master cannot be parsed.
    #[error("'{0}' is not the address of a ROS master")]
    MasterUri(String),
    /// The name is not one that ROS allows.
    #[error("'{0}' is not a valid ROS name")]
    Name(String),
    /// A private parameter among the arguments cannot be set.
    #[error("invalid value '{value}' for {name}: {reason}")]
    Argument {
        /// The parameter, as `~name`.
        name: String,
        /// Its value as given.
        value: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The node subscribes to the topic with another type already.
    #[error("{topic} is subscribed to as {subscribed}, not {wanted}")]
    TypeMismatch {
        /// The topic's whole name.
        topic: String,
        /// Its type so far.
        subscribed: &'static str,
        /// The other type.
        wanted: &'static str,
    },
}
