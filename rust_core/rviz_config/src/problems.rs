//! Problems of configs whose keys are all valid: cameras that publish no images, and settings without effect.

use std::collections::HashMap;
use std::fmt;

use rcs_text::{clean_name, full_name, graph_name};

use crate::config::Config;
use crate::displays::{CameraPubSettings, DisplayConfig, DisplaySettings, Role};
use crate::one_line::one_line;

/// Reasons why cameras of a config publish no images although all its keys are valid, a line each.
pub fn camera_problems(config: &Config) -> Vec<String> {
    let placed = config.placed_displays();
    let cameras: Vec<(&DisplayConfig, &CameraPubSettings, String, bool)> = placed
        .iter()
        .filter_map(|placed| match &placed.display.settings {
            DisplaySettings::CameraPub(settings) => {
                Some((placed.display, settings, placed.path.join(" / "), placed.enabled))
            }
            _ => None,
        })
        .collect();
    if cameras.is_empty() {
        let source = &config.source;
        return vec![format!(
            "no CameraPub display, so no picture is published; add one with: camera_stream new-camera -d '{source}'"
        )];
    }
    let mut problems = Vec::new();
    let enabled: Vec<_> = cameras.iter().filter(|(.., enabled)| *enabled).collect();
    if enabled.is_empty() {
        let lines: Vec<String> = cameras.iter().map(|(display, ..)| display.line.to_string()).collect();
        let lines = lines.join(", ");
        problems.push(format!(
            "line {lines}: no CameraPub display is enabled, so no picture is published; set Enabled: true for one, and for \
             the groups around it"
        ));
    }
    let mut names: HashMap<&str, usize> = HashMap::new();
    let mut image_topics: HashMap<String, usize> = HashMap::new();
    for (display, settings, path, _) in enabled {
        let line = display.line;
        if settings.image_topic.is_empty() {
            problems.push(format!("line {line}: {path} / Image Topic: empty, so no picture is published"));
        }
        if settings.camera_info_topic.is_empty() {
            problems.push(format!("line {line}: {path} / Camera Info Topic: empty, so there is no picture"));
        }
        if let Some(first) = names.get(&*display.name) {
            problems.push(format!(
                "line {line}: {path}: the CameraPub of line {first} has the same name, so the names of their settings \
                 and statuses tell them apart only by number, and render --camera finds only the first"
            ));
        }
        names.entry(&display.name).or_insert(line);
        let topic = clean_name(&settings.image_topic);
        if let (false, Some(first)) = (topic.is_empty(), image_topics.get(&topic)) {
            problems.push(format!(
                "line {line}: {path} / Image Topic: the CameraPub of line {first} publishes on {topic}, too, so their \
                 pictures alternate"
            ));
        }
        image_topics.entry(topic).or_insert(line);
    }
    problems
}

/// A valid setting with which a part of a display does not work.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SettingProblem {
    /// Line of the display in the file, from 1.
    pub line: usize,
    /// `true` if no image changes by it.
    pub is_note: bool,
    /// The display's path, and the problem.
    pub text: String,
}

impl fmt::Display for SettingProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let note = if self.is_note { "note: " } else { "" };
        write!(f, "line {}: {note}{}", self.line, self.text)
    }
}

/// Finds enabled displays without a topic or with one that ROS does not allow, and cameras of which only one can be
/// triggered.
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
    let mut namespaces: HashMap<String, &DisplayConfig> = HashMap::new();
    for placed in config.placed_displays().into_iter().filter(|placed| placed.enabled) {
        let (display, path) = (placed.display, placed.path.join(" / "));
        let line = display.line;
        if display.settings.role() == Role::Scene && display.topic_setting().is_some_and(str::is_empty) {
            let text = format!("{path}: enabled, and its topic is empty, so it shows nothing");
            problems.push(SettingProblem { line, is_note: false, text });
        }
        let wrong_names = wrong_names(display).into_iter();
        problems.extend(wrong_names.map(|text| SettingProblem {
            line,
            is_note: false,
            text: format!("{path}: {text}"),
        }));
        if let DisplaySettings::CameraPub(camera) = &display.settings {
            let namespace = full_name(&camera.display_namespace);
            match namespaces.get(&namespace) {
                Some(first) => problems.push(shared_namespace(display, camera, &path, first)),
                None => drop(namespaces.insert(namespace, display)),
            }
        }
    }
    problems
}

/// Names of a display's topics that ROS does not allow, as problems.
fn wrong_names(display: &DisplayConfig) -> Vec<String> {
    let names = match &display.settings {
        DisplaySettings::CameraPub(camera) => {
            vec![&*camera.image_topic, &*camera.camera_info_topic, &*camera.display_namespace]
        }
        _ => display.topic_setting().into_iter().collect(),
    };
    // A camera's namespace may be the root.
    let given = names.into_iter().filter(|name| !["", "/"].contains(name));
    given.filter_map(|name| Some(format!("'{}' is not {}", one_line(name), graph_name(name).err()?))).collect()
}

/// The problem of a camera that cannot be triggered; a note unless it publishes on triggers alone.
fn shared_namespace(
    display: &DisplayConfig,
    camera: &CameraPubSettings,
    path: &str,
    first: &DisplayConfig,
) -> SettingProblem {
    let namespace = full_name(&camera.display_namespace);
    let namespace = namespace.trim_start_matches('/');
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
    use crate::parse;

    /// A config with these displays, the first in line 4.
    fn config(displays: &[&str]) -> Config {
        let list: String = displays.iter().map(|display| format!("  - {{{display}}}\n")).collect();
        parse(&format!("Visualization Manager:\n  Enabled: true\n  Displays:\n{list}"), "a.rviz").unwrap()
    }

    fn problems_of(displays: &[&str]) -> Vec<String> {
        camera_problems(&config(displays))
    }

    fn setting_problems_of(displays: &[&str]) -> Vec<String> {
        setting_problems(&config(displays)).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn cameras_without_images_are_reported() {
        let camera = |rest: &str| format!("Class: rviz_camera_stream/CameraPub, {rest}");
        let good = camera("Name: a, Enabled: true, Image Topic: /i, Camera Info Topic: /c");
        assert_eq!(problems_of(&[&good]), Vec::<String>::new());
        let has = |displays: &[&str], words: &[&str]| {
            let found = problems_of(displays);
            assert_eq!(found.len(), 1, "{found:?}");
            assert!(words.iter().all(|word| found[0].contains(word)), "{words:?}: {found:?}");
        };
        has(&["Class: rviz/Grid, Enabled: true"], &["no CameraPub", "new-camera -d 'a.rviz'"]);
        has(&[&camera("Name: a, Image Topic: /i")], &["line 4", "Enabled: true"]);
        has(&[&camera("Name: a, Enabled: true, Camera Info Topic: /c")], &["line 4: a / Image Topic: empty"]);
        has(&[&camera("Name: a, Enabled: true, Image Topic: /i")], &["line 4: a / Camera Info Topic: empty"]);
        let other = good.replace("/i", "/j");
        has(&[&good, &other], &["line 5: a: ", "line 4", "same name"]);
        has(&[&good, &good.replace("Name: a", "Name: b")], &["line 5: b / Image Topic", "line 4", "/i"]);
        // One that is disabled publishes nothing anyway.
        let off = camera("Name: a, Enabled: false, Image Topic: /i");
        assert_eq!(problems_of(&[&good, &off]), Vec::<String>::new());
    }

    #[test]
    fn an_enabled_display_without_a_topic_is_reported() {
        let found = setting_problems_of(&[
            "Class: rviz/PointCloud2, Name: cloud, Enabled: true, Topic: ''",
            "Class: rviz/InteractiveMarkers, Name: handles, Enabled: true",
            "Class: rviz/Path, Name: off, Enabled: false, Topic: ''",
            "Class: rviz/Image, Name: window, Enabled: true",
            "Class: rviz/Grid, Name: floor, Enabled: true",
            "Class: rviz/Path, Name: path, Enabled: true, Topic: /path",
        ]);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].starts_with("line 4: cloud: enabled, and its topic is empty"), "{found:?}");
        assert!(found[1].starts_with("line 5: handles: "), "{found:?}");
    }

    #[test]
    fn a_name_that_ros_does_not_allow_is_reported_and_one_that_is_cleaned_is_not() {
        let camera = "Class: rviz_camera_stream/CameraPub, Name: a, Enabled: true, Camera Info Topic: //c/";
        let camera = |rest: &str| format!("{camera}, {rest}");
        let (good, wrong) = (camera("Image Topic: /i//j, Display namespace: /"), camera("Image Topic: /i j"));
        let found = setting_problems_of(&[&good, "Class: rviz/Path, Name: path, Enabled: true, Topic: //p/"]);
        assert_eq!(found, Vec::<String>::new());
        let found = setting_problems_of(&[&wrong, "Class: rviz/Path, Name: path, Enabled: true, Topic: 1st"]);
        let expected = ["line 4: a: '/i j' is not a ROS name", "line 5: path: '1st' is not a ROS name"];
        assert!(found.len() == 2 && expected.iter().zip(&found).all(|(e, f)| f.starts_with(e)), "{found:?}");
        let found = problems_of(&[&camera("Image Topic: /i/j"), &good.replace("Name: a", "Name: b")]);
        assert!(found.len() == 1 && found[0].contains("publishes on /i/j, too"), "{found:?}");
    }

    #[test]
    fn cameras_that_share_a_namespace_are_a_note_unless_one_waits_for_triggers() {
        let camera = |name: &str, namespace: &str, enabled: bool| {
            format!(
                "Class: rviz_camera_stream/CameraPub, Name: {name}, Enabled: {enabled}, Image Topic: /{name}, Camera Info \
                 Topic: /c, Display namespace: {namespace}"
            )
        };
        let [left, right] = [camera("left", "/view", true), camera("right", "view//", true)];
        let found = setting_problems_of(&[&left, &right]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with("line 5: note: right / Display namespace: the CameraPub of line 4"), "{found:?}");
        assert!(found[0].ends_with("camera_trigger triggers left only"), "{found:?}");
        let found = setting_problems_of(&[&left, &format!("{right}, Frame Rate: 0")]);
        assert!(found[0].starts_with("line 5: right / Display namespace: "), "{found:?}");
        assert!(found[0].ends_with("this camera publishes nothing at a Frame Rate of 0"), "{found:?}");
        for other in [camera("right", "other", true), camera("right", "view", false)] {
            assert_eq!(setting_problems_of(&[&left, &other]), Vec::<String>::new());
        }
    }
}
