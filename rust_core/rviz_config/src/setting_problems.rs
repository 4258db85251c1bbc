//! Settings that are understood and valid, and with which something does not work: what the node reports when it runs.

use std::collections::HashMap;

use crate::{Config, DisplaySettings, Role};

/// Enabled displays without a topic, and cameras of which only one can be triggered: one line for each problem.
///
/// ```
/// let text = "
/// Visualization Manager:
///   Displays:
///   - {Class: rviz/Path, Name: plan, Enabled: true, Topic: ''}
/// ";
/// let config = rcs_rviz_config::parse(text, "scene.rviz")?;
/// assert_eq!(
///     rcs_rviz_config::setting_problems(&config),
///     ["line 4: plan: enabled, and its topic is empty, so it shows nothing"]
/// );
/// # Ok::<(), rcs_rviz_config::ConfigError>(())
/// ```
pub fn setting_problems(config: &Config) -> Vec<String> {
    let mut problems = Vec::new();
    // The line and name of the first camera of each namespace.
    let mut namespaces: HashMap<&str, (usize, &str)> = HashMap::new();
    for placed in config.placed_displays().into_iter().filter(|placed| placed.enabled) {
        let (display, path) = (placed.display, placed.path.join(" / "));
        let line = display.line;
        if display.settings.role() == Role::Scene && display.topic_setting().is_some_and(str::is_empty) {
            problems.push(format!("line {line}: {path}: enabled, and its topic is empty, so it shows nothing"));
        }
        if let DisplaySettings::CameraPub(camera) = &display.settings {
            let namespace = camera.display_namespace.trim_matches('/');
            match namespaces.get(namespace) {
                Some((first_line, first)) => problems.push(format!(
                    "line {line}: {path} / Display namespace: the CameraPub of line {first_line} has the same, \
                     \"{namespace}\", so its service camera_trigger triggers {first} only"
                )),
                None => drop(namespaces.insert(namespace, (line, &display.name))),
            }
        }
    }
    problems
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The problems of a config with these displays, the first in line 3.
    fn problems_of(displays: &[&str]) -> Vec<String> {
        let list: String = displays.iter().map(|display| format!("  - {{{display}}}\n")).collect();
        setting_problems(&crate::parse(&format!("Visualization Manager:\n  Displays:\n{list}"), "a.rviz").unwrap())
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
    fn cameras_that_share_a_namespace_are_reported() {
        let camera = |name: &str, namespace: &str, enabled: bool| {
            format!(
                "Class: rviz_camera_stream/CameraPub, Name: {name}, Enabled: {enabled}, Image Topic: /{name}, Camera Info \
                 Topic: /c, Display namespace: {namespace}"
            )
        };
        let [left, right] = [camera("left", "/view", true), camera("right", "view", true)];
        let found = problems_of(&[&left, &right]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with("line 4: right / Display namespace: the CameraPub of line 3"), "{found:?}");
        assert!(found[0].ends_with("camera_trigger triggers left only"), "{found:?}");
        for other in [camera("right", "other", true), camera("right", "view", false)] {
            assert_eq!(problems_of(&[&left, &other]), Vec::<String>::new());
        }
    }
}
