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
    /// Registered, but to be registered again.
    pub(super) again: BTreeSet<Entry>,
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
    /// The master names more than [`MOST_PUBLISHERS`].
    pub(super) has_too_many: bool,
}

/// A call to the master.
pub(super) enum RegistrarStep {
    Unregister(Entry),
    Register(Entry),
}

impl SubscribedTopic {
    pub(super) fn new(number: u64, subscription: &Arc<Subscription>) -> Self {
        Self { number, subscription: Arc::downgrade(subscription), publishers: Vec::new(), has_too_many: false }
    }
}

impl RegistrarState {
    /// The next call. Unregistering goes first: a topic may be wanted with another type, and an entry that replaces
    /// another of its name is registered after that was unregistered.
    pub(super) fn next_step(&self) -> Option<RegistrarStep> {
        if let Some(surplus) = self.registered.difference(&self.wanted).next() {
            return Some(RegistrarStep::Unregister(surplus.clone()));
        }
        let is_due = |entry: &&Entry| !self.registered.contains(entry) || self.again.contains(entry);
        let mut missing = self.wanted.iter().filter(is_due).filter(|entry| !self.refused.contains(entry));
        missing.next().map(|entry| RegistrarStep::Register(entry.clone()))
    }

    /// [`next_step`](Self::next_step), which is about to be made.
    pub(super) fn take_step(&mut self) -> Option<RegistrarStep> {
        let step = self.next_step();
        if let Some(RegistrarStep::Register(entry)) = &step {
            self.again.remove(entry);
        }
        step
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
