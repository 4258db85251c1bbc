//! Session with a projector's screen and a camera: the steps that scan, verification and refinement share.

use std::time::{Duration, Instant};

use rcs_calibration::patterns::Pattern;
use rcs_files::capture::PatternImage;

use crate::depth_average::DepthAverage;
use crate::devices::{CameraFrame, ProjectorScreen, ScanCamera};
use crate::failure::{check_size, ScanFailure};
use crate::light::{Delay, Illumination};

/// Timeout of the camera's frames.
const FRAME_TIMEOUT: Duration = Duration::from_secs(5);

/// Time after which fewer depth images than wanted are enough.
const DEPTHS_TIMEOUT: Duration = Duration::from_secs(5);

/// Options of a session.
pub struct ScanOptions<'a> {
    /// The projector's width and height, pixels.
    pub projector_px: [u32; 2],
    /// Projector pixels that share a code.
    pub step: u32,
    /// Frames that each image is the mean of, at least 1.
    pub frames: usize,
    /// Returns `true` if the session is to end.
    pub is_cancelled: &'a dyn Fn() -> bool,
}

/// Events of a session.
#[derive(Debug, Clone, Copy)]
pub enum ScanEvent<'a> {
    /// The delay was measured; this number of images follows.
    Delay(Delay, usize),
    /// An image was taken.
    Captured {
        /// All images of patterns so far.
        images: &'a [PatternImage],
        /// The share of lit pixels that can tell the last stripes from their inverse.
        readable: f64,
    },
    /// A finding.
    Note(&'a str),
    /// A problem that is no reason to give up.
    Warning(&'a str),
}

/// Session with a screen and a camera, used up by one scan, verification or refinement.
pub struct ScanSession<'a> {
    pub(crate) screen: &'a mut dyn ProjectorScreen,
    pub(crate) camera: &'a mut dyn ScanCamera,
    pub(crate) options: &'a ScanOptions<'a>,
    pub(crate) observe: &'a mut dyn FnMut(ScanEvent<'_>),
    pub(crate) depth: DepthAverage,
}

impl<'a> ScanSession<'a> {
    /// A session whose events are passed to `observe`.
    pub fn new(
        screen: &'a mut dyn ProjectorScreen,
        camera: &'a mut dyn ScanCamera,
        options: &'a ScanOptions<'a>,
        observe: &'a mut dyn FnMut(ScanEvent<'_>),
    ) -> Self {
        let [width, height] = camera.lens().size_px.map(|side| side as usize);
        Self { screen, camera, options, observe, depth: DepthAverage::new(width * height) }
    }

    pub(crate) fn warn(&mut self, warning: &str) {
        (self.observe)(ScanEvent::Warning(warning));
    }

    /// Shows a pattern and returns the time.
    pub(crate) fn show(&mut self, pattern: &Pattern) -> Result<Instant, ScanFailure> {
        self.show_image(pattern.image(self.options.projector_px))
    }

    /// Shows an image of the projector's size, grey levels row by row, and returns the time.
    pub(crate) fn show_image(&mut self, image: Vec<u8>) -> Result<Instant, ScanFailure> {
        let shown = self.camera.now();
        match self.screen.show(image) {
            Ok(()) => Ok(shown),
            Err(reason) => Err(ScanFailure::Screen { screen: self.screen.name(), reason }),
        }
    }

    /// Shows images one after the other and returns the camera's image of each. `last` is the image before the first.
    pub(crate) fn capture_images(
        &mut self,
        images: Vec<Vec<u8>>,
        light: &Illumination,
        last: &[u8],
    ) -> Result<Vec<Vec<u8>>, ScanFailure> {
        (self.observe)(ScanEvent::Delay(light.delay, images.len()));
        let mut seen: Vec<Vec<u8>> = Vec::new();
        for image in images {
            let shown = self.show_image(image)?;
            let grey = self.capture_shown(shown, light, Some(seen.last().map_or(last, Vec::as_slice)))?;
            seen.push(grey);
            (self.observe)(ScanEvent::Captured { images: &[], readable: 1.0 });
        }
        Ok(seen)
    }

    /// The camera's first frame that was received after a time. Depth images that come meanwhile are averaged.
    pub(crate) fn frame(&mut self, after: Instant) -> Result<CameraFrame, ScanFailure> {
        if (self.options.is_cancelled)() {
            return Err(ScanFailure::Interrupted);
        }
        let frame = self.camera.frame(after, FRAME_TIMEOUT)?;
        let camera_px = self.camera.lens().size_px;
        check_size("picture", frame.size_px, frame.grey.len(), camera_px)?;
        if let Some(depth) = self.camera.depth()? {
            check_size("depth image", depth.size_px, depth.depth_m.len(), camera_px)?;
            self.depth.add(&depth);
        }
        Ok(frame)
    }

    /// The mean of at least this number of depth images, metres, unless fewer come in time.
    ///
    /// # Errors
    /// [`ScanFailure::NoDepth`], or a frame's.
    pub(crate) fn average_depth(&mut self, least: u32) -> Result<Vec<f32>, ScanFailure> {
        let mut after = self.camera.now();
        let until = after + DEPTHS_TIMEOUT;
        loop {
            let frames = self.depth.frames;
            if frames >= least || (frames > 0 && after > until) {
                return Ok(self.depth.depth_m());
            }
            if after > until {
                return Err(ScanFailure::NoDepth);
            }
            after = self.frame(after)?.received;
        }
    }
}
