//! Wanted and made registrations.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Weak};
use std::time::Instant;

use super::entry::Entry;
use crate::tcpros::Subscription;

/// Publishers of a topic that the node connects with: a stranger's message may name any number.
pub(super) const MOST_PUBLISHERS: usize = 256;

/// The registrations, wanted and made.
#[derive(Default)]
pub(super) struct RegistrarState {
    pub(super) wanted: BTreeSet<Entry>,
    pub(super) registered: BTreeSet<Entry>,
    /// Refused by the master; not tried again.
    pub(super) refused: BTreeSet<Entry>,
    /// Subscribed topics by their whole names.
    pub(super) topics: BTreeMap<String, SubscribedTopic>,
    /// The master does not take several calls at once.
    pub(super) has_no_batches: bool,
    /// Number of times the master has named the publishers of some topic.
    pub(super) updates: u64,
    /// Time of the master's last answer.
    pub(super) answered: Option<Instant>,
    pub(super) is_ended: bool,
    /// [`Registrar::run`](super::Registrar::run) has returned.
    pub(super) is_done: bool,
}

/// A subscribed topic and its publishers, by the addresses of their nodes.
pub(super) struct SubscribedTopic {
    /// Number of the subscription's entry.
    pub(super) number: u64,
    pub(super) subscription: Weak<Subscription>,
    pub(super) publishers: Vec<String>,
    /// Publishers that the master named when the topic was registered.
    pub(super) registered_publishers: Option<Vec<String>>,
    /// Publishers that a master named which was then restarted, until the new one names others.
    pub(super) named_before_restart: Vec<String>,
    /// Publishers for which the topic was registered again.
    pub(super) compared: Option<ComparedPublishers>,
    /// The master names more than [`MOST_PUBLISHERS`].
    pub(super) has_too_many: bool,
}

/// The publishers of a topic that was registered again because they may be others than the master's.
pub(super) struct ComparedPublishers {
    /// Names of the publishers' nodes on the master's list, in order.
    pub(super) named: Vec<String>,
    /// Addresses that this node was told.
    pub(super) known: Vec<String>,
    pub(super) when: Instant,
}

/// A call to the master.
pub(super) enum RegistrarStep {
    Unregister(Entry),
    Register(Entry),
}

impl SubscribedTopic {
    pub(super) fn new(number: u64, subscription: &Arc<Subscription>) -> Self {
        Self {
            number,
            subscription: Arc::downgrade(subscription),
            publishers: Vec::new(),
            registered_publishers: None,
            named_before_restart: Vec::new(),
            compared: None,
            has_too_many: false,
        }
    }
}

impl RegistrarState {
    /// The next call. Unregistering goes first: a topic may be wanted with another type, and an entry that replaces
    /// another of its name is registered after that was unregistered.
    pub(super) fn next_step(&self) -> Option<RegistrarStep> {
        if let Some(surplus) = self.registered.difference(&self.wanted).next() {
            return Some(RegistrarStep::Unregister(surplus.clone()));
        }
        let mut missing = self.wanted.difference(&self.registered).filter(|entry| !self.refused.contains(entry));
        missing.next().map(|entry| RegistrarStep::Register(entry.clone()))
    }

    /// The subscription of a topic.
    pub(super) fn subscription(&self, topic: &str) -> Option<Arc<Subscription>> {
        self.topics.get(topic)?.subscription.upgrade()
    }

    /// Known publishers of a topic.
    pub(super) fn publishers(&self, topic: &str) -> Vec<String> {
        self.topics.get(topic).map(|topic| topic.publishers.clone()).unwrap_or_default()
    }
}
