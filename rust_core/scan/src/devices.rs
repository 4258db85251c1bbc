//! The devices of a scan: the projector's screen and the camera. Tests simulate them, with a time of their own.

use std::time::{Duration, Instant};

use rcs_calibration::Lens;

/// The projector.
pub trait ProjectorScreen {
    /// Its name in messages, such as `monitor HDMI-1`.
    fn name(&self) -> String;

    /// Shows an image of the projector's size: grey levels, row by row from the top. It may be seen later.
    ///
    /// # Errors
    /// The reason, in one line.
    fn show(&mut self, image: Vec<u8>) -> anyhow::Result<()>;
}

/// A frame from the camera.
#[derive(Debug, Clone)]
pub struct CameraFrame {
    /// Width and height, pixels.
    pub size_px: [u32; 2],
    /// Grey levels, row by row from the top.
    pub grey: Vec<u8>,
    /// Time of receipt.
    pub received: Instant,
}

/// A depth image that is registered to the camera's frames.
#[derive(Debug, Clone)]
pub struct DepthFrame {
    /// Width and height, pixels.
    pub size_px: [u32; 2],
    /// Depth along the view, metres, row by row; none where not a positive number.
    pub depth_m: Vec<f32>,
}

/// A camera, with depth or without.
pub trait ScanCamera {
    /// The present time.
    fn now(&self) -> Instant {
        Instant::now()
    }

    /// The lens; its size is that of all frames.
    fn lens(&self) -> Lens;

    /// The optical frame; may be empty.
    fn frame_id(&self) -> String;

    /// The first frame received after a time. Frames between two calls may be skipped.
    ///
    /// # Errors
    /// [`ScanCameraError`]: no frame within `timeout`, or an unusable one.
    fn frame(&mut self, after: Instant, timeout: Duration) -> Result<CameraFrame, ScanCameraError>;

    /// `true` if it measures depth.
    fn has_depth(&self) -> bool;

    /// The newest depth image, if there is one that was not returned before.
    ///
    /// # Errors
    /// [`ScanCameraError::Unusable`].
    fn depth(&mut self) -> Result<Option<DepthFrame>, ScanCameraError>;
}

/// The reason for a missing frame.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ScanCameraError {
    /// Nothing was received.
    #[error("nothing was received on {topic} within {} s: {reason}", waited.as_secs())]
    Silent {
        /// The topic.
        topic: String,
        /// The timeout.
        waited: Duration,
        /// State of its publishers.
        reason: String,
        /// Topics that may be meant, with types and publishers, a line each.
        known_topics: Vec<String>,
    },
    /// A message or topic that cannot be used.
    #[error("{topic}: {reason}")]
    Unusable {
        /// The topic.
        topic: String,
        /// The reason.
        reason: String,
    },
    /// The program was asked to end.
    #[error("interrupted")]
    Interrupted,
}

/// The topic of depth.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DepthTopic {
    /// Depth images that are registered to the camera's frames.
    Image(String),
    /// Organised clouds with a point for each pixel.
    Cloud(String),
    /// No depth.
    None,
}

/// The topics of a camera, live or in a bag.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CameraTopics {
    /// Images, plain or compressed.
    pub image: String,
    /// CameraInfo.
    pub camera_info: String,
    /// Depth.
    pub depth: DepthTopic,
}
