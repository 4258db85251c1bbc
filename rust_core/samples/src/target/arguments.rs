//! Options of a node's target.

use std::time::Duration;

use anyhow::bail;

use rcs_node_support::node_options::within;

/// Source and timeout of the target; exactly one source is given.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct TargetArguments {
    /// Take the target from a geometry_msgs/PoseStamped on this topic
    #[arg(long, value_name = "TOPIC", conflicts_with_all = ["target_point", "target_cloud", "target_frame"])]
    target_pose: Option<String>,
    /// Take the target from a geometry_msgs/PointStamped on this topic
    #[arg(long, value_name = "TOPIC", conflicts_with_all = ["target_cloud", "target_frame"])]
    target_point: Option<String>,
    /// Take the centroid of a sensor_msgs/PointCloud2 on this topic
    #[arg(long, value_name = "TOPIC", conflicts_with = "target_frame")]
    target_cloud: Option<String>,
    /// Take the origin of this frame
    #[arg(long, value_name = "FRAME")]
    target_frame: Option<String>,
    /// Drop a target that was not received for this time [s; 0: keep it until the next]
    #[arg(long, value_name = "SECS", default_value_t = 1.0, value_parser = within(0.0, 86_400.0))]
    target_timeout: f64,
    /// Fixed frame of the targets: map or odom on a mobile robot
    #[arg(long, value_name = "FRAME", default_value = "base_link")]
    pub(crate) fixed_frame: String,
}

/// Source of a target.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum TargetSource {
    /// Topic of poses.
    Pose(String),
    /// Topic of points.
    Point(String),
    /// Topic of clouds.
    Cloud(String),
    /// A frame.
    Frame(String),
}

impl TargetArguments {
    /// The source.
    ///
    /// # Errors
    /// None is given.
    pub(crate) fn source(&self) -> anyhow::Result<TargetSource> {
        let Self { target_pose, target_point, target_cloud, target_frame, .. } = self;
        Ok(match (target_pose, target_point, target_cloud, target_frame) {
            (Some(topic), ..) => TargetSource::Pose(topic.clone()),
            (_, Some(topic), ..) => TargetSource::Point(topic.clone()),
            (_, _, Some(topic), _) => TargetSource::Cloud(topic.clone()),
            (.., Some(frame)) => TargetSource::Frame(frame.clone()),
            _ => bail!(
                "no target: give --target-pose, --target-point, --target-cloud or --target-frame, or its parameter"
            ),
        })
    }

    /// Time without a message after which the target expires; `None`: never.
    pub(crate) fn timeout(&self) -> Option<Duration> {
        (self.target_timeout > 0.0).then(|| Duration::from_secs_f64(self.target_timeout))
    }
}
