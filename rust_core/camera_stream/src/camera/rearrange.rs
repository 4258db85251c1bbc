//! Turns the node's cameras into those of a config without touching what stays the same.

use std::sync::Arc;

use rcs_displays::SceneState;
use rcs_rviz_config::Config;

use super::connections::{take_where, CameraConnections, KeptConnections};
use super::output::{CameraContext, CameraPublisher};
use super::plan::CameraPlan;
use super::reconfigurable::{switches, Switch};
use crate::outputs::{Outputs, PageOutput, WindowOutput};

/// The cameras of a config, in its order. Topics, services and parameters that are kept are not touched. `window` gives
/// the window of a camera, by name.
pub(crate) fn rearrange(
    context: &Arc<CameraContext>,
    plans: Vec<CameraPlan>,
    mut old: Vec<CameraPublisher>,
    config: &Config,
    displays: &SceneState,
    window: impl Fn(&str) -> Option<WindowOutput>,
) -> Vec<CameraPublisher> {
    let ros = &context.ros;
    let mut kept = KeptConnections::new(ros, old.iter_mut().map(CameraPublisher::release), &plans);
    // Removed cameras free the names of their parameters first, as others may use them.
    old.retain(|camera| plans.iter().any(|plan| plan.id == camera.id()));
    let switches: Arc<[Switch]> = switches(config).into();
    let mut cameras = Vec::new();
    for plan in plans {
        let trigger_service = kept.trigger_service(ros, &plan);
        let page = context.page.as_ref().map(|images| PageOutput::new(images, plan.name()));
        let outputs = Outputs { topic: kept.topic(ros, &plan), window: window(plan.name()), page };
        let connections = CameraConnections { outputs, trigger_service };
        let known = take_where(&mut old, |camera| camera.id() == plan.id);
        let mut camera = known.unwrap_or_else(|| CameraPublisher::new(context, &plan, &switches));
        camera.apply(plan, connections, &switches, config.global.frame_rate_hz, displays);
        cameras.push(camera);
    }
    cameras
}
