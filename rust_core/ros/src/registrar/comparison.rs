//! Comparing with the master's list, every other second: what was lost on the way is noticed and repaired.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use rcs_scene::lock;

use super::{Entry, Registrar, State, MOST_PUBLISHERS};
use crate::graph::Publications;
use crate::tcpros::Subscription;

/// How often the master is asked again for the publishers of a topic while some of them cannot be connected with.
const REMINDER: Duration = Duration::from_secs(30);

/// Why a subscription was registered again.
pub(super) struct Compared {
    /// The names of the publishers' nodes on the master's list, in order.
    named: Vec<String>,
    /// The addresses that this node was told.
    known: Vec<String>,
    when: Instant,
}

/// How many publishers of a topic there is a connection with, and how many in all whose first attempt has not failed.
#[derive(Clone, Copy, Default)]
struct Links {
    connected: usize,
    promising: usize,
}

impl Registrar {
    /// Registers again what is not on the master's list, and each subscription whose publishers may be others than the
    /// master's: what the master tells may be lost on the way, and somebody else may tell something. What is wanted no
    /// more stays registered until it is unregistered.
    pub(super) fn repair(&self) {
        let Some(system) = self.query() else { return };
        let publications = self.publications().unwrap_or_default();
        let links: BTreeMap<String, Links> =
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

/// Whether a subscription's publishers may be others than the master's. The master's list has the names of their nodes
/// and this node their addresses, so that numbers are compared; registering again tells for certain.
fn has_other_publishers(
    entry: &Entry,
    state: &mut State,
    publications: &Publications,
    links: &BTreeMap<String, Links>,
) -> bool {
    let Entry::Subscriber { topic, .. } = entry else { return false };
    let named = publications.get(topic).map(|publication| publication.nodes.as_slice()).unwrap_or_default();
    let links = links.get(topic).copied().unwrap_or_default();
    let known = state.publishers.get(topic).cloned().unwrap_or_default();
    if named.len().min(MOST_PUBLISHERS) > known.len() {
        return true;
    }
    // Connections that stand are kept, whatever the master says; and registering again helps once.
    if known.len() > named.len().max(links.connected) && Some(&known) != state.registered_publishers.get(topic) {
        return true;
    }
    // As many as the master names, but some of them do not answer: perhaps they are those of an earlier list.
    if named.len().min(MOST_PUBLISHERS) <= links.promising {
        state.compared.remove(topic);
        return false;
    }
    let mut named = named.to_vec();
    named.sort_unstable();
    let is_old = |before: &Compared| before.named != named || before.known != known || before.when.elapsed() > REMINDER;
    let is_due = state.compared.get(topic).is_none_or(is_old);
    if is_due {
        state.compared.insert(topic.clone(), Compared { named, known, when: Instant::now() });
    }
    is_due
}

/// A subscribed topic, and its links.
fn links_of(subscription: &Subscription) -> (String, Links) {
    let links = subscription.links();
    let count = Links {
        connected: links.iter().filter(|link| link.connected().is_some()).count(),
        promising: links.iter().filter(|link| link.is_promising()).count(),
    };
    (subscription.wanted().topic.to_string(), count)
}
