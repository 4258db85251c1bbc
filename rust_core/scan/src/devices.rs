//! What a scan needs of the world: a screen to show pictures on, and a camera that sees them. Tests bring simulated
//! ones, whose time is not that of the clock.

use std::time::{Duration, Instant};

use rcs_calibration::Lens;

/// Where pictures are shown: the projector.
pub trait Screen {
    /// What a message calls it, such as `monitor HDMI-1`.
    fn name(&self) -> String;

    /// Shows a picture of the projector's size in place of the one before: grey levels, row by row from the top. It
    /// may be seen later.
    ///
    /// # Errors
    /// One line that says why it cannot be shown.
    fn show(&mut self, picture: Vec<u8>) -> anyhow::Result<()>;
}

/// A picture from the camera.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Width and height, pixels.
    pub size_px: [u32; 2],
    /// Grey levels, row by row from the top.
    pub grey: Vec<u8>,
    /// When it was received.
    pub received: Instant,
}

/// A depth image that is registered to the pictures.
#[derive(Debug, Clone)]
pub struct DepthFrame {
    /// Width and height, pixels.
    pub size_px: [u32; 2],
    /// Depth along the view, metres, row by row; what is not a positive number is no depth.
    pub depth_m: Vec<f32>,
}

/// A camera, with depth or without.
pub trait Camera {
    /// The present time.
    fn now(&self) -> Instant {
        Instant::now()
    }

    /// The lens; its size is that of all pictures.
    fn lens(&self) -> Lens;

    /// The optical frame; may be empty.
    fn frame_id(&self) -> String;

    /// The first picture received after a time. Pictures between two calls may be left out.
    ///
    /// # Errors
    /// [`CameraError`]: no picture within `timeout`, or one that cannot be used.
    fn frame(&mut self, after: Instant, timeout: Duration) -> Result<Frame, CameraError>;

    /// Whether it measures depth.
    fn has_depth(&self) -> bool;

    /// The newest depth image, if there is one that was not returned before.
    ///
    /// # Errors
    /// [`CameraError::Unusable`].
    fn depth(&mut self) -> Result<Option<DepthFrame>, CameraError>;
}

/// Why there is no picture.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// Nothing arrived.
    #[error("nothing was received on {topic} within {} s: is the camera's driver running?", waited.as_secs())]
    Silent {
        /// The topic.
        topic: String,
        /// How long it was waited for.
        waited: Duration,
    },
    /// What arrived cannot be used.
    #[error("{topic}: {reason}")]
    Unusable {
        /// The topic.
        topic: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The program is asked to end.
    #[error("interrupted")]
    Interrupted,
}
