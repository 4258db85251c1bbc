//! Names in a camera's Visibility that no display has.

use crate::displays::visibility::Visibility;
use crate::displays::{label, DisplayConfig, DisplaySettings};
use crate::finding::FindingKind;
use crate::node::Node;
use crate::report::Report;
use crate::section::{join, Properties, Section, OWN_VALUE};

/// Reports the names in the cameras' Visibility that no display has. `displays` belong to the list `node`; `all` is the
/// whole tree.
pub(crate) fn check_visibilities(
    node: Option<&Node>,
    displays: &[DisplayConfig],
    all: &[DisplayConfig],
    path: &str,
    report: &Report,
) {
    for (item, display) in node.map(Node::items).unwrap_or_default().iter().zip(displays) {
        let path = join(path, label(&display.name, &display.class));
        report.with_notes(!display.enabled, || match &display.settings {
            DisplaySettings::CameraPub(_) => {
                if let Some(visibility) = item.get("Visibility") {
                    check(visibility, &join(&path, "Visibility"), &all.iter().collect::<Vec<_>>(), report);
                }
            }
            DisplaySettings::Group(group) => {
                check_visibilities(item.get("Displays"), &group.displays, all, &path, report);
            }
            _ => {}
        });
    }
}

/// Reports the names in a camera's Visibility that none of `displays` has. A name that would hide nothing is a note.
fn check(node: &Node, path: &str, displays: &[&DisplayConfig], report: &Report) {
    for entry in node.entries().iter().filter(|entry| entry.key != OWN_VALUE) {
        let path = join(path, &entry.key);
        let mut named = displays.iter().filter(|display| display.name == entry.key).peekable();
        if named.peek().is_none() {
            let present = displays.iter().map(|display| display.name.clone()).collect();
            let boxes = Visibility::read(&mut Section::new(&entry.value, String::new(), &Report::default()));
            let kind = FindingKind::UnknownDisplay { present };
            report.with_notes(!boxes.hides_something(), || report.add(entry.line, &path, kind));
            continue;
        }
        let inside = named.filter_map(|display| match &display.settings {
            DisplaySettings::Group(group) => Some(&group.displays),
            _ => None,
        });
        check(&entry.value, &path, &inside.flatten().collect::<Vec<_>>(), report);
    }
}
