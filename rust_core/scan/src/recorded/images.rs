//! A scan that exists as images in files, one of each pattern, such as those of another tool or a camera without ROS.

use rcs_calibration::patterns::Pattern;
use rcs_calibration::{DecodeError, Lens, ScanProblem};
use rcs_files::capture::PatternImage;

use crate::depth_average::DepthAverage;
use crate::devices::DepthFrame;
use crate::failure::{check_size, ScanFailure};
use crate::finish::{check_keystone, check_orientation, ScanImages, ScanResult};
use crate::light::{lit_pixels, Illumination, MIN_LIT};
use crate::orientation::grey_of;
use crate::session::ScanEvent;

/// Maximum share of pixels that are darker in white than in black, of those that are brighter. Of stripes and their
/// inverse it is about 1.
const MAX_DARKER: f64 = 0.25;

/// Images of a scan in files.
#[derive(Debug)]
pub struct ImageSet {
    /// Width and height of the images, pixels.
    pub size_px: [u32; 2],
    /// Grey levels in the order in which the images were taken, row by row.
    pub greys: Vec<Vec<u8>>,
    /// The camera's lens, if it is known.
    pub camera: Option<Lens>,
    /// Depth of each pixel, metres, if it was measured.
    pub depth_m: Option<Vec<f32>>,
}

impl ImageSet {
    /// Gives the images their patterns, checks and decodes them. White and black may come first, as in `patterns`, or
    /// last, as in OpenCV's Gray code.
    ///
    /// # Errors
    /// [`ScanFailure`]: the first thing that would make a calibration wrong. [`DecodeError::Count`] for another number
    /// of images.
    pub fn scan(
        self,
        patterns: &[Pattern],
        projector_px: [u32; 2],
        observe: &mut dyn FnMut(ScanEvent<'_>),
    ) -> Result<ScanResult, ScanFailure> {
        let Self { size_px, greys, camera, depth_m } = self;
        let [middle_x, middle_y] = size_px.map(|side| 0.5 * (f64::from(side) - 1.0));
        // Only its size counts.
        let unknown = || Lens::pinhole(size_px, [f64::from(size_px[0]); 2], [middle_x, middle_y]);
        let lens = camera.unwrap_or_else(unknown);
        for grey in &greys {
            check_size("picture", size_px, grey.len(), lens.size_px)?;
        }
        let images = in_order(greys, patterns)?;
        let mut warn = |warning: &str| observe(ScanEvent::Warning(warning));
        let light = illumination(&images, lens.size_px)?;
        light.warn(&mut warn);
        // These are not a projector's that mirrors.
        let orientation = check_orientation(&images, &light, lens.size_px, projector_px, &mut warn);
        orientation.map_err(|_| ScanFailure::Problem(ScanProblem::Order))?;
        let depth = depth_m.map(|depth_m| {
            let mut depth = DepthAverage::new(depth_m.len());
            depth.add(&DepthFrame { size_px, depth_m });
            depth
        });
        if let Some(depth) = &depth {
            check_keystone(&images, depth, &lens, projector_px, &mut warn)?;
        }
        let (frame_id, depth) = (String::new(), depth.as_ref());
        let images = ScanImages { projector_px, lens, frame_id, images, light: &light, depth, ended: None };
        let mut scanned = images.finish(&mut warn)?;
        scanned.capture.is_camera_calibrated = camera.is_some();
        Ok(scanned)
    }
}

/// Gives images their patterns.
fn in_order(greys: Vec<Vec<u8>>, patterns: &[Pattern]) -> Result<Vec<PatternImage>, ScanFailure> {
    if greys.len() != patterns.len() {
        return Err(DecodeError::Count(greys.len(), patterns.len()).into());
    }
    let mut patterns = patterns.to_vec();
    if let [Pattern::White, Pattern::Black, _, _, ..] = patterns[..] {
        if is_white_and_black(&greys[greys.len() - 2], &greys[greys.len() - 1]) {
            patterns.rotate_left(2);
        }
    }
    Ok(patterns.into_iter().zip(greys).map(|(pattern, grey)| PatternImage { pattern, grey }).collect())
}

/// `true` if hardly a pixel is darker in the first of two images, which fine stripes and their inverse never are.
fn is_white_and_black(white: &[u8], black: &[u8]) -> bool {
    let all: Vec<usize> = (0..white.len()).collect();
    let [brighter, darker] = [(black, white), (white, black)]
        .map(|(black, white)| lit_pixels(black, white, &all, 0.0).len() as f64 / all.len().max(1) as f64);
    brighter >= MIN_LIT && darker <= MAX_DARKER * brighter
}

fn illumination(images: &[PatternImage], camera_px: [u32; 2]) -> Result<Illumination, ScanFailure> {
    let white = grey_of(images, Pattern::White).ok_or(DecodeError::Missing("the white picture"))?;
    let black = grey_of(images, Pattern::Black).ok_or(DecodeError::Missing("the black picture"))?;
    let light = |black, white| Illumination::of_images(black, white, camera_px, 0.0, "the pictures");
    light(black, white).map_err(|failure| match light(white, black) {
        Ok(_) => ScanFailure::Problem(ScanProblem::Order),
        Err(_) => failure,
    })
}

#[cfg(test)]
mod tests {
    use rcs_calibration::patterns::gray_code;

    use super::*;

    const PROJECTOR_PX: [u32; 2] = [96, 64];

    /// Images of a wall of which the camera sees the columns from `first` on, each three pixels wide.
    fn images(first: u32, exposure: f64) -> Vec<Vec<u8>> {
        let level = |is_lit: bool| ((if is_lit { 180.0 } else { 20.0 }) * exposure) as u8;
        let grey = |pattern: &Pattern| -> Vec<u8> {
            let pixels = (0..3 * PROJECTOR_PX[1]).flat_map(|y| (0..3 * (PROJECTOR_PX[0] - first)).map(move |x| [x, y]));
            pixels.map(|[x, y]| level(pattern.is_lit(first + x / 3, y / 3))).collect()
        };
        gray_code(PROJECTOR_PX).iter().map(grey).collect()
    }

    fn scan(first: u32, greys: Vec<Vec<u8>>) -> Result<ScanResult, ScanFailure> {
        let size_px = [3 * (PROJECTOR_PX[0] - first), 3 * PROJECTOR_PX[1]];
        let set = ImageSet { size_px, greys, camera: None, depth_m: None };
        set.scan(&gray_code(PROJECTOR_PX), PROJECTOR_PX, &mut |_| {})
    }

    #[test]
    fn white_and_black_come_first_or_last_whatever_the_other_images_show() {
        // From column 64 on, the first stripes are as bright as white; where the light is faint, too.
        for (first, exposure) in [(0, 1.0), (64, 1.0), (64, 1.4), (0, 0.1)] {
            let greys = images(first, exposure);
            let mut last = greys.clone();
            last.rotate_left(2);
            for greys in [greys, last] {
                let scanned = scan(first, greys).unwrap_or_else(|failure| panic!("{first} {exposure}: {failure}"));
                let decoded = scanned.decoded;
                let index = 60 * decoded.size_px[0] as usize + 31;
                let [u, v] = decoded.pixels[index].at;
                let truth = [first as f32 + 10.0, 20.0];
                assert!((u - truth[0]).abs() < 0.5 && (v - truth[1]).abs() < 0.5, "{first} {exposure}: {u} {v}");
            }
        }
    }

    #[test]
    fn images_in_another_order_are_refused_for_it() {
        let greys = images(0, 1.0);
        let bits = [7, 6];
        let swapped = |pairs: std::ops::Range<usize>| {
            let mut greys = greys.clone();
            pairs.for_each(|pair| greys.swap(2 * pair, 2 * pair + 1));
            greys
        };
        let mut rows_first = greys.clone();
        rows_first[2..].rotate_left(2 * bits[0]);
        let orders = [
            ("black before white", swapped(0..1)),
            ("rows first", rows_first),
            ("inverses first", swapped(1..1 + bits[0] + bits[1])),
            ("inverses of columns first", swapped(1..1 + bits[0])),
            ("inverses of rows first", swapped(1 + bits[0]..1 + bits[0] + bits[1])),
            ("a pair swapped", swapped(2..3)),
        ];
        for (name, greys) in orders {
            let failure = scan(0, greys).err();
            assert!(matches!(failure, Some(ScanFailure::Problem(ScanProblem::Order))), "{name}: {failure:?}");
        }
        let mirrored = greys.iter().map(|grey| grey.chunks(288).flat_map(|row| row.iter().rev().copied()).collect());
        let failure = scan(0, mirrored.collect()).err();
        assert!(matches!(failure, Some(ScanFailure::Problem(ScanProblem::Order))), "{failure:?}");
    }
}
