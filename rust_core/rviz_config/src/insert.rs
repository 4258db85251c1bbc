//! Adding a camera to the text of a config; all other bytes stay.
//!
//! The parser's events tell where the list of displays begins. The camera is written there in the style of its
//! surroundings: as a block with the list's indentation, or between braces where the list is in brackets.

use saphyr_parser::{Event, Parser, ScalarStyle, Span};

use crate::config::{parse, Config};
use crate::displays::DisplaySettings;
use crate::error::ConfigError;
use crate::finding::FindingKind;
use crate::one_line::one_line;

/// A camera for a config.
///
/// ```
/// let camera = rcs_rviz_config::NewCamera {
///     name: "Projector".to_owned(),
///     camera_info_topic: "/proj_view/camera_info".to_owned(),
///     image_topic: "/proj_view/image".to_owned(),
///     display_namespace: "proj_view".to_owned(),
/// };
/// assert!(camera.block(4, "\n").starts_with("    - Class: rviz_camera_stream/CameraPub\n      Name: Projector\n"));
/// let text = "Visualization Manager:\n  Displays:\n  - {Class: rviz/Grid, Name: floor, Enabled: true}\n";
/// let extended = rcs_rviz_config::insert_camera(text, "scene.rviz", &camera)?;
/// assert_eq!(rcs_rviz_config::parse(&extended, "scene.rviz")?.displays[0].name, "Projector");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewCamera {
    /// The display's name.
    pub name: String,
    /// The property "Camera Info Topic".
    pub camera_info_topic: String,
    /// The property "Image Topic".
    pub image_topic: String,
    /// The property "Display namespace".
    pub display_namespace: String,
}

/// Error of [`insert_camera`].
#[derive(Debug, thiserror::Error)]
pub enum InsertError {
    /// The text is no config.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A camera of the config has the same name, image topic or namespace.
    #[error(
        "{file}: line {line}: the CameraPub {camera} has the {what} {value} already; choose another with {option}"
    )]
    Taken {
        /// The file's name.
        file: String,
        /// The camera's line.
        line: usize,
        /// The camera's name, in one line.
        camera: String,
        /// The property.
        what: &'static str,
        /// The value, in one line.
        value: String,
        /// The option that gives another.
        option: &'static str,
    },
    /// The list of displays is written in a way that cannot be extended safely.
    #[error("{file}: cannot add to the list of displays: {reason}; print the block without -d and paste it")]
    Place {
        /// The file's name.
        file: String,
        /// The obstacle.
        reason: &'static str,
    },
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
            ("Near Clip Distance", "0.01".to_owned()),
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
    let failed = |reason| InsertError::Place { file: source_name.to_owned(), reason };
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
            return Err(InsertError::Taken {
                file: config.source.clone(),
                line: display.line,
                camera: one_line(&display.name),
                what,
                value: one_line(value),
                option,
            });
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

/// The parts of a config that the insertion depends on.
#[derive(Default)]
struct ConfigLayout {
    /// The first event inside the map of the manager.
    manager: Option<Span>,
    /// The key `Displays`.
    key: Option<Span>,
    list: Option<List>,
}

enum List {
    /// `- ` at the beginning of lines, or `[`.
    Sequence(Span),
    /// A plain or quoted text, which may be empty, without tag and anchor: an empty text's may be lines away.
    Scalar(Span, ScalarStyle, String),
    Other,
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
    let places = places(text).ok_or("the text cannot be parsed")?;
    let text = IndexedText::new(text);
    let extended = match (places.key, places.list) {
        (Some(key), Some(List::Sequence(span))) => extend_list(&text, &key, &span, camera, line_end)?,
        (Some(key), Some(List::Scalar(span, ScalarStyle::Plain, value))) if matches!(&*value, "" | "~" | "null") => {
            fill(&text, &key, &span, &value, camera, line_end)?
        }
        (Some(_), _) => return Err("what is below Displays is no list"),
        (None, _) => add_list(&text, &places.manager.ok_or("the section is empty")?, camera, line_end)?,
    };
    Ok(format!("{mark}{extended}"))
}

/// Adds to a list that has entries, or to an empty one in brackets.
fn extend_list(
    text: &IndexedText<'_>,
    key: &Span,
    list: &Span,
    camera: &NewCamera,
    line_end: &str,
) -> Result<String, &'static str> {
    let at = text.byte(list.start.index());
    if text.after(at).starts_with('[') {
        let is_empty = text.after(at + 1).trim_start().starts_with(']');
        let comma = if is_empty { "" } else { ", " };
        return Ok(text.with(at + 1, 0, &format!("{}{comma}", camera.flow())));
    }
    // The parser does not say where the first dash is.
    let mut start = text.next_line(text.byte(key.start.index()));
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
fn fill(
    text: &IndexedText<'_>,
    key: &Span,
    value_span: &Span,
    value: &str,
    camera: &NewCamera,
    line_end: &str,
) -> Result<String, &'static str> {
    if !value.is_empty() {
        return Ok(text.with(text.byte(value_span.start.index()), value.len(), &format!("[{}]", camera.flow())));
    }
    let colon = text.byte(key.end.index());
    let rest = text.after(colon).strip_prefix(':').ok_or("its key is written in an unusual way")?;
    let line = rest.lines().next().unwrap_or_default().trim();
    if !(line.is_empty() || line.starts_with('#')) {
        // Inside of braces.
        return Ok(text.with(colon + 1, 0, &format!(" [{}]", camera.flow())));
    }
    let next = text.next_line(colon);
    let missing_end = if text.text.get(..next).is_some_and(|before| before.ends_with('\n')) { "" } else { line_end };
    let block = camera.block(key.start.col() + 2, line_end);
    Ok(text.with(next, 0, &format!("{missing_end}{block}")))
}

/// Adds a list as the first entry of the section.
fn add_list(text: &IndexedText<'_>, first: &Span, camera: &NewCamera, line_end: &str) -> Result<String, &'static str> {
    let at = text.byte(first.start.index());
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

/// Finds the list of displays among the parser's events; `None` where the text is no YAML.
fn places(text: &str) -> Option<ConfigLayout> {
    let mut found = ConfigLayout::default();
    let mut depth = 0_usize;
    // The keys of the maps that lead here: the root's, and the manager's.
    let mut keys: [Option<String>; 2] = [None, None];
    let mut is_key = [true; 2];
    let mut parser = Parser::new_from_str(text);
    while let Some(event) = parser.next_event() {
        let (event, span) = event.ok()?;
        let is_manager = keys[0].as_deref() == Some("Visualization Manager") && !is_key[0];
        if depth == 2 && is_manager && found.manager.is_none() {
            found.manager = Some(span);
        }
        // A value of the manager, or a key of it.
        if depth == 2 && is_manager && !is_key[1] && keys[1].as_deref() == Some("Displays") {
            found.list = match &event {
                Event::SequenceStart(..) => Some(List::Sequence(span)),
                Event::Scalar(value, style, 0, None) => Some(List::Scalar(span, *style, value.to_string())),
                Event::SequenceEnd | Event::MappingEnd => None,
                _ => Some(List::Other),
            };
        }
        match event {
            Event::SequenceStart(..) | Event::MappingStart(..) => {
                if depth == 0 && matches!(event, Event::SequenceStart(..)) {
                    return None;
                }
                depth += 1;
                if let Some(state) = is_key.get_mut(depth - 1) {
                    *state = true;
                }
            }
            Event::SequenceEnd | Event::MappingEnd => {
                depth = depth.checked_sub(1)?;
                step(depth, &mut is_key);
            }
            Event::Scalar(value, ..) => {
                if let (1..=2, true) = (depth, is_key.get(depth.wrapping_sub(1)).copied().unwrap_or(false)) {
                    if depth == 2 && is_manager && value == "Displays" {
                        found.key = Some(span);
                    }
                    if let Some(key) = keys.get_mut(depth - 1) {
                        *key = Some(value.to_string());
                    }
                }
                step(depth, &mut is_key);
            }
            Event::Alias(_) => step(depth, &mut is_key),
            Event::DocumentEnd | Event::StreamEnd => break,
            _ => {}
        }
    }
    Some(found)
}

/// Toggles between key and value of the map at this depth.
fn step(depth: usize, is_key: &mut [bool; 2]) {
    if let Some(state) = depth.checked_sub(1).and_then(|index| is_key.get_mut(index)) {
        *state = !*state;
    }
}
