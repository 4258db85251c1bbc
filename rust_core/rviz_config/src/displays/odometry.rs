//! `rviz/Odometry`: the last poses of a `nav_msgs/Odometry` as arrows or axes, and their covariances.

use crate::displays::covariance::CovarianceSettings;
use crate::displays::pose_symbol::PoseSymbolSettings;
use crate::section::{at_least, Section};

/// The properties of an Odometry display.
#[derive(Debug, Clone, PartialEq)]
pub struct OdometrySettings {
    /// Topic of `nav_msgs/Odometry`; empty when none is chosen.
    pub topic: String,
    /// How many messages may wait for their transform.
    pub queue_size: u32,
    /// A pose is added when it is at least so far from the last one, in metres, or turned far enough; at least 0.
    pub position_tolerance_m: f32,
    /// A pose is added when it is turned by at least so much from the last one, in radians, or is far enough away; at
    /// least 0.
    pub angle_tolerance_rad: f32,
    /// How many poses are shown; 0 shows all that were ever added.
    pub keep: u32,
    /// What stands at each pose.
    pub symbol: PoseSymbolSettings,
    /// What is shown of their covariances.
    pub covariance: CovarianceSettings,
}

impl Default for OdometrySettings {
    fn default() -> Self {
        OdometrySettings {
            topic: String::new(),
            queue_size: 10,
            position_tolerance_m: 0.1,
            angle_tolerance_rad: 0.1,
            keep: 100,
            symbol: PoseSymbolSettings::default(),
            covariance: CovarianceSettings::default(),
        }
    }
}

impl OdometrySettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = OdometrySettings::default();
        section.subscription(&mut settings.topic, 0, &mut settings.queue_size);
        section.float("Position Tolerance", at_least(0.0), &mut settings.position_tolerance_m);
        section.float("Angle Tolerance", at_least(0.0), &mut settings.angle_tolerance_rad);
        section.count("Keep", 0, &mut settings.keep);
        section.skip_old(&["Color"], "Shape / Color");
        section.skip_old(&["Length"], "Shape / Shaft Length and Head Length");
        settings.symbol = PoseSymbolSettings::read_inside_shape(section);
        settings.covariance = CovarianceSettings::read(section);
        settings
    }
}
