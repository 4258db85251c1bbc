//! The topics of a camera, live or in a bag.

use clap::Args;

/// Where depth comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum DepthTopic {
    /// A depth image that is registered to the pictures.
    Image(String),
    /// An organised cloud with a point for each pixel.
    Cloud(String),
    /// Nowhere.
    None,
}

/// The topics of a camera.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct CameraTopics {
    /// Its pictures.
    pub(super) image: String,
    /// Its CameraInfo.
    pub(super) camera_info: String,
    /// Its depth.
    pub(super) depth: DepthTopic,
}

/// The topics of a camera, as a user names them.
#[derive(Debug, Clone, Args)]
pub(in crate::projector_calibrate) struct TopicArguments {
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
