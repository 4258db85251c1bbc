//! Blurred light of any displayed image.
//!
//! Such an image changes along both axes, so each place weights the pixels around it by a Gaussian over their squares.
//! Uniform blocks, which most of these images mostly have, cost nothing.

use crate::stripes::{deviation_px, normal_distribution};

/// Side of a block, pixels.
const BLOCK: usize = 16;
/// Reach of blur, standard deviations.
const REACH: f32 = 3.5;
/// Maximum taps along an axis.
const MOST_TAPS: usize = 64;

/// Image on the projector's panel.
#[derive(Debug, Clone)]
pub(crate) struct ProjectedImage {
    width: usize,
    height: usize,
    /// Light of each pixel, 0 to 1.
    light: Vec<f32>,
    blocks_wide: usize,
    /// Minimum and maximum light of each block.
    blocks: Vec<[f32; 2]>,
}

impl ProjectedImage {
    /// Creates the image from grey levels, row by row, that are linear in light; black ones leak a share.
    pub(crate) fn new(image: &[u8], size_px: [u32; 2], black: f32) -> Self {
        let [width, height] = size_px.map(|side| side as usize);
        let light: Vec<f32> = image.iter().map(|level| black + (1.0 - black) * f32::from(*level) / 255.0).collect();
        let (blocks_wide, blocks_high) = (width.div_ceil(BLOCK), height.div_ceil(BLOCK));
        let mut blocks = vec![[f32::INFINITY, 0.0_f32]; blocks_wide * blocks_high];
        for (index, light) in light.iter().take(width * height).enumerate() {
            let block = &mut blocks[index / width / BLOCK * blocks_wide + index % width / BLOCK];
            *block = [block[0].min(*light), block[1].max(*light)];
        }
        Self { width, height, light, blocks_wide, blocks }
    }

    /// Light at a place, pixels, for blur strengths along u and v; 0 outside of the image.
    pub(crate) fn at(&self, place: [f32; 2], blur: [u8; 2]) -> f32 {
        let deviations = blur.map(deviation_px);
        let range = |axis: usize| {
            let reach = REACH * deviations[axis] + 0.5;
            [(place[axis] - reach).floor() as i64, (place[axis] + reach).ceil() as i64]
        };
        let (columns, rows) = (range(0), range(1));
        if let Some(even) = self.even(columns, rows) {
            return even;
        }
        let (across, down) = (weights(place[0], deviations[0], columns), weights(place[1], deviations[1], rows));
        let mut sum = 0.0;
        for (row, weight) in (rows[0]..=rows[1]).zip(down).filter(|(row, _)| (0..self.height as i64).contains(row)) {
            let first = columns[0].clamp(0, self.width as i64) as usize;
            let skipped = (first as i64 - columns[0]) as usize;
            let from = row as usize * self.width;
            let end = (columns[1] + 1).clamp(first as i64, self.width as i64) as usize;
            let Some(light) = self.light.get(from + first..from + end) else { continue };
            let taps = across.iter().skip(skipped).zip(light);
            sum += weight * taps.map(|(weight, light)| weight * light).sum::<f32>();
        }
        sum
    }

    /// Light of columns and rows if it is uniform.
    fn even(&self, columns: [i64; 2], rows: [i64; 2]) -> Option<f32> {
        let [width, height] = [self.width as i64, self.height as i64];
        if columns[1] < 0 || rows[1] < 0 || columns[0] >= width || rows[0] >= height {
            return Some(0.0);
        }
        if columns[0] < 0 || rows[0] < 0 || columns[1] >= width || rows[1] >= height {
            return None;
        }
        let [left, right, top, bottom] = [columns[0], columns[1], rows[0], rows[1]].map(|at| at as usize / BLOCK);
        let mut found = [f32::INFINITY, 0.0_f32];
        for row in top..=bottom {
            for [least, most] in &self.blocks[row * self.blocks_wide + left..=row * self.blocks_wide + right] {
                found = [found[0].min(*least), found[1].max(*most)];
            }
        }
        (found[0] >= found[1]).then_some(found[1])
    }
}

/// Shares of a Gaussian around a place over each pixel of a range.
fn weights(place: f32, deviation: f32, [first, last]: [i64; 2]) -> [f32; MOST_TAPS] {
    let below = |edge: f64| normal_distribution((edge - f64::from(place)) / f64::from(deviation));
    let mut weights = [0.0; MOST_TAPS];
    let mut before = below(first as f64 - 0.5);
    for (weight, at) in weights.iter_mut().zip(first..=last) {
        let after = below(at as f64 + 0.5);
        *weight = (after - before) as f32;
        before = after;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stripes::strength;

    #[test]
    fn a_square_is_blurred_and_keeps_its_light() {
        let size = [200_u32, 120];
        let is_lit = |index: u32| (90..100).contains(&(index % 200)) && (50..60).contains(&(index / 200));
        let image: Vec<u8> = (0..200 * 120).map(|index| if is_lit(index) { 255 } else { 0 }).collect();
        let image = ProjectedImage::new(&image, size, 0.0);
        let blur = [strength(1.5), strength(3.0)];
        assert!(image.at([94.5, 54.5], [0, 0]) > 0.99 && image.at([89.5, 54.5], [0, 0]) > 0.49);
        assert_eq!(image.at([20.0, 20.0], blur), 0.0);
        assert_eq!(image.at([-900.0, 20.0], blur), 0.0);
        let (mut sum, mut along) = (0.0, 0.0);
        for v in 0..120_u16 {
            for u in 0..200_u16 {
                let light = image.at([f32::from(u), f32::from(v)], blur);
                sum += light;
                along += light * f32::from(u);
            }
        }
        assert!((sum - 100.0).abs() < 0.2 && (along / sum - 94.5).abs() < 0.01, "{sum} {}", along / sum);
    }

    #[test]
    fn white_ends_at_the_edge_and_black_leaks() {
        let white = ProjectedImage::new(&[255; 64 * 48], [64, 48], 0.1);
        let blur = [strength(1.0); 2];
        for (at, expected) in [([30.0, 20.0], 1.0), ([-0.5, 20.0], 0.5), ([63.5, 47.5], 0.25), ([30.0, 60.0], 0.0)] {
            assert!((white.at(at, blur) - expected).abs() < 0.01, "{at:?}: {}", white.at(at, blur));
        }
        let black = ProjectedImage::new(&[0; 64 * 48], [64, 48], 0.1);
        assert!((black.at([30.0, 20.0], blur) - 0.1).abs() < 1e-6);
    }
}
