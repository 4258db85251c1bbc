//! What was decoded, as a picture: red grows with the projector's column, green with its row; black is not decoded.

use rcs_calibration::{Decoded, DecodedPixel};
use rcs_scene::{Encoding, Picture};

/// The blue of decoded pixels, so that the projector's first pixel is not black.
const BLUE: u8 = 128;

/// The picture, of the camera's size.
pub(super) fn false_colours(decoded: &Decoded, projector_px: [u32; 2]) -> Picture {
    let [width_px, height_px] = decoded.size_px;
    let colour = |pixel: &DecodedPixel| {
        if !pixel.is_decoded() {
            return [0; 3];
        }
        let share = |axis: usize| (255.0 * pixel.at[axis] / projector_px[axis] as f32).round().clamp(0.0, 255.0) as u8;
        [share(0), share(1), BLUE]
    };
    let data = decoded.pixels.iter().flat_map(colour).collect();
    Picture { width_px, height_px, encoding: Encoding::Rgb8, data }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rcs_calibration::Quality;

    #[test]
    fn colours_tell_the_place() {
        let pixel = |u, v| DecodedPixel { at: [u, v], sigma: [0.1; 2] };
        let pixels = vec![pixel(0.0, 0.0), pixel(640.0, 800.0), DecodedPixel::NONE];
        let decoded = Decoded { size_px: [3, 1], pixels, lit: 3, quality: Quality::default() };
        assert_eq!(false_colours(&decoded, [1280, 800]).data, [0, 0, 128, 128, 255, 128, 0, 0, 0]);
    }
}
