//! `rviz/RobotModel`: the links of a robot's description where TF says they are.

use std::collections::BTreeMap;

use crate::finding::FindingKind;
use crate::node::{Content, Node};
use crate::section::{at_least, join, Section, ANY};

/// The properties of one link below `Links`.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkSettings {
    /// Whether the link is shown, with its axes and its trail. Of no effect on a link without geometry.
    pub enabled: bool,
    /// Opacity, multiplied with those of the display and of the material. It has no bounds in rviz.
    pub alpha: f32,
    /// Whether the link's axes are shown.
    pub show_axes: bool,
    /// Whether a two metre ribbon follows the link.
    pub show_trail: bool,
}

impl Default for LinkSettings {
    fn default() -> Self {
        LinkSettings { enabled: true, alpha: 1.0, show_axes: false, show_trail: false }
    }
}

/// The properties of a RobotModel display.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotModelSettings {
    /// Whether the links' visual geometry is shown.
    pub visual_enabled: bool,
    /// Whether the links' collision geometry is shown.
    pub collision_enabled: bool,
    /// How often the links are moved, in seconds; below 0.0001 whenever there is something new.
    pub update_interval_secs: f32,
    /// Opacity, 0 to 1.
    pub alpha: f32,
    /// The name of the parameter with the robot's description.
    pub robot_description: String,
    /// What stands, with a slash, before the links' names in their frames' names; empty for nothing.
    pub tf_prefix: String,
    /// What the settings of a link begin with that `links` does not have.
    pub other_links: LinkSettings,
    /// The settings of single links by their names.
    pub links: BTreeMap<String, LinkSettings>,
}

impl Default for RobotModelSettings {
    fn default() -> Self {
        RobotModelSettings {
            visual_enabled: true,
            collision_enabled: false,
            update_interval_secs: 0.0,
            alpha: 1.0,
            robot_description: "robot_description".to_owned(),
            tf_prefix: String::new(),
            other_links: LinkSettings::default(),
            links: BTreeMap::new(),
        }
    }
}

/// The keys below `Links` that only concern rviz's tree.
const TREE_KEYS: [&str; 5] = ["Link Tree Style", "Expand Tree", "Expand Link Details", "Expand Joint Details", "Value"];

/// What rviz calls the links where another Link Tree Style was chosen. It writes them under these names and does not
/// find them again when it reads the file, so that all links are shown, and no axes of links or joints.
const OTHER_TREES: [&str; 3] = ["Link Tree", "Joints", "Link/Joint Tree"];

impl RobotModelSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = RobotModelSettings::default();
        section.bool("Visual Enabled", &mut settings.visual_enabled);
        section.bool("Collision Enabled", &mut settings.collision_enabled);
        section.float("Update Interval", at_least(0.0), &mut settings.update_interval_secs);
        section.float("Alpha", 0.0..=1.0, &mut settings.alpha);
        section.text("Robot Description", &mut settings.robot_description);
        section.text("TF Prefix", &mut settings.tf_prefix);
        OTHER_TREES.iter().for_each(|key| report_unread_tree(section, key));
        settings.read_links(section.child("Links"));
        settings
    }

    fn read_links(&mut self, mut section: Section<'_>) {
        const ALL: &str = "All Links Enabled";
        section.bool(ALL, &mut self.other_links.enabled);
        for (name, _, _) in section.all() {
            if name == ALL || TREE_KEYS.contains(&name) {
                continue;
            }
            let mut section = section.child(name);
            let mut link = self.other_links.clone();
            section.bool("Value", &mut link.enabled);
            section.float("Alpha", ANY, &mut link.alpha);
            section.bool("Show Axes", &mut link.show_axes);
            section.bool("Show Trail", &mut link.show_trail);
            section.skip(&["Position", "Orientation", "Details"]);
            section.finish();
            self.links.insert(name.to_owned(), link);
        }
    }

    /// The settings of a link.
    pub fn link(&self, name: &str) -> &LinkSettings {
        self.links.get(name).unwrap_or(&self.other_links)
    }
}

/// The most settings of a tree that a finding lists.
const MOST_LISTED: usize = 8;

/// Passes over a tree that rviz does not read back. Its author saw something else if settings in it are not the
/// defaults.
fn report_unread_tree(section: &mut Section<'_>, key: &str) {
    let Some(tree) = section.node(key) else { return };
    let mut changed = Vec::new();
    add_changed(tree, key, &mut changed);
    if !changed.is_empty() {
        let path = join(section.path(), key);
        section.report().add_note(tree.line, &path, FindingKind::UnreadTree { changed });
    }
}

/// Adds the settings of a link or joint, and of those below it, that are not the defaults.
fn add_changed(node: &Node, name: &str, changed: &mut Vec<String>) {
    let Content::Map(entries) = &node.content else { return };
    for entry in entries {
        if changed.len() >= MOST_LISTED {
            return;
        }
        match (entry.key.as_str(), &entry.value.content) {
            ("Show Axes" | "Show Trail" | "Show Joint Axis", Content::Scalar(value)) if value == "true" => {
                changed.push(format!("{} of {name}", entry.key));
            }
            ("Alpha", Content::Scalar(value)) if value != "1" => changed.push(format!("Alpha {value} of {name}")),
            ("All Links Enabled", Content::Scalar(value)) if value == "false" => {
                changed.push("All Links Enabled is false".to_owned());
            }
            ("Value", Content::Scalar(value)) if value == "false" => changed.push(format!("{name} is switched off")),
            ("Details", _) => add_changed(&entry.value, name, changed),
            (_, Content::Map(_)) => add_changed(&entry.value, &entry.key, changed),
            _ => {}
        }
    }
}
