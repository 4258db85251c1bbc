//! The cameras that a config asks for, and turning the node's cameras into those without touching what stays the same.

use std::collections::HashSet;
use std::sync::Arc;

use anyhow::Result;
use rcs_displays::{CameraView, DisplaySet};
use rcs_ros::image_topic::camera_info_topic;
use rcs_ros::RosNode;
use rcs_rviz_config::{CameraPubSettings, Config, DisplaySettings};
use rcs_scene::DisplayMask;

use crate::camera_stream::camera::output::{CameraConnections, CameraOutput};
use crate::camera_stream::camera::reconfigurable::{ros_name, switches, unique, Switch};
use crate::camera_stream::outputs::{self, Outputs, TopicNames, TopicOutput};
use crate::camera_stream::runtime::windows::Windows;

/// A camera as a config asks for it, with all its names resolved.
pub(crate) struct CameraPlan {
    /// Its display's name as a valid ROS name, unique in the config.
    pub(crate) id: String,
    /// Its properties.
    pub(crate) settings: CameraPubSettings,
    name: String,
    /// The names of the groups around it and its own.
    path: Vec<String>,
    /// The image topic before remapping, and the whole names after it; `None` where a topic is not set.
    topics: Option<(String, TopicNames)>,
    /// The whole name of the trigger service.
    service: String,
}

/// A name in a display's namespace: resolved as roscpp does in a node handle of that namespace.
fn in_namespace(namespace: &str, name: &str) -> String {
    let namespace = namespace.trim_end_matches('/');
    if namespace.is_empty() || name.starts_with(['/', '~']) {
        name.to_owned()
    } else {
        format!("{namespace}/{name}")
    }
}

/// The plans of a config's enabled cameras.
///
/// # Errors
/// The first name that is not valid in ROS.
pub(crate) fn plans(ros: &RosNode, config: &Config) -> Result<Vec<CameraPlan>> {
    let mut ids = HashSet::new();
    let mut plans = Vec::new();
    for placed in config.placed_displays().iter().filter(|placed| placed.enabled) {
        let DisplaySettings::CameraPub(settings) = &placed.display.settings else { continue };
        let topics = if settings.image_topic.is_empty() || settings.camera_info_topic.is_empty() {
            None
        } else {
            let topic = in_namespace(&settings.display_namespace, &settings.image_topic);
            let whole = [ros.resolve(&topic)?, ros.resolve(&camera_info_topic(&topic))?];
            Some((topic, whole))
        };
        plans.push(CameraPlan {
            id: unique(ros_name(&placed.display.name, "camera_"), &mut ids),
            name: placed.display.name.clone(),
            path: placed.path.iter().map(|name| (*name).to_owned()).collect(),
            service: ros.resolve(&in_namespace(&settings.display_namespace, "camera_trigger"))?,
            settings: settings.clone(),
            topics,
        });
    }
    Ok(plans)
}

impl CameraPlan {
    /// Its display's name.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// The camera before its tick boxes are applied.
    pub(crate) fn view(&self) -> CameraView {
        let (name, path, settings) = (self.name.clone(), self.path.clone(), self.settings.clone());
        CameraView { name, path, settings, visible: DisplayMask::all() }
    }

    fn serve_trigger(&self, ros: &RosNode) -> Option<Arc<str>> {
        let name = in_namespace(&self.settings.display_namespace, "camera_trigger");
        ros.serve_trigger(&name).map_err(|error| log::error!("camera {}: {error}", self.name)).ok()
    }
}

/// Turns the existing cameras into those of a config. Topics, services and parameters that are kept are not touched.
pub(crate) fn rearrange(
    ros: &RosNode,
    plans: Vec<CameraPlan>,
    mut old: Vec<CameraOutput>,
    config: &Config,
    displays: &DisplaySet,
    windows: &Windows,
) -> Vec<CameraOutput> {
    let mut kept = KeptResources::of(ros, &mut old, &plans);
    // Removed cameras free the names of their parameters first, as others may use them.
    old.retain(|camera| plans.iter().any(|plan| plan.id == camera.id()));
    let switches: Arc<[Switch]> = switches(config).into();
    let mut cameras = Vec::new();
    for plan in plans {
        let trigger_service = kept.trigger_service(ros, &plan);
        let outputs = Outputs { topic: kept.topic(ros, &plan), window: windows.of(&plan.name) };
        let connections = CameraConnections { outputs, trigger_service };
        let known = take_where(&mut old, |camera| camera.id() == plan.id);
        let mut camera = known.unwrap_or_else(|| CameraOutput::new(ros, &plan, &switches));
        camera.apply(&plan, connections, &switches, config.global.frame_rate_hz, ros, displays);
        cameras.push(camera);
    }
    cameras
}

fn take_where<T>(from: &mut Vec<T>, fits: impl Fn(&T) -> bool) -> Option<T> {
    from.iter().position(fits).map(|index| from.remove(index))
}

/// The topics and trigger services that are kept, until they are assigned to cameras.
struct KeptResources {
    topics: Vec<TopicOutput>,
    services: Vec<Arc<str>>,
    /// The services that cameras have by now, each with the camera's name.
    assigned: Vec<(String, String)>,
}

impl KeptResources {
    /// Those of the old cameras that a plan asks for. All others are closed.
    fn of(ros: &RosNode, old: &mut [CameraOutput], plans: &[CameraPlan]) -> Self {
        let (mut topics, mut services) = (Vec::new(), Vec::new());
        for CameraConnections { outputs, trigger_service } in old.iter_mut().map(CameraOutput::release) {
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
    fn trigger_service(&mut self, ros: &RosNode, plan: &CameraPlan) -> Option<Arc<str>> {
        if let Some((service, other)) = self.assigned.iter().find(|(service, _)| *service == plan.service) {
            log::warn!(
                "cameras {other} and {} have the same display namespace \"{}\", so {service} triggers {other} only; \
                 make sure that the display namespace is unique",
                plan.name,
                plan.settings.display_namespace
            );
            return None;
        }
        self.assigned.push((plan.service.clone(), plan.name.clone()));
        take_where(&mut self.services, |service| **service == *plan.service).or_else(|| plan.serve_trigger(ros))
    }

    /// A plan's topic, newly advertised if need be; `None` and an error in the log if that is not possible.
    fn topic(&mut self, ros: &RosNode, plan: &CameraPlan) -> Option<TopicOutput> {
        let Some((topic, names)) = &plan.topics else {
            log::error!("camera {}: Image Topic and Camera Info Topic must both be set", plan.name);
            return None;
        };
        take_where(&mut self.topics, |output| output.names() == *names).or_else(|| {
            TopicOutput::advertise(ros, topic).map_err(|error| log::error!("camera {}: {error}", plan.name)).ok()
        })
    }
}
