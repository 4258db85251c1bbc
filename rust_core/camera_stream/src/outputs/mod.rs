//! Outputs of finished frames: one trait for all, one file for each kind.
//!
//! A camera decides when a frame is due and what it shows; an [`Output`] publishes the finished [`OutputFrame`], and
//! reports whether anybody is watching. To add one: implement the trait in a file beside these, and add it to
//! [`Outputs`].

mod compressed;
mod compressed_settings;
mod confirmed_image;
pub(crate) mod depth_image;
mod image_files;
pub(crate) mod page;
mod page_image;
pub(crate) mod shown;
mod topic;
mod video;
mod window;

use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use rcs_light::{Grant, Lit};
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::Time;
use rcs_scene::{Encoding, Image};
use rcs_window::{OnScreen, Refresh};

use crate::outputs::depth_image::EncodedDepths;
use crate::outputs::shown::{ShownPublisher, ShownRecord};
use crate::safety::black_image::black_image;

pub(crate) use image_files::{ImageFile, ImageSequence};
pub(crate) use page::PageOutput;
pub(crate) use topic::{retain, TopicNames, TopicOutput};
pub(crate) use video::VideoFile;
pub(crate) use window::{WindowOutput, WindowThread};

/// An image for the outputs: black, or lit as long as its grant holds.
#[derive(Clone, Debug)]
pub(crate) struct FrameImage(ImageContent);

#[derive(Clone, Debug)]
enum ImageContent {
    Black(Arc<Image>),
    Lit(Lit<Arc<Image>>),
}

impl FrameImage {
    /// A black image.
    pub(crate) fn black(size_px: [u32; 2], encoding: Encoding) -> Self {
        Self(ImageContent::Black(Arc::new(black_image(size_px, encoding))))
    }

    /// A lit image, while its grant is valid.
    pub(crate) fn lit(lit: Lit<Arc<Image>>) -> Self {
        Self(ImageContent::Lit(lit))
    }

    /// Width and height.
    pub(crate) fn size_px(&self) -> [u32; 2] {
        match &self.0 {
            ImageContent::Black(image) => [image.width_px, image.height_px],
            ImageContent::Lit(lit) => lit.size_px(),
        }
    }

    /// The image; black once its grant is void.
    pub(crate) fn content(&self, now: Instant) -> Arc<Image> {
        match &self.0 {
            ImageContent::Black(image) => Arc::clone(image),
            ImageContent::Lit(lit) => {
                lit.content(now).map_or_else(|| Arc::new(black_image(lit.size_px(), lit.encoding())), Arc::clone)
            }
        }
    }

    /// The lit image; `None` for black.
    pub(crate) fn lit_image(&self) -> Option<&Lit<Arc<Image>>> {
        match &self.0 {
            ImageContent::Black(_) => None,
            ImageContent::Lit(lit) => Some(lit),
        }
    }

    /// The grant; `None` for black.
    pub(crate) fn grant(&self) -> Option<&Grant> {
        self.lit_image().map(Lit::grant)
    }

    /// Takes a later grant, if that allows the same light. Returns `true` if so.
    pub(crate) fn renew(&mut self, grant: &Grant) -> bool {
        match &mut self.0 {
            ImageContent::Black(_) => false,
            ImageContent::Lit(lit) => lit.renew(grant),
        }
    }

    /// The image for its memory, which is drawn into again once no output holds it any more.
    pub(crate) fn into_memory(self) -> Arc<Image> {
        match self.0 {
            ImageContent::Black(image) => image,
            ImageContent::Lit(lit) => lit.into_memory(),
        }
    }
}

/// A finished image with its CameraInfo. Cheap to clone: all is shared.
#[derive(Clone, Debug)]
pub(crate) struct OutputFrame {
    pub(crate) image: FrameImage,
    pub(crate) info: Arc<CameraInfo>,
    /// The image's depths, if somebody subscribes to them.
    pub(crate) depth: Option<Arc<EncodedDepths>>,
    pub(crate) stamp: Time,
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

    /// Hands the last image's grant to a window that would become black otherwise.
    pub(crate) fn renew(&self, image: &FrameImage) {
        let grant = image.grant();
        self.window.iter().zip(grant).for_each(|(window, grant)| window.renew(grant));
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.all().next().is_none()
    }
}

/// All of them together.
impl Output for Outputs {
    /// Hands the frame to each output, also after one that failed. Returns the first error. Without a CameraInfo, a
    /// frame is for the window alone.
    fn send(&mut self, frame: &OutputFrame) -> Result<()> {
        let mut result = Ok(());
        let count = if frame.info.width == 0 { usize::from(self.window.is_some()) } else { usize::MAX };
        for output in self.each().take(count) {
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
