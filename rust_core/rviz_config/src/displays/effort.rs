//! `rviz/Effort`: circles around a robot's joints for the efforts of a `sensor_msgs/JointState`.

use std::collections::BTreeMap;

use crate::section::{Section, ANY, MAX_HISTORY};

/// The properties of an Effort display.
#[derive(Debug, Clone, PartialEq)]
pub struct EffortSettings {
    /// Topic of `sensor_msgs/JointState`; empty when none is chosen.
    pub topic: String,
    /// How many messages may wait to be taken.
    pub queue_size: u32,
    /// Width of a circle's line in metres, and the size of its arrow. It has no bounds in rviz.
    pub width_m: f32,
    /// What the circles' sizes are multiplied with.
    pub scale: f32,
    /// How many of the latest messages are shown; 1 to 100,000.
    pub history_length: u32,
    /// The name of the parameter with the robot's description.
    pub robot_description: String,
    /// What stands, with a slash, before the links' names in their frames' names; empty for nothing.
    pub tf_prefix: String,
    /// Which joints are shown; those not listed are.
    pub joints: BTreeMap<String, bool>,
}

impl Default for EffortSettings {
    fn default() -> Self {
        EffortSettings {
            topic: String::new(),
            queue_size: 10,
            width_m: 0.02,
            scale: 1.0,
            history_length: 1,
            robot_description: "robot_description".to_owned(),
            tf_prefix: String::new(),
            joints: BTreeMap::new(),
        }
    }
}

impl EffortSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = EffortSettings::default();
        section.subscription(&mut settings.topic, 0, &mut settings.queue_size);
        // Without effect in rviz: the circles are opaque.
        section.skip(&["Alpha"]);
        section.float("Width", ANY, &mut settings.width_m);
        section.float("Scale", ANY, &mut settings.scale);
        section.count_in("History Length", 1..=MAX_HISTORY, &mut settings.history_length);
        section.text("Robot Description", &mut settings.robot_description);
        section.text("TF Prefix", &mut settings.tf_prefix);
        let mut joints = section.child("Joints");
        for (name, _, _) in joints.all() {
            let mut joint = joints.child(name);
            let mut enabled = true;
            joint.bool("Value", &mut enabled);
            joint.skip(&["Effort", "Max Effort"]);
            joint.finish();
            settings.joints.insert(name.to_owned(), enabled);
        }
        settings
    }
}
