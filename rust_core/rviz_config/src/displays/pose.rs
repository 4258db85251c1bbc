//! `rviz/Pose`: a `geometry_msgs/PoseStamped` as an arrow or axes.

use crate::displays::pose_symbol::PoseSymbolSettings;
use crate::section::Section;

/// The properties of a Pose display.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseSettings {
    /// Topic of `geometry_msgs/PoseStamped`; empty when none is chosen.
    pub topic: String,
    /// How many messages may wait for their transform.
    pub queue_size: u32,
    /// What is drawn.
    pub symbol: PoseSymbolSettings,
}

impl Default for PoseSettings {
    fn default() -> Self {
        PoseSettings { topic: String::new(), queue_size: 10, symbol: PoseSymbolSettings::default() }
    }
}

impl PoseSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = PoseSettings::default();
        section.subscription(&mut settings.topic, 0, &mut settings.queue_size);
        settings.symbol = PoseSymbolSettings::read(section);
        settings
    }
}
