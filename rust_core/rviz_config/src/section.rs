//! The keys of a map, read into settings as rviz's properties load.
//!
//! A missing key or a null leaves the setting as it is, a property may be written as `key: value` or as
//! `key: {Value: value}`, text is converted by Qt's rules, and numbers are clamped. Each reader marks its key as read;
//! [`Section::finish`] reports all the others.

use std::collections::HashMap;
use std::ops::RangeInclusive;

use crate::finding::FindingKind;
use crate::node::{Content, Node};
use crate::qt_value;
use crate::report::{Report, ENTRY};

/// Settings that are read from the keys of a section; [`properties!`] implements it for tables of properties.
pub(crate) trait Properties: Default {
    /// Reads the properties that the section has; the others stay as they are.
    fn read_properties(&mut self, section: &mut Section<'_>);

    /// The settings of a section: the defaults, overwritten by its keys.
    fn read(section: &mut Section<'_>) -> Self {
        let mut settings = Self::default();
        settings.read_properties(section);
        settings
    }
}

/// The range of a property without bounds.
pub(crate) const ANY: RangeInclusive<f32> = f32::MIN..=f32::MAX;

/// The range of a property with only a smallest value.
pub(crate) fn at_least(min: f32) -> RangeInclusive<f32> {
    min..=f32::MAX
}

/// The longest "History Length" that rviz keeps.
pub(crate) const MAX_HISTORY: u32 = 100_000;

/// The key that holds a property's own value where the property is written as a map.
pub(crate) const OWN_VALUE: &str = "Value";

struct Item<'a> {
    key: &'a str,
    line: usize,
    value: &'a Node,
    read: bool,
}

/// The keys of a map and which of them have been read.
pub(crate) struct Section<'a> {
    items: Vec<Item<'a>>,
    /// The last of repeated keys counts.
    index_of: HashMap<&'a str, usize>,
    path: String,
    report: &'a Report,
}

/// The path of `key` inside `path`; the file's top has the empty path.
pub(crate) fn join(path: &str, key: &str) -> String {
    if path.is_empty() {
        key.to_owned()
    } else {
        format!("{path} / {key}")
    }
}

impl<'a> Section<'a> {
    /// The section `path`, whose keys are those of `node`. A scalar is a map with only its own value; null has no
    /// keys; a list is reported and has none.
    pub(crate) fn new(node: &'a Node, path: String, report: &'a Report) -> Section<'a> {
        let mut section = Section::empty(path, report);
        match &node.content {
            Content::Null => {}
            Content::Scalar(_) => section.push(OWN_VALUE, node.line, node),
            Content::List(_) => report.add_invalid(node.line, &section.path, "a list", "the defaults"),
            Content::Map(entries) => {
                for entry in entries {
                    section.push(&entry.key, entry.line, &entry.value);
                }
            }
        }
        section
    }

    /// A section without keys.
    pub(crate) fn empty(path: String, report: &'a Report) -> Section<'a> {
        Section { items: Vec::new(), index_of: HashMap::new(), path, report }
    }

    fn push(&mut self, key: &'a str, line: usize, value: &'a Node) {
        let index = self.items.len();
        if let Some(earlier) = self.index_of.insert(key, index) {
            if let Some(item) = self.items.get_mut(earlier) {
                item.read = true;
                let line = item.line;
                self.invalid(line, key, "repeated key", "the last one");
            }
        }
        self.items.push(Item { key, line, value, read: false });
    }

    pub(crate) fn path(&self) -> &str {
        &self.path
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// The line of the first key; 0 without keys.
    pub(crate) fn line(&self) -> usize {
        self.items.first().map_or(0, |item| item.line)
    }

    pub(crate) fn report(&self) -> &'a Report {
        self.report
    }

    /// Records a property with its default. The own value of a property that is a section goes by the section's path.
    pub(crate) fn record(&self, key: &str, default: impl FnOnce() -> String) {
        self.report.record(|| if key == OWN_VALUE { self.path.clone() } else { join(&self.path, key) }, default);
    }

    /// Reports an invalid value of `key` and the value used instead.
    fn invalid(&self, line: usize, key: &str, value: &str, used: &str) {
        self.report.add_invalid(line, &join(&self.path, key), value, used);
    }

    /// The value under `key`, marked as read.
    pub(crate) fn node(&mut self, key: &str) -> Option<&'a Node> {
        let item = self.items.get_mut(*self.index_of.get(key)?)?;
        item.read = true;
        Some(item.value)
    }

    /// Marks keys as read that do not change the image.
    pub(crate) fn skip(&mut self, keys: &[&str]) {
        for key in keys {
            self.node(key);
        }
    }

    /// Marks keys as read that older versions of rviz wrote; `now` names their replacements.
    pub(crate) fn skip_old(&mut self, keys: &[&str], now: &'static str) {
        for item in self.items.iter_mut().filter(|item| !item.read && keys.contains(&item.key)) {
            item.read = true;
            self.report.add_note(item.line, &join(&self.path, item.key), FindingKind::OldKey { now });
        }
    }

    /// Marks all keys as read.
    pub(crate) fn skip_rest(&mut self) {
        for item in &mut self.items {
            item.read = true;
        }
    }

    /// The section under `key`; without keys when there is none.
    pub(crate) fn child(&mut self, key: &str) -> Section<'a> {
        let path = join(&self.path, key);
        match self.node(key) {
            Some(node) => Section::new(node, path, self.report),
            None => Section::empty(path, self.report),
        }
    }

    /// All keys with their values, each marked as read: names of joints, links and the like. Where properties are
    /// recorded, one [`ENTRY`], but none inside of another.
    pub(crate) fn all(&mut self) -> Vec<(&'a str, &'a Node)> {
        if self.report.is_recording() && !self.path.ends_with(ENTRY) {
            return vec![(ENTRY, &Node::NO_VALUE)];
        }
        self.skip_rest();
        let last = |(index, item): (usize, &Item<'a>)| {
            (self.index_of.get(item.key) == Some(&index)).then_some((item.key, item.value))
        };
        self.items.iter().enumerate().filter_map(last).collect()
    }

    /// Reports every key that has not been read.
    pub(crate) fn finish(self) {
        for item in self.items.iter().filter(|item| !item.read) {
            let path = join(&self.path, item.key);
            self.report.add(item.line, &path, FindingKind::UnknownKey);
        }
    }

    /// The text of a property and its line.
    pub(crate) fn scalar(&mut self, key: &str) -> Option<(&'a str, usize)> {
        let node = self.node(key)?;
        match &node.content {
            Content::Scalar(text) => Some((text, node.line)),
            Content::Null => None,
            Content::List(_) => {
                self.invalid(node.line, key, "a list", "the default");
                None
            }
            Content::Map(_) => {
                let mut inside = Section::new(node, join(&self.path, key), self.report);
                let own = inside.node(OWN_VALUE);
                inside.finish();
                match own.map(|node| (&node.content, node.line)) {
                    Some((Content::Scalar(text), line)) => Some((text, line)),
                    _ => None,
                }
            }
        }
    }

    /// Reads settings from the keys of this section.
    pub(crate) fn properties(&mut self, settings: &mut impl Properties) {
        settings.read_properties(self);
    }

    /// Reads settings from the keys inside `key`.
    pub(crate) fn inside(&mut self, key: &str, settings: &mut impl Properties) {
        let mut inside = self.child(key);
        inside.properties(settings);
        inside.finish();
    }

    /// Reads a topic. Whether UDP is preferred makes no difference: all connections are TCP.
    pub(crate) fn topic(&mut self, key: &str, topic: &mut String) {
        self.text(key, topic);
        self.skip(&["Unreliable"]);
    }

    /// Reads a text.
    pub(crate) fn text(&mut self, key: &str, setting: &mut String) {
        self.record(key, || setting.clone());
        if let Some((text, _)) = self.scalar(key) {
            text.clone_into(setting);
        }
    }

    /// Reads a bool.
    pub(crate) fn bool(&mut self, key: &str, setting: &mut bool) {
        self.record(key, || setting.to_string());
        if let Some((text, line)) = self.scalar(key) {
            let (value, meant) = qt_value::to_bool(text);
            *setting = value;
            if !meant {
                self.invalid(line, key, text, &value.to_string());
            }
        }
    }

    /// Reads an integer; any other text counts as 0.
    pub(crate) fn int(&mut self, key: &str, setting: &mut i32) {
        self.int_in(key, i32::MIN..=i32::MAX, setting);
    }

    /// Reads a count, clamped to at least `min`; text that is no integer counts as 0.
    pub(crate) fn count(&mut self, key: &str, min: u32, setting: &mut u32) {
        self.count_in(key, min..=u32::MAX, setting);
    }

    /// Reads a count, clamped to `range`; text that is no integer counts as 0.
    pub(crate) fn count_in(&mut self, key: &str, range: RangeInclusive<u32>, setting: &mut u32) {
        let int = |count: u32| i32::try_from(count).unwrap_or(i32::MAX);
        let mut value = int(*setting);
        self.int_in(key, int(*range.start())..=int(*range.end()), &mut value);
        *setting = value.unsigned_abs();
    }

    fn int_in(&mut self, key: &str, range: RangeInclusive<i32>, setting: &mut i32) {
        self.record(key, || setting.to_string());
        if let Some((text, line)) = self.scalar(key) {
            let read = qt_value::to_int(text);
            *setting = read.unwrap_or(0).clamp(*range.start(), *range.end());
            if read != Some(*setting) {
                self.invalid(line, key, text, &setting.to_string());
            }
        }
    }

    /// Reads a number, clamped to `range`; text that is no number counts as 0. The setting is always finite.
    pub(crate) fn float(&mut self, key: &str, range: RangeInclusive<f32>, setting: &mut f32) {
        self.record(key, || setting.to_string());
        if let Some((text, line)) = self.scalar(key) {
            let read = qt_value::to_f64(text).map(|value| value as f32);
            match read.unwrap_or(0.0) {
                value if !value.is_nan() => *setting = value.clamp(*range.start(), *range.end()),
                _ if range != ANY => *setting = *range.start(),
                _ => {}
            }
            if !read.is_some_and(|value| is_same_in_five_digits(value, *setting)) {
                self.invalid(line, key, text, &setting.to_string());
            }
        }
    }

    /// Reads a colour; any other text leaves the setting.
    pub(crate) fn color(&mut self, key: &str, setting: &mut [u8; 3]) {
        self.record(key, || numbers(setting));
        if let Some((text, line)) = self.scalar(key) {
            let read = qt_value::to_color(text);
            if let Some((color, _)) = read {
                *setting = color;
            }
            if !matches!(read, Some((_, true))) {
                self.invalid(line, key, text, &numbers(setting));
            }
        }
    }

    /// Reads one of `choices` by its name in the file; an unknown name counts as the first.
    pub(crate) fn choice<T: Copy + PartialEq>(&mut self, key: &str, choices: &[(&str, T)], setting: &mut T) {
        self.record(key, || name_of(choices, setting));
        if let Some((text, line)) = self.scalar(key) {
            if let Some((_, value)) = choices.iter().find(|(name, _)| *name == text) {
                *setting = *value;
            } else if let Some((name, value)) = choices.first() {
                *setting = *value;
                self.invalid(line, key, text, name);
            }
        }
    }

    /// Reads one of `choices`; `None`, for a name that is unknown or empty, lets rviz choose by the message.
    pub(crate) fn choice_or_automatic<T: Copy + PartialEq>(
        &mut self,
        key: &str,
        choices: &[(&str, T)],
        setting: &mut Option<T>,
    ) {
        self.record(key, || setting.as_ref().map(|chosen| name_of(choices, chosen)).unwrap_or_default());
        if let Some((text, line)) = self.scalar(key) {
            let found = choices.iter().find(|(name, _)| *name == text);
            *setting = found.map(|(_, value)| *value);
            if found.is_none() && !text.is_empty() {
                self.invalid(line, key, text, "what fits the message");
            }
        }
    }

    /// Reads a frame name without its leading `/`.
    pub(crate) fn frame(&mut self, key: &str, setting: &mut String) {
        if let Some((text, _)) = self.scalar(key) {
            text.strip_prefix('/').unwrap_or(text).clone_into(setting);
        }
    }

    /// Reads a frame name where `<Fixed Frame>` stands for the config's fixed frame: `None`.
    pub(crate) fn frame_or_fixed(&mut self, key: &str, setting: &mut Option<String>) {
        let mut name = String::new();
        self.record(key, || setting.as_deref().unwrap_or(FIXED_FRAME).to_owned());
        if self.index_of.contains_key(key) {
            setting.as_deref().unwrap_or(FIXED_FRAME).clone_into(&mut name);
            self.frame(key, &mut name);
            *setting = (name != FIXED_FRAME).then_some(name);
        }
    }

    /// Reads a vector from the keys X, Y and Z inside `key`; unless all three are numbers the setting is left.
    pub(crate) fn vector(&mut self, key: &str, setting: &mut [f32; 3]) {
        self.record(key, || numbers(setting));
        let Some(node) = self.node(key) else {
            return;
        };
        if matches!(node.content, Content::Null) {
            return;
        }
        let mut inside = Section::new(node, join(&self.path, key), self.report);
        let [x, y, z] = ["X", "Y", "Z"].map(|axis| {
            let (text, _) = inside.scalar(axis)?;
            let value = qt_value::to_f64_or_german(text)? as f32;
            value.is_finite().then_some(value)
        });
        if let (Some(x), Some(y), Some(z)) = (x, y, z) {
            *setting = [x, y, z];
        } else {
            inside.skip(&[OWN_VALUE]);
            self.invalid(node.line, key, "not three numbers X, Y, Z", &numbers(setting));
        }
        inside.skip_old(&[OWN_VALUE], "X, Y and Z");
        inside.finish();
    }
}

/// `true` for numbers equal in the five digits that older versions of rviz wrote: the largest pitch of a view,
/// 1.5697963, stands in their files as 1.5698, which is above it.
fn is_same_in_five_digits(a: f32, b: f32) -> bool {
    a == b || (a - b).abs() <= 5e-5 * a.abs().min(b.abs())
}

/// Colours and vectors as a config writes colours.
fn numbers<T: ToString>(values: &[T; 3]) -> String {
    values.each_ref().map(ToString::to_string).join("; ")
}

/// The name of a value among choices; empty for one that is not among them.
fn name_of<T: PartialEq>(choices: &[(&str, T)], value: &T) -> String {
    choices.iter().find(|(_, choice)| choice == value).map(|(name, _)| (*name).to_owned()).unwrap_or_default()
}

/// How a config names its own fixed frame.
pub(crate) const FIXED_FRAME: &str = "<Fixed Frame>";
