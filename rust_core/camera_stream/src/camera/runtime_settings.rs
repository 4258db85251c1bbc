//! The settings of a camera that can be changed while the node runs: the config's, and dynamic_reconfigure's over them.
//!
//! At the start the config's values apply. A user's values replace them until the value in the file changes; a
//! display's switch is also forgotten with its display, as in rviz. Values that an earlier run left on the parameter
//! server are ignored: the user sees and edits the `.rviz` file.

use std::sync::Arc;

use rcs_displays::{CameraView, SceneState};
use rcs_messages::dynamic_reconfigure::Config as Values;
use rcs_ros::settings::{accepted, NamedValues, SettingGroup};
use rcs_ros::{ParameterValue, ReconfigureServer, RosNode};
use rcs_rviz_config::CameraPubSettings;

use super::plan::CameraPlan;
use super::reconfigurable::{self, CameraParameters, Switch};
use crate::control::{Control, BLACKOUT};

/// The settings of one camera that can be changed while it runs.
pub(super) struct RuntimeSettings {
    /// Identifies the camera when the config is read again; its parameters are below this name.
    id: String,
    /// The camera with the settings of the next frame.
    view: Arc<CameraView>,
    in_file: CameraParameters,
    current: CameraParameters,
    switches: Arc<[Switch]>,
    /// `None` where its services cannot be offered.
    server: Option<ReconfigureServer>,
    /// `true` if `current` differs from what `view` has.
    has_changed: bool,
    /// The camera's own blackout, as the server has it.
    is_black: bool,
    /// Whether what a user has changed was saved.
    is_saved: bool,
}

impl RuntimeSettings {
    /// The config's settings of a camera, offered as `~ID`, with its blackout.
    pub(super) fn start(ros: &RosNode, plan: &CameraPlan, switches: &Arc<[Switch]>, is_black: bool) -> Self {
        let current = CameraParameters::of(&plan.view.settings);
        let (id, view) = (plan.id.clone(), Arc::new(plan.view.clone()));
        let server = ros.serve_reconfigure(&format!("~{id}"), current.groups(&current, switches, is_black));
        let server = server.map_err(|error| log::error!("{error}")).ok();
        let (in_file, switches) = (current.clone(), Arc::clone(switches));
        Self { id, view, in_file, current, switches, server, has_changed: true, is_black, is_saved: true }
    }

    /// Identifies the camera when the config is read again.
    pub(super) fn id(&self) -> &str {
        &self.id
    }

    /// The camera with the settings of the next frame.
    pub(super) fn view(&self) -> &Arc<CameraView> {
        &self.view
    }

    /// Its server of dynamic_reconfigure.
    pub(super) fn server(&self) -> Option<&ReconfigureServer> {
        self.server.as_ref()
    }

    /// The switches of the displays: path, name of the parameter, and `true` for one that is on.
    pub(super) fn switches(&self) -> impl Iterator<Item = (&[String], &str, bool)> {
        self.switches.iter().map(|switch| {
            let (path, name) = switch.path_and_name();
            (path, name, self.current.is_on(switch))
        })
    }

    /// The displays that are shown, by their paths, without the groups around them.
    pub(super) fn shown_displays(&self) -> Vec<String> {
        let displays = reconfigurable::displays(&self.switches);
        displays.filter(|switch| self.current.shows(switch)).map(Switch::text).collect()
    }

    /// The values that show these displays and hide all others.
    ///
    /// # Errors
    /// A display that the config does not have.
    pub(super) fn values_showing(&self, shown: &[String]) -> Result<NamedValues, String> {
        reconfigurable::values_showing(&self.switches, shown)
    }

    /// The table of its settings.
    fn groups(&self) -> Vec<SettingGroup> {
        self.current.groups(&self.in_file, &self.switches, self.is_black)
    }

    /// Takes a caller's values. Returns the values that apply from the next frame on; `None` without a server.
    pub(super) fn set(
        &mut self,
        ros: &RosNode,
        control: &Control,
        request: &NamedValues,
        caller: &str,
    ) -> Option<Values> {
        let (name, server) = (&self.view.name, self.server.as_ref()?);
        let before = self.current.clone();
        for (setting, value) in accepted(server.groups(), request) {
            if let (BLACKOUT, ParameterValue::Bool(is_black)) = (setting.as_str(), &value) {
                if let Err(error) = control.set_camera_blackout(name, *is_black, caller) {
                    log::error!("camera {name}: {error}");
                }
            } else if let Err(encoding) = self.current.take(&setting, &value, &self.switches) {
                log::warn!("{}: {setting}: unknown encoding \"{encoding}\"", server.name());
            }
        }
        self.is_black = control.of_camera(name).is_switched_off;
        self.has_changed = true;
        self.is_saved &= self.current == before;
        self.publish(ros)
    }

    /// Whether a user's values differ from the config's and were not saved.
    pub(super) fn is_unsaved(&self) -> bool {
        !self.is_saved && self.current != self.in_file
    }

    pub(super) fn set_saved(&mut self, is_saved: bool) {
        self.is_saved = is_saved;
    }

    /// Forgets a user's values.
    pub(super) fn discard_changes(&mut self) {
        (self.current, self.has_changed, self.is_saved) = (self.in_file.clone(), true, true);
    }

    /// The camera's settings with the values of the next frame.
    pub(super) fn current_settings(&self) -> CameraPubSettings {
        let mut settings = self.view.settings.clone();
        self.current.write_to(&mut settings);
        settings
    }

    fn publish(&mut self, ros: &RosNode) -> Option<Values> {
        let groups = self.groups();
        self.server.as_mut().map(|server| server.set(ros, groups))
    }

    /// Publishes the camera's own blackout if it was set elsewhere.
    pub(super) fn set_black(&mut self, ros: &RosNode, is_black: bool) {
        if std::mem::replace(&mut self.is_black, is_black) != is_black {
            self.publish(ros);
        }
    }

    /// Takes over the values that changed in the config.
    pub(super) fn update_from(&mut self, ros: &RosNode, view: CameraView, switches: &Arc<[Switch]>) {
        let in_file = CameraParameters::of(&view.settings);
        self.current = self.current.with_changes(&self.in_file, &in_file);
        let is_gone = |known: &&Switch| !switches.iter().any(|switch| switch.is_of_same_display(known));
        self.current.forget(self.switches.iter().filter(is_gone), &in_file);
        (self.in_file, self.switches) = (in_file, Arc::clone(switches));
        (self.view, self.has_changed) = (Arc::new(view), true);
        if self.server.as_ref().is_some_and(|server| server.groups() != self.groups()) {
            self.publish(ros);
        }
    }

    /// Applies the values that were taken since the last call. Returns `true` if there were some.
    pub(super) fn apply_changes(&mut self, displays: &SceneState) -> bool {
        if !std::mem::take(&mut self.has_changed) {
            return false;
        }
        let view = Arc::make_mut(&mut self.view);
        self.current.write_to(&mut view.settings);
        view.visible = displays.mask(&view.settings.visibility);
        true
    }
}
