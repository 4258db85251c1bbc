//! The camera image with expected and measured positions of the projected marks.

use nalgebra::{Point2, Vector2};
use rcs_calibration::{VerificationResult, VerifiedPoint};
use rcs_scene::Image;

use crate::canvas::Canvas;

/// Where light should land.
const EXPECTED: [u8; 3] = [60, 230, 90];
/// Where spots have landed.
const SPOT: [u8; 3] = [255, 150, 40];
/// Where outlines have landed.
const EDGE: [u8; 3] = [80, 170, 255];
/// Length of an arrow in multiples of the error, if it fits.
const ENLARGED: f64 = 10.0;
/// The longest arrow, pixels.
const LONGEST_PX: f64 = 60.0;
/// The head of an arrow, pixels.
const HEAD_PX: f64 = 3.0;

/// Green crosses where light should land; from them arrows, orange for spots and blue for outlines, that point to where
/// it has landed. They are ten times as long as the distance, or shorter if all of them are short enough only then; the
/// factor is returned. `grey` are levels of the camera's image of this size, row by row.
pub fn image(grey: &[u8], size_px: [u32; 2], verified: &VerificationResult) -> (Image, f64) {
    let mut canvas = Canvas::from_grey(size_px, grey.iter().map(|level| level / 2 + 10));
    let all = || verified.spots.iter().chain(&verified.edges);
    let longest = all().map(|miss| (miss.landed - miss.expected).norm()).fold(0.0, f64::max);
    let factor = if longest * ENLARGED > LONGEST_PX { (LONGEST_PX / longest).max(1.0) } else { ENLARGED };
    all().for_each(|miss| canvas.cross(miss.expected, EXPECTED));
    for (misses, color) in [(&verified.edges, EDGE), (&verified.spots, SPOT)] {
        misses.iter().for_each(|miss| arrow(&mut canvas, miss, factor, color));
    }
    (canvas.into_image(), factor)
}

fn arrow(canvas: &mut Canvas, miss: &VerifiedPoint, factor: f64, color: [u8; 3]) {
    let off = (miss.landed - miss.expected) * factor;
    let tip: Point2<f64> = miss.expected + off;
    canvas.line(miss.expected, tip, color);
    if let Some(back) = off.try_normalize(HEAD_PX).map(|along: Vector2<f64>| -along * HEAD_PX) {
        let side = Vector2::new(-back.y, back.x) * 0.7;
        canvas.line(tip, tip + back + side, color);
        canvas.line(tip, tip + back - side, color);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrows_are_enlarged_as_far_as_they_fit() {
        let miss = |off: f64| VerifiedPoint {
            expected: Point2::new(100.0, 50.0),
            landed: Point2::new(100.0 + off, 50.0),
            px: off,
            m: 0.0,
        };
        let verified =
            |off| VerificationResult { spots: vec![miss(off)], spots_shown: 1, edges: Vec::new(), edges_shown: 0 };
        for (off, expected, tip) in [(2.0, 10.0, 120), (12.0, 5.0, 160), (90.0, 1.0, 190)] {
            let (image, factor) = image(&[0; 200 * 100], [200, 100], &verified(off));
            assert_eq!(factor, expected);
            let at = |x: usize| &image.data[3 * (50 * 200 + x)..3 * (50 * 200 + x) + 3];
            assert!(at(tip) == SPOT && at(tip + 1) != SPOT && at(98) == EXPECTED, "{off}");
        }
    }
}
