//! Publishers' nodes that do not answer: each is reported once, however many of its topics the node subscribes to.
//!
//! A node that was killed stays on the master's list, under an address where nobody listens any more. Each of its
//! topics has a thread that tries again and again, see [`crate::tcpros`]; what they find is gathered here by the
//! address of the node.

use std::collections::BTreeMap;
use std::sync::Mutex;

use rcs_scene::lock;

/// A publisher's node that the master names and that does not answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unreachable {
    /// Its name, or its address while the name is not known.
    pub node: String,
    /// What happens when it is asked.
    pub reason: String,
}

/// The nodes that do not answer, by their addresses.
#[derive(Default)]
pub(crate) struct Contacts(Mutex<BTreeMap<String, Unreachable>>);

impl Contacts {
    /// Notes that the node at an address does not answer; true if that is news.
    pub(crate) fn fail(&self, uri: &str, reason: &str) -> bool {
        let mut nodes = lock(&self.0);
        let is_new = !nodes.contains_key(uri);
        if is_new {
            nodes.insert(uri.to_owned(), Unreachable { node: uri.to_owned(), reason: reason.to_owned() });
        }
        is_new
    }

    /// Notes the name of a node that does not answer.
    pub(crate) fn set_name(&self, uri: &str, name: &str) {
        if let Some(node) = lock(&self.0).get_mut(uri) {
            name.clone_into(&mut node.node);
        }
    }

    /// Notes that the node at an address has answered.
    pub(crate) fn succeed(&self, uri: &str) {
        lock(&self.0).remove(uri);
    }

    /// Forgets the nodes that the master no longer names.
    pub(crate) fn retain(&self, is_named: impl Fn(&str) -> bool) {
        lock(&self.0).retain(|uri, _| is_named(uri));
    }

    /// Those of some addresses whose nodes do not answer.
    pub(crate) fn among(&self, uris: &[String]) -> Vec<Unreachable> {
        let nodes = lock(&self.0);
        uris.iter().filter_map(|uri| nodes.get(uri).cloned()).collect()
    }
}

/// Topics as a sentence names them: the first ones, and how many more there are.
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
