//! `rviz/RobotModel`: the links of a robot's description where TF says they are.

use std::collections::BTreeMap;

use crate::finding::FindingKind;
use crate::node::{Content, Node};
use crate::section::{at_least, join, Section, ANY};

properties! {
    /// The properties of one link below `Links`.
    pub struct LinkSettings {
        /// `true` if the link is drawn, with its axes and its trail. Of no effect on a link without geometry.
        enabled: bool = true => bool("Value");
        /// Opacity, multiplied with the display's and the material's. It has no bounds in rviz.
        alpha: f32 = 1.0 => float("Alpha", ANY);
        /// `true` if the link's axes are drawn.
        show_axes: bool = false => bool("Show Axes");
        /// `true` if a two metre ribbon follows the link.
        show_trail: bool = false => bool("Show Trail");
    }
    skip ["Position", "Orientation", "Details"];
}

properties! {
    /// The properties of a RobotModel display.
    pub struct RobotModelSettings {
        /// `true` if the links' visual geometry is drawn.
        visual_enabled: bool = true => bool("Visual Enabled");
        /// `true` if the links' collision geometry is drawn.
        collision_enabled: bool = false => bool("Collision Enabled");
        /// Seconds between two updates of the links; below 0.0001 whenever there is something new.
        update_interval_secs: f32 = 0.0 => float("Update Interval", at_least(0.0));
        /// Opacity, 0 to 1.
        alpha: f32 = 1.0 => float("Alpha", 0.0..=1.0);
        /// The name of the parameter with the robot's description.
        robot_description: String = "robot_description".to_owned() => text("Robot Description");
        /// Prefix of the links' frames, without the slash after it; empty for none.
        tf_prefix: String = String::new() => text("TF Prefix");
        /// Defaults of the links, and the settings of links that are not in `links`.
        other_links: LinkSettings = LinkSettings::default();
        /// The settings of single links by their names.
        links: BTreeMap<String, LinkSettings> = BTreeMap::new();
    }
    then read_links;
}

/// The keys below `Links` that only concern rviz's tree.
const TREE_KEYS: [&str; 5] = ["Link Tree Style", "Expand Tree", "Expand Link Details", "Expand Joint Details", "Value"];

/// Names of the links' section where another Link Tree Style was chosen. rviz does not read these back, so all links
/// are shown, and no axes of links or joints.
const OTHER_TREES: [&str; 3] = ["Link Tree", "Joints", "Link/Joint Tree"];

impl RobotModelSettings {
    fn read_links(&mut self, section: &mut Section<'_>) {
        const ALL: &str = "All Links Enabled";
        OTHER_TREES.iter().for_each(|key| report_unread_tree(section, key));
        let mut links = section.child("Links");
        links.bool(ALL, &mut self.other_links.enabled);
        for (name, _) in links.all() {
            if name != ALL && !TREE_KEYS.contains(&name) {
                let mut link = self.other_links.clone();
                links.inside(name, &mut link);
                self.links.insert(name.to_owned(), link);
            }
        }
    }

    /// The settings of a link.
    pub fn link(&self, name: &str) -> &LinkSettings {
        self.links.get(name).unwrap_or(&self.other_links)
    }
}

/// Most settings of a tree that a finding lists.
const MOST_LISTED: usize = 8;

/// Skips a tree that rviz does not read back, and reports its settings that are not the defaults.
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
    for entry in node.entries() {
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
