//! The settings of all cameras on dynamic_reconfigure, below the node's own name: brightness, fade and cue.

use rcs_messages::dynamic_reconfigure::Config as Values;
use rcs_ros::settings::{NamedValues, Setting, SettingGroup};
use rcs_ros::{ParameterValue, ReconfigureServer, RosNode};

use crate::control::brightness::LONGEST_FADE_SECS;
use crate::control::Control;

const BRIGHTNESS: &str = "brightness";
const FADE: &str = "fade_seconds";
const CUE: &str = "cue";

/// Offers the settings of all cameras.
pub(crate) struct NodeSettings {
    /// `None` where its services cannot be offered.
    server: Option<ReconfigureServer>,
    /// Name of the cue that is shown; empty for none.
    cue: String,
}

impl NodeSettings {
    pub(super) fn start(ros: &RosNode, control: &Control) -> Self {
        let server = ros.serve_reconfigure(ros.name(), groups(control, ""));
        Self { server: server.map_err(|error| log::error!("{error}")).ok(), cue: String::new() }
    }

    /// Its server, if that has this name.
    pub(crate) fn server(&self, name: &str) -> Option<&ReconfigureServer> {
        self.server.as_ref().filter(|server| &**server.name() == name)
    }

    /// Takes a caller's values. Returns those that apply from then on.
    ///
    /// # Errors
    /// A value that is out of its range or of another type; nothing has changed. More light than was asked for is no
    /// near value.
    pub(crate) fn set(
        &mut self,
        ros: &RosNode,
        control: &Control,
        request: &NamedValues,
        caller: &str,
    ) -> Result<Option<Values>, String> {
        let number = |name: &str| {
            let given = request.iter().find(|(known, _)| known == name);
            given
                .map(|(_, value)| match value {
                    ParameterValue::Double(value) => Ok(*value),
                    other => Err(format!("{name}: {other} is no double")),
                })
                .transpose()
        };
        control.set_brightness(number(BRIGHTNESS)?, number(FADE)?, caller)?;
        Ok(self.publish(ros, control))
    }

    /// The cue of a request, if that is another one than the current.
    pub(crate) fn other_cue<'r>(&self, request: &'r NamedValues) -> Option<&'r str> {
        request.iter().find_map(|(name, value)| match value {
            ParameterValue::String(cue) if name == CUE && *cue != self.cue => Some(cue.as_str()),
            _ => None,
        })
    }

    /// Sets the brightness of a cue.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    pub(crate) fn set_brightness(
        &mut self,
        ros: &RosNode,
        control: &Control,
        share: f64,
        caller: &str,
    ) -> Result<(), String> {
        self.set(ros, control, &vec![(BRIGHTNESS.to_owned(), share.into())], caller).map(|_| ())
    }

    /// Publishes the name of the cue that is shown.
    pub(crate) fn set_cue(&mut self, ros: &RosNode, control: &Control, cue: String) {
        self.cue = cue;
        self.publish(ros, control);
    }

    fn publish(&mut self, ros: &RosNode, control: &Control) -> Option<Values> {
        self.server.as_mut().map(|server| server.set(ros, groups(control, &self.cue)))
    }
}

/// The table of the settings.
fn groups(control: &Control, cue: &str) -> Vec<SettingGroup> {
    let brightness = control.brightness();
    let share = [brightness.fade.target(), 1.0];
    let settings = vec![
        Setting::new(BRIGHTNESS, "Share of each level that is shown, in all cameras", share, [0.0, 1.0]),
        Setting::new(
            FADE,
            "Time in which the brightness changes, in seconds",
            [brightness.fade_secs, 0.0],
            [0.0, LONGEST_FADE_SECS],
        ),
        Setting::choice(CUE, "Cue that is shown in all cameras", [cue, ""], Vec::new()),
    ];
    vec![("Default", settings)]
}
