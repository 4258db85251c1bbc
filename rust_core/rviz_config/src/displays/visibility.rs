//! The displays that a camera draws: a tick box for every display, with groups as branches.
//!
//! rviz makes the boxes from the displays that exist and looks up each one's value by the display's name. So a name
//! that no display has is without effect, displays of one name share their value, a display that is not listed is
//! drawn, and a branch that is not ticked hides everything below it.

use std::collections::BTreeMap;

use crate::section::{Properties, Section, OWN_VALUE};

/// A tick box of a camera's Visibility, with those below it.
///
/// ```
/// let mut visibility = rcs_rviz_config::Visibility::default();
/// visibility.set(&["robot", "frames"], false);
/// assert!(!visibility.shows(&["robot", "frames"]) && visibility.shows(&["robot", "model"]));
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Visibility {
    /// `true` if this box is ticked.
    pub value: bool,
    /// The boxes below it by the names of their displays.
    pub children: BTreeMap<String, Visibility>,
}

impl Default for Visibility {
    /// Everything is drawn.
    fn default() -> Self {
        Visibility { value: true, children: BTreeMap::new() }
    }
}

impl Visibility {
    /// `true` if the camera draws the display `path` (the names of the groups around it from the outermost in, then its
    /// own), provided that it is enabled.
    pub fn shows(&self, path: &[&str]) -> bool {
        let Some((name, rest)) = path.split_first() else { return self.value };
        self.value && self.children.get(*name).is_none_or(|child| child.shows(rest))
    }

    /// `true` if a display's own box is ticked, whatever is around it.
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

    pub(crate) fn hides_something(&self) -> bool {
        !self.value || self.children.values().any(Visibility::hides_something)
    }
}

impl Properties for Visibility {
    fn read_properties(&mut self, section: &mut Section<'_>) {
        section.bool(OWN_VALUE, &mut self.value);
        for (name, _) in section.all() {
            // A display may be called "Value" too. Its box is the branch's own then, which `shows` asks first.
            if name != OWN_VALUE {
                section.inside(name, self.children.entry(name.to_owned()).or_default());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node;
    use crate::report::Report;

    fn read(text: &str) -> Visibility {
        let tree = node::parse(text).unwrap();
        let report = Report::default();
        let visibility = Visibility::read(&mut Section::new(&tree, String::new(), &report));
        assert_eq!(report.into_findings(), []);
        visibility
    }

    #[test]
    fn a_display_not_listed_is_drawn() {
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
