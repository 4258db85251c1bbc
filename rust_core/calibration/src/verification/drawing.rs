//! Binary images of discs and lines: no grey levels, which a projector's gamma would distort.

use nalgebra::Point2;

/// Image of grey levels.
#[derive(Debug, Clone)]
pub(super) struct Drawing {
    size: [i64; 2],
    /// Row by row.
    pub(super) levels: Vec<u8>,
}

impl Drawing {
    pub(super) fn black(size_px: [u32; 2]) -> Self {
        let [width, height] = size_px;
        Self { size: size_px.map(i64::from), levels: vec![0; width as usize * height as usize] }
    }

    /// Draws a disc, clipped to the image.
    pub(super) fn disc(&mut self, middle: Point2<f64>, radius: f64) {
        let range = |at: f64, size: i64| {
            let (first, last) = ((at - radius).ceil() as i64, (at + radius).floor() as i64);
            first.clamp(0, size)..(last + 1).clamp(0, size)
        };
        for v in range(middle.y, self.size[1]) {
            for u in range(middle.x, self.size[0]) {
                if (Point2::new(u as f64, v as f64) - middle).norm_squared() <= radius * radius {
                    self.levels[(v * self.size[0] + u) as usize] = u8::MAX;
                }
            }
        }
    }

    /// Draws a line with round ends and a width of twice the radius.
    pub(super) fn line(&mut self, from: Point2<f64>, to: Point2<f64>, radius: f64) {
        let steps = (to - from).amax().ceil().clamp(1.0, 1e4);
        for step in 0..=steps as u32 {
            self.disc(from + (to - from) * (f64::from(step) / steps), radius);
        }
    }

    /// Adds another image of the same size.
    pub(super) fn add(&mut self, other: &Self) {
        self.levels.iter_mut().zip(&other.levels).for_each(|(level, other)| *level = (*level).max(*other));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discs_are_even_around_their_pixel_and_are_cut_off() {
        let mut drawing = Drawing::black([40, 30]);
        drawing.disc(Point2::new(20.0, 10.0), 4.0);
        let lit: Vec<[i64; 2]> =
            (0..1200).filter(|i| drawing.levels[*i as usize] > 0).map(|i: i64| [i % 40, i / 40]).collect();
        assert_eq!(lit.len(), 49);
        assert!(lit.iter().map(|[u, _]| u - 20).sum::<i64>() == 0 && lit.iter().map(|[_, v]| v - 10).sum::<i64>() == 0);
        let mut corner = Drawing::black([40, 30]);
        corner.disc(Point2::new(-1.0, 29.0), 2.0);
        corner.line(Point2::new(-50.0, -50.0), Point2::new(-40.0, 90.0), 2.0);
        assert_eq!(corner.levels.iter().filter(|level| **level > 0).count(), 3);
        corner.add(&drawing);
        assert_eq!(corner.levels.iter().filter(|level| **level > 0).count(), 52);
    }
}
