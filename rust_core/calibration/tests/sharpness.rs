//! Decoding of stripes on a wall that a camera sees pixel by pixel, or too coarsely.
#![expect(clippy::unwrap_used, reason = "a test without its images fails")]

use rcs_calibration::patterns::{gray_code, Pattern};
use rcs_calibration::{decode, Decoded, DecodedPixel, Images};

/// A wall that a camera sees with `scale` projector pixels to a pixel of its own.
struct Wall {
    projector_px: [u32; 2],
    scale: f64,
    /// Rows that a column drops by, and columns that a row is moved by.
    slant: f64,
}

impl Wall {
    fn size_px(&self) -> [u32; 2] {
        self.projector_px.map(|side| (f64::from(side) / self.scale) as u32)
    }

    fn at(&self, x: f64, y: f64) -> [f64; 2] {
        let (u, v) = ((x + 0.5) * self.scale - 0.5, (y + 0.5) * self.scale - 0.5);
        [u + self.slant * v, v - self.slant * u]
    }

    fn image(&self, pattern: &Pattern) -> Vec<u8> {
        let [width, height] = self.size_px();
        let parts = if self.scale == 1.0 { 1 } else { 6 };
        let shift = |part: u32| (f64::from(part) + 0.5) / f64::from(parts) - 0.5;
        let level = |x: u32, y: u32| {
            let lit = (0..parts * parts).filter(|part| {
                let at = self.at(f64::from(x) + shift(part % parts), f64::from(y) + shift(part / parts));
                let is_in = (0..2).all(|axis| (-0.5..f64::from(self.projector_px[axis]) - 0.5).contains(&at[axis]));
                is_in && pattern.is_lit(at[0].round() as u32, at[1].round() as u32)
            });
            20 + (180 * lit.count() as u32 / (parts * parts)) as u8
        };
        (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).map(|[x, y]| level(x, y)).collect()
    }

    fn decode(&self) -> Decoded {
        let patterns = gray_code(self.projector_px);
        let images: Vec<Vec<u8>> = patterns.iter().map(|pattern| self.image(pattern)).collect();
        let levels = images.iter().map(Vec::as_slice).collect();
        decode(&Images { size_px: self.size_px(), patterns: &patterns, levels }, self.projector_px).unwrap()
    }

    /// Share of the decoded pixels that are off by more.
    fn wrong(&self, decoded: &Decoded, most_px: f64) -> f64 {
        let width = decoded.size_px[0] as usize;
        let known = || decoded.pixels.iter().enumerate().filter(|(_, pixel)| pixel.is_decoded());
        let is_wrong = |(index, pixel): &(usize, &DecodedPixel)| {
            let truth = self.at((index % width) as f64, (index / width) as f64);
            (0..2).any(|axis| (f64::from(pixel.at[axis]) - truth[axis]).abs() > most_px)
        };
        known().filter(is_wrong).count() as f64 / known().count().max(1) as f64
    }
}

#[test]
fn a_wall_that_a_camera_sees_pixel_by_pixel_is_decoded() {
    for slant in [0.0, 0.02] {
        let wall = Wall { projector_px: [1024, 768], scale: 1.0, slant };
        let decoded = wall.decode();
        assert_eq!(decoded.quality.problems(), [], "{slant}");
        let (count, wrong) = (decoded.count(), wall.wrong(&decoded, 1.0));
        assert!(count as f64 > 0.95 * decoded.lit as f64 && wrong < 0.001, "{slant}: {count} {wrong}");
    }
}

#[test]
fn stripes_that_are_too_fine_for_a_camera_do_no_harm() {
    for (scale, slant) in [(3.0, 0.01), (4.0, 0.0), (5.3, 0.02), (8.0, 0.0), (11.0, 0.05)] {
        let wall = Wall { projector_px: [1024, 768], scale, slant };
        let decoded = wall.decode();
        assert_eq!(decoded.quality.problems(), [], "{scale}");
        let (count, wrong) = (decoded.count(), wall.wrong(&decoded, f64::max(1.0, 0.5 * scale)));
        assert!(count as f64 > 0.75 * decoded.lit as f64 && wrong < 0.01, "{scale}: {count} {wrong}");
    }
}
