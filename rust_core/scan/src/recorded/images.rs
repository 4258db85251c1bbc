//! A scan that exists as images in files, one of each pattern, such as those of another tool or a camera without ROS.

use rcs_calibration::patterns::Pattern;
use rcs_calibration::{DecodeError, Lens};
use rcs_files::capture::PatternImage;

use crate::failure::{check_size, ScanFailure};
use crate::finish::{check_orientation, ScanImages, ScanResult};
use crate::light::Illumination;
use crate::session::ScanEvent;

/// Gives images, in the order in which they were taken, their patterns. White and black may come first, as in
/// `patterns`, or last, as in OpenCV's Gray code.
///
/// # Errors
/// [`DecodeError::Count`].
pub fn in_order(greys: Vec<Vec<u8>>, patterns: &[Pattern]) -> Result<Vec<PatternImage>, ScanFailure> {
    if greys.len() != patterns.len() {
        return Err(DecodeError::Count(greys.len(), patterns.len()).into());
    }
    let mut patterns = patterns.to_vec();
    let level = |index: usize| greys[index].iter().map(|level| u64::from(*level)).sum::<u64>();
    let count = greys.len();
    if patterns.starts_with(&[Pattern::White, Pattern::Black]) && level(0) < level(count - 2) {
        patterns.rotate_left(2);
    }
    Ok(patterns.into_iter().zip(greys).map(|(pattern, grey)| PatternImage { pattern, grey }).collect())
}

/// Checks and decodes images of a scan. Of a camera without CameraInfo, only the lens's size counts.
///
/// # Errors
/// [`ScanFailure`]: the first thing that would make a calibration wrong.
pub fn of_images(
    images: Vec<PatternImage>,
    lens: Lens,
    projector_px: [u32; 2],
    observe: &mut dyn FnMut(ScanEvent<'_>),
) -> Result<ScanResult, ScanFailure> {
    let [width, height] = lens.size_px;
    for image in &images {
        check_size("picture", [width, height], image.grey.len(), lens.size_px)?;
    }
    let find = |wanted, name| {
        let found = images.iter().find(|image| image.pattern == wanted);
        found.map(|image| image.grey.as_slice()).ok_or(DecodeError::Missing(name))
    };
    let (white, black) = (find(Pattern::White, "the white picture")?, find(Pattern::Black, "the black picture")?);
    let light = Illumination::of_images(black, white, lens.size_px, 0.0, "the pictures")?;
    let mut warn = |warning: &str| observe(ScanEvent::Warning(warning));
    light.warn(&mut warn);
    check_orientation(&images, &light, lens.size_px, projector_px, &mut warn)?;
    let frame_id = String::new();
    let images = ScanImages { projector_px, lens, frame_id, images, light: &light, depth: None, is_complete: true };
    images.finish(&mut warn)
}
