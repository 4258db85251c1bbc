//! `rviz/Odometry`: the last poses of a `nav_msgs/Odometry` as arrows or axes, and their covariances.

use crate::displays::covariance::CovarianceSettings;
use crate::displays::pose_symbol::PoseSymbolSettings;
use crate::section::{at_least, Section};

properties! {
    /// The properties of an Odometry display. A pose is added if it is far enough from the last one, or turned enough.
    pub struct OdometrySettings {
        /// Topic of `nav_msgs/Odometry`; empty when none is chosen.
        topic: String = String::new() => topic("Topic");
        /// Most messages that wait for their transform.
        queue_size: u32 = 10 => count("Queue Size", 0);
        /// Smallest distance in metres between two poses; at least 0.
        position_tolerance_m: f32 = 0.1 => float("Position Tolerance", at_least(0.0));
        /// Smallest angle in radians between two poses; at least 0.
        angle_tolerance_rad: f32 = 0.1 => float("Angle Tolerance", at_least(0.0));
        /// Most poses that are drawn; 0 for all that were ever added.
        keep: u32 = 100 => count("Keep", 0);
        /// Symbol of each pose.
        symbol: PoseSymbolSettings = PoseSymbolSettings::default() => pose_symbol_inside_shape();
        /// How the covariances are drawn.
        covariance: CovarianceSettings = CovarianceSettings::default() => properties();
    }
    then skip_old_keys;
}

impl OdometrySettings {
    fn skip_old_keys(&mut self, section: &mut Section<'_>) {
        section.skip_old(&["Color"], "Shape / Color");
        section.skip_old(&["Length"], "Shape / Shaft Length and Head Length");
    }
}
