//! Where finished pictures go: one trait for all outputs, one file for each kind.
//!
//! A camera decides when a picture is due and what is drawn; an [`Output`] hands the finished [`Frame`] on, and reports
//! whether anybody is watching. To add one: implement the trait in a file beside
//! these, and add it to [`Outputs`].

mod compressed;
mod compressed_settings;
pub mod depth_image;
pub(crate) mod parameter_description;
mod picture_files;
mod topic;
mod video;
mod window;

use std::io;
use std::sync::Arc;

use rcs_files::picture_file::PictureFileError;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::Time;
use rcs_scene::Picture;
use rcs_window::Refresh;

use crate::outputs::depth_image::DepthImage;
use crate::safety::permit::Permit;

pub use picture_files::{PictureFile, PictureSequence, SequenceError};
pub use topic::{retain, TopicNames, TopicOutput};
pub use video::{VideoError, VideoFile};
pub use window::{test_light, window_permit, WindowOutput, WindowThread};

/// A finished picture with the CameraInfo it was drawn with. Cheap to clone: picture and CameraInfo are shared.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// The picture. Its memory is drawn into again once no output holds it any more.
    pub picture: Arc<Picture>,
    /// The CameraInfo that the camera was made of.
    pub info: Arc<CameraInfo>,
    /// How far away is what the picture shows, where that was drawn.
    pub depth: Option<Arc<DepthImage>>,
    /// When the picture is handed on, in ROS time.
    pub stamp: Time,
    /// The permit for a window to show something else in its place.
    pub permit: Permit,
    /// The picture before post-processing, for a window that may hold it below newer masks.
    pub drawn: Option<Arc<Picture>>,
}

/// Why a frame was not handed on.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// A topic cannot be published on.
    #[error(transparent)]
    Topic(#[from] io::Error),
    /// A picture cannot be written to a file.
    #[error(transparent)]
    Picture(#[from] PictureFileError),
    /// The folder of a sequence cannot be created.
    #[error(transparent)]
    Sequence(#[from] SequenceError),
    /// A video cannot be written.
    #[error(transparent)]
    Video(#[from] VideoError),
}

/// Hands a camera's finished pictures on.
pub trait Output {
    /// Hands a frame on. Does not wait for those who watch.
    ///
    /// # Errors
    /// See [`OutputError`].
    fn send(&mut self, frame: &Frame) -> Result<(), OutputError>;

    /// Completes what was handed on, after the last frame.
    ///
    /// # Errors
    /// See [`OutputError`].
    fn finish(&mut self) -> Result<(), OutputError> {
        Ok(())
    }

    /// Whether anybody is watching. Nothing is drawn for an output that nobody watches.
    fn is_watched(&self) -> bool {
        true
    }

    /// Whether somebody began to watch since this was last asked, and so has no picture yet.
    fn take_new_watcher(&mut self) -> bool {
        false
    }
}

/// The outputs of one of the node's cameras.
#[derive(Default)]
pub struct Outputs {
    /// The image topic; `None` where the config names none, or where it cannot be published.
    pub topic: Option<TopicOutput>,
    /// The window in this process, if there is one for this camera.
    pub window: Option<WindowOutput>,
}

impl Outputs {
    fn all(&self) -> impl Iterator<Item = &dyn Output> {
        let window = self.window.iter().map(|window| window as &dyn Output);
        // The window first: a topic takes longer.
        window.chain(self.topic.iter().map(|topic| topic as &dyn Output))
    }

    fn each(&mut self) -> impl Iterator<Item = &mut dyn Output> {
        let window = self.window.iter_mut().map(|window| window as &mut dyn Output);
        window.chain(self.topic.iter_mut().map(|topic| topic as &mut dyn Output))
    }

    /// When the screen that shows the pictures is refreshed, where that is known.
    pub fn refresh(&self) -> Option<Refresh> {
        self.window.as_ref()?.refresh()
    }

    /// Whether anybody watches how far away things are.
    pub fn wants_depth(&self) -> bool {
        self.topic.as_ref().is_some_and(TopicOutput::wants_depth)
    }

    /// Says that the last picture is still what is to be seen, to a window that would become black otherwise.
    pub fn confirm(&self) {
        self.window.iter().for_each(WindowOutput::confirm);
    }

    /// Whether there is no output at all.
    pub fn is_empty(&self) -> bool {
        self.all().next().is_none()
    }
}

/// All of them together.
impl Output for Outputs {
    /// Hands the frame to each output, also after one that failed. Returns the first error.
    fn send(&mut self, frame: &Frame) -> Result<(), OutputError> {
        let mut result = Ok(());
        for output in self.each() {
            let sent = output.send(frame);
            result = result.and(sent);
        }
        result
    }

    fn is_watched(&self) -> bool {
        self.all().any(Output::is_watched)
    }

    fn take_new_watcher(&mut self) -> bool {
        let mut is_new = false;
        // Each is asked, for each forgets when it is.
        for output in self.each() {
            is_new |= output.take_new_watcher();
        }
        is_new
    }
}
