//! A frame of a camera, from due to finished: each state is a type of its own, and each step consumes the one before.
//!
//! ```text
//!   idle ──► DueFrame ──submit──► FrameInFlight ──finish──► FinishedFrame ──► outputs ──► idle
//!            (CameraPublisher::poll)                        (CameraPublisher::publish)
//! ```

use std::sync::Arc;
use std::time::Instant;

use rcs_displays::CameraView;
use rcs_light::{Content, DarkReason, Evidence, Grant};
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_render::{DepthRequest, Depths, Finished, Orientation, RenderError, Renderer, View};
use rcs_scene::{Camera, DepthImage, DisplayId, DisplayMask, Image, Scene};
use rcs_transforms::Time;

use super::light_check::CheckedLight;
use crate::control::pattern::Pattern;
use crate::control::OperatorSettings;
use crate::outputs::depth_image::{DepthEncoding, EncodedDepths};
use crate::outputs::FrameImage;
use crate::safety::surface::SurfaceCheck;
use crate::scene::renderer_view;
use rcs_window::test_images::TestImage;

/// The content of a frame.
#[derive(Clone, PartialEq)]
pub(crate) enum FrameContent {
    /// The scene in this version, without the displays that are stale.
    Scene { version: u64, camera: Arc<Camera>, hidden: Vec<DisplayId> },
    /// Black. Sizes are those before post-processing turns the image.
    Black { size_px: [u32; 2], dark: DarkReason },
    /// A line of text on black that says why.
    Note { size_px: [u32; 2], dark: DarkReason },
    /// A test image or a pattern.
    Test { size_px: [u32; 2], test: TestContent },
}

/// An image that stands on the projector as it is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TestContent {
    /// A test image of the operator.
    Image(TestImage),
    /// A pattern of a calibration.
    Pattern(Arc<Pattern>),
}

/// A frame's content and everything that is published with it.
#[derive(Clone)]
pub(crate) struct FrameSpec {
    pub(crate) content: FrameContent,
    /// The grant of the content when it was chosen; `None` for black.
    pub(crate) grant: Option<Grant>,
    pub(crate) orientation: Orientation,
    /// A paused frame stays only among those of its number: they leave out the same data, of the same config.
    pub(crate) epoch: u64,
    pub(crate) info: Arc<CameraInfo>,
    /// ROS time of the lookup of predicted transforms.
    pub(crate) looked_up: Option<Time>,
    /// Stamp of the oldest data in a scene, where somebody wants to know it.
    pub(crate) oldest: Option<Time>,
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
    pub(crate) check: Option<(SurfaceCheck, DepthImage)>,
    /// `true` if the image before post-processing is needed, too: a pause may keep it below newer masks.
    pub(crate) keeps_drawn: bool,
    /// Time of the decision to draw it.
    pub(crate) begun: Instant,
}

/// A frame that the renderer works on.
pub(crate) struct FrameInFlight {
    spec: FrameSpec,
    camera: Arc<Camera>,
    depth: Option<DepthEncoding>,
    check: Option<(SurfaceCheck, DepthImage)>,
    keeps_drawn: bool,
    begun: Instant,
}

/// A frame that is ready to be published.
pub(crate) struct FinishedFrame {
    pub(crate) spec: FrameSpec,
    pub(crate) image: FrameImage,
    pub(crate) depth: Option<Arc<EncodedDepths>>,
    /// The image before post-processing, where it is needed.
    pub(crate) drawn: Option<Arc<Image>>,
    /// Its light, where that must be confirmed, for the camera.
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
    turned: Image,
}

impl FrameContent {
    /// `true` if one of the two shows something that is stale in the other, or another test image.
    pub(crate) fn differs_in_staleness(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Test { test: own, .. }, Self::Test { test, .. }) => own != test,
            (Self::Scene { hidden: own, .. }, Self::Scene { hidden, .. }) => own != hidden,
            (Self::Black { .. } | Self::Note { .. }, Self::Black { .. } | Self::Note { .. }) => false,
            _ => true,
        }
    }

    /// Width and height before post-processing.
    pub(crate) fn size_px(&self) -> [u32; 2] {
        match self {
            Self::Scene { camera, .. } => size_px(camera),
            Self::Black { size_px, .. } | Self::Note { size_px, .. } | Self::Test { size_px, .. } => *size_px,
        }
    }
}

impl FrameSpec {
    /// `true` if both have the same light at each pixel, of the same generation.
    pub(crate) fn has_light_of(&self, other: &Self) -> bool {
        match (&self.grant, &other.grant) {
            (Some(own), Some(other)) => own.allows_the_same(other),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        }
    }

    /// `true` if an image of the other one looks the same.
    pub(crate) fn looks_like(&self, other: &Self) -> bool {
        self.content == other.content && self.orientation == other.orientation && self.has_light_of(other)
    }

    /// The frame, black for a reason that is not written into it.
    pub(crate) fn blacked_out(mut self, dark: DarkReason) -> Self {
        self.content = FrameContent::Black { size_px: self.content.size_px(), dark };
        (self.grant, self.oldest) = (None, None);
        self
    }

    /// Why the image is black.
    pub(crate) fn dark_reason(&self) -> Option<&DarkReason> {
        match &self.content {
            FrameContent::Scene { .. } | FrameContent::Test { .. } => None,
            FrameContent::Black { dark, .. } | FrameContent::Note { dark, .. } => Some(dark),
        }
    }

    /// `true` if it has no light, or may be lit now.
    pub(crate) fn may_leave(&self, now: Instant) -> bool {
        self.grant.as_ref().is_none_or(|grant| grant.is_valid(now))
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
        let Self { spec, camera, depth, check, keeps_drawn, begun, .. } = self;
        Ok(FrameInFlight { spec, camera, depth, check, keeps_drawn, begun })
    }
}

impl FrameInFlight {
    /// Waits for the renderer and post-processes the image; it is drawn into `image`. `None` if the renderer has lost
    /// the frame, or nothing of it may be lit. Frames are finished in the order in which they were submitted.
    ///
    /// # Errors
    /// The renderer's; the frame is lost.
    pub(crate) fn finish(
        mut self,
        renderer: &mut dyn Renderer,
        mut image: Image,
        buffers: &mut SharedBuffers,
    ) -> Result<Option<FinishedFrame>, RenderError> {
        let Finished::Drawn = renderer.finish_with_depths(&mut image, &mut buffers.depths)? else { return Ok(None) };
        let drawn = self.keeps_drawn.then(|| Arc::new(image.clone()));
        let checked = self.check.map(|(surface, memory)| {
            let objects = std::mem::replace(&mut buffers.depths.objects, memory);
            CheckedLight::new(objects, self.camera, &surface)
        });
        let Some(mut grant) = self.spec.grant else { return Ok(None) };
        if let Some(checked) = &checked {
            grant = grant.confirm(checked.mask());
        }
        self.spec.grant = Some(grant.clone());
        let depth =
            self.depth.map(|encoding| EncodedDepths::new(&buffers.depths.opaque, encoding, self.spec.orientation));
        let Some(lit) = grant.light(image, &mut buffers.turned) else { return Ok(None) };
        let (image, depth, begun) = (FrameImage::lit(lit), depth.map(Arc::new), Some(self.begun));
        Ok(Some(FinishedFrame { spec: self.spec, image, depth, drawn, checked, begun, is_published: false }))
    }
}

impl FinishedFrame {
    /// Takes a later grant, if that allows the same light.
    pub(crate) fn renew(&mut self, grant: Option<&Grant>) {
        if let Some(grant) = grant.filter(|grant| self.image.renew(grant)) {
            self.spec.grant = Some(grant.clone());
        }
    }

    /// Decides about its content again, and takes the grant if that allows the same light. Light that must be confirmed
    /// is not granted again for what was confirmed before.
    ///
    /// # Errors
    /// Why it is dark now.
    pub(crate) fn decide_again(
        &mut self,
        evidence: &Evidence,
        operator: &OperatorSettings,
        now: Instant,
    ) -> Result<(), DarkReason> {
        let content = match &self.spec.content {
            FrameContent::Scene { .. } => Content::Scene,
            // A pattern's end is its own.
            FrameContent::Test { test: TestContent::Pattern(_), .. } | FrameContent::Black { .. } => return Ok(()),
            FrameContent::Test { .. } => Content::Test,
            FrameContent::Note { .. } => Content::Note,
        };
        let grant = evidence.decide(content, self.spec.content.size_px(), operator.light.clone(), now)?;
        self.renew(Some(&grant));
        Ok(())
    }
}

/// Width and height of a camera's images.
pub(crate) fn size_px(camera: &Camera) -> [u32; 2] {
    camera.lens().map_or([camera.width_px(), camera.height_px()], |lens| lens.size_px())
}
