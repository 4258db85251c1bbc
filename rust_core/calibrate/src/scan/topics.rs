//! The topics of a camera, live or in a bag.

use clap::Args;
use rcs_scan::{CameraTopics, DepthTopic};

/// The topics of a camera, as a user names them.
#[derive(Debug, Clone, Args)]
pub(crate) struct TopicArguments {
    /// The camera's pictures
    #[arg(long, value_name = "TOPIC", default_value = "/head_camera/rgb/image_raw")]
    image: String,
    /// Its CameraInfo
    #[arg(long, value_name = "TOPIC", default_value = "/head_camera/rgb/camera_info")]
    camera_info: String,
    /// Depth images that are registered to the pictures
    #[arg(long, value_name = "TOPIC", default_value = "/head_camera/depth_registered/image_raw")]
    depth: String,
    /// Take depth from an organised cloud with a point for each pixel instead
    #[arg(long, value_name = "TOPIC", conflicts_with = "depth")]
    cloud: Option<String>,
}

impl TopicArguments {
    /// With depth.
    pub(super) fn topics(&self) -> CameraTopics {
        let depth = match &self.cloud {
            Some(cloud) => DepthTopic::Cloud(cloud.clone()),
            None => DepthTopic::Image(self.depth.clone()),
        };
        CameraTopics { image: self.image.clone(), camera_info: self.camera_info.clone(), depth }
    }
}
