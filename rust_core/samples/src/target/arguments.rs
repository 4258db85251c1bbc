//! The options that say what a node aims at.

use std::time::Duration;

use anyhow::bail;

use rcs_node_support::node_options::number_within;

/// What is aimed at, one of four, and for how long.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct TargetArguments {
    /// The target is the position of a geometry_msgs/PoseStamped on this topic
    #[arg(long, value_name = "TOPIC", conflicts_with_all = ["target_point", "target_cloud", "target_frame"])]
    target_pose: Option<String>,
    /// The target is a geometry_msgs/PointStamped on this topic
    #[arg(long, value_name = "TOPIC", conflicts_with_all = ["target_cloud", "target_frame"])]
    target_point: Option<String>,
    /// The target is the centroid of a sensor_msgs/PointCloud2 on this topic
    #[arg(long, value_name = "TOPIC", conflicts_with = "target_frame")]
    target_cloud: Option<String>,
    /// The target is the origin of this frame
    #[arg(long, value_name = "FRAME")]
    target_frame: Option<String>,
    /// The target is gone when it was not received for so many seconds; 0: it stays until another one is received
    #[arg(long, value_name = "SECS", default_value_t = 1.0, value_parser = timeout)]
    target_timeout: f64,
    /// The frame in which targets stand still: map or odom on a robot that drives
    #[arg(long, value_name = "FRAME", default_value = "base_link")]
    pub(crate) fixed_frame: String,
}

/// Where a target comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum TargetSource {
    /// A topic with poses.
    Pose(String),
    /// A topic with points.
    Point(String),
    /// A topic with clouds.
    Cloud(String),
    /// A frame.
    Frame(String),
}

fn timeout(text: &str) -> Result<f64, String> {
    number_within(text, 0.0, 86_400.0)
}

impl TargetArguments {
    /// Where the target comes from.
    ///
    /// # Errors
    /// When there is none.
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

    /// After which time without a message it is gone; none: never.
    pub(crate) fn timeout(&self) -> Option<Duration> {
        (self.target_timeout > 0.0).then(|| Duration::from_secs_f64(self.target_timeout))
    }
}
