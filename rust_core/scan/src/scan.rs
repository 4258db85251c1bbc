//! A live scan.
//!
//! 1. Black and white alternate ([`crate::measure_light`]): delay, exposure, stability.
//! 2. The patterns, coarse stripes of both axes first. These tell whether the image is mirrored
//!    ([`crate::orientation`]) or distorted by the projector ([`rcs_calibration::Keystone`]), and soon an interrupted
//!    scan is worth something.
//! 3. White again, compared with the first one, and decoding.

use rcs_calibration::patterns::{gray_code, shifted_gray_code, Pattern};
use rcs_files::capture::PatternImage;

use crate::failure::ScanFailure;
use crate::finish::{check_keystone, check_orientation, ScanImages, ScanResult, KEYSTONE_BITS};
use crate::light::Illumination;
use crate::orientation::{self, grey_of, is_coarse};
use crate::session::{ScanEvent, ScanSession};

/// Least difference of a stripe and its inverse that can be read: levels, and a multiple of the noise.
const READABLE_LEVELS: f64 = 4.0;
const READABLE_NOISE: f64 = 2.0;

impl ScanSession<'_> {
    /// Scans.
    ///
    /// # Errors
    /// [`ScanFailure`]: the first thing that would make a calibration wrong.
    pub fn scan(mut self) -> Result<ScanResult, ScanFailure> {
        let light = self.measure_light()?;
        let patterns = coarse_first(&patterns(self.options.projector_px, self.options.step));
        (self.observe)(ScanEvent::Delay(light.delay, patterns.len()));
        light.warn(&mut |warning| self.warn(warning));
        let mut images = Vec::new();
        let ended = match self.capture_all(&patterns, &light, &mut images) {
            Ok(()) => None,
            Err(failure) if failure.leaves_images() => Some(failure),
            Err(failure) => return Err(failure),
        };
        let images = ScanImages {
            projector_px: self.options.projector_px,
            lens: self.camera.lens(),
            frame_id: self.camera.frame_id(),
            images,
            light: &light,
            depth: self.camera.has_depth().then_some(&self.depth),
            ended,
        };
        images.finish(&mut |warning| (self.observe)(ScanEvent::Warning(warning)))
    }

    /// Takes the images of all patterns, and compares white at the beginning with white at the end.
    fn capture_all(
        &mut self,
        patterns: &[Pattern],
        light: &Illumination,
        images: &mut Vec<PatternImage>,
    ) -> Result<(), ScanFailure> {
        let first = |bits| patterns.iter().take_while(|pattern| is_coarse(pattern, bits)).count();
        let [for_orientation, for_keystone] = [orientation::BITS, KEYSTONE_BITS].map(first);
        for pattern in patterns {
            let last = images.last().map(|image: &PatternImage| image.grey.as_slice());
            let grey = self.capture(pattern, light, last)?;
            images.push(PatternImage { pattern: *pattern, grey });
            let readable = readable_share(images, light);
            (self.observe)(ScanEvent::Captured { images, readable });
            let (camera, projector_px) = (self.camera.lens(), self.options.projector_px);
            let mut warn = |warning: &str| (self.observe)(ScanEvent::Warning(warning));
            if images.len() == for_orientation {
                check_orientation(images, light, camera.size_px, projector_px, &mut warn)?;
            }
            if images.len() == for_keystone && self.camera.has_depth() {
                check_keystone(images, &self.depth, &camera, projector_px, &mut warn)?;
            }
        }
        grey_of(images, Pattern::White).map_or(Ok(()), |first| self.check_unchanged(first, light))
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

/// The share of lit pixels with a difference between the last two images; 1 unless these are a pair of stripes.
fn readable_share(images: &[PatternImage], light: &Illumination) -> f64 {
    let [.., one, other] = images else { return 1.0 };
    match (one.pattern, other.pattern) {
        (Pattern::GrayCode(stripes), Pattern::GrayCode(inverse)) if stripes.inverse() == inverse => {}
        _ => return 1.0,
    }
    let limit = READABLE_LEVELS.max(READABLE_NOISE * light.noise);
    let is_readable = |pixel: &&usize| (f64::from(one.grey[**pixel]) - f64::from(other.grey[**pixel])).abs() > limit;
    light.lit.iter().filter(is_readable).count() as f64 / light.lit.len().max(1) as f64
}
