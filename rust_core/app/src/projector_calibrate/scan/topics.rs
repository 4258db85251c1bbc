//! The topics of a camera, live or in a bag.

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
