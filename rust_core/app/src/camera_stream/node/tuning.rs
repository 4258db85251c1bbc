//! A camera's settings between the config and dynamic_reconfigure.
//!
//! At the start the config's values hold. A user's values replace them until the config's own value becomes another one.
//! Values that an earlier run left on the parameter server do not count: the `.rviz` file is what the user sees and edits.

use std::sync::Arc;

use rcs_messages::dynamic_reconfigure::Config as Values;
use rcs_ros::{ReconfigureServer, RosNode};
use rcs_rviz_config::CameraPubSettings;

use super::parameters::{Parameters, Switch};

/// The settings of one camera that can be changed while it runs.
pub(super) struct Tuning {
    in_file: Parameters,
    now: Parameters,
    switches: Arc<[Switch]>,
    /// None where rosrust refuses.
    server: Option<ReconfigureServer>,
}

impl Tuning {
    /// A camera's settings of the config, offered below the node's name under `name`.
    pub(super) fn start(ros: &RosNode, name: &str, settings: &CameraPubSettings, switches: &Arc<[Switch]>) -> Self {
        let now = Parameters::of(settings);
        let server = ros.serve_reconfigure(&format!("~{name}"), now.description(switches), now.values(switches));
        let server = server.map_err(|error| log::error!("{error}")).ok();
        Self { in_file: now.clone(), now, switches: Arc::clone(switches), server }
    }

    /// Whether this is the server of that name.
    pub(super) fn serves(&self, server: &str) -> bool {
        self.server.as_ref().is_some_and(|own| &**own.name() == server)
    }

    /// Takes a user's values. Returns those that hold now.
    pub(super) fn take(&mut self, ros: &RosNode, request: &Values) -> Values {
        self.now.set(request, &self.switches, &self.in_file.description(&self.switches));
        let values = self.now.values(&self.switches);
        if let Some(server) = &mut self.server {
            server.set_config(ros, values.clone());
        }
        values
    }

    /// Takes over what changed in the config.
    pub(super) fn follow(&mut self, ros: &RosNode, settings: &CameraPubSettings, switches: &Arc<[Switch]>) {
        let in_file = Parameters::of(settings);
        let now = self.now.with_changes(&self.in_file, &in_file);
        let values = now.values(switches);
        if let Some(server) = &mut self.server {
            server.set_description(in_file.description(switches));
            if values != self.now.values(&self.switches) {
                server.set_config(ros, values);
            }
        }
        (self.in_file, self.now, self.switches) = (in_file, now, Arc::clone(switches));
    }

    /// Puts the present values into the camera's settings.
    pub(super) fn write_to(&self, settings: &mut CameraPubSettings) {
        self.now.write_to(settings);
    }
}
