//! From the pictures of a scan to its capture: decoding, and what is refused or warned of. A live scan and one from a
//! bag share this.

use rcs_calibration::patterns::{Axis, Pattern};
use rcs_calibration::{decode, Decoded, Keystone, Lens, Pictures, ScanProblem};
use rcs_files::capture::{Capture, PatternPicture};

use crate::depth_average::DepthAverage;
use crate::failure::ScanFailure;
use crate::light::Light;
use crate::orientation::{self, Orientation};

/// A capture with fewer decoded pixels is worth nothing: this share of the picture.
const LEAST_DECODED: f64 = 0.002;
/// Below this share of decoded pixels among the lit ones there is a warning.
const FEW_DECODED: f64 = 0.5;

/// The stripes whose crossings tell whether the projector distorts its picture: so many bits of each axis.
pub(crate) const KEYSTONE_BITS: u32 = 5;

/// What a scan yields.
#[derive(Debug)]
pub struct Scanned {
    /// To be written.
    pub capture: Capture,
    /// What it tells.
    pub decoded: Decoded,
    /// False if the scan was interrupted when it had seen enough.
    pub is_whole: bool,
}

/// What a scan has seen.
pub(crate) struct Seen<'a> {
    /// The projector's width and height, pixels.
    pub(crate) projector_px: [u32; 2],
    /// The camera's lens; its size is that of all pictures.
    pub(crate) lens: Lens,
    /// The camera's optical frame; may be empty.
    pub(crate) frame_id: String,
    /// A picture of each pattern.
    pub(crate) pictures: Vec<PatternPicture>,
    /// What white and black have told.
    pub(crate) light: &'a Light,
    /// Depth; none for a camera without.
    pub(crate) depth: Option<&'a DepthAverage>,
    /// False if the scan was interrupted.
    pub(crate) is_whole: bool,
}

impl Seen<'_> {
    /// Decodes the pictures and makes a capture of them, unless it is not worth it.
    ///
    /// # Errors
    /// [`ScanFailure`]: what is wrong with them. [`ScanFailure::Interrupted`] if more of them might have been enough.
    pub(crate) fn finish(mut self, warn: &mut dyn FnMut(&str)) -> Result<Scanned, ScanFailure> {
        drop_unpaired(&mut self.pictures);
        let decoded = self.decode()?;
        for problem in decoded.quality.problems() {
            let is_known = matches!(problem, ScanProblem::Clipped(_)) && self.light.is_overexposed();
            if problem.is_fatal() {
                return Err(ScanFailure::Problem(problem));
            }
            if !is_known {
                warn(&problem.to_string());
            }
        }
        let count = decoded.count();
        if (count as f64) < LEAST_DECODED * decoded.pixels.len() as f64 {
            return Err(if self.is_whole { ScanFailure::Undecoded { count } } else { ScanFailure::Interrupted });
        }
        let share = count as f64 / decoded.lit.max(1) as f64;
        if share < FEW_DECODED {
            warn(&format!("only {:.0} % of the lit pixels could be decoded", 100.0 * share));
        }
        if self.depth.is_some_and(|depth| depth.frames() == 0) {
            return Err(ScanFailure::NoDepth);
        }
        let capture = Capture {
            projector_size_px: self.projector_px,
            camera: self.lens,
            camera_frame_id: self.frame_id,
            pictures: self.pictures,
            depth_m: self.depth.map(DepthAverage::depth_m),
            warnings: Vec::new(),
        };
        Ok(Scanned { capture, decoded, is_whole: self.is_whole })
    }

    fn decode(&self) -> Result<Decoded, ScanFailure> {
        let patterns: Vec<Pattern> = self.pictures.iter().map(|picture| picture.pattern).collect();
        let levels = self.pictures.iter().map(|picture| picture.grey.as_slice()).collect();
        let pictures = Pictures { size_px: self.lens.size_px, patterns: &patterns, levels };
        decode(&pictures, self.projector_px).map_err(|error| {
            if self.is_whole {
                error.into()
            } else {
                ScanFailure::Interrupted
            }
        })
    }
}

/// Whether the picture is mirrored, another one, or cut off, by its coarse stripes. `screen` is what a message calls
/// where they are shown.
///
/// # Errors
/// [`ScanFailure::Mirrored`] and [`ScanFailure::OtherPicture`].
pub(crate) fn check_orientation(
    pictures: &[PatternPicture],
    light: &Light,
    camera_px: [u32; 2],
    projector_px: [u32; 2],
    screen: &str,
    warn: &mut dyn FnMut(&str),
) -> Result<(), ScanFailure> {
    let pictures: Vec<(Pattern, &[u8])> =
        pictures.iter().map(|picture| (picture.pattern, picture.grey.as_slice())).collect();
    match orientation::judge(&pictures, &light.lit, camera_px, projector_px) {
        Orientation::Right => Ok(()),
        Orientation::Mirrored => Err(ScanFailure::Mirrored),
        Orientation::OtherPicture(share) => {
            Err(ScanFailure::OtherPicture { share, size_px: projector_px, screen: screen.to_owned() })
        }
        Orientation::Cut(axis, [first, last]) => {
            let lines = if axis == Axis::X { "columns" } else { "rows" };
            warn(&format!(
                "the projector's {lines} {first} to {last} are not seen: is its picture cut off or covered, or the \
                 size wrong?"
            ));
            Ok(())
        }
    }
}

/// Whether the projector distorts its picture, by the crossings of its coarse stripes, as far as these tell.
///
/// # Errors
/// [`ScanFailure::Keystone`].
pub(crate) fn check_keystone(
    pictures: &[PatternPicture],
    depth: &DepthAverage,
    camera: &Lens,
    projector_px: [u32; 2],
    warn: &mut dyn FnMut(&str),
) -> Result<(), ScanFailure> {
    let is_coarse = |picture: &&PatternPicture| orientation::is_coarse(&picture.pattern, KEYSTONE_BITS);
    let coarse: Vec<&PatternPicture> = pictures.iter().filter(is_coarse).collect();
    let patterns: Vec<Pattern> = coarse.iter().map(|picture| picture.pattern).collect();
    let levels = coarse.iter().map(|picture| picture.grey.as_slice()).collect();
    let pictures = Pictures { size_px: camera.size_px, patterns: &patterns, levels };
    match Keystone::find(&pictures, &depth.depth_m(), camera, projector_px) {
        Some(Keystone::Skewed(reason)) => return Err(ScanFailure::Keystone(reason)),
        Some(Keystone::Stretched(reason)) => warn(&reason),
        None => {}
    }
    Ok(())
}

/// Removes stripes without their inverse: those after which the scan was interrupted.
fn drop_unpaired(pictures: &mut Vec<PatternPicture>) {
    let patterns: Vec<Pattern> = pictures.iter().map(|picture| picture.pattern).collect();
    pictures.retain(|picture| match picture.pattern {
        Pattern::GrayCode(stripes) => patterns.contains(&Pattern::GrayCode(stripes.inverse())),
        _ => true,
    });
}
