//! A frame of a camera, from due to finished: each state is a type of its own, and each step consumes the one before.
//!
//! ```text
//!   idle ──► DueFrame ──submit──► FrameInFlight ──finish──► FinishedFrame ──► outputs ──► idle
//!            (CameraOutput::poll)                           (CameraOutput::publish)
//! ```

use std::sync::Arc;
use std::time::Instant;

use rcs_displays::CameraView;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_render::{DepthRequest, Depths, Finished, LastStep, RenderError, Renderer, View};
use rcs_scene::{Camera, DepthPicture, DisplayId, DisplayMask, Picture, Scene};
use rcs_transforms::Time;

use super::light_check::{confirmed, CheckedLight};
use crate::control::pattern::Pattern;
use crate::control::LightTicket;
use crate::outputs::depth_image::{DepthEncoding, DepthImage};
use crate::safety;
use crate::safety::causes::DarkReason;
use crate::safety::permit::Permit;
use crate::safety::surface::SurfaceCheck;
use crate::scene::renderer_view;
use rcs_window::test_pictures::TestPicture;

/// The content of a frame.
#[derive(Clone, PartialEq)]
pub(crate) enum FrameContent {
    /// The scene in this version, without the displays that are stale.
    Scene { version: u64, camera: Arc<Camera>, hidden: Vec<DisplayId> },
    /// Black. The size is that before post-processing turns it; `has_note`: it says why it is black.
    Black { size_px: [u32; 2], dark: DarkReason, has_note: bool },
    /// A test picture or a pattern. The size is that before post-processing turns it.
    Test { size_px: [u32; 2], test: TestImage },
}

/// An image that stands on the projector as it is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TestImage {
    /// A test picture of the operator.
    Picture(TestPicture),
    /// A pattern of a calibration.
    Pattern(Arc<Pattern>),
}

/// A frame's content and everything that is published with it.
#[derive(Clone)]
pub(crate) struct FrameSpec {
    pub(crate) content: FrameContent,
    pub(crate) post: Arc<LastStep>,
    /// `true` if the camera has masks on a topic, keep-out frames, or light that must be confirmed.
    pub(crate) protects_eyes: bool,
    /// A paused frame stays only among those of its number: they leave out the same data, of the same config.
    pub(crate) epoch: u64,
    pub(crate) info: Arc<CameraInfo>,
    /// Expiry if nothing new arrives.
    pub(crate) valid_until: Option<Instant>,
    /// ROS time of the lookup of predicted transforms.
    pub(crate) looked_up: Option<Time>,
    /// Stamp of the oldest data in a scene, where somebody wants to know it.
    pub(crate) oldest: Option<Time>,
    /// Void from the next blackout on.
    pub(crate) ticket: LightTicket,
}

/// A frame that is due and to be drawn.
pub(crate) struct DueFrame {
    pub(crate) spec: FrameSpec,
    pub(crate) view: Arc<CameraView>,
    pub(crate) visible: DisplayMask,
    pub(crate) camera: Arc<Camera>,
    /// The encoding of its depths, if somebody subscribes to them.
    pub(crate) depth: Option<DepthEncoding>,
    /// What its light is checked against, and memory for the depths of what it lights.
    pub(crate) check: Option<(SurfaceCheck, DepthPicture)>,
    /// `true` if the image before post-processing is needed, too: a pause may keep it below newer masks.
    pub(crate) keeps_drawn: bool,
    /// Time of the decision to draw it.
    pub(crate) begun: Instant,
}

/// A frame that the renderer works on.
pub(crate) struct FrameInFlight {
    spec: FrameSpec,
    depth: Option<DepthEncoding>,
    check: Option<(SurfaceCheck, DepthPicture)>,
    keeps_drawn: bool,
    begun: Instant,
}

/// A frame that is ready to be published.
pub(crate) struct FinishedFrame {
    pub(crate) spec: FrameSpec,
    pub(crate) picture: Arc<Picture>,
    pub(crate) depth: Option<Arc<DepthImage>>,
    /// The image before post-processing, where it is needed.
    pub(crate) drawn: Option<Arc<Picture>>,
    /// Its light, where that must be confirmed.
    pub(crate) checked: Option<CheckedLight>,
    /// Time of the decision to draw it; `None` for a black frame.
    pub(crate) begun: Option<Instant>,
    /// `false` until it is published for the first time.
    pub(crate) is_published: bool,
}

/// The renderer's buffers that all frames share, one after the other.
#[derive(Default)]
pub(crate) struct SharedBuffers {
    pub(crate) depths: Depths,
    /// Scratch buffer of post-processing.
    turned: Picture,
}

impl FrameContent {
    /// `true` if one of the two shows something that is stale in the other, or another test picture.
    pub(crate) fn differs_in_staleness(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Test { test: own, .. }, Self::Test { test, .. }) => own != test,
            (Self::Scene { hidden: own, .. }, Self::Scene { hidden, .. }) => own != hidden,
            (Self::Black { .. }, Self::Black { .. }) => false,
            _ => true,
        }
    }

    /// Width and height before post-processing.
    pub(crate) fn size_px(&self) -> [u32; 2] {
        match self {
            Self::Scene { camera, .. } => size_px(camera),
            Self::Black { size_px, .. } | Self::Test { size_px, .. } => *size_px,
        }
    }
}

impl FrameSpec {
    /// The permit to show something else in the frame's place.
    pub(crate) fn permit(&self) -> Permit {
        Permit::new(self.dark_reason(), self.protects_eyes, &self.post)
    }

    /// `true` if an image of the other one looks the same.
    pub(crate) fn looks_like(&self, other: &Self) -> bool {
        self.content == other.content && self.post == other.post
    }

    /// The frame, black for a reason that is not written into it.
    pub(crate) fn blacked_out(mut self, dark: DarkReason) -> Self {
        self.content = FrameContent::Black { size_px: self.content.size_px(), dark, has_note: false };
        self.post = safety::unplaced(&self.post);
        self.oldest = None;
        self
    }

    /// Why the image is black.
    pub(crate) fn dark_reason(&self) -> Option<&DarkReason> {
        match &self.content {
            FrameContent::Scene { .. } | FrameContent::Test { .. } => None,
            FrameContent::Black { dark, .. } => Some(dark),
        }
    }

    /// The ticket that lets an image of the frame out; `None` if it has no light.
    pub(crate) fn needed_ticket(&self) -> Option<&LightTicket> {
        let is_black = matches!(self.content, FrameContent::Black { has_note: false, .. });
        (!is_black).then_some(&self.ticket)
    }

    /// `true` if an image of the frame may leave: it is black, or no blackout came since it was begun.
    pub(crate) fn may_leave(&self) -> bool {
        self.needed_ticket().is_none_or(LightTicket::is_valid)
    }

    pub(crate) fn is_expired(&self, now: Instant) -> bool {
        self.valid_until.is_some_and(|until| until < now)
    }
}

impl DueFrame {
    /// Gives the frame to the renderer.
    ///
    /// # Errors
    /// The renderer's; the frame is lost.
    pub(crate) fn submit(self, renderer: &mut dyn Renderer, scene: &Scene) -> Result<FrameInFlight, RenderError> {
        let view = View { visible: &self.visible, ..renderer_view(&self.view, scene, &self.camera) };
        let objects_of = self.check.as_ref().map(|(surface, _)| &surface.displays);
        renderer.submit_with_depths(&view, &DepthRequest { opaque: self.depth.is_some(), objects_of })?;
        let Self { spec, depth, check, keeps_drawn, begun, .. } = self;
        Ok(FrameInFlight { spec, depth, check, keeps_drawn, begun })
    }
}

impl FrameInFlight {
    /// Waits for the renderer and post-processes the image; it is drawn into `picture`. `None` if the renderer has lost
    /// the frame. Frames are finished in the order in which they were submitted.
    ///
    /// # Errors
    /// The renderer's; the frame is lost.
    pub(crate) fn finish(
        mut self,
        renderer: &mut dyn Renderer,
        mut picture: Picture,
        buffers: &mut SharedBuffers,
    ) -> Result<Option<FinishedFrame>, RenderError> {
        let Finished::Drawn = renderer.finish_with_depths(&mut picture, &mut buffers.depths)? else { return Ok(None) };
        let drawn = self.keeps_drawn.then(|| Arc::new(picture.clone()));
        let checked = self.check.map(|(surface, memory)| {
            let objects = std::mem::replace(&mut buffers.depths.objects, memory);
            CheckedLight::new(objects, &surface)
        });
        if let Some(checked) = &checked {
            self.spec.post = confirmed(&self.spec.post, checked.mask());
        }
        self.spec.post.apply(&mut picture, &mut buffers.turned);
        let orientation = self.spec.post.orientation;
        let depth = self.depth.map(|encoding| DepthImage::new(&buffers.depths.opaque, encoding, orientation));
        let (spec, picture, depth, begun) = (self.spec, Arc::new(picture), depth.map(Arc::new), Some(self.begun));
        Ok(Some(FinishedFrame { spec, picture, depth, drawn, checked, begun, is_published: false }))
    }
}

/// Width and height of a camera's images.
pub(crate) fn size_px(camera: &Camera) -> [u32; 2] {
    camera.lens().map_or([camera.width_px(), camera.height_px()], |lens| lens.size_px())
}
