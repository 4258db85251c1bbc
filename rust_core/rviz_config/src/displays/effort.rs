//! `rviz/Effort`: circles around a robot's joints for the efforts of a `sensor_msgs/JointState`.

use std::collections::BTreeMap;

use crate::section::{Section, ANY, MAX_HISTORY};

properties! {
    /// The properties of an Effort display.
    pub struct EffortSettings {
        /// Topic of `sensor_msgs/JointState`; empty when none is chosen.
        topic: String = String::new() => topic("Topic");
        /// Most messages that wait to be taken.
        queue_size: u32 = 10 => count("Queue Size", 0);
        /// Width of a circle's line in metres, and the size of its arrow. It has no bounds in rviz.
        width_m: f32 = 0.02 => float("Width", ANY);
        /// Factor of the circles' sizes.
        scale: f32 = 1.0 => float("Scale", ANY);
        /// Number of the latest messages that are drawn; 1 to 100,000.
        history_length: u32 = 1 => count_in("History Length", 1..=MAX_HISTORY);
        /// The name of the parameter with the robot's description.
        robot_description: String = "robot_description".to_owned() => text("Robot Description");
        /// Prefix of the links' frames, without the slash after it; empty for none.
        tf_prefix: String = String::new() => text("TF Prefix");
        /// `true` for joints that are drawn, as are joints that are not listed.
        joints: BTreeMap<String, bool> = BTreeMap::new();
    }
    // Without effect in rviz: the circles are opaque.
    skip ["Alpha"];
    then read_joints;
}

impl EffortSettings {
    fn read_joints(&mut self, section: &mut Section<'_>) {
        let mut joints = section.child("Joints");
        for (name, _) in joints.all() {
            let mut joint = joints.child(name);
            let mut enabled = true;
            joint.bool("Value", &mut enabled);
            joint.skip(&["Effort", "Max Effort"]);
            joint.finish();
            self.joints.insert(name.to_owned(), enabled);
        }
    }
}
