//! `rviz/PoseWithCovariance`: a `geometry_msgs/PoseWithCovarianceStamped` as an arrow or axes, and its covariance.

use crate::displays::covariance::CovarianceSettings;
use crate::displays::pose_symbol::PoseSymbolSettings;
use crate::section::Section;

/// The properties of a PoseWithCovariance display.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseWithCovarianceSettings {
    /// Topic of `geometry_msgs/PoseWithCovarianceStamped`; empty when none is chosen.
    pub topic: String,
    /// How many messages may wait for their transform.
    pub queue_size: u32,
    /// What stands at the pose.
    pub symbol: PoseSymbolSettings,
    /// What is shown of its covariance.
    pub covariance: CovarianceSettings,
}

impl Default for PoseWithCovarianceSettings {
    fn default() -> Self {
        PoseWithCovarianceSettings {
            topic: String::new(),
            queue_size: 10,
            symbol: PoseSymbolSettings::default(),
            covariance: CovarianceSettings::default(),
        }
    }
}

impl PoseWithCovarianceSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = PoseWithCovarianceSettings::default();
        section.subscription(&mut settings.topic, 0, &mut settings.queue_size);
        settings.symbol = PoseSymbolSettings::read(section);
        settings.covariance = CovarianceSettings::read(section);
        settings
    }
}
