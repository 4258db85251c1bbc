//! How near an image is to the one that rviz drew.
//!
//! A content pixel is one that differs by more than 2 levels from the expected image's most frequent colour, in
//! either image. *strict* is the share of content pixels whose channels all differ by at most 2 levels; *close* is
//! the share that match within 16 levels, the match being allowed one pixel away, in both directions: it forgives one
//! pixel of rasterisation, not a wrong size, place, order, shade or colour.

use std::collections::HashMap;

/// A colour image; grey ones have three equal channels.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rgb {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) pixels: Vec<[u8; 3]>,
}

/// The result of a comparison.
#[derive(Clone, Debug)]
pub(crate) struct Score {
    pub(crate) strict: f64,
    pub(crate) close: f64,
    /// For each pixel whether it is close.
    pub(crate) is_close: Vec<bool>,
}

const STRICT_LEVELS: u8 = 2;
const CLOSE_LEVELS: u8 = 16;

fn near(a: [u8; 3], b: [u8; 3], levels: u8) -> bool {
    a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= levels)
}

impl Rgb {
    fn has_near(&self, x: usize, y: usize, color: [u8; 3]) -> bool {
        let columns = x.saturating_sub(1)..=(x + 1).min(self.width - 1);
        (y.saturating_sub(1)..=(y + 1).min(self.height - 1))
            .any(|y| columns.clone().any(|x| near(self.pixels[y * self.width + x], color, CLOSE_LEVELS)))
    }
}

/// Compares two images; `None` when their sizes differ.
pub(crate) fn score(expected: &Rgb, actual: &Rgb) -> Option<Score> {
    if (expected.width, expected.height) != (actual.width, actual.height) {
        return None;
    }
    let mut counts: HashMap<[u8; 3], usize> = HashMap::new();
    for pixel in &expected.pixels {
        *counts.entry(*pixel).or_default() += 1;
    }
    let background = counts.into_iter().max_by_key(|&(color, count)| (count, std::cmp::Reverse(color)))?.0;
    let (mut content, mut strict, mut close) = (0_usize, 0_usize, 0_usize);
    let mut is_close = Vec::with_capacity(expected.pixels.len());
    for (i, (&e, &a)) in expected.pixels.iter().zip(&actual.pixels).enumerate() {
        let (x, y) = (i % expected.width, i / expected.width);
        let exact = near(e, a, STRICT_LEVELS);
        let hit = exact || (expected.has_near(x, y, a) && actual.has_near(x, y, e));
        is_close.push(hit);
        if !near(e, background, STRICT_LEVELS) || !near(a, background, STRICT_LEVELS) {
            content += 1;
            strict += usize::from(exact);
            close += usize::from(hit);
        }
    }
    let share = |hits: usize| if content == 0 { 1.0 } else { hits as f64 / content as f64 };
    Some(Score { strict: share(strict), close: share(close), is_close })
}

/// Expected | difference | actual, side by side; what is not close is magenta in the middle.
pub(crate) fn comparison(expected: &Rgb, actual: &Rgb, score: &Score) -> Rgb {
    let width = expected.width;
    let mut pixels = Vec::with_capacity(expected.pixels.len() * 3);
    for y in 0..expected.height {
        let row = y * width..(y + 1) * width;
        pixels.extend_from_slice(&expected.pixels[row.clone()]);
        pixels.extend(row.clone().map(|i| {
            if score.is_close[i] {
                actual.pixels[i].map(|channel| channel / 3)
            } else {
                [255, 0, 255]
            }
        }));
        pixels.extend_from_slice(&actual.pixels[row]);
    }
    Rgb { width: 3 * width, height: expected.height, pixels }
}
