//! Which displays a camera sees: a tick box for every display, with groups as branches.
//!
//! rviz makes the boxes from the displays that exist and looks up each one's value by the display's name. So a name
//! that no display has is without effect, displays of the same name share their value, a display that is not listed
//! is seen, and a branch that is not ticked hides everything below it.

use std::collections::BTreeMap;

use crate::displays::{DisplayConfig, DisplaySettings};
use crate::finding::FindingKind;
use crate::node::{Content, Node};
use crate::section::{join, Report, Section};

/// A tick box of a camera's Visibility, with those below it.
///
/// ```
/// let mut visibility = rcs_rviz_config::Visibility::default();
/// visibility.set(&["robot", "frames"], false);
/// assert!(!visibility.shows(&["robot", "frames"]) && visibility.shows(&["robot", "model"]));
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Visibility {
    /// Whether this box is ticked.
    pub value: bool,
    /// The boxes below it by the names of their displays.
    pub children: BTreeMap<String, Visibility>,
}

impl Default for Visibility {
    /// Everything is seen.
    fn default() -> Self {
        Visibility { value: true, children: BTreeMap::new() }
    }
}

/// The key of a branch's own value.
const OWN_VALUE: &str = "Value";

impl Visibility {
    /// Whether the display `path` is seen: the names of the groups around it from the outermost in, then its own.
    ///
    /// Only this camera's choice; whether the display is enabled is another question.
    pub fn shows(&self, path: &[&str]) -> bool {
        if !self.value {
            return false;
        }
        let Some((name, rest)) = path.split_first() else {
            return true;
        };
        match self.children.get(*name) {
            Some(child) => child.shows(rest),
            None => true,
        }
    }

    /// Whether a display's own box is ticked, whatever is around it.
    pub fn is_ticked(&self, path: &[&str]) -> bool {
        match path.split_first() {
            None => self.value,
            Some((name, rest)) => self.children.get(*name).is_none_or(|child| child.is_ticked(rest)),
        }
    }

    /// Ticks or unticks a display's own box.
    pub fn set(&mut self, path: &[&str], value: bool) {
        match path.split_first() {
            None => self.value = value,
            Some((name, rest)) => self.children.entry((*name).to_owned()).or_default().set(rest, value),
        }
    }

    /// These boxes, with the new value wherever two states of a file differ.
    #[must_use]
    pub fn with_changes(&self, before: &Self, after: &Self) -> Self {
        let ticked = Visibility::default();
        let value = if after.value == before.value { self.value } else { after.value };
        let names = self.children.keys().chain(before.children.keys()).chain(after.children.keys());
        let child = |name: &String| {
            let [own, before, after] = [self, before, after].map(|boxes| boxes.children.get(name).unwrap_or(&ticked));
            (name.clone(), own.with_changes(before, after))
        };
        Visibility { value, children: names.map(child).collect() }
    }

    pub(crate) fn read(mut section: Section<'_>) -> Self {
        let mut visibility = Visibility::default();
        section.bool(OWN_VALUE, &mut visibility.value);
        for (name, _, _) in section.all() {
            // A display may be called "Value" too. Its box is the branch's own then, which `shows` asks first.
            if name != OWN_VALUE {
                let child = Visibility::read(section.child(name));
                visibility.children.insert(name.to_owned(), child);
            }
        }
        visibility
    }

    fn hides_something(&self) -> bool {
        !self.value || self.children.values().any(Visibility::hides_something)
    }
}

/// Reports the names in a camera's Visibility that none of `displays` has. One that would hide nothing is a note.
pub(crate) fn check(node: &Node, path: &str, displays: &[&DisplayConfig], report: &Report) {
    let Content::Map(entries) = &node.content else { return };
    for entry in entries.iter().filter(|entry| entry.key != OWN_VALUE) {
        let path = join(path, &entry.key);
        let mut named = displays.iter().filter(|display| display.name == entry.key).peekable();
        if named.peek().is_none() {
            let present = displays.iter().map(|display| display.name.clone()).collect();
            let boxes = Visibility::read(Section::new(&entry.value, String::new(), &Report::default()));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node;
    use crate::section::Report;

    fn read(text: &str) -> Visibility {
        let tree = node::parse(text).unwrap();
        let report = Report::default();
        let visibility = Visibility::read(Section::new(&tree, String::new(), &report));
        assert_eq!(report.into_findings(), []);
        visibility
    }

    #[test]
    fn a_display_not_listed_is_seen() {
        assert!(Visibility::default().shows(&["a"]));
        let some = read("{Value: true, a: false, g: {Value: true, b: false}}");
        assert!(some.shows(&["other"]));
        assert!(some.shows(&["g", "other"]));
        assert!(!some.shows(&["a"]));
        assert!(!some.shows(&["g", "b"]));
        assert!(some.shows(&["b"]), "only inside the group");
    }

    #[test]
    fn an_unticked_branch_hides_all_below() {
        let none = read("{Value: false, a: true}");
        assert!(!none.shows(&["a"]) && !none.shows(&["other"]));
        let group = read("{g: {Value: false, a: true}, h: false}");
        assert!(!group.shows(&["g", "a"]) && !group.shows(&["g", "other"]) && !group.shows(&["g"]));
        assert!(!group.shows(&["h", "in it"]), "a group may be a plain value");
        assert!(group.shows(&["a"]));
        assert!(!read("false").shows(&["a"]));
    }

    #[test]
    fn a_box_is_set_alone() {
        let mut boxes = Visibility::default();
        boxes.set(&["g", "a"], false);
        boxes.set(&["g"], false);
        boxes.set(&["g"], true);
        assert!(boxes.is_ticked(&["g"]) && boxes.is_ticked(&["g", "b"]) && !boxes.is_ticked(&["g", "a"]));
        boxes.set(&[], false);
        assert!(boxes.is_ticked(&["g"]) && !boxes.shows(&["g"]) && !boxes.is_ticked(&[]));
    }

    #[test]
    fn a_file_changes_only_the_boxes_in_which_it_differs() {
        let before = read("{Value: true, a: false, g: {Value: true, b: true}}");
        let after = read("{Value: true, a: false, g: {Value: false, b: true}, c: false}");
        let mut own = before.clone();
        own.set(&["a"], true);
        own.set(&["g", "b"], false);
        let merged = own.with_changes(&before, &after);
        let ticked = [&["a"][..], &["g"], &["g", "b"], &["c"]].map(|path| merged.is_ticked(path));
        assert_eq!(ticked, [true, false, false, false]);
        assert_eq!(own.with_changes(&after, &after).is_ticked(&["a"]), own.is_ticked(&["a"]));
    }

    #[test]
    fn a_display_called_value_shares_the_branchs_box() {
        assert!(!read("{Value: false}").shows(&["Value"]));
        let all = read("{Value: true}");
        assert!(all.shows(&["Value"]) && all.children.is_empty());
    }
}
