//! Outputs of finished frames: one trait for all, one file for each kind.
//!
//! A camera decides when a frame is due and what it shows; an [`Output`] publishes the finished [`OutputFrame`], and
//! reports whether anybody is watching. To add one: implement the trait in a file beside these, and add it to
//! [`Outputs`].

mod compressed;
mod compressed_settings;
mod confirmed_image;
pub(crate) mod depth_image;
pub(crate) mod page;
mod page_image;
pub(crate) mod parameter_description;
mod picture_files;
pub(crate) mod shown;
mod topic;
mod video;
mod window;

use std::sync::Arc;

use anyhow::Result;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::Time;
use rcs_scene::Picture;
use rcs_window::{OnScreen, Refresh};

use crate::control::LightTicket;
use crate::outputs::depth_image::DepthImage;
use crate::outputs::shown::{ShownPublisher, ShownRecord};
use crate::safety::permit::Permit;

pub(crate) use page::PageOutput;
pub(crate) use picture_files::{PictureFile, PictureSequence};
pub(crate) use topic::{retain, TopicNames, TopicOutput};
pub(crate) use video::VideoFile;
pub use window::window_permit;
pub(crate) use window::{test_light, WindowOutput, WindowThread};

/// A finished image with its CameraInfo. Cheap to clone: both are shared.
#[derive(Clone, Debug, Default)]
pub(crate) struct OutputFrame {
    /// The image. Its memory is drawn into again once no output holds it any more.
    pub(crate) picture: Arc<Picture>,
    pub(crate) info: Arc<CameraInfo>,
    /// The image's depths, if somebody subscribes to them.
    pub(crate) depth: Option<Arc<DepthImage>>,
    pub(crate) stamp: Time,
    /// The permit for a window to show something else in its place.
    pub(crate) permit: Permit,
    /// Lets the image out; `None` if it has no light.
    pub(crate) ticket: Option<LightTicket>,
    /// The record of a new image, if somebody subscribes to them.
    pub(crate) shown: Option<Arc<ShownRecord>>,
}

/// An output of a camera's frames.
pub(crate) trait Output {
    /// Publishes a frame. Does not wait for viewers.
    fn send(&mut self, frame: &OutputFrame) -> Result<()>;

    /// Completes the output after the last frame.
    fn finish(&mut self) -> Result<()> {
        Ok(())
    }

    /// `true` if anybody is watching. Nothing is drawn for an output that nobody watches.
    fn is_watched(&self) -> bool {
        true
    }

    /// `true` if somebody began to watch since the last call, and so has no image yet.
    fn take_new_watcher(&mut self) -> bool {
        false
    }
}

/// The outputs of one of the node's cameras.
#[derive(Default)]
pub(crate) struct Outputs {
    /// The image topic; `None` where the config names none, or where it cannot be published.
    pub(crate) topic: Option<TopicOutput>,
    /// The window in this process, if there is one for this camera.
    pub(crate) window: Option<WindowOutput>,
    /// The operator's page, if there is one.
    pub(crate) page: Option<PageOutput>,
}

impl Outputs {
    fn all(&self) -> impl Iterator<Item = &dyn Output> {
        let window = self.window.iter().map(|window| window as &dyn Output);
        let page = self.page.iter().map(|page| page as &dyn Output);
        // The window first: a topic takes longer.
        window.chain(self.topic.iter().map(|topic| topic as &dyn Output)).chain(page)
    }

    fn each(&mut self) -> impl Iterator<Item = &mut dyn Output> {
        let window = self.window.iter_mut().map(|window| window as &mut dyn Output);
        let page = self.page.iter_mut().map(|page| page as &mut dyn Output);
        window.chain(self.topic.iter_mut().map(|topic| topic as &mut dyn Output)).chain(page)
    }

    /// The refresh of the screen that shows the images, where it is known.
    pub(crate) fn refresh(&self) -> Option<Refresh> {
        self.window.as_ref()?.refresh()
    }

    pub(crate) fn wants_depth(&self) -> bool {
        self.topic.as_ref().is_some_and(TopicOutput::wants_depth)
    }

    /// The topic of records of what was shown, if somebody subscribes to it.
    pub(crate) fn shown(&self) -> Option<&ShownPublisher> {
        self.topic.as_ref().and_then(TopicOutput::shown)
    }

    /// Confirms the last image to a window that would become black otherwise.
    pub(crate) fn confirm(&self) {
        self.window.iter().for_each(WindowOutput::confirm);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.all().next().is_none()
    }
}

/// All of them together.
impl Output for Outputs {
    /// Hands the frame to each output, also after one that failed. Returns the first error.
    fn send(&mut self, frame: &OutputFrame) -> Result<()> {
        let mut result = Ok(());
        for output in self.each() {
            let sent = output.send(frame);
            result = result.and(sent);
        }
        // A window reports itself when it has shown the image.
        if !self.window.as_ref().is_some_and(Output::is_watched) {
            frame.shown.iter().for_each(|record| record.shown());
        }
        result
    }

    fn is_watched(&self) -> bool {
        self.all().any(Output::is_watched)
    }

    fn take_new_watcher(&mut self) -> bool {
        let mut is_new = false;
        // No short-circuit: the call resets each flag.
        for output in self.each() {
            is_new |= output.take_new_watcher();
        }
        is_new
    }
}
