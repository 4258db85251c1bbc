//! The text of a config whose cameras were changed, as rviz saves one: block YAML without comments.
//!
//! Everything that is not a changed property of a camera is written as it was read, also what nothing here reads.

use crate::config::{parse, Config, MANAGER};
use crate::displays::visibility::Visibility;
use crate::displays::{CameraPubSettings, DisplayConfig, DisplaySettings};
use crate::error::ConfigError;
use crate::insert::quoted;
use crate::node::{self, Content, Node, SyntaxError};
use crate::section::OWN_VALUE;

/// A YAML value to be written.
#[derive(Clone, Debug, PartialEq)]
enum Yaml {
    Null,
    Scalar(String),
    List(Vec<Yaml>),
    Map(Vec<(String, Yaml)>),
}

impl Config {
    /// The config's text with the present settings of its cameras.
    ///
    /// # Errors
    /// The text cannot be written so that it is read as the same again.
    pub fn saved_text(&self) -> Result<String, ConfigError> {
        let failed = |problem: &str| ConfigError::new(&self.source, format_args!("cannot be saved: {problem}"));
        let before = parse(&self.text, &self.source)?;
        let root = node::parse(&self.text).map_err(|SyntaxError { reason, .. }| failed(&reason))?;
        let mut tree = Yaml::of(&root);
        if let Some(list) = tree.get_mut(MANAGER).and_then(|manager| manager.get_mut("Displays")) {
            write_cameras(list, &before.displays, &self.displays);
        }
        let text = tree.block(0);
        match node::parse(&text) {
            Ok(again) if Yaml::of(&again) == tree => Ok(text),
            _ => Err(failed("its YAML is written in an unusual way")),
        }
    }

    /// Visits the names and settings of the enabled cameras, in the order of
    /// [`placed_displays`](Self::placed_displays).
    pub fn enabled_cameras_mut(&mut self, visit: &mut dyn FnMut(&str, &mut CameraPubSettings)) {
        if self.enabled {
            visit_cameras(&mut self.displays, visit);
        }
    }
}

fn visit_cameras(displays: &mut [DisplayConfig], visit: &mut dyn FnMut(&str, &mut CameraPubSettings)) {
    for display in displays.iter_mut().filter(|display| display.enabled) {
        match &mut display.settings {
            DisplaySettings::CameraPub(settings) => visit(&display.name, settings),
            DisplaySettings::Group(group) => visit_cameras(&mut group.displays, visit),
            _ => {}
        }
    }
}

/// Writes into a list of displays what has changed in the settings of its cameras.
fn write_cameras(list: &mut Yaml, before: &[DisplayConfig], after: &[DisplayConfig]) {
    let Yaml::List(items) = list else { return };
    for ((item, before), after) in items.iter_mut().zip(before).zip(after) {
        match (&before.settings, &after.settings) {
            (DisplaySettings::CameraPub(before), DisplaySettings::CameraPub(after)) => {
                write_camera(item, before, after);
            }
            (DisplaySettings::Group(before), DisplaySettings::Group(after)) => {
                if let Some(list) = item.get_mut("Displays") {
                    write_cameras(list, &before.displays, &after.displays);
                }
            }
            _ => {}
        }
    }
}

fn write_camera(item: &mut Yaml, before: &CameraPubSettings, after: &CameraPubSettings) {
    let texts = |settings: &CameraPubSettings| {
        let [r, g, b] = settings.background_color;
        [
            ("Frame Rate", settings.frame_rate_hz.to_string()),
            ("Background Color", format!("{r}; {g}; {b}")),
            ("Image Encoding", settings.image_encoding.name().to_owned()),
            ("Near Clip Distance", settings.near_clip_m.to_string()),
        ]
    };
    for ((key, before), (_, after)) in texts(before).into_iter().zip(texts(after)) {
        if before != after {
            item.set(key, Yaml::Scalar(after));
        }
    }
    if before.visibility != after.visibility {
        let boxes = written_boxes(item.get_mut("Visibility").as_deref(), &after.visibility);
        item.set("Visibility", boxes);
    }
}

/// Tick boxes: a text for one, a map where there are boxes below it. `old` is what the file has.
fn written_boxes(old: Option<&Yaml>, boxes: &Visibility) -> Yaml {
    let own = Yaml::Scalar(boxes.value.to_string());
    let mut map = match old {
        Some(Yaml::Map(entries)) => Yaml::Map(entries.clone()),
        _ if boxes.children.is_empty() => return own,
        _ => Yaml::Map(Vec::new()),
    };
    map.set(OWN_VALUE, own);
    for (name, child) in &boxes.children {
        let child = written_boxes(map.get_mut(name).as_deref(), child);
        map.set(name, child);
    }
    map
}

impl Yaml {
    fn of(node: &Node) -> Self {
        match &node.content {
            Content::Null => Self::Null,
            Content::Scalar(text) => Self::Scalar(text.clone()),
            Content::List(items) => Self::List(items.iter().map(|item| Self::of(item)).collect()),
            Content::Map(entries) => {
                Self::Map(entries.iter().map(|entry| (entry.key.clone(), Self::of(&entry.value))).collect())
            }
        }
    }

    fn get_mut(&mut self, key: &str) -> Option<&mut Self> {
        match self {
            // Of repeated keys the last counts.
            Self::Map(entries) => entries.iter_mut().rev().find(|(name, _)| name == key).map(|(_, value)| value),
            _ => None,
        }
    }

    fn set(&mut self, key: &str, value: Self) {
        if let Some(known) = self.get_mut(key) {
            *known = value;
        } else if let Self::Map(entries) = self {
            entries.push((key.to_owned(), value));
        }
    }

    /// Text behind a key or a dash; `None` for a value that needs lines of its own.
    fn inline(&self) -> Option<String> {
        match self {
            Self::Null => Some("~".to_owned()),
            Self::Scalar(text) => Some(plain_or_quoted(text)),
            Self::List(items) => items.is_empty().then(|| "[]".to_owned()),
            Self::Map(entries) => entries.is_empty().then(|| "{}".to_owned()),
        }
    }

    /// The lines of a list or map.
    fn block(&self, indentation: usize) -> String {
        let indent = " ".repeat(indentation);
        let item = |item: &Self| match item.inline() {
            Some(text) => format!("{indent}- {text}\n"),
            None => {
                let mut lines = item.block(indentation + 2);
                lines.replace_range(indentation..=indentation, "-");
                lines
            }
        };
        let entry = |(key, value): &(String, Self)| match (plain_or_quoted(key), value.inline()) {
            (key, Some(text)) => format!("{indent}{key}: {text}\n"),
            (key, None) => format!("{indent}{key}:\n{}", value.block(indentation + 2)),
        };
        match self {
            Self::List(items) => items.iter().map(item).collect(),
            Self::Map(entries) => entries.iter().map(entry).collect(),
            Self::Null | Self::Scalar(_) => String::new(),
        }
    }
}

/// A text as a YAML value: as it is where it is read as the same again, else in double quotes.
fn plain_or_quoted(text: &str) -> String {
    let is_null = matches!(text, "" | "~" | "null" | "Null" | "NULL");
    let mut letters = text.chars();
    let begins_well = match letters.next() {
        Some('-' | '?' | ':') => letters.next().is_some_and(|next| next.is_alphanumeric() || next == '.'),
        Some(first) => !first.is_whitespace() && !",[]{}#&*!|>'\"%@`".contains(first),
        None => false,
    };
    let is_plain = |c: char| !c.is_control() && !matches!(c, '\u{85}' | '\u{2028}' | '\u{2029}' | '\u{feff}');
    let ends_well = !text.ends_with(|c: char| c.is_whitespace() || c == ':');
    let has_sign = [": ", " #"].iter().any(|sign| text.contains(sign));
    if !is_null && begins_well && ends_well && !has_sign && !text.starts_with("...") && text.chars().all(is_plain) {
        text.to_owned()
    } else {
        quoted(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The text that is saved after the first enabled camera was changed.
    fn saved(text: &str, change: impl Fn(&mut CameraPubSettings)) -> String {
        let mut config = parse(text, "a.rviz").unwrap();
        config.enabled_cameras_mut(&mut |_, camera| change(camera));
        config.saved_text().unwrap()
    }

    const CAMERA: &str = "Class: rviz_camera_stream/CameraPub, Name: eye, Enabled: true";

    #[test]
    fn a_text_is_saved_as_it_was_read_but_for_comments() {
        let odd =
            ["", "~", "null", "- a", "-1", ": a", "a: b", "a #b", "'", "\"\\", " a", "a ", "a:", "...", "é\n\t", "[x]"];
        let odd: Vec<String> = odd.iter().map(|text| quoted(text)).collect();
        let text = format!(
            "# by hand\nPanels: [[1, [2]], {{}}, [], ~, {}]\nVisualization Manager:\n  Displays: &d [{{{CAMERA}}}]\n  \
             \"Other: x\": *d\nWindow Geometry: {{Height: 5}}\n",
            odd.join(", ")
        );
        let again = saved(&text, |_| {});
        let [before, after] = [&*text, &again].map(|text| Yaml::of(&node::parse(text).unwrap()));
        assert_eq!(before, after, "{again}");
        assert!(!again.contains("by hand") && again.contains("\n  Displays:\n    - Class: rviz_camera"), "{again}");
        assert_eq!(saved(&again, |_| {}), again);
    }

    #[test]
    fn lines_are_as_rviz_writes_them() {
        let text = "\
Panels:
  - Class: rviz/Displays
    Property Tree Widget:
      Expanded:
        - /Status1
      Splitter Ratio: 0.5
  - Class: rviz/Time
    SyncSource: \"\"
Visualization Manager:
  Class: \"\"
  Displays:
    - Class: rviz/Grid
      Color: 160; 160; 164
      Line Style:
        Value: Lines
  Global Options:
    Fixed Frame: <Fixed Frame>
Window Geometry:
  Height: -1
  QMainWindow State: 000000ff
";
        assert_eq!(saved(text, |_| {}), text);
    }

    #[test]
    fn changed_settings_of_a_camera_are_saved_and_nothing_else() {
        let before = format!(
            "Visualization Manager:\n  Displays:\n  - {{Class: rviz/Group, Name: g, Enabled: true, Displays: [{{{CAMERA}, \
             Frame Rate: 5, Frame Rate: 7, Near Clip Distance: 0.10, Other: x}}]}}\n  - {{Class: rviz/Grid, Name: a}}\n"
        );
        let after = saved(&before, |camera| {
            camera.frame_rate_hz = 12.5;
            camera.background_color = [1, 2, 3];
            camera.image_encoding = rcs_scene::Encoding::Mono8;
            camera.visibility.set(&["g", "b"], false);
        });
        let config = parse(&after, "a.rviz").unwrap();
        let DisplaySettings::Group(group) = &config.displays[0].settings else { panic!("a group") };
        let DisplaySettings::CameraPub(camera) = &group.displays[0].settings else { panic!("a camera") };
        assert_eq!((camera.frame_rate_hz, camera.background_color, camera.near_clip_m), (12.5, [1, 2, 3], 0.1));
        assert_eq!(camera.image_encoding, rcs_scene::Encoding::Mono8);
        assert!(camera.visibility.shows(&["g"]) && !camera.visibility.shows(&["g", "b"]));
        for kept in ["Frame Rate: 5\n", "Frame Rate: 12.5\n", "Near Clip Distance: 0.10\n", "Other: x\n", "Name: a\n"] {
            assert!(after.contains(kept), "{kept}{after}");
        }
    }

    #[test]
    fn boxes_below_a_plain_one_make_it_a_map() {
        let before =
            format!("Visualization Manager: {{Displays: [{{{CAMERA}, Visibility: {{g: true, h: {{i: true}}}}}}]}}");
        let after = saved(&before, |camera| {
            camera.visibility.set(&["g", "a"], false);
            camera.visibility.set(&["h", "i"], false);
            camera.visibility.set(&[], false);
        });
        let expected =
            "        g:\n          Value: true\n          a: false\n        h:\n          i: false\n          \
                        Value: true\n        Value: false\n";
        assert!(after.ends_with(expected), "{after}");
    }

    #[test]
    fn a_disabled_camera_is_not_visited() {
        let mut config =
            parse("Visualization Manager: {Displays: [{Class: rviz_camera_stream/CameraPub}]}", "a").unwrap();
        config.enabled_cameras_mut(&mut |_, _| panic!("none is enabled"));
    }
}
