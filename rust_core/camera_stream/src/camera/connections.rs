//! A camera's outputs and its trigger service, and how they are kept when the config is read again.

use std::sync::Arc;

use rcs_ros::RosNode;

use super::plan::CameraPlan;
use crate::outputs::{self, Outputs, TopicOutput};

/// The outputs and the trigger service of a camera.
#[derive(Default)]
pub(crate) struct CameraConnections {
    pub(crate) outputs: Outputs,
    /// The whole name of its trigger service; `None` where another camera has that name.
    pub(crate) trigger_service: Option<Arc<str>>,
}

/// The topics and trigger services that are kept, until they are assigned to cameras.
pub(super) struct KeptConnections {
    topics: Vec<TopicOutput>,
    services: Vec<Arc<str>>,
    /// The services that cameras have by now, each with the camera's name.
    assigned: Vec<(String, String)>,
}

impl KeptConnections {
    /// Keeps the old topics and services that a plan asks for, and closes all others.
    pub(super) fn new(ros: &RosNode, old: impl Iterator<Item = CameraConnections>, plans: &[CameraPlan]) -> Self {
        let (mut topics, mut services) = (Vec::new(), Vec::new());
        for CameraConnections { outputs, trigger_service } in old {
            topics.extend(outputs.topic);
            services.extend(trigger_service);
        }
        outputs::retain(&mut topics, plans.iter().filter_map(|plan| Some(&plan.topics.as_ref()?.1)).collect());
        services.retain(|service: &Arc<str>| {
            let wanted = plans.iter().any(|plan| *plan.service == **service);
            if !wanted {
                ros.stop_serving(service);
            }
            wanted
        });
        Self { topics, services, assigned: Vec::new() }
    }

    /// A plan's trigger service, newly offered if need be; `None` and a warning if another camera has it.
    pub(super) fn trigger_service(&mut self, ros: &RosNode, plan: &CameraPlan) -> Option<Arc<str>> {
        let name = plan.name();
        if let Some((service, other)) = self.assigned.iter().find(|(service, _)| *service == plan.service) {
            log::warn!(
                "cameras {other} and {name} have the same display namespace \"{}\", so {service} triggers {other} only; \
                 make sure that the display namespace is unique",
                plan.view.settings.display_namespace
            );
            return None;
        }
        self.assigned.push((plan.service.clone(), name.to_owned()));
        let serve = || {
            let served = ros.serve_trigger(&plan.trigger_name());
            served.map_err(|error| log::error!("camera {name}: {error}")).ok()
        };
        take_where(&mut self.services, |service| **service == *plan.service).or_else(serve)
    }

    /// A plan's topic, newly advertised if need be; `None` and an error in the log if that is not possible.
    pub(super) fn topic(&mut self, ros: &RosNode, plan: &CameraPlan) -> Option<TopicOutput> {
        let name = plan.name();
        let Some((topic, names)) = &plan.topics else {
            log::error!("camera {name}: Image Topic and Camera Info Topic must both be set");
            return None;
        };
        take_where(&mut self.topics, |output| output.names() == *names)
            .or_else(|| TopicOutput::advertise(ros, topic).map_err(|error| log::error!("camera {name}: {error}")).ok())
    }
}

/// Removes and returns the first element that fits.
pub(super) fn take_where<T>(from: &mut Vec<T>, fits: impl Fn(&T) -> bool) -> Option<T> {
    from.iter().position(fits).map(|index| from.remove(index))
}
