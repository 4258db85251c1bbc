//! A scan from the first look to the capture: what is shown, what is checked, and when it is given up.
//!
//! 1. Black and white in turn ([`super::light`]): the delay, exposure, rest.
//! 2. The patterns, coarse stripes of both axes first. Once those were seen, it is known whether the picture is
//!    mirrored or another one ([`super::orientation`]) and whether the projector distorts it
//!    ([`rcs_calibration::Keystone`]), and soon an interrupted scan is worth something.
//! 3. White again, compared with the first one, and decoding.

use std::time::{Duration, Instant};

use rcs_calibration::patterns::{gray_code, shifted_gray_code, Pattern};
use rcs_calibration::Lens;
use rcs_files::capture::PatternPicture;

use crate::compare::Change;
use crate::depth_average::DepthAverage;
use crate::devices::{Camera, Frame, Screen};
use crate::failure::{check_size, ScanFailure};
use crate::finish::{check_keystone, check_orientation, Scanned, Seen, KEYSTONE_BITS};
use crate::light::{Delay, Light};
use crate::orientation::{self, is_coarse};

/// How long the camera may be silent.
const SILENCE: Duration = Duration::from_secs(5);
/// A stripe can be read where it and its inverse differ by so many levels and so many times the noise.
const READABLE_LEVELS: f64 = 4.0;
const READABLE_NOISE: f64 = 2.0;

/// What is to be scanned and how.
pub struct ScanOptions<'a> {
    /// The projector's width and height, pixels.
    pub projector_px: [u32; 2],
    /// How many projector pixels share a code.
    pub step: u32,
    /// Frames that each picture is the mean of, at least 1.
    pub frames: usize,
    /// Whether the scan is to end.
    pub is_cancelled: &'a dyn Fn() -> bool,
}

/// What happens during a scan.
#[derive(Debug, Clone, Copy)]
pub enum ScanEvent<'a> {
    /// The delay was measured; so many pictures follow.
    Delay(Delay, usize),
    /// A picture was taken, the last of these.
    Captured {
        /// All up to now.
        pictures: &'a [PatternPicture],
        /// The share of lit pixels that can tell the last stripes from their inverse.
        readable: f64,
    },
    /// Something that was found out.
    Note(&'a str),
    /// Something is not as it should be.
    Warning(&'a str),
}

/// A scan.
pub struct Session<'a> {
    screen: &'a mut dyn Screen,
    camera: &'a mut dyn Camera,
    options: &'a ScanOptions<'a>,
    observe: &'a mut dyn FnMut(ScanEvent<'_>),
    depth: DepthAverage,
}

impl<'a> Session<'a> {
    /// A scan that has not begun.
    pub fn new(
        screen: &'a mut dyn Screen,
        camera: &'a mut dyn Camera,
        options: &'a ScanOptions<'a>,
        observe: &'a mut dyn FnMut(ScanEvent<'_>),
    ) -> Self {
        let [width, height] = camera.lens().size_px.map(|side| side as usize);
        Self { screen, camera, options, observe, depth: DepthAverage::new(width * height) }
    }

    /// Scans.
    ///
    /// # Errors
    /// [`ScanFailure`]: the first thing that would make a calibration wrong.
    pub fn run(mut self) -> Result<Scanned, ScanFailure> {
        let light = self.find_light()?;
        let patterns = coarse_first(&patterns(self.options.projector_px, self.options.step));
        (self.observe)(ScanEvent::Delay(light.delay, patterns.len()));
        for warning in light.warnings() {
            (self.observe)(ScanEvent::Warning(&warning));
        }
        let mut pictures = Vec::new();
        let is_whole = match self.capture_all(&patterns, &light, &mut pictures) {
            Ok(()) => true,
            Err(ScanFailure::Interrupted) => false,
            Err(failure) => return Err(failure),
        };
        self.finish(pictures, &light, is_whole)
    }

    /// Takes the pictures of all patterns, and compares white at the beginning with white at the end.
    fn capture_all(
        &mut self,
        patterns: &[Pattern],
        light: &Light,
        pictures: &mut Vec<PatternPicture>,
    ) -> Result<(), ScanFailure> {
        let first = |bits| patterns.iter().take_while(|pattern| is_coarse(pattern, bits)).count();
        let [for_orientation, for_keystone] = [orientation::BITS, KEYSTONE_BITS].map(first);
        for pattern in patterns {
            let last = pictures.last().map(|picture: &PatternPicture| picture.grey.as_slice());
            let grey = self.capture(pattern, light, last)?;
            pictures.push(PatternPicture { pattern: *pattern, grey });
            let readable = readable_share(pictures, light);
            (self.observe)(ScanEvent::Captured { pictures, readable });
            let (camera, projector_px, screen) = (self.camera.lens(), self.options.projector_px, self.screen_name());
            let mut warn = |warning: &str| (self.observe)(ScanEvent::Warning(warning));
            if pictures.len() == for_orientation {
                check_orientation(pictures, light, camera.size_px, projector_px, &screen, &mut warn)?;
            }
            if pictures.len() == for_keystone && self.camera.has_depth() {
                check_keystone(pictures, &self.depth, &camera, projector_px, &mut warn)?;
            }
        }
        let Some(first) = pictures.iter().find(|picture| picture.pattern == Pattern::White) else { return Ok(()) };
        self.check_unchanged(&first.grey, light)
    }

    /// Compares the first white picture with what white looks like now.
    pub(crate) fn check_unchanged(&mut self, first_white: &[u8], light: &Light) -> Result<(), ScanFailure> {
        let last = self.capture(&Pattern::White, light, None)?;
        Change::between(first_white, &last, &light.lit, light.noise).check()
    }

    /// Decodes what was seen and makes a capture of it, unless it is not worth it.
    fn finish(self, pictures: Vec<PatternPicture>, light: &Light, is_whole: bool) -> Result<Scanned, ScanFailure> {
        let seen = Seen {
            projector_px: self.options.projector_px,
            lens: self.camera.lens(),
            frame_id: self.camera.frame_id(),
            pictures,
            light,
            depth: self.camera.has_depth().then_some(&self.depth),
            is_whole,
        };
        seen.finish(&mut |warning| (self.observe)(ScanEvent::Warning(warning)))
    }

    /// Shows a pattern; the time at which that was done.
    pub(crate) fn show(&mut self, pattern: &Pattern) -> Result<Instant, ScanFailure> {
        self.show_picture(pattern.picture(self.options.projector_px))
    }

    /// Shows a picture of the projector's size, grey levels row by row; the time at which that was done.
    pub(crate) fn show_picture(&mut self, picture: Vec<u8>) -> Result<Instant, ScanFailure> {
        let shown = self.camera.now();
        match self.screen.show(picture) {
            Ok(()) => Ok(shown),
            Err(reason) => Err(ScanFailure::Screen { screen: self.screen_name(), reason }),
        }
    }

    /// The camera's first frame that was received after a time. Depth that comes meanwhile is added up.
    pub(crate) fn frame(&mut self, after: Instant) -> Result<Frame, ScanFailure> {
        if (self.options.is_cancelled)() {
            return Err(ScanFailure::Interrupted);
        }
        let frame = self.camera.frame(after, SILENCE)?;
        let camera_px = self.camera_px();
        check_size("picture", frame.size_px, frame.grey.len(), camera_px)?;
        if let Some(depth) = self.camera.depth()? {
            check_size("depth image", depth.size_px, depth.depth_m.len(), camera_px)?;
            self.depth.add(&depth);
        }
        Ok(frame)
    }

    /// The camera's time.
    pub(crate) fn now(&self) -> Instant {
        self.camera.now()
    }

    /// The camera's lens.
    pub(crate) fn camera_lens(&self) -> Lens {
        self.camera.lens()
    }

    /// What depth images were added up to.
    pub(crate) fn depth(&self) -> &DepthAverage {
        &self.depth
    }

    /// Tells who watches.
    pub(crate) fn tell(&mut self, event: ScanEvent<'_>) {
        (self.observe)(event);
    }

    pub(crate) fn options(&self) -> &ScanOptions<'a> {
        self.options
    }

    pub(crate) fn screen_name(&self) -> String {
        self.screen.name()
    }

    /// Width and height of the camera's pictures.
    pub(crate) fn camera_px(&self) -> [u32; 2] {
        self.camera.lens().size_px
    }
}

/// The patterns of a scan.
pub fn patterns(projector_px: [u32; 2], step: u32) -> Vec<Pattern> {
    if step > 1 {
        shifted_gray_code(projector_px, step)
    } else {
        gray_code(projector_px)
    }
}

/// White and black, then the stripes of x and y in turn, the coarse ones first.
fn coarse_first(patterns: &[Pattern]) -> Vec<Pattern> {
    let mut counts = [0; 2];
    let mut ranked: Vec<(usize, Pattern)> = Vec::with_capacity(patterns.len());
    for pattern in patterns {
        let rank = match pattern {
            Pattern::GrayCode(stripes) => {
                let count = &mut counts[stripes.axis.index()];
                *count += 1;
                // Stripes and their inverse stay together.
                usize::div_ceil(*count, 2)
            }
            _ => 0,
        };
        ranked.push((rank, *pattern));
    }
    ranked.sort_by_key(|(rank, _)| *rank);
    ranked.into_iter().map(|(_, pattern)| pattern).collect()
}

/// The share of lit pixels that see the difference between the last two pictures; all if they are no pair.
fn readable_share(pictures: &[PatternPicture], light: &Light) -> f64 {
    let [.., one, other] = pictures else { return 1.0 };
    match (one.pattern, other.pattern) {
        (Pattern::GrayCode(stripes), Pattern::GrayCode(inverse)) if stripes.inverse() == inverse => {}
        _ => return 1.0,
    }
    let limit = READABLE_LEVELS.max(READABLE_NOISE * light.noise);
    let is_readable = |pixel: &&usize| (f64::from(one.grey[**pixel]) - f64::from(other.grey[**pixel])).abs() > limit;
    light.lit.iter().filter(is_readable).count() as f64 / light.lit.len().max(1) as f64
}
