//! Publishers' nodes that do not answer, each reported once for all of its topics.
//!
//! A node that was killed stays on the master's list. Each of its topics has a thread that retries to connect; the
//! failures are collected here by the address of the node.

use std::collections::BTreeMap;
use std::sync::Mutex;

use rcs_process::lock;

/// A publisher's node that does not answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unreachable {
    /// Name, or address while the name is unknown.
    pub node: String,
    /// Error of the last call.
    pub reason: String,
}

/// Nodes that do not answer, by address.
#[derive(Default)]
pub(crate) struct Contacts(Mutex<BTreeMap<String, Unreachable>>);

impl Contacts {
    /// Notes a failure; `true` if it is the first of this node.
    pub(crate) fn fail(&self, uri: &str, reason: &str) -> bool {
        let mut nodes = lock(&self.0);
        let is_new = !nodes.contains_key(uri);
        if is_new {
            nodes.insert(uri.to_owned(), Unreachable { node: uri.to_owned(), reason: reason.to_owned() });
        }
        is_new
    }

    /// Notes the name of a failed node.
    pub(crate) fn set_name(&self, uri: &str, name: &str) {
        if let Some(node) = lock(&self.0).get_mut(uri) {
            name.clone_into(&mut node.node);
        }
    }

    /// Notes an answer.
    pub(crate) fn succeed(&self, uri: &str) {
        lock(&self.0).remove(uri);
    }

    /// Forgets the nodes that the master no longer names.
    pub(crate) fn retain(&self, is_named: impl Fn(&str) -> bool) {
        lock(&self.0).retain(|uri, _| is_named(uri));
    }

    /// The failed nodes among some addresses.
    pub(crate) fn among(&self, uris: &[String]) -> Vec<Unreachable> {
        let nodes = lock(&self.0);
        uris.iter().filter_map(|uri| nodes.get(uri).cloned()).collect()
    }
}

/// Formats the first topics and the number of the others.
pub(crate) fn list_of(topics: &[String]) -> String {
    const MOST: usize = 3;
    let named: Vec<String> = topics.iter().take(MOST).map(|topic| format!("[{topic}]")).collect();
    let more = match topics.len().saturating_sub(MOST) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("topic{} {}{more}", if topics.len() == 1 { "" } else { "s" }, named.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_news_once_until_it_answers_or_is_no_longer_named() {
        let contacts = Contacts::default();
        let uri = "http://robot:1/".to_owned();
        assert!(contacts.fail(&uri, "refused") && !contacts.fail(&uri, "refused"));
        contacts.set_name(&uri, "/talker");
        let expected = Unreachable { node: "/talker".to_owned(), reason: "refused".to_owned() };
        assert_eq!(contacts.among(&["http://other:1/".to_owned(), uri.clone()]), [expected]);
        contacts.succeed(&uri);
        assert!(contacts.among(std::slice::from_ref(&uri)).is_empty() && contacts.fail(&uri, "refused"));
        contacts.retain(|_| false);
        assert!(contacts.fail(&uri, "refused"));
    }

    #[test]
    fn many_topics_are_a_number() {
        let topics: Vec<String> = (0..5).map(|index| format!("/{index}")).collect();
        assert_eq!(list_of(&topics[..1]), "topic [/0]");
        assert_eq!(list_of(&topics[..2]), "topics [/0], [/1]");
        assert_eq!(list_of(&topics), "topics [/0], [/1], [/2] and 2 more");
    }
}
