//! From the images of a scan to its capture: decoding and its checks, for a live scan and one from a bag.

use rcs_calibration::patterns::{Axis, Pattern};
use rcs_calibration::{decode, DecodeError, Decoded, Images, Keystone, Lens, ScanProblem};
use rcs_files::capture::{Capture, CapturedRobot, PatternImage};

use crate::depth_average::DepthAverage;
use crate::failure::ScanFailure;
use crate::light::Illumination;
use crate::orientation::{self, ImageOrientation};

/// The least share of the image that must be decoded.
const MIN_DECODED: f64 = 0.002;
/// The share of the lit pixels below which there is a warning.
const FEW_DECODED: f64 = 0.5;

/// Bits of each axis whose stripes' crossings tell whether the projector distorts its image.
pub(crate) const KEYSTONE_BITS: u32 = 5;

/// The result of a scan.
#[derive(Debug)]
pub struct ScanResult {
    /// The capture.
    pub capture: Capture,
    /// Its decoded pixels.
    pub decoded: Decoded,
    /// The reason why the scan ended early, with enough to decode; `None` if it is complete.
    pub ended: Option<ScanFailure>,
}

/// The images of a scan.
pub(crate) struct ScanImages<'a> {
    pub(crate) projector_px: [u32; 2],
    /// The camera's lens; its size is that of all images.
    pub(crate) lens: Lens,
    /// The camera's optical frame; may be empty.
    pub(crate) frame_id: String,
    pub(crate) images: Vec<PatternImage>,
    pub(crate) light: &'a Illumination,
    pub(crate) depth: Option<&'a DepthAverage>,
    /// The reason why the scan ended early.
    pub(crate) ended: Option<ScanFailure>,
}

impl ScanImages<'_> {
    /// Decodes the images and makes a capture of them.
    ///
    /// # Errors
    /// [`ScanFailure`]: their fault, or the reason why there are not enough of them.
    pub(crate) fn finish(mut self, warn: &mut dyn FnMut(&str)) -> Result<ScanResult, ScanFailure> {
        drop_unpaired(&mut self.images);
        let ended = self.ended.take();
        match self.judge(warn) {
            Ok(decoded) => Ok(self.result(decoded, ended)),
            Err(fault) => Err(ended.unwrap_or(fault)),
        }
    }

    /// Decodes the images and checks what they yield.
    fn judge(&self, warn: &mut dyn FnMut(&str)) -> Result<Decoded, ScanFailure> {
        let decoded = self.decode()?;
        for problem in decoded.quality.problems() {
            let is_reported = matches!(problem, ScanProblem::Clipped(_)) && self.light.is_overexposed();
            if problem.is_fatal() {
                return Err(ScanFailure::Problem(problem));
            }
            if !is_reported {
                warn(&problem.to_string());
            }
        }
        let count = decoded.count();
        if (count as f64) < MIN_DECODED * decoded.pixels.len() as f64 {
            return Err(ScanFailure::Undecoded(count));
        }
        let share = decoded.share();
        if share < FEW_DECODED {
            warn(&format!("only {:.0} % of the lit pixels could be decoded", 100.0 * share));
        }
        if self.depth.is_some_and(|depth| depth.frames == 0) {
            return Err(ScanFailure::NoDepth);
        }
        Ok(decoded)
    }

    fn result(self, decoded: Decoded, ended: Option<ScanFailure>) -> ScanResult {
        let capture = Capture {
            projector_size_px: self.projector_px,
            camera: self.lens,
            is_camera_calibrated: true,
            camera_frame_id: self.frame_id,
            images: self.images,
            depth_m: self.depth.map(DepthAverage::depth_m),
            robot: CapturedRobot::default(),
            warnings: Vec::new(),
        };
        ScanResult { capture, decoded, ended }
    }

    fn decode(&self) -> Result<Decoded, DecodeError> {
        let images = self.images.iter().map(|image| (image.pattern, image.grey.as_slice()));
        let (patterns, levels): (Vec<Pattern>, Vec<&[u8]>) = images.unzip();
        let images = Images { size_px: self.lens.size_px, patterns: &patterns, levels };
        decode(&images, self.projector_px)
    }
}

/// Checks by the coarse stripes that the image is not mirrored, and warns if it is cut off.
///
/// # Errors
/// [`ScanFailure::Mirrored`].
pub(crate) fn check_orientation(
    images: &[PatternImage],
    light: &Illumination,
    camera_px: [u32; 2],
    projector_px: [u32; 2],
    warn: &mut dyn FnMut(&str),
) -> Result<(), ScanFailure> {
    match orientation::judge(images, &light.lit, camera_px, projector_px) {
        ImageOrientation::Right => Ok(()),
        ImageOrientation::Mirrored => Err(ScanFailure::Mirrored),
        ImageOrientation::Cut(axis, [first, last]) => {
            let lines = if axis == Axis::X { "columns" } else { "rows" };
            warn(&format!(
                "the projector's {lines} {first} to {last} are not seen: is its picture cut off or covered, or the \
                 size wrong?"
            ));
            Ok(())
        }
    }
}

/// Checks by the crossings of the coarse stripes that the projector does not distort its image.
///
/// # Errors
/// [`ScanFailure::Keystone`].
pub(crate) fn check_keystone(
    images: &[PatternImage],
    depth: &DepthAverage,
    camera: &Lens,
    projector_px: [u32; 2],
    warn: &mut dyn FnMut(&str),
) -> Result<(), ScanFailure> {
    let is_coarse = |image: &&PatternImage| orientation::is_coarse(&image.pattern, KEYSTONE_BITS);
    let coarse = images.iter().filter(is_coarse).map(|image| (image.pattern, image.grey.as_slice()));
    let (patterns, levels): (Vec<Pattern>, Vec<&[u8]>) = coarse.unzip();
    let images = Images { size_px: camera.size_px, patterns: &patterns, levels };
    match Keystone::find(&images, &depth.depth_m(), camera, projector_px) {
        Some(Keystone::Skewed(reason)) => return Err(ScanFailure::Keystone(reason)),
        Some(Keystone::Stretched(reason)) => warn(&reason),
        None => {}
    }
    Ok(())
}

/// Removes stripes without their inverse, after which the scan was interrupted.
fn drop_unpaired(images: &mut Vec<PatternImage>) {
    let patterns: Vec<Pattern> = images.iter().map(|image| image.pattern).collect();
    images.retain(|image| match image.pattern {
        Pattern::GrayCode(stripes) => patterns.contains(&Pattern::GrayCode(stripes.inverse())),
        _ => true,
    });
}
