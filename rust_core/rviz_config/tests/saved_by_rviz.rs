//! Configs that rviz 1.14.19 itself wrote: each of its display classes, once as rviz makes it and once with every
//! property changed. All is understood, and each property of the one is read or listed as one that is not: given the
//! other's value, the settings are other ones.

use std::collections::BTreeSet;

use rcs_rviz_config::{parse, Config, Finding, FindingKind, Role};

const DEFAULTS: &str = include_str!("saved_by_rviz/defaults.rviz");
const CHANGED: &str = include_str!("saved_by_rviz/changed.rviz");

/// Properties that change nothing in an image, by the end of their place. Camera and Image show theirs in rviz's
/// window, and "All Enabled" is a button there: when rviz loads a file, there is no frame yet that it could switch. A
/// size in pixels belongs to another style than the default one.
const NOT_READ: [&str; 23] = [
    "/Selectable",
    "/Show Visual Aids",
    "rviz/Effort/Alpha",
    "/Unreliable",
    "/Size (Pixels)",
    "/Tree Height",
    "/Expand Tree",
    "/Expand Link Details",
    "/Expand Joint Details",
    "/Link Tree Style",
    "/Median window",
    "rviz/Image/Max Value",
    "rviz/Image/Min Value",
    "/Normalize Range",
    "/Image Rendering",
    "/Overlay Alpha",
    "/Zoom Factor",
    "/Topic Filter",
    "rviz/Camera/Queue Size",
    "rviz/Camera/Unreliable",
    "rviz/Image/Queue Size",
    "rviz/Image/Unreliable",
    "rviz/TF/Frames/All Enabled",
];

/// A property in the text of a display: its place, which is the display's class and the keys that lead to it, its
/// value, and its line from 0.
#[derive(Clone, Debug)]
struct Property {
    place: String,
    value: String,
    line: usize,
}

/// The displays' properties, as rviz lays them out: `- ` begins a display, two spaces more are one level deeper.
fn properties(text: &str) -> Vec<Property> {
    let mut found: Vec<(usize, Property)> = Vec::new();
    let mut classes: Vec<String> = Vec::new();
    let mut keys: Vec<(usize, String)> = Vec::new();
    let lines = text.lines().enumerate().skip_while(|(_, line)| *line != "  Displays:").skip(1);
    for (number, line) in lines.take_while(|(_, line)| line.starts_with("    ")) {
        if line.starts_with("    - ") {
            classes.push(String::new());
            keys.clear();
        }
        let content = line.replacen("- ", "  ", 1);
        let indent = content.len() - content.trim_start().len();
        let Some((key, value)) = content.trim().split_once(':') else { continue };
        keys.retain(|(at, _)| *at < indent);
        keys.push((indent, key.to_owned()));
        let value = value.trim();
        if let ("Class", 1, Some(class)) = (key, keys.len(), classes.last_mut()) {
            value.clone_into(class);
        }
        if !value.is_empty() {
            let place: Vec<&str> = keys.iter().map(|(_, key)| key.as_str()).collect();
            let property = Property { place: place.join("/"), value: value.to_owned(), line: number };
            found.push((classes.len() - 1, property));
        }
    }
    let with_class = |(display, property): (usize, Property)| Property {
        place: format!("{}/{}", classes[display], property.place),
        ..property
    };
    found.into_iter().map(with_class).collect()
}

fn read(text: &str) -> Config {
    parse(text, "saved.rviz").unwrap_or_else(|error| panic!("{error}"))
}

fn with_value(text: &str, property: &Property, value: &str) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let line = &mut lines[property.line];
    let end = line.find(':').map(|colon| line[..=colon].to_owned()).unwrap_or_default();
    *line = format!("{end} {value}");
    lines.join("\n") + "\n"
}

#[test]
fn all_that_rviz_writes_is_understood() {
    for (text, trees) in [(DEFAULTS, 0), (CHANGED, 1)] {
        let config = read(text);
        // rviz does not read all that it writes.
        let is_tree = |finding: &Finding| finding.is_note && matches!(finding.kind, FindingKind::UnreadTree { .. });
        assert!(config.findings.len() == trees && config.findings.iter().all(is_tree), "{:#?}", config.findings);
        assert_eq!(config.displays.len(), 33);
        assert!(config.placed_displays().iter().all(|placed| placed.display.settings.role() != Role::Unknown));
    }
}

#[test]
fn each_property_is_read() {
    let changed = properties(CHANGED);
    let whole = read(DEFAULTS);
    let mut compared = BTreeSet::new();
    let mut wrong = Vec::new();
    for property in properties(DEFAULTS) {
        let Some(other) = changed.iter().find(|other| other.place == property.place) else { continue };
        if other.value == property.value {
            continue;
        }
        let config = read(&with_value(DEFAULTS, &property, &other.value));
        let is_inert = NOT_READ.iter().any(|end| property.place.ends_with(end));
        assert!(config.findings.is_empty(), "{}: {:?}", property.place, config.findings);
        if (config.displays == whole.displays) != is_inert {
            wrong.push(format!("{} = {}: listed as not read: {is_inert}", property.place, other.value));
        }
        compared.insert(property.place);
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(compared.len() > 300, "only {} properties were compared", compared.len());
}
