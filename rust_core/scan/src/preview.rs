//! The decoded pixels as an image: red grows with the projector's column, green with its row; black is not decoded.
//!
//! During a scan, [`PreviewDecoder`] reads each pixel's code bit by bit, with one comparison for each pair of stripes.
//! The final result is decoded by [`rcs_calibration::decode()`].

use rcs_calibration::patterns::{Pattern, Stripes};
use rcs_calibration::Decoded;
use rcs_files::capture::PatternImage;
use rcs_scene::{Encoding, Image};

use crate::coarse_code::CoarseCode;
use crate::orientation::grey_of;

/// The blue of decoded pixels: the projector's first pixel is not black.
const BLUE: u8 = 128;
/// The least difference of white and black of a lit pixel, levels.
const LIT_LEVELS: u8 = 6;
/// Stripes narrower than this may blur, and a pixel counts as decoded without them, projector pixels.
const FINE_PX: f64 = 8.0;

/// The decoded pixels as an image of the camera's size.
pub fn of_decoded(decoded: &Decoded, projector_px: [u32; 2]) -> Image {
    let place = decoded.pixels.iter().map(|pixel| pixel.is_decoded().then_some(pixel.at));
    false_colours(decoded.size_px, place, projector_px)
}

fn false_colours(size_px: [u32; 2], places: impl Iterator<Item = Option<[f32; 2]>>, projector_px: [u32; 2]) -> Image {
    let colour = |place: Option<[f32; 2]>| {
        let Some(at) = place else { return [0; 3] };
        let share = |axis: usize| (255.0 * at[axis] / projector_px[axis] as f32).round().clamp(0.0, 255.0) as u8;
        [share(0), share(1), BLUE]
    };
    let [width_px, height_px] = size_px;
    Image { width_px, height_px, encoding: Encoding::Rgb8, data: places.flat_map(colour).collect() }
}

/// Decodes the camera's pixels during a scan.
#[derive(Default)]
pub struct PreviewDecoder {
    /// The difference of white and black, levels; 0 where a pixel is not lit, empty before white and black.
    contrast: Vec<u8>,
    axes: [PreviewAxis; 2],
}

impl PreviewDecoder {
    /// Adds the last of the images of a scan so far.
    pub fn add(&mut self, images: &[PatternImage]) {
        if self.contrast.is_empty() {
            return self.start(images);
        }
        let [.., one, other] = images else { return };
        if let (Pattern::GrayCode(stripes), Pattern::GrayCode(inverse)) = (one.pattern, other.pattern) {
            if stripes.inverse() == inverse && !stripes.inverted && stripes.offset == 0 {
                self.axes[stripes.axis.index()].add(stripes, &one.grey, &other.grey, &self.contrast);
            }
        }
    }

    /// Finds the lit pixels once white and black are there.
    fn start(&mut self, images: &[PatternImage]) {
        let (Some(white), Some(black)) = (grey_of(images, Pattern::White), grey_of(images, Pattern::Black)) else {
            return;
        };
        let contrast = white.iter().zip(black).map(|(white, black)| white.saturating_sub(*black));
        self.contrast = contrast.map(|levels| if levels > LIT_LEVELS { levels } else { 0 }).collect();
        self.axes.iter_mut().for_each(|axis| axis.codes = vec![CoarseCode::default(); self.contrast.len()]);
    }

    /// The share of lit pixels that have read all stripes so far along both axes, except for fine ones; `None` before
    /// white and black.
    pub fn share(&self) -> Option<f64> {
        let lit = self.contrast.iter().filter(|contrast| **contrast > 0).count();
        let decoded = (0..self.contrast.len()).filter(|pixel| self.is_decoded(*pixel)).count();
        (!self.contrast.is_empty()).then_some(decoded as f64 / lit.max(1) as f64)
    }

    fn is_decoded(&self, pixel: usize) -> bool {
        self.contrast[pixel] > 0 && self.axes.iter().all(|axis| axis.is_read(pixel))
    }

    /// The image, of the camera's size.
    pub fn image(&self, size_px: [u32; 2], projector_px: [u32; 2]) -> Image {
        let place = |pixel| {
            let [u, v] = &self.axes;
            self.is_decoded(pixel).then(|| Some([u.place_px(pixel)?, v.place_px(pixel)?])).flatten()
        };
        false_colours(size_px, (0..self.contrast.len()).map(place), projector_px)
    }
}

/// The codes along an axis.
#[derive(Default)]
struct PreviewAxis {
    codes: Vec<CoarseCode>,
    /// The last stripes.
    last: Option<Stripes>,
    /// Number of stripes so far that are wide enough for any camera.
    wide: u32,
}

impl PreviewAxis {
    /// Adds a pair of stripes. A pixel that could not read one reads none of the finer ones.
    fn add(&mut self, stripes: Stripes, lit: &[u8], inverse: &[u8], contrast: &[u8]) {
        let before = self.last.map_or(0, |last| last.bit + 1);
        if stripes.bit != before {
            return;
        }
        self.wide += u32::from(stripes.width_px() >= FINE_PX);
        self.last = Some(stripes);
        for (pixel, code) in self.codes.iter_mut().enumerate().filter(|(_, code)| code.bits == before) {
            if let (true, Some(bit)) =
                (contrast[pixel] > 0, CoarseCode::bit(lit[pixel], inverse[pixel], f64::from(contrast[pixel])))
            {
                code.push(bit);
            }
        }
    }

    fn is_read(&self, pixel: usize) -> bool {
        self.last.is_some() && self.codes[pixel].bits >= self.wide.max(1)
    }

    fn place_px(&self, pixel: usize) -> Option<f32> {
        self.last.map(|last| self.codes[pixel].place_px(&last) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rcs_calibration::patterns::gray_code;
    use rcs_calibration::{DecodedPixel, Quality};

    #[test]
    fn colours_encode_the_place() {
        let pixel = |u, v| DecodedPixel { at: [u, v], sigma: [0.1; 2] };
        let pixels = vec![pixel(0.0, 0.0), pixel(640.0, 800.0), DecodedPixel::NONE];
        let decoded = Decoded { size_px: [3, 1], pixels, lit: 3, quality: Quality::default() };
        assert_eq!(of_decoded(&decoded, [1280, 800]).data, [0, 0, 128, 128, 255, 128, 0, 0, 0]);
    }

    /// The image of a camera whose pixels are the projector's, except for a dark one at the end.
    fn image(projector_px: [u32; 2], pattern: &Pattern) -> Vec<u8> {
        let mut grey: Vec<u8> = pattern.image(projector_px).iter().map(|level| 20 + level / 2).collect();
        if let Some(last) = grey.last_mut() {
            *last = 20;
        }
        grey
    }

    #[test]
    fn places_become_more_precise_with_every_pair() {
        let projector_px = [32, 20];
        let (mut decoder, mut images, mut errors) = (PreviewDecoder::default(), Vec::new(), Vec::new());
        for pattern in gray_code(projector_px) {
            images.push(PatternImage { pattern, grey: image(projector_px, &pattern) });
            decoder.add(&images);
            let Some(share) = decoder.share() else { continue };
            let colours = decoder.image(projector_px, projector_px).data;
            if images.len() < 2 + 2 * 5 + 2 {
                assert_eq!((share, colours.iter().max()), (0.0, Some(&0)), "{}", images.len());
            } else if images.len().is_multiple_of(2) {
                assert_eq!(share, 1.0);
                assert_eq!(colours[3 * (32 * 20 - 1)..], [0; 3]);
                let error =
                    |pixel: usize| (f64::from(colours[3 * pixel + 1]) - 255.0 * (pixel / 32) as f64 / 20.0).abs();
                errors.push((0..639).map(error).fold(0.0, f64::max));
            }
        }
        assert!(errors.len() == 5 && errors.windows(2).all(|pair| pair[1] < pair[0]), "{errors:?}");
        assert!(errors[4] < 8.0, "{errors:?}");
    }

    #[test]
    fn blurred_fine_stripes_change_nothing() {
        let projector_px = [32, 20];
        let (mut decoder, mut images) = (PreviewDecoder::default(), Vec::new());
        for pattern in gray_code(projector_px) {
            let is_fine = matches!(pattern, Pattern::GrayCode(stripes) if stripes.width_px() < FINE_PX);
            let grey = if is_fine { vec![80; 640] } else { image(projector_px, &pattern) };
            images.push(PatternImage { pattern, grey });
            decoder.add(&images);
        }
        assert_eq!(decoder.share(), Some(1.0));
    }
}
