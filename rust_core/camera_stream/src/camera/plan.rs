//! The cameras that a config asks for.

use std::collections::HashSet;

use anyhow::Result;
use rcs_displays::CameraView;
use rcs_ros::image_topic::camera_info_topic;
use rcs_ros::RosNode;
use rcs_rviz_config::{Config, DisplaySettings};
use rcs_scene::DisplayMask;

use super::reconfigurable::{ros_name, unique};
use crate::cli::Cli;
use crate::outputs::TopicNames;
use rcs_node_support::node_options;

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
    if namespace.is_empty() || name.starts_with(['/', '~']) {
        name.to_owned()
    } else {
        format!("{namespace}/{name}")
    }
}

fn trigger_name(namespace: &str) -> String {
    in_namespace(namespace, "camera_trigger")
}

/// The namespace `~CAMERA` of a camera's parameters, which is no option's parameter.
fn parameter_namespace(camera: &str, reserved: &[String]) -> String {
    let name = ros_name(camera, "camera_");
    if reserved.contains(&name) {
        format!("camera_{name}")
    } else {
        name
    }
}

/// The plans of a config's enabled cameras.
///
/// # Errors
/// The first name that is not valid in ROS.
pub(crate) fn plans(ros: &RosNode, config: &Config) -> Result<Vec<CameraPlan>> {
    let reserved = node_options::parameter_names::<Cli>();
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
        plans.push(CameraPlan {
            id: unique(parameter_namespace(&view.name, &reserved), &mut ids),
            view,
            topics,
            service,
        });
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cameras_parameters_are_in_no_options_place() {
        let reserved = node_options::parameter_names::<Cli>();
        let names = ["mask", "projection", "Left"].map(|camera| parameter_namespace(camera, &reserved));
        assert_eq!(names, ["camera_mask", "camera_projection", "Left"]);
    }
}
