//! The settings of a camera that can be changed while the node runs: the config's, and dynamic_reconfigure's over them.
//!
//! At the start the config's values apply. A user's values replace them until the value in the file changes; that of a
//! display's switch is also forgotten with its display, as in rviz. Values that an earlier run left on the parameter
//! server are ignored: the `.rviz` file is what the user sees and edits.

use std::sync::Arc;

use rcs_messages::dynamic_reconfigure::Config as Values;
use rcs_ros::{ReconfigureServer, RosNode};
use rcs_rviz_config::CameraPubSettings;

use crate::camera_stream::camera::reconfigurable::{Parameters, Switch, ENCODING};

/// The settings of one camera that can be changed while it runs.
pub(crate) struct RuntimeSettings {
    in_file: Parameters,
    current: Parameters,
    switches: Arc<[Switch]>,
    /// `None` where its services cannot be offered.
    server: Option<ReconfigureServer>,
}

impl RuntimeSettings {
    /// The config's settings of a camera, offered as `~name`.
    pub(crate) fn start(ros: &RosNode, name: &str, settings: &CameraPubSettings, switches: &Arc<[Switch]>) -> Self {
        let current = Parameters::of(settings);
        let server =
            ros.serve_reconfigure(&format!("~{name}"), current.description(switches), current.values(switches));
        let server = server.map_err(|error| log::error!("{error}")).ok();
        Self { in_file: current.clone(), current, switches: Arc::clone(switches), server }
    }

    /// Whether dynamic_reconfigure's server of this name is this one.
    pub(crate) fn serves(&self, server: &str) -> bool {
        self.server.as_ref().is_some_and(|own| &**own.name() == server)
    }

    /// Applies a user's values. Returns the values that apply now.
    pub(crate) fn set(&mut self, ros: &RosNode, request: &Values) -> Values {
        let unknown = self.current.set(request, &self.switches, &self.in_file.description(&self.switches));
        if let Some(encoding) = unknown {
            let server = self.server.as_ref().map(|server| &**server.name()).unwrap_or_default();
            log::warn!("{server}: {ENCODING}: unknown encoding \"{encoding}\"");
        }
        let values = self.current.values(&self.switches);
        if let Some(server) = &mut self.server {
            server.set_config(ros, values.clone());
        }
        values
    }

    /// Takes over the values that changed in the config.
    pub(crate) fn update_from(&mut self, ros: &RosNode, settings: &CameraPubSettings, switches: &Arc<[Switch]>) {
        let in_file = Parameters::of(settings);
        let mut current = self.current.with_changes(&self.in_file, &in_file);
        let is_gone = |known: &&Switch| !switches.iter().any(|switch| switch.is_of_same_display(known));
        current.forget(self.switches.iter().filter(is_gone), &in_file);
        let values = current.values(switches);
        if let Some(server) = &mut self.server {
            server.set_description(in_file.description(switches));
            if values != self.current.values(&self.switches) {
                server.set_config(ros, values);
            }
        }
        (self.in_file, self.current, self.switches) = (in_file, current, Arc::clone(switches));
    }

    /// Writes the values that apply now to the camera's settings.
    pub(crate) fn write_to(&self, settings: &mut CameraPubSettings) {
        self.current.write_to(settings);
    }
}
