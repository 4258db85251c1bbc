//! Registrations.

use std::sync::atomic::{AtomicU64, Ordering};

/// A registration. Two of one name and type differ by their number, so that one that replaces another is registered
/// anew.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Entry {
    /// The node publishes a topic of a type.
    Publisher { topic: String, ros_type: String, number: u64 },
    /// The node subscribes to a topic of a type.
    Subscriber { topic: String, ros_type: String, number: u64 },
    /// The node serves at an address `rosrpc://host:port`.
    Service { service: String, api: String, number: u64 },
}

impl Entry {
    /// A number that is unique in the process.
    pub(crate) fn next_number() -> u64 {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        NEXT.fetch_add(1, Ordering::Relaxed)
    }

    pub(super) fn name(&self) -> &str {
        match self {
            Self::Publisher { topic, .. } | Self::Subscriber { topic, .. } => topic,
            Self::Service { service, .. } => service,
        }
    }

    /// `true` if the master has one entry for both, so that unregistering one unregisters the other.
    pub(super) fn shares_place(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other) && self.name() == other.name()
    }
}
