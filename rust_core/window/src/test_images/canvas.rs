//! A grey image to draw on: rectangles, lines, discs and text, clipped at the edges.
//!
//! Pixel (u, v) is the square around (u, v), so lines and rectangles with whole coordinates are exact; discs and text
//! are antialiased.

use rcs_scene::{letters, Encoding, Image, LETTER_ASCENT_EM, LETTER_DESCENT_EM};

/// The lowest level.
pub(super) const BLACK: u8 = 0;
/// The highest level.
pub(super) const WHITE: u8 = 255;

/// The point of a text's box that lies at its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    /// The top left corner.
    TopLeft,
    /// The top right corner.
    TopRight,
    /// The bottom left corner.
    BottomLeft,
    /// The bottom right corner.
    BottomRight,
    /// The centre.
    Middle,
}

/// An image that is being drawn.
pub(super) struct Canvas {
    size_px: [u32; 2],
    grey: Vec<u8>,
}

impl Canvas {
    /// An image of one level.
    pub(super) fn new(size_px: [u32; 2], level: u8) -> Self {
        Self { size_px, grey: vec![level; size_px[0] as usize * size_px[1] as usize] }
    }

    /// The finished image.
    pub(super) fn into_image(self) -> Image {
        let [width_px, height_px] = self.size_px;
        Image { width_px, height_px, encoding: Encoding::Mono8, data: self.grey }
    }

    /// Width and height.
    pub(super) fn size_px(&self) -> [i64; 2] {
        self.size_px.map(i64::from)
    }

    /// Fills the columns and rows from `first` to before `end`.
    pub(super) fn fill(&mut self, first: [i64; 2], end: [i64; 2], level: u8) {
        let [columns, rows] = [0, 1].map(|axis| self.clipped(axis, first[axis], end[axis]));
        for row in rows {
            let start = row * self.size_px[0] as usize;
            self.grey[start + columns.start..start + columns.end].fill(level);
        }
    }

    /// A vertical line through the whole image, one pixel wide.
    pub(super) fn column(&mut self, u: i64, level: u8) {
        self.fill([u, 0], [u + 1, self.size_px()[1]], level);
    }

    /// A horizontal line through the whole image, one pixel wide.
    pub(super) fn row(&mut self, v: i64, level: u8) {
        self.fill([0, v], [self.size_px()[0], v + 1], level);
    }

    /// The outermost pixels of the columns and rows from `first` to before `end`.
    pub(super) fn frame(&mut self, first: [i64; 2], end: [i64; 2], level: u8) {
        let [left, top] = first;
        let [right, bottom] = end;
        self.fill([left, top], [right, top + 1], level);
        self.fill([left, bottom - 1], [right, bottom], level);
        self.fill([left, top], [left + 1, bottom], level);
        self.fill([right - 1, top], [right, bottom], level);
    }

    /// Sets each pixel of the columns and rows from `first` to before `end` to `level(u, v)`.
    pub(super) fn fill_with(&mut self, first: [i64; 2], end: [i64; 2], level: impl Fn(i64, i64) -> u8) {
        let [columns, rows] = [0, 1].map(|axis| self.clipped(axis, first[axis], end[axis]));
        for row in rows {
            let start = row * self.size_px[0] as usize;
            for column in columns.clone() {
                self.grey[start + column] = level(column as i64, row as i64);
            }
        }
    }

    /// An antialiased disc.
    pub(super) fn disc(&mut self, center: [f64; 2], radius: f64, level: u8) {
        let first = center.map(|at| (at - radius).floor() as i64 - 1);
        let end = center.map(|at| (at + radius).ceil() as i64 + 2);
        self.blend(first, end, level, |u, v| {
            let distance = (u as f64 - center[0]).hypot(v as f64 - center[1]);
            radius - distance + 0.5
        });
    }

    /// Width and height of a line of text, pixels. `em_px` is the letters' size.
    pub(super) fn text_size_px(text: &str, em_px: f64) -> [f64; 2] {
        let width: f32 = letters(text, em_px as f32).iter().map(|letter| letter.advance_px).sum();
        [f64::from(width), f64::from(LETTER_ASCENT_EM + LETTER_DESCENT_EM) * em_px]
    }

    /// A line of text.
    pub(super) fn text(&mut self, text: &str, place: [f64; 2], anchor: Anchor, em_px: f64, level: u8) {
        let [width, height] = Self::text_size_px(text, em_px);
        let [across, down] = match anchor {
            Anchor::TopLeft => [0.0, 0.0],
            Anchor::TopRight => [1.0, 0.0],
            Anchor::BottomLeft => [0.0, 1.0],
            Anchor::BottomRight => [1.0, 1.0],
            Anchor::Middle => [0.5, 0.5],
        };
        let mut left = place[0] - across * width;
        let baseline = place[1] - down * height + f64::from(LETTER_ASCENT_EM) * em_px;
        for letter in letters(text, em_px as f32) {
            // Letters on whole pixels are crisper.
            let first =
                [left.round() as i64 + i64::from(letter.left_px), baseline.round() as i64 + i64::from(letter.top_px)];
            let columns = i64::from(letter.width_px);
            let end = [first[0] + columns, first[1] + i64::from(letter.height_px)];
            self.blend(first, end, level, |u, v| {
                let index = (v - first[1]) * columns + u - first[0];
                letter.coverage.get(index as usize).map_or(0.0, |coverage| f64::from(*coverage) / 255.0)
            });
            left += f64::from(letter.advance_px);
        }
    }

    /// Blends the level into each pixel from `first` to before `end` by its coverage.
    fn blend(&mut self, first: [i64; 2], end: [i64; 2], level: u8, coverage: impl Fn(i64, i64) -> f64) {
        let [columns, rows] = [0, 1].map(|axis| self.clipped(axis, first[axis], end[axis]));
        for row in rows {
            let start = row * self.size_px[0] as usize;
            for column in columns.clone() {
                let share = coverage(column as i64, row as i64).clamp(0.0, 1.0);
                let pixel = &mut self.grey[start + column];
                *pixel = (f64::from(*pixel) * (1.0 - share) + f64::from(level) * share).round() as u8;
            }
        }
    }

    /// The part of a range that is in the image.
    fn clipped(&self, axis: usize, first: i64, end: i64) -> std::ops::Range<usize> {
        let side = self.size_px()[axis];
        let first = first.clamp(0, side);
        first as usize..end.clamp(first, side) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_exact_and_are_cut_off() {
        let mut canvas = Canvas::new([5, 4], BLACK);
        canvas.frame([0, 0], [5, 4], WHITE);
        canvas.fill([3, 1], [99, 2], 7);
        canvas.fill([-9, -9], [-1, -1], 9);
        let image = canvas.into_image();
        let expected = [[255; 5], [255, 0, 0, 7, 7], [255, 0, 0, 0, 255], [255; 5]].concat();
        assert_eq!(image.data, expected);
    }

    #[test]
    fn a_disc_has_the_area_of_a_disc_and_text_its_size() {
        let mut canvas = Canvas::new([64, 64], BLACK);
        canvas.disc([31.5, 31.5], 20.0, WHITE);
        let area: f64 = canvas.grey.iter().map(|grey| f64::from(*grey) / 255.0).sum();
        assert!((area / (std::f64::consts::PI * 400.0) - 1.0).abs() < 0.01, "{area}");
        for height in [9.0, 28.0, 60.0] {
            let [width, _] = Canvas::text_size_px("1280", height);
            let mut canvas = Canvas::new([200, 80], BLACK);
            canvas.text("1280", [10.0, 5.0], Anchor::TopLeft, height, WHITE);
            let lit: Vec<usize> =
                (0..canvas.grey.len()).filter(|pixel| canvas.grey[*pixel] > 100).map(|p| p % 200).collect();
            let (first, last) = (*lit.iter().min().unwrap() as f64, *lit.iter().max().unwrap() as f64);
            assert!(first >= 10.0 && last < 10.0 + width, "{first} {last} {width}");
            assert!(last - first > 0.8 * width, "{first} {last} {width}");
        }
    }
}
