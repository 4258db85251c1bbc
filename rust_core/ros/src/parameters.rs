//! Parameters that the scene needs, a robot's description most of all, fetched in the background.
//!
//! A name is looked up as `ros::NodeHandle::getParam` and, failing that, `searchParam` do: in the node's namespace
//! first and then in the namespaces around it. A parameter that is not set yet is polled once a second, as rviz does. A
//! parameter that is not a string counts as an empty one, as in rviz.

use crate::node::Shared;
use crate::{NodeEvent, RosNode};
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
        let shared = Arc::downgrade(&self.shared);
        let spawned = std::thread::Builder::new().name("ros-parameters".to_owned()).spawn(move || poll(names, &shared));
        if let Err(error) = spawned {
            log::error!("parameters cannot be fetched: {error}");
        }
    }
}

fn poll(mut names: Vec<String>, shared: &Weak<Shared>) {
    let mut first = true;
    loop {
        {
            let Some(shared) = shared.upgrade() else { return };
            names.retain(|name| {
                let text = find(name);
                let found = text.is_some();
                if found || first {
                    let event = NodeEvent::Parameter { name: name.as_str().into(), text };
                    shared.events.sender(0).push(event);
                }
                !found
            });
        }
        if names.is_empty() || !rosrust::is_ok() {
            return;
        }
        first = false;
        std::thread::sleep(POLL_PERIOD);
    }
}

/// The value of a parameter in the nearest namespace that has it.
fn find(name: &str) -> Option<Arc<str>> {
    let own = rosrust::param(name)?.name().to_owned();
    let is_relative = !name.starts_with(['/', '~']);
    let candidates = if is_relative { upwards(&own, name) } else { vec![own] };
    candidates.iter().find_map(|candidate| {
        let parameter = rosrust::param(candidate)?;
        parameter.exists().unwrap_or(false).then(|| parameter.get::<String>().unwrap_or_default().into())
    })
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
