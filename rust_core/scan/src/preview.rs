//! What is decoded, as a picture: red grows with the projector's column, green with its row; black is not decoded.
//!
//! While the scan goes on, [`Reading`] reads each pixel's code bit by bit: a comparison for each pixel with every pair
//! of stripes, after which its place is known to half as many pixels. What comes out in the end is decoded by
//! [`rcs_calibration::decode()`].

use rcs_calibration::patterns::{Axis, Pattern, Stripes};
use rcs_calibration::Decoded;
use rcs_files::capture::PatternPicture;
use rcs_scene::{Encoding, Picture};

use crate::coarse_code::CoarseCode;

/// The blue of decoded pixels, so that the projector's first pixel is not black.
const BLUE: u8 = 128;
/// A pixel is lit if white is brighter than black by so many levels.
const LIT_LEVELS: u8 = 6;
/// Stripes that are narrower than this may blur: a pixel counts as decoded without them, projector pixels.
const FINE_PX: f64 = 8.0;

/// The picture of what was decoded, of the camera's size.
pub fn of_decoded(decoded: &Decoded, projector_px: [u32; 2]) -> Picture {
    let place = decoded.pixels.iter().map(|pixel| pixel.is_decoded().then_some(pixel.at));
    false_colours(decoded.size_px, place, projector_px)
}

fn false_colours(size_px: [u32; 2], places: impl Iterator<Item = Option<[f32; 2]>>, projector_px: [u32; 2]) -> Picture {
    let colour = |place: Option<[f32; 2]>| {
        let Some(at) = place else { return [0; 3] };
        let share = |axis: usize| (255.0 * at[axis] / projector_px[axis] as f32).round().clamp(0.0, 255.0) as u8;
        [share(0), share(1), BLUE]
    };
    let [width_px, height_px] = size_px;
    Picture { width_px, height_px, encoding: Encoding::Rgb8, data: places.flat_map(colour).collect() }
}

/// What the stripes up to now tell of the camera's pixels.
pub struct Reading {
    /// By how many levels white is brighter than black; 0 where a pixel is not lit.
    contrast: Vec<u8>,
    axes: [AxisReading; 2],
}

/// Along one axis.
struct AxisReading {
    codes: Vec<CoarseCode>,
    /// How many bits each pixel might have read, none yet: no stripes were seen.
    seen: Option<Seen>,
}

#[derive(Debug, Clone, Copy)]
struct Seen {
    /// The last stripes.
    last: Stripes,
    /// How many bits they and those before are.
    bits: u32,
    /// How many of these are wide enough for any camera.
    wide: u32,
}

impl Reading {
    /// Takes the last of the pictures of a scan up to now. None while white or black is missing.
    pub fn take(reading: &mut Option<Self>, pictures: &[PatternPicture]) {
        let Some(reading) = reading else {
            *reading = Self::new(pictures);
            return;
        };
        let [.., one, other] = pictures else { return };
        if let (Pattern::GrayCode(stripes), Pattern::GrayCode(inverse)) = (one.pattern, other.pattern) {
            if stripes.inverse() == inverse && !stripes.inverted && stripes.offset == 0 {
                reading.axes[stripes.axis.index()].take(stripes, &one.grey, &other.grey, &reading.contrast);
            }
        }
    }

    fn new(pictures: &[PatternPicture]) -> Option<Self> {
        let find = |wanted| pictures.iter().find(|picture| picture.pattern == wanted).map(|picture| &picture.grey);
        let (white, black) = (find(Pattern::White)?, find(Pattern::Black)?);
        let contrast = white.iter().zip(black).map(|(white, black)| white.saturating_sub(*black));
        let contrast: Vec<u8> = contrast.map(|levels| if levels > LIT_LEVELS { levels } else { 0 }).collect();
        let axes = Axis::ALL.map(|_| AxisReading { codes: vec![CoarseCode::default(); contrast.len()], seen: None });
        Some(Self { contrast, axes })
    }

    /// The share of lit pixels that have read all stripes up to now along both axes, but for fine ones.
    pub fn share(&self) -> f64 {
        let lit = self.contrast.iter().filter(|contrast| **contrast > 0).count();
        let decoded = (0..self.contrast.len()).filter(|pixel| self.is_decoded(*pixel)).count();
        decoded as f64 / lit.max(1) as f64
    }

    fn is_decoded(&self, pixel: usize) -> bool {
        self.contrast[pixel] > 0 && self.axes.iter().all(|axis| axis.is_read(pixel))
    }

    /// The picture, of the camera's size.
    pub fn picture(&self, size_px: [u32; 2], projector_px: [u32; 2]) -> Picture {
        let place = |pixel| {
            let [u, v] = &self.axes;
            self.is_decoded(pixel).then(|| Some([u.place_px(pixel)?, v.place_px(pixel)?])).flatten()
        };
        false_colours(size_px, (0..self.contrast.len()).map(place), projector_px)
    }
}

impl AxisReading {
    /// Takes a pair of stripes. A pixel that could not read one reads none of the finer ones.
    fn take(&mut self, stripes: Stripes, lit: &[u8], inverse: &[u8], contrast: &[u8]) {
        let before = self.seen.map_or(0, |seen| seen.bits);
        if stripes.bit != before {
            return;
        }
        let wide = self.seen.map_or(0, |seen| seen.wide) + u32::from(stripes.width_px() >= FINE_PX);
        self.seen = Some(Seen { last: stripes, bits: before + 1, wide });
        for (pixel, code) in self.codes.iter_mut().enumerate().filter(|(_, code)| code.bits() == before) {
            if let (true, Some(bit)) =
                (contrast[pixel] > 0, CoarseCode::bit(lit[pixel], inverse[pixel], f64::from(contrast[pixel])))
            {
                code.push(bit);
            }
        }
    }

    fn is_read(&self, pixel: usize) -> bool {
        self.seen.is_some_and(|seen| self.codes[pixel].bits() >= seen.wide.max(1))
    }

    fn place_px(&self, pixel: usize) -> Option<f32> {
        self.seen.map(|seen| self.codes[pixel].place_px(&seen.last).0 as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rcs_calibration::patterns::gray_code;
    use rcs_calibration::{DecodedPixel, Quality};

    #[test]
    fn colours_tell_the_place() {
        let pixel = |u, v| DecodedPixel { at: [u, v], sigma: [0.1; 2] };
        let pixels = vec![pixel(0.0, 0.0), pixel(640.0, 800.0), DecodedPixel::NONE];
        let decoded = Decoded { size_px: [3, 1], pixels, lit: 3, quality: Quality::default() };
        assert_eq!(of_decoded(&decoded, [1280, 800]).data, [0, 0, 128, 128, 255, 128, 0, 0, 0]);
    }

    /// A camera whose pixels are the projector's, but for a dark one at the end.
    fn seen(projector_px: [u32; 2], pattern: &Pattern) -> Vec<u8> {
        let mut grey: Vec<u8> = pattern.picture(projector_px).iter().map(|level| 20 + level / 2).collect();
        if let Some(last) = grey.last_mut() {
            *last = 20;
        }
        grey
    }

    #[test]
    fn places_become_more_precise_with_every_pair() {
        let projector_px = [32, 20];
        let (mut reading, mut pictures, mut errors) = (None, Vec::new(), Vec::new());
        for pattern in gray_code(projector_px) {
            pictures.push(PatternPicture { pattern, grey: seen(projector_px, &pattern) });
            Reading::take(&mut reading, &pictures);
            let Some(reading) = &reading else { continue };
            let colours = reading.picture(projector_px, projector_px).data;
            if pictures.len() < 2 + 2 * 5 + 2 {
                assert_eq!((reading.share(), colours.iter().max()), (0.0, Some(&0)), "{}", pictures.len());
            } else if pictures.len().is_multiple_of(2) {
                assert_eq!(reading.share(), 1.0);
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
    fn blurred_fine_stripes_leave_what_is_known() {
        let projector_px = [32, 20];
        let (mut reading, mut pictures) = (None, Vec::new());
        for pattern in gray_code(projector_px) {
            let is_fine = matches!(pattern, Pattern::GrayCode(stripes) if stripes.width_px() < FINE_PX);
            let grey = if is_fine { vec![80; 640] } else { seen(projector_px, &pattern) };
            pictures.push(PatternPicture { pattern, grey });
            Reading::take(&mut reading, &pictures);
        }
        assert_eq!(reading.map(|reading| reading.share()), Some(1.0));
    }
}
