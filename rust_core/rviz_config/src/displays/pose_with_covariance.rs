//! `rviz/PoseWithCovariance`: a `geometry_msgs/PoseWithCovarianceStamped` as an arrow or axes, and its covariance.

use crate::displays::covariance::CovarianceSettings;
use crate::displays::pose_symbol::PoseSymbolSettings;

properties! {
    /// The properties of a PoseWithCovariance display.
    pub struct PoseWithCovarianceSettings {
        /// Topic of `geometry_msgs/PoseWithCovarianceStamped`; empty when none is chosen.
        topic: String = String::new() => topic("Topic");
        /// Most messages that wait for their transform.
        queue_size: u32 = 10 => count("Queue Size", 0);
        /// Symbol of the pose.
        symbol: PoseSymbolSettings = PoseSymbolSettings::default() => pose_symbol();
        /// How its covariance is drawn.
        covariance: CovarianceSettings = CovarianceSettings::default() => properties();
    }
}
