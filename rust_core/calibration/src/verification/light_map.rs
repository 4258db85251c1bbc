//! Share of the projector's light at each camera pixel, independent of the surface's colour: 0 for black, 1 for white.

use nalgebra::Point2;

/// Minimum difference of white and black for a known share, levels.
const LEAST_LEVELS: f64 = 10.0;

/// Projector light in the camera's image, from images of white and black.
#[derive(Debug, Clone)]
pub struct LightMap {
    pub(super) width: usize,
    /// Levels of black.
    black: Vec<f32>,
    /// Reciprocal of white minus black; 0 where the difference is too small.
    per_level: Vec<f32>,
}

impl LightMap {
    /// Creates the map from grey levels of the camera's images of white and black, row by row, `width` pixels wide.
    /// `noise` is the RMS difference of two images of the same, levels.
    pub fn new(white: &[u8], black: &[u8], width: u32, noise: f64) -> Self {
        let least = LEAST_LEVELS.max(4.0 * noise);
        let per_level = |(white, black): (&u8, &u8)| {
            let levels = f64::from(*white) - f64::from(*black);
            if levels >= least {
                (1.0 / levels) as f32
            } else {
                0.0
            }
        };
        Self {
            width: width as usize,
            black: black.iter().map(|level| f32::from(*level)).collect(),
            per_level: white.iter().zip(black).map(per_level).collect(),
        }
    }

    /// `true` if the projector lights a pixel and all up to `reach` pixels beside it.
    pub(super) fn is_lit_around(&self, x: usize, y: usize, reach: usize) -> bool {
        let height = self.per_level.len() / self.width.max(1);
        let is_inside = x >= reach && y >= reach && x + reach < self.width && y + reach < height;
        is_inside
            && (y - reach..=y + reach).all(|row| {
                let start = row * self.width;
                self.per_level[start + x - reach..=start + x + reach].iter().all(|per_level| *per_level > 0.0)
            })
    }

    /// Shares of an image of the map's size; 0 where unknown.
    pub(super) fn shares(&self, grey: &[u8]) -> Shares {
        let known = grey.iter().zip(&self.black).zip(&self.per_level);
        let share = |((level, black), per_level): ((&u8, &f32), &f32)| (f32::from(*level) - black) * per_level;
        Shares { width: self.width, shares: known.map(share).collect() }
    }
}

/// Shares of light, row by row.
#[derive(Debug, Clone)]
pub(super) struct Shares {
    pub(super) width: usize,
    pub(super) shares: Vec<f32>,
}

impl Shares {
    pub(super) fn height(&self) -> usize {
        self.shares.len() / self.width.max(1)
    }

    /// Bilinear interpolation; `None` outside of the image.
    pub(super) fn at(&self, place: Point2<f64>) -> Option<f64> {
        let (left, top) = (place.x.floor(), place.y.floor());
        if left < 0.0 || top < 0.0 || left + 1.0 >= self.width as f64 || top + 1.0 >= self.height() as f64 {
            return None;
        }
        let first = top as usize * self.width + left as usize;
        let row = |start: usize| {
            let (one, next) = (f64::from(self.shares[start]), f64::from(self.shares[start + 1]));
            one + (next - one) * (place.x - left)
        };
        let (upper, lower) = (row(first), row(first + self.width));
        Some(upper + (lower - upper) * (place.y - top))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_do_not_depend_on_the_surface() {
        let (white, black) = ([220, 60, 30, 25], [20, 20, 10, 20]);
        let map = LightMap::new(&white, &black, 2, 0.5);
        let shares = map.shares(&[120, 40, 20, 255]);
        assert!(shares
            .shares
            .iter()
            .zip([0.5, 0.5, 0.5, 0.0])
            .all(|(share, expected)| (share - expected).abs() < 1e-6));
        assert!((shares.at(Point2::new(0.5, 0.0)).unwrap_or(0.0) - 0.5).abs() < 1e-6 || shares.height() == 2);
        assert_eq!(shares.at(Point2::new(-0.1, 0.0)), None);
        assert!(map.is_lit_around(0, 0, 0) && !map.is_lit_around(1, 1, 0) && !map.is_lit_around(0, 0, 1));
    }
}
