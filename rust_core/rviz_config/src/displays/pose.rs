//! `rviz/Pose`: a `geometry_msgs/PoseStamped` as an arrow or axes.

use crate::displays::pose_symbol::PoseSymbolSettings;

properties! {
    /// The properties of a Pose display.
    pub struct PoseSettings {
        /// Topic of `geometry_msgs/PoseStamped`; empty when none is chosen.
        topic: String = String::new() => topic("Topic");
        /// Most messages that wait for their transform.
        queue_size: u32 = 10 => count("Queue Size", 0);
        /// Symbol of the pose.
        symbol: PoseSymbolSettings = PoseSymbolSettings::default() => pose_symbol();
    }
}
