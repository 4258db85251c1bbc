//! The cameras that a config asks for.

use std::collections::HashSet;

use anyhow::Result;
use rcs_displays::CameraView;
use rcs_ros::image_topic::camera_info_topic;
use rcs_ros::RosNode;
use rcs_rviz_config::{Config, DisplaySettings};
use rcs_scene::DisplayMask;

use super::reconfigurable::{ros_name, unique};
use crate::outputs::TopicNames;

/// A camera as a config asks for it, with all its names resolved.
pub(crate) struct CameraPlan {
    /// Its display's name as a valid ROS name, unique in the config.
    pub(super) id: String,
    /// The camera before its tick boxes are applied.
    pub(super) view: CameraView,
    /// The image topic before remapping, and the whole names after it; `None` where a topic is not set.
    pub(super) topics: Option<(String, TopicNames)>,
    /// The whole name of the trigger service.
    pub(super) service: String,
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

fn trigger_name(namespace: &str) -> String {
    in_namespace(namespace, "camera_trigger")
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
        let view = CameraView {
            name: placed.display.name.clone(),
            path: placed.path.iter().map(|name| (*name).to_owned()).collect(),
            settings: settings.clone(),
            visible: DisplayMask::all(),
        };
        let service = ros.resolve(&trigger_name(&settings.display_namespace))?;
        plans.push(CameraPlan { id: unique(ros_name(&view.name, "camera_"), &mut ids), view, topics, service });
    }
    Ok(plans)
}

impl CameraPlan {
    /// Its display's name.
    pub(crate) fn name(&self) -> &str {
        &self.view.name
    }

    /// The trigger service's name before it is resolved.
    pub(super) fn trigger_name(&self) -> String {
        trigger_name(&self.view.settings.display_namespace)
    }
}
