//! Adding a camera to the text of a config; all other bytes stay.
//!
//! The parsed tree tells where the list of displays begins. The camera is written there in the style of its
//! surroundings: as a block with the list's indentation, or between braces where the list is in brackets.

use crate::config::{parse, Config, MANAGER};
use crate::displays::DisplaySettings;
use crate::error::ConfigError;
use crate::finding::FindingKind;
use crate::node::{self, Content, MapEntry, Node};
use crate::one_line::one_line;

/// A camera for a config.
///
/// ```
/// let camera = rcs_rviz_config::NewCamera {
///     name: "Projector".to_owned(),
///     camera_info_topic: "/proj_view/camera_info".to_owned(),
///     image_topic: "/proj_view/image".to_owned(),
///     display_namespace: "proj_view".to_owned(),
///     near_clip_m: 0.01,
/// };
/// assert!(camera.block(4, "\n").starts_with("    - Class: rviz_camera_stream/CameraPub\n      Name: Projector\n"));
/// let text = "Visualization Manager:\n  Displays:\n  - {Class: rviz/Grid, Name: floor, Enabled: true}\n";
/// let extended = rcs_rviz_config::insert_camera(text, "scene.rviz", &camera)?;
/// assert_eq!(rcs_rviz_config::parse(&extended, "scene.rviz")?.displays[0].name, "Projector");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct NewCamera {
    /// The display's name.
    pub name: String,
    /// The property "Camera Info Topic".
    pub camera_info_topic: String,
    /// The property "Image Topic".
    pub image_topic: String,
    /// The property "Display namespace".
    pub display_namespace: String,
    /// The property "Near Clip Distance", metres.
    pub near_clip_m: f32,
}

/// Error of [`insert_camera`].
#[derive(Debug, thiserror::Error)]
pub enum InsertError {
    /// The text is no config.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A camera of the config has the same name, image topic or namespace: which one, and the option for another.
    #[error("{0}")]
    Taken(String),
    /// The list of displays is written in a way that cannot be extended safely.
    #[error("{0}: cannot add to the list of displays: {1}; print the block without -d and paste it")]
    Place(String, &'static str),
}

impl NewCamera {
    /// Keys and values, each value as YAML.
    fn entries(&self) -> Vec<(&'static str, String)> {
        vec![
            ("Class", "rviz_camera_stream/CameraPub".to_owned()),
            ("Name", yaml_text(&self.name)),
            ("Enabled", "true".to_owned()),
            ("Camera Info Topic", yaml_text(&self.camera_info_topic)),
            ("Image Topic", yaml_text(&self.image_topic)),
            ("Display namespace", yaml_text(&self.display_namespace)),
            ("Frame Rate", "-1".to_owned()),
            ("Image Encoding", "rgb8".to_owned()),
            ("Background Color", "0; 0; 0".to_owned()),
            ("Near Clip Distance", self.near_clip_m.to_string()),
            ("Queue Size", "2".to_owned()),
        ]
    }

    /// The display as an entry of a block list.
    pub fn block(&self, indentation: usize, line_end: &str) -> String {
        let indent = " ".repeat(indentation);
        let mut lines: Vec<String> = self.entries().iter().map(|(key, value)| format!("  {key}: {value}")).collect();
        lines.extend(["  Visibility:".to_owned(), "    Value: true".to_owned()]);
        if let Some(first) = lines.first_mut() {
            first.replace_range(..1, "-");
        }
        lines.iter().map(|line| format!("{indent}{line}{line_end}")).collect()
    }

    /// The display as a YAML flow map. Values that may hold a comma are quoted already.
    fn flow(&self) -> String {
        let entries: Vec<String> = self.entries().iter().map(|(key, value)| format!("{key}: {value}")).collect();
        format!("{{{}, Visibility: {{Value: true}}}}", entries.join(", "))
    }
}

/// A text as a YAML value, in double quotes unless it can only be a text.
fn yaml_text(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '/' | '.' | '-' | ' ');
    let begins_well = text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '/');
    let words = ["true", "false", "yes", "no", "on", "off", "null", "y", "n"];
    let is_word = words.contains(&text.to_lowercase().as_str());
    if begins_well && !is_word && !text.ends_with(' ') && text.chars().all(is_plain) {
        return text.to_owned();
    }
    quoted(text)
}

/// A text in double quotes.
pub(crate) fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}' | '\u{feff}') => {
                quoted += &format!("\\U{:08x}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted + "\""
}

/// The text of a config with the camera added as the first of its displays. `source_name` names the text in errors.
///
/// # Errors
/// [`InsertError`]; a camera's name, image topic and namespace must be its own.
pub fn insert_camera(text: &str, source_name: &str, camera: &NewCamera) -> Result<String, InsertError> {
    let before = parse(text, source_name)?;
    check_is_own(&before, camera)?;
    let failed = |reason| InsertError::Place(source_name.to_owned(), reason);
    let extended = extend(text, camera).map_err(failed)?;
    // Everything but the camera must be as before.
    let after = parse(&extended, source_name).map_err(|_| failed("its YAML is written in an unusual way"))?;
    if is_extended(&before, &after, camera) {
        Ok(extended)
    } else {
        Err(failed("its YAML is written in an unusual way"))
    }
}

fn check_is_own(config: &Config, camera: &NewCamera) -> Result<(), InsertError> {
    for placed in config.placed_displays() {
        let DisplaySettings::CameraPub(other) = &placed.display.settings else { continue };
        let display = placed.display;
        let values = [
            ("name", &display.name, &camera.name, "--name"),
            ("Image Topic", &other.image_topic, &camera.image_topic, "--image-topic"),
            ("Display namespace", &other.display_namespace, &camera.display_namespace, "--display-namespace"),
        ];
        let taken = values.into_iter().find(|(_, theirs, own, _)| theirs == own && !own.is_empty());
        if let Some((what, _, value, option)) = taken {
            let (camera, value) = (one_line(&display.name), one_line(value));
            return Err(InsertError::Taken(format!(
                "{}: line {}: the CameraPub {camera} has the {what} {value} already; choose another with {option}",
                config.source, display.line
            )));
        }
    }
    Ok(())
}

/// `true` if the second config is the first with the camera in front.
fn is_extended(before: &Config, after: &Config, camera: &NewCamera) -> bool {
    let Some((first, rest)) = after.displays.split_first() else { return false };
    let DisplaySettings::CameraPub(settings) = &first.settings else { return false };
    let is_camera = first.name == camera.name
        && first.enabled
        && settings.image_topic == camera.image_topic
        && settings.camera_info_topic == camera.camera_info_topic
        && settings.display_namespace == camera.display_namespace;
    // Without lines, which differ.
    let placed = |config: &Config| -> Vec<(String, String, bool)> {
        let all = config.placed_displays();
        all.iter().map(|placed| (placed.path.join("\n"), placed.display.class.clone(), placed.enabled)).collect()
    };
    // Without unknown names in a Visibility: they may be the camera's.
    let findings = |config: &Config| -> Vec<(bool, String, FindingKind)> {
        let others =
            config.findings.iter().filter(|finding| !matches!(finding.kind, FindingKind::UnknownDisplay { .. }));
        others.map(|finding| (finding.is_note, finding.path.clone(), finding.kind.clone())).collect()
    };
    let all = placed(after);
    is_camera
        && rest.len() == before.displays.len()
        && all.get(1..) == Some(&*placed(before))
        && findings(before) == findings(after)
        && before.global == after.global
        && before.view == after.view
}

/// A text with the byte offsets of its characters: the parser counts characters.
struct IndexedText<'a> {
    text: &'a str,
    /// The byte offset of each character, and the length.
    bytes: Vec<usize>,
}

impl<'a> IndexedText<'a> {
    fn new(text: &'a str) -> Self {
        let bytes = text.char_indices().map(|(byte, _)| byte).chain([text.len()]).collect();
        Self { text, bytes }
    }

    fn byte(&self, index: usize) -> usize {
        self.bytes.get(index).copied().unwrap_or(self.text.len())
    }

    fn after(&self, byte: usize) -> &'a str {
        self.text.get(byte..).unwrap_or_default()
    }

    fn line_start(&self, byte: usize) -> usize {
        self.text.get(..byte).and_then(|before| before.rfind('\n')).map_or(0, |end| end + 1)
    }

    fn next_line(&self, byte: usize) -> usize {
        self.after(byte).find('\n').map_or(self.text.len(), |end| byte + end + 1)
    }

    fn with(&self, byte: usize, removed: usize, inserted: &str) -> String {
        let (before, after) = self.text.split_at(byte);
        format!("{before}{inserted}{}", after.get(removed..).unwrap_or_default())
    }
}

fn extend(text: &str, camera: &NewCamera) -> Result<String, &'static str> {
    let mark = text.strip_prefix('\u{feff}').map_or("", |_| "\u{feff}");
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let line_end = if text.contains("\r\n") { "\r\n" } else { "\n" };
    let root = node::parse(text).map_err(|_| "the text cannot be parsed")?;
    let manager = root.get(MANAGER).ok_or("the section is empty")?;
    let text = IndexedText::new(text);
    let extended = match manager.entry("Displays") {
        None => add_list(&text, manager, camera, line_end)?,
        // A value before its key is an alias's.
        Some(MapEntry { place, value, .. }) if value.start < place.start => {
            return Err("what is below Displays is no list")
        }
        Some(entry) => match entry.value.content {
            Content::List(_) => extend_list(&text, entry, camera, line_end)?,
            Content::Null => fill(&text, entry, camera, line_end)?,
            Content::Scalar(_) | Content::Map(_) => return Err("what is below Displays is no list"),
        },
    };
    Ok(format!("{mark}{extended}"))
}

/// Adds to a list that has entries, or to an empty one in brackets.
fn extend_list(
    text: &IndexedText<'_>,
    entry: &MapEntry,
    camera: &NewCamera,
    line_end: &str,
) -> Result<String, &'static str> {
    let at = text.byte(entry.value.start);
    if text.after(at).starts_with('[') {
        let is_empty = text.after(at + 1).trim_start().starts_with(']');
        let comma = if is_empty { "" } else { ", " };
        return Ok(text.with(at + 1, 0, &format!("{}{comma}", camera.flow())));
    }
    // The parser does not say where the first dash is.
    let mut start = text.next_line(text.byte(entry.place.start));
    loop {
        let line = text.after(start).lines().next().ok_or("its beginning was not found")?;
        let entry = line.trim_start_matches(' ');
        if entry.starts_with('-') {
            return Ok(text.with(start, 0, &camera.block(line.len() - entry.len(), line_end)));
        }
        if !(entry.trim().is_empty() || entry.starts_with('#')) {
            return Err("its first entry does not begin its line");
        }
        start = text.next_line(start);
    }
}

/// Fills a list that is a key without value, or `~`.
fn fill(text: &IndexedText<'_>, entry: &MapEntry, camera: &NewCamera, line_end: &str) -> Result<String, &'static str> {
    let (start, colon) = (text.byte(entry.place.start), text.byte(entry.place.end));
    let rest = text.after(colon).strip_prefix(':').ok_or("its key is written in an unusual way")?;
    let line = rest.lines().next().unwrap_or_default();
    let value = line.trim();
    if let Some(null) = ["~", "null", "Null", "NULL"].into_iter().find(|null| value.starts_with(null)) {
        let at = text.byte(entry.value.start);
        return Ok(text.with(at, null.len(), &format!("[{}]", camera.flow())));
    }
    if !(value.is_empty() || value.starts_with('#')) {
        // Inside of braces.
        return Ok(text.with(colon + 1, 0, &format!(" [{}]", camera.flow())));
    }
    let next = text.next_line(colon);
    let missing_end = if text.text.get(..next).is_some_and(|before| before.ends_with('\n')) { "" } else { line_end };
    let block = camera.block(start - text.line_start(start) + 2, line_end);
    Ok(text.with(next, 0, &format!("{missing_end}{block}")))
}

/// Adds a list as the first entry of the section.
fn add_list(
    text: &IndexedText<'_>,
    manager: &Node,
    camera: &NewCamera,
    line_end: &str,
) -> Result<String, &'static str> {
    let begin = text.byte(manager.start);
    let at = match manager.entries() {
        [first, ..] => text.byte(first.place.start),
        [] => begin + text.after(begin).find('}').ok_or("the section is empty")?,
    };
    let start = text.line_start(at);
    let indentation = text.text.get(start..at).ok_or("its indentation")?;
    if indentation.bytes().all(|byte| byte == b' ') && !text.after(at).starts_with('}') {
        let key = format!("{indentation}Displays:{line_end}");
        return Ok(text.with(start, 0, &(key + &camera.block(indentation.len() + 2, line_end))));
    }
    // Inside of braces.
    let comma = if text.after(at).starts_with('}') { "" } else { ", " };
    Ok(text.with(at, 0, &format!("Displays: [{}]{comma}", camera.flow())))
}
