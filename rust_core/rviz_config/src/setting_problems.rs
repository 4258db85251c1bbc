//! Settings that are understood and valid, and with which something does not work: what the node reports when it runs.

use std::collections::HashMap;
use std::fmt;

use crate::{CameraPubSettings, Config, DisplayConfig, DisplaySettings, Role};

/// A setting with which something does not work.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SettingProblem {
    /// Line of the display in the file, from 1.
    pub line: usize,
    /// Whether it changes no picture.
    pub is_note: bool,
    /// The display's path, and what does not work.
    pub text: String,
}

impl fmt::Display for SettingProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let note = if self.is_note { "note: " } else { "" };
        write!(f, "line {}: {note}{}", self.line, self.text)
    }
}

/// Enabled displays without a topic, and cameras of which only one can be triggered.
///
/// ```
/// let text = "
/// Visualization Manager:
///   Displays:
///   - {Class: rviz/Path, Name: plan, Enabled: true, Topic: ''}
/// ";
/// let config = rcs_rviz_config::parse(text, "scene.rviz")?;
/// let problems = rcs_rviz_config::setting_problems(&config);
/// assert_eq!(problems[0].to_string(), "line 4: plan: enabled, and its topic is empty, so it shows nothing");
/// # Ok::<(), rcs_rviz_config::ConfigError>(())
/// ```
pub fn setting_problems(config: &Config) -> Vec<SettingProblem> {
    let mut problems = Vec::new();
    // The first camera of each namespace.
    let mut namespaces: HashMap<&str, &DisplayConfig> = HashMap::new();
    for placed in config.placed_displays().into_iter().filter(|placed| placed.enabled) {
        let (display, path) = (placed.display, placed.path.join(" / "));
        let line = display.line;
        if display.settings.role() == Role::Scene && display.topic_setting().is_some_and(str::is_empty) {
            let text = format!("{path}: enabled, and its topic is empty, so it shows nothing");
            problems.push(SettingProblem { line, is_note: false, text });
        }
        if let DisplaySettings::CameraPub(camera) = &display.settings {
            match namespaces.get(camera.display_namespace.trim_matches('/')) {
                Some(first) => problems.push(shared_namespace(display, camera, &path, first)),
                None => drop(namespaces.insert(camera.display_namespace.trim_matches('/'), display)),
            }
        }
    }
    problems
}

/// A camera that cannot be triggered. That matters to one that publishes on triggers alone.
fn shared_namespace(
    display: &DisplayConfig,
    camera: &CameraPubSettings,
    path: &str,
    first: &DisplayConfig,
) -> SettingProblem {
    let namespace = camera.display_namespace.trim_matches('/');
    let is_note = camera.frame_rate_hz != 0.0;
    let so = if is_note { "" } else { ", and this camera publishes nothing at a Frame Rate of 0" };
    let text = format!(
        "{path} / Display namespace: the CameraPub of line {} has the same, \"{namespace}\", so the service camera_trigger \
         triggers {} only{so}",
        first.line, first.name
    );
    SettingProblem { line: display.line, is_note, text }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The problems of a config with these displays, the first in line 3.
    fn problems_of(displays: &[&str]) -> Vec<String> {
        let list: String = displays.iter().map(|display| format!("  - {{{display}}}\n")).collect();
        let config = crate::parse(&format!("Visualization Manager:\n  Displays:\n{list}"), "a.rviz").unwrap();
        setting_problems(&config).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn an_enabled_display_without_a_topic_is_reported() {
        let found = problems_of(&[
            "Class: rviz/PointCloud2, Name: cloud, Enabled: true, Topic: ''",
            "Class: rviz/InteractiveMarkers, Name: handles, Enabled: true",
            "Class: rviz/Path, Name: off, Enabled: false, Topic: ''",
            "Class: rviz/Image, Name: window, Enabled: true",
            "Class: rviz/Grid, Name: floor, Enabled: true",
            "Class: rviz/Path, Name: path, Enabled: true, Topic: /path",
        ]);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].starts_with("line 3: cloud: enabled, and its topic is empty"), "{found:?}");
        assert!(found[1].starts_with("line 4: handles: "), "{found:?}");
    }

    #[test]
    fn cameras_that_share_a_namespace_are_a_note_unless_one_waits_for_triggers() {
        let camera = |name: &str, namespace: &str, enabled: bool| {
            format!(
                "Class: rviz_camera_stream/CameraPub, Name: {name}, Enabled: {enabled}, Image Topic: /{name}, Camera Info \
                 Topic: /c, Display namespace: {namespace}"
            )
        };
        let [left, right] = [camera("left", "/view", true), camera("right", "view", true)];
        let found = problems_of(&[&left, &right]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with("line 4: note: right / Display namespace: the CameraPub of line 3"), "{found:?}");
        assert!(found[0].ends_with("camera_trigger triggers left only"), "{found:?}");
        let found = problems_of(&[&left, &format!("{right}, Frame Rate: 0")]);
        assert!(found[0].starts_with("line 4: right / Display namespace: "), "{found:?}");
        assert!(found[0].ends_with("this camera publishes nothing at a Frame Rate of 0"), "{found:?}");
        for other in [camera("right", "other", true), camera("right", "view", false)] {
            assert_eq!(problems_of(&[&left, &other]), Vec::<String>::new());
        }
    }
}
