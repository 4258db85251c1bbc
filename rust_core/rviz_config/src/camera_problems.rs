//! What keeps the cameras of a config from publishing pictures, although every key of it is understood.

use std::collections::HashMap;

use crate::{CameraPubSettings, Config, DisplayConfig, DisplaySettings};

/// What keeps the cameras of a config from publishing pictures, although every key of it is understood: one line for
/// each problem.
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
    let mut image_topics: HashMap<&str, usize> = HashMap::new();
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
        let topic = &*settings.image_topic;
        if let (false, Some(first)) = (topic.is_empty(), image_topics.get(topic)) {
            problems.push(format!(
                "line {line}: {path} / Image Topic: the CameraPub of line {first} publishes on {topic}, too, so their \
                 pictures alternate"
            ));
        }
        image_topics.entry(topic).or_insert(line);
    }
    problems
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A config with these displays, the first in line 4.
    fn problems_of(displays: &[&str]) -> Vec<String> {
        let list: String = displays.iter().map(|display| format!("  - {{{display}}}\n")).collect();
        let text = format!("Visualization Manager:\n  Enabled: true\n  Displays:\n{list}");
        camera_problems(&crate::parse(&text, "a.rviz").unwrap())
    }

    #[test]
    fn cameras_without_pictures_are_reported() {
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
}
