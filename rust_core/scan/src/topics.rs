//! The topics of a camera, live or in a bag.

/// Where depth comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DepthTopic {
    /// A depth image that is registered to the pictures.
    Image(String),
    /// An organised cloud with a point for each pixel.
    Cloud(String),
    /// Nowhere.
    None,
}

/// The topics of a camera.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CameraTopics {
    /// Its pictures.
    pub image: String,
    /// Its CameraInfo.
    pub camera_info: String,
    /// Its depth.
    pub depth: DepthTopic,
}
