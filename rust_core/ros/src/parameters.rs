//! Parameters that are fetched in the background, such as robot descriptions.
//!
//! A name is looked up as by `ros::NodeHandle::getParam` and `searchParam`: in the node's namespace and then in those
//! around it, and one that is remapped to an absolute name only there. As in rviz, a parameter that is not set is
//! polled once a second, and one that is not a string counts as empty.

use crate::events::NodeEvent;
use crate::names::remapping_of;
use crate::node::{RosNode, Shared};
use crate::xmlrpc::CallError;
use rcs_process::lock;
use rcs_text::clean_name;
use std::sync::{Arc, Weak};
use std::time::Duration;

const POLL_PERIOD: Duration = Duration::from_secs(1);

impl RosNode {
    /// Polls string parameters until each is set. Each causes a [`NodeEvent::Parameter`] with its value, and one
    /// without before, if it is not set at first.
    pub fn follow_parameters(&self, names: Vec<String>) {
        if names.is_empty() {
            return;
        }
        let is_polling = {
            let mut followed = lock(&self.shared.followed_parameters);
            let is_polling = !followed.is_empty();
            followed.extend(names.into_iter().map(|name| (name, false)));
            is_polling
        };
        if is_polling {
            return;
        }
        let shared = Arc::downgrade(&self.shared);
        let spawned = std::thread::Builder::new().name("ros-parameters".to_owned()).spawn(move || poll(&shared));
        if let Err(error) = spawned {
            log::error!("parameters cannot be fetched: {error}");
        }
    }
}

impl RosNode {
    /// Reads parameters by their whole names and passes their values as texts to `done`, in the same order; `None` for
    /// one that is not set or has no text. A silent master is asked again.
    pub fn fetch_texts(&self, names: Vec<String>, done: impl FnOnce(Vec<Option<String>>) + Send + 'static) {
        let network = Arc::downgrade(self.network());
        let fetching = move || loop {
            let Some(network) = network.upgrade().filter(|network| !network.is_ended()) else { return };
            let master = network.registrar().master();
            let values: Result<Vec<_>, CallError> = names.iter().map(|name| master.param(name)).collect();
            if let Ok(values) = values {
                return done(values.iter().map(|value| value.as_ref()?.text()).collect());
            }
            drop(network);
            std::thread::sleep(POLL_PERIOD);
        };
        let spawned = std::thread::Builder::new().name("ros-fetch".to_owned()).spawn(fetching);
        if let Err(error) = spawned {
            log::error!("parameters cannot be fetched: {error}");
        }
    }
}

/// Polls until all followed parameters were found. The master is called without a lock.
fn poll(shared: &Weak<Shared>) {
    loop {
        let Some(names) = shared.upgrade().map(|shared| lock(&shared.followed_parameters).clone()) else { return };
        for (name, is_reported) in names {
            let Some(shared) = shared.upgrade() else { return };
            // A silent master is no answer.
            let Ok(text) = find(&shared, &name) else { continue };
            let mut followed = lock(&shared.followed_parameters);
            if text.is_some() {
                followed.remove(&name);
            } else {
                followed.insert(name.clone(), true);
            }
            drop(followed);
            if text.is_some() || !is_reported {
                shared.events.sender(0).push(NodeEvent::Parameter { name: name.as_str().into(), text });
            }
        }
        let Some(shared) = shared.upgrade() else { return };
        if lock(&shared.followed_parameters).is_empty() || shared.network.is_ended() {
            return;
        }
        drop(shared);
        std::thread::sleep(POLL_PERIOD);
    }
}

/// The value of a parameter in the nearest namespace.
///
/// # Errors
/// The master does not answer.
fn find(shared: &Shared, name: &str) -> Result<Option<Arc<str>>, CallError> {
    let (Ok(own), master) = (shared.names.resolve(name), shared.network.registrar().master()) else { return Ok(None) };
    let (namespace, _) = master.node_name.rsplit_once('/').unwrap_or_default();
    for candidate in candidates(own, namespace, &clean_name(name), remapping_of(name).as_deref()) {
        if let Some(value) = master.param(&candidate)? {
            return Ok(Some(value.as_str().unwrap_or_default().into()));
        }
    }
    Ok(None)
}

/// The whole names to look up, in order. `own` is the name resolved in the node's namespace, `remapping` its remapping
/// on the command line.
fn candidates(own: String, namespace: &str, name: &str, remapping: Option<&str>) -> Vec<String> {
    let is_absolute = |name: &str| name.starts_with(['/', '~']);
    let searched = match remapping {
        _ if own == format!("{namespace}/{name}") => name,
        Some(other) => other,
        None => return vec![own],
    };
    if is_absolute(name) || is_absolute(searched) {
        return vec![own];
    }
    let mut namespace = namespace;
    let mut names = Vec::new();
    loop {
        names.push(clean_name(&format!("{namespace}/{searched}")));
        match namespace.rsplit_once('/') {
            Some((outer, _)) => namespace = outer,
            None => return names,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_relative_name_is_looked_for_in_all_namespaces_around_the_node() {
        let names = candidates("/a/b/robot_description".to_owned(), "/a/b", "robot_description", None);
        assert_eq!(names, ["/a/b/robot_description", "/a/robot_description", "/robot_description"]);
        assert_eq!(candidates("/robot".to_owned(), "", "robot", None), ["/robot"]);
    }

    #[test]
    fn a_name_that_is_remapped_to_an_absolute_one_is_looked_for_there_alone() {
        let names = |own: &str, remapping| candidates(own.to_owned(), "/a", "robot_description", remapping);
        assert_eq!(names("/r1/robot_description", Some("/r1/robot_description")), ["/r1/robot_description"]);
        assert_eq!(names("/a/c/robot_description", Some("~robot_description")), ["/a/c/robot_description"]);
        assert_eq!(
            names("/r1/robot_description", None),
            ["/r1/robot_description"],
            "/a/robot_description:= was remapped"
        );
        assert_eq!(names("/a/arm", Some("arm")), ["/a/arm", "/arm"], "a relative one is searched");
        for name in ["/robot_description", "~robot_description"] {
            assert_eq!(candidates("/x".to_owned(), "/a", name, None), ["/x"]);
        }
    }
}
