//! Errors of the node.

/// Errors of the node.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NodeError {
    /// Waiting for the master was cancelled.
    #[error("gave up waiting for the ROS master at {0}")]
    Cancelled(String),
    /// There is no master.
    #[error("no ROS master at {uri}: {reason}")]
    NoMaster {
        /// Address of the master.
        uri: String,
        /// Error of the call.
        reason: String,
    },
    /// No port or thread is available.
    #[error("cannot start {what}: {reason}")]
    Start {
        /// The part that cannot be started.
        what: &'static str,
        /// The system's error.
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
        /// Reason.
        reason: String,
    },
    /// A service cannot be called, or answers with an error.
    #[error("calling {service} failed: {reason}")]
    Call {
        /// Whole name of the service.
        service: String,
        /// Reason.
        reason: String,
    },
    /// The node subscribes to the topic with another type already.
    #[error("{topic} is subscribed to as {subscribed}, not {wanted}")]
    TypeMismatch {
        /// Whole name of the topic.
        topic: String,
        /// Type of the subscription.
        subscribed: &'static str,
        /// Type that was wanted.
        wanted: &'static str,
    },
}
