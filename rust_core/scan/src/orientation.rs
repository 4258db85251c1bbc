//! The orientation of the projector's image in the camera's image, by coarse stripes.
//!
//! Camera and projector see the same side of a surface, so the determinant of d(u, v)/d(x, y) is positive, also for a
//! projector that hangs upside down (rotated by 180°). It is negative where the image is mirrored: such a capture
//! would be fitted by a projector behind the wall.

use nalgebra::{Matrix3, Vector3};
use rcs_calibration::patterns::{Axis, Pattern, Stripes};
use rcs_files::capture::PatternImage;

use crate::coarse_code::CoarseCode;

/// Bits that are read of each axis.
pub(crate) const BITS: u32 = 4;
/// The least clear pixels for a result.
const MIN_PIXELS: usize = 100;
/// The least share of variance that the fit must explain.
const MIN_EXPLAINED: f64 = 0.2;
/// The share of the image that may be missing at an edge without a warning.
const MARGIN: f64 = 0.2;
/// Width of the image's edge, as a share of it: lit pixels there mean that more is lit than is seen.
const EDGE: f64 = 0.03;

/// The verdict by the coarse stripes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ImageOrientation {
    /// Right, or too few pixels for a verdict.
    Right,
    /// Mirrored.
    Mirrored,
    /// Columns (x) or rows (y) from the first to the second are not seen though the camera sees all of the light.
    Cut(Axis, [u32; 2]),
}

/// A camera pixel and roughly the projector's pixel there.
struct CoarseMatch {
    camera: [f64; 2],
    projector: [f64; 2],
}

/// `true` for white, black and the first bits, which are checked before the fine stripes are known.
pub(crate) fn is_coarse(pattern: &Pattern, bits: u32) -> bool {
    match pattern {
        Pattern::GrayCode(stripes) => stripes.bit < bits && stripes.offset == 0,
        _ => true,
    }
}

/// Judges the images taken so far, white and black among them; `lit` is a sample of the lit pixels.
pub(crate) fn judge(
    images: &[PatternImage],
    lit: &[usize],
    camera_px: [u32; 2],
    projector_px: [u32; 2],
) -> ImageOrientation {
    let (Some(white), Some(black)) = (grey_of(images, Pattern::White), grey_of(images, Pattern::Black)) else {
        return ImageOrientation::Right;
    };
    let [bits_x, bits_y] = Axis::ALL.map(|axis| coarse_bits(images, axis));
    if bits_x.is_empty() || bits_y.is_empty() {
        return ImageOrientation::Right;
    }
    // The middle of the columns or rows with the pixel's code.
    let place = |bits: &[(Stripes, &[u8], &[u8])], pixel: usize| {
        let contrast = f64::from(white[pixel]) - f64::from(black[pixel]);
        let mut code = CoarseCode::default();
        for (_, stripes, inverse) in bits {
            code.push(CoarseCode::bit(stripes[pixel], inverse[pixel], contrast)?);
        }
        bits.first().map(|(first, ..)| code.place_px(first))
    };
    let coarse_match = |pixel: &usize| {
        let projector = [place(&bits_x, *pixel)?, place(&bits_y, *pixel)?];
        let (x, y) = (*pixel as u32 % camera_px[0], *pixel as u32 / camera_px[0]);
        Some(CoarseMatch { camera: [f64::from(x), f64::from(y)], projector })
    };
    let matches: Vec<CoarseMatch> = lit.iter().filter_map(coarse_match).collect();
    if matches.len() < MIN_PIXELS {
        return ImageOrientation::Right;
    }
    if determinant(&matches).is_some_and(|determinant| determinant < 0.0) {
        return ImageOrientation::Mirrored;
    }
    cut(&matches, camera_px, projector_px).unwrap_or(ImageOrientation::Right)
}

/// The coarse bits of an axis from the most significant on, with the images of the stripes and of their inverse.
fn coarse_bits(images: &[PatternImage], axis: Axis) -> Vec<(Stripes, &[u8], &[u8])> {
    let find = |bit: u32| {
        images.iter().find_map(|image| match image.pattern {
            Pattern::GrayCode(stripes)
                if stripes.axis == axis && stripes.bit == bit && !stripes.inverted && stripes.offset == 0 =>
            {
                Some((stripes, &*image.grey, grey_of(images, Pattern::GrayCode(stripes.inverse()))?))
            }
            _ => None,
        })
    };
    (0..BITS).map_while(find).collect()
}

/// The image of a pattern.
pub(crate) fn grey_of(images: &[PatternImage], wanted: Pattern) -> Option<&[u8]> {
    images.iter().find(|image| image.pattern == wanted).map(|image| image.grey.as_slice())
}

/// The determinant of d(u, v)/d(x, y) by a linear fit; `None` for a bad fit.
fn determinant(matches: &[CoarseMatch]) -> Option<f64> {
    let rows = matches.iter().map(|one| (Vector3::new(one.camera[0], one.camera[1], 1.0), one.projector));
    let (mut normal, mut right) = (Matrix3::zeros(), [Vector3::zeros(); 2]);
    for (row, place) in rows.clone() {
        normal += row * row.transpose();
        for axis in 0..2 {
            right[axis] += row * place[axis];
        }
    }
    let inverse = normal.try_inverse()?;
    let fits = right.map(|right| inverse * right);
    for axis in 0..2 {
        let mean = matches.iter().map(|one| one.projector[axis]).sum::<f64>() / matches.len() as f64;
        let (mut all, mut left) = (0.0, 0.0);
        for (row, place) in rows.clone() {
            all += (place[axis] - mean).powi(2);
            left += (place[axis] - row.dot(&fits[axis])).powi(2);
        }
        if all <= 0.0 || 1.0 - left / all < MIN_EXPLAINED {
            return None;
        }
    }
    Some(fits[0].x * fits[1].y - fits[0].y * fits[1].x)
}

/// The missing part of the projector's image, if the camera sees where the light ends.
fn cut(matches: &[CoarseMatch], camera_px: [u32; 2], projector_px: [u32; 2]) -> Option<ImageOrientation> {
    let is_at_edge = |one: &&CoarseMatch| {
        (0..2).any(|axis| {
            let size = f64::from(camera_px[axis]);
            !(EDGE * size..(1.0 - EDGE) * size).contains(&one.camera[axis])
        })
    };
    if matches.iter().filter(is_at_edge).count() * 200 > matches.len() {
        return None;
    }
    Axis::ALL.into_iter().find_map(|axis| {
        let size = f64::from(projector_px[axis.index()]);
        let mut places: Vec<f64> = matches.iter().map(|one| one.projector[axis.index()]).collect();
        places.sort_by(f64::total_cmp);
        // Single pixels may be wrong.
        let (first, last) = (places[places.len() / 200], places[places.len() - 1 - places.len() / 200]);
        if first > MARGIN * size {
            return Some(ImageOrientation::Cut(axis, [0, first as u32]));
        }
        (last < (1.0 - MARGIN) * size).then_some(ImageOrientation::Cut(axis, [last as u32, size as u32 - 1]))
    })
}

#[cfg(test)]
mod tests {
    use rcs_calibration::patterns::gray_code;

    use super::*;

    const CAMERA_PX: [u32; 2] = [64, 48];
    const PROJECTOR_PX: [u32; 2] = [128, 80];

    /// The verdict on a camera's images of a wall, by the projector's pixel that lights each of its pixels.
    fn judged(size_px: [u32; 2], lit_by: impl Fn(f64, f64) -> [f64; 2]) -> ImageOrientation {
        let all: Vec<usize> = (0..64 * 48).collect();
        let place = |pixel: &usize| lit_by((pixel % 64) as f64, (pixel / 64) as f64);
        let is_in = |at: [f64; 2]| (0..2).all(|axis| (0.0..f64::from(PROJECTOR_PX[axis])).contains(&at[axis]));
        let patterns = gray_code(PROJECTOR_PX);
        let level = |pattern: &Pattern, pixel: &usize| {
            let at = place(pixel);
            if is_in(at) && pattern.is_lit(at[0] as u32, at[1] as u32) {
                200
            } else {
                20
            }
        };
        let image = |pattern: &Pattern| {
            let grey = all.iter().map(|pixel| level(pattern, pixel)).collect();
            PatternImage { pattern: *pattern, grey }
        };
        let images: Vec<PatternImage> = patterns.iter().map(image).collect();
        let lit: Vec<usize> = all.iter().copied().filter(|pixel| is_in(place(pixel))).collect();
        judge(&images, &lit, CAMERA_PX, size_px)
    }

    #[test]
    fn rotated_images_are_right_and_mirrored_ones_are_not() {
        let right = |x: f64, y: f64| [2.6 * x - 20.0 + 0.1 * y, 2.2 * y - 12.0];
        assert_eq!(judged(PROJECTOR_PX, right), ImageOrientation::Right);
        assert_eq!(judged(PROJECTOR_PX, |x, y| right(63.0 - x, 47.0 - y)), ImageOrientation::Right);
        assert_eq!(judged(PROJECTOR_PX, |x, y| right(63.0 - x, y)), ImageOrientation::Mirrored);
        assert_eq!(judged(PROJECTOR_PX, |x, y| right(x, 47.0 - y)), ImageOrientation::Mirrored);
    }

    #[test]
    fn a_image_that_is_cut_off_is_noticed() {
        let cut = |x: f64, y: f64| if x < 40.0 { [2.6 * x - 20.0, 2.2 * y - 12.0] } else { [-1.0; 2] };
        assert!(matches!(judged(PROJECTOR_PX, cut), ImageOrientation::Cut(Axis::X, [70..90, 127])));
        // Where the camera's image ends, it is the camera that does not see more.
        let beside = |x: f64, y: f64| [1.4 * x, 2.2 * y - 12.0];
        assert_eq!(judged(PROJECTOR_PX, beside), ImageOrientation::Right);
    }
}
