//! Comparison with the master's list every other second, which repairs what was lost on the way.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use rcs_scene::lock;

use super::entry::Entry;
use super::state::{ComparedPublishers, RegistrarState, MOST_PUBLISHERS};
use super::Registrar;
use crate::graph::Publications;
use crate::tcpros::Subscription;

/// How often the master is asked again for the publishers of a topic while some of them cannot be connected with.
const REMINDER: Duration = Duration::from_secs(30);

/// Publishers of a topic that are connected, and all whose first attempt has not failed.
#[derive(Clone, Copy, Default)]
struct LinkCounts {
    connected: usize,
    promising: usize,
}

impl Registrar {
    /// Registers again what is not on the master's list, and each subscription whose publishers may be others than the
    /// master's. What is no longer wanted stays registered until it is unregistered.
    pub(super) fn repair(&self) {
        let Some(system) = self.query() else { return };
        let publications = self.publications().unwrap_or_default();
        let links: BTreeMap<String, LinkCounts> =
            self.subscriptions().iter().map(|subscription| links_of(subscription)).collect();
        let mut state = lock(&self.state);
        let wanted: Vec<Entry> = state.registered.intersection(&state.wanted).cloned().collect();
        for entry in wanted {
            if !entry.is_in(&system) || has_other_publishers(&entry, &mut state, &publications, &links) {
                log::debug!("registering again: {entry:?}");
                state.registered.remove(&entry);
            }
        }
    }
}

/// `true` if a subscription's publishers may be others than the master's. The master lists names of nodes and this node
/// knows their addresses, so numbers are compared; registering again tells for certain.
fn has_other_publishers(
    entry: &Entry,
    state: &mut RegistrarState,
    publications: &Publications,
    links: &BTreeMap<String, LinkCounts>,
) -> bool {
    let Entry::Subscriber { topic, .. } = entry else { return false };
    let named = publications.get(topic).map(|publication| publication.nodes.as_slice()).unwrap_or_default();
    let links = links.get(topic).copied().unwrap_or_default();
    let Some(subscribed) = state.topics.get_mut(topic) else { return false };
    let known = &subscribed.publishers;
    if named.len().min(MOST_PUBLISHERS) > known.len() {
        return true;
    }
    // Connections that stand are kept, whatever the master says; and registering again helps once.
    if known.len() > named.len().max(links.connected) && Some(known) != subscribed.registered_publishers.as_ref() {
        return true;
    }
    // As many as the master names, but some of them do not answer: perhaps they are those of an earlier list.
    if named.len().min(MOST_PUBLISHERS) <= links.promising {
        subscribed.compared = None;
        return false;
    }
    let mut named = named.to_vec();
    named.sort_unstable();
    let is_old = |before: &ComparedPublishers| {
        before.named != named || before.known != *known || before.when.elapsed() > REMINDER
    };
    let is_due = subscribed.compared.as_ref().is_none_or(is_old);
    if is_due {
        subscribed.compared = Some(ComparedPublishers { named, known: known.clone(), when: Instant::now() });
    }
    is_due
}

/// A subscribed topic and its connections.
fn links_of(subscription: &Subscription) -> (String, LinkCounts) {
    let links = subscription.links();
    let count = LinkCounts {
        connected: links.iter().filter(|link| link.connected().is_some()).count(),
        promising: links.iter().filter(|link| link.is_promising()).count(),
    };
    (subscription.wanted().topic.to_string(), count)
}
