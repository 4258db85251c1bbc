//! Parameters that the scene needs, a robot's description most of all, fetched in the background.
//!
//! A name is looked up as `ros::NodeHandle::getParam` and, failing that, `searchParam` do: in the node's namespace
//! first and then in the namespaces around it. A parameter that is not set yet is polled once a second, as rviz does. A
//! parameter that is not a string counts as an empty one, as in rviz.

use crate::graph::Master;
use crate::node::{text_of, Shared};
use crate::xmlrpc::CallError;
use crate::{lock, NodeEvent, RosNode};
use std::sync::{Arc, Weak};
use std::time::Duration;

const POLL_PERIOD: Duration = Duration::from_secs(1);

impl RosNode {
    /// Polls string parameters until each was found. Each is a [`NodeEvent::Parameter`] with its value once it is set,
    /// and before that one without, if it is not set at first.
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
    /// Asks for parameters by their whole names, and hands their values over as text, in the same order, once the
    /// master has answered; `None` for one that is not set, or is neither a string, a boolean nor a number. A master
    /// that is silent is asked again.
    pub fn fetch_texts(&self, names: Vec<String>, done: impl FnOnce(Vec<Option<String>>) + Send + 'static) {
        let network = Arc::downgrade(self.network());
        let fetching = move || loop {
            let Some(network) = network.upgrade().filter(|network| !network.is_ended()) else { return };
            let master = network.registrar().master();
            let values: Result<Vec<_>, CallError> = names.iter().map(|name| master.param(name)).collect();
            if let Ok(values) = values {
                return done(values.iter().map(|value| text_of(value.as_ref()?)).collect());
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

/// Polls until all parameters that are followed were found. The master is asked without a lock.
fn poll(shared: &Weak<Shared>) {
    loop {
        let Some(names) = shared.upgrade().map(|shared| lock(&shared.followed_parameters).clone()) else { return };
        for (name, is_reported) in names {
            let Some(shared) = shared.upgrade() else { return };
            // A master that is silent says nothing about a parameter.
            let Ok(text) = find(shared.network.registrar().master(), &name) else { continue };
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

/// The value of a parameter in the nearest namespace that has it.
///
/// # Errors
/// [`CallError`] if the master does not answer.
fn find(master: &Master, name: &str) -> Result<Option<Arc<str>>, CallError> {
    let Some(own) = rosrust::param(name).map(|param| param.name().to_owned()) else { return Ok(None) };
    let is_relative = !name.starts_with(['/', '~']);
    let candidates = if is_relative { upwards(&own, name) } else { vec![own] };
    for candidate in candidates {
        if let Some(value) = master.param(&candidate)? {
            return Ok(Some(value.as_str().unwrap_or_default().into()));
        }
    }
    Ok(None)
}

/// The whole names that a relative name may stand for, the innermost namespace first. A remapped name has only one.
fn upwards(whole: &str, name: &str) -> Vec<String> {
    let Some(namespace) = whole.strip_suffix(name) else { return vec![whole.to_owned()] };
    let mut namespace = namespace.trim_end_matches('/');
    let mut names = Vec::new();
    loop {
        names.push(format!("{namespace}/{name}"));
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
        let names = upwards("/a/b/robot_description", "robot_description");
        assert_eq!(names, ["/a/b/robot_description", "/a/robot_description", "/robot_description"]);
        assert_eq!(upwards("/robot_description", "robot_description"), ["/robot_description"]);
        assert_eq!(upwards("/other", "robot_description"), ["/other"]);
    }
}
