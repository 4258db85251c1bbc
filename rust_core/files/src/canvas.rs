//! Drawing marks on a small image: crosses, dots and lines one pixel wide, without blending. An integer is a pixel's
//! centre, as in ROS; marks are clipped.

use nalgebra::Point2;

use rcs_scene::{Encoding, Image};

/// Most pixels of a line.
const MOST_STEPS: u32 = 4000;

/// A colour image to draw on.
#[derive(Debug, Clone)]
pub struct Canvas {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
}

impl Canvas {
    /// An image of grey levels, row by row; missing ones are black.
    pub fn from_grey(size_px: [u32; 2], levels: impl IntoIterator<Item = u8>) -> Self {
        let [width, height] = size_px;
        let mut rgb: Vec<u8> = levels.into_iter().flat_map(|level| [level; 3]).collect();
        rgb.resize(3 * width as usize * height as usize, 0);
        Self { width, height, rgb }
    }

    /// Draws a pixel.
    pub fn set(&mut self, at: Point2<f64>, color: [u8; 3]) {
        let (x, y) = (at.x.round(), at.y.round());
        if x >= 0.0 && y >= 0.0 && x < f64::from(self.width) && y < f64::from(self.height) {
            let index = 3 * (y as usize * self.width as usize + x as usize);
            self.rgb[index..index + 3].copy_from_slice(&color);
        }
    }

    /// Draws an upright cross, seven pixels wide.
    pub fn cross(&mut self, at: Point2<f64>, color: [u8; 3]) {
        for step in -3..=3 {
            let step = f64::from(step);
            self.set(Point2::new(at.x + step, at.y), color);
            self.set(Point2::new(at.x, at.y + step), color);
        }
    }

    /// Draws a dot, three pixels wide.
    pub fn dot(&mut self, at: Point2<f64>, color: [u8; 3]) {
        for y in -1..=1 {
            for x in -1..=1 {
                self.set(Point2::new(at.x + f64::from(x), at.y + f64::from(y)), color);
            }
        }
    }

    /// Draws a line.
    pub fn line(&mut self, from: Point2<f64>, to: Point2<f64>, color: [u8; 3]) {
        let steps = ((to - from).amax().ceil() as u32).min(MOST_STEPS);
        for step in 0..=steps {
            let share = f64::from(step) / f64::from(steps.max(1));
            self.set(from + (to - from) * share, color);
        }
    }

    /// Converts it to an image.
    pub fn into_image(self) -> Image {
        Image { width_px: self.width, height_px: self.height, encoding: Encoding::Rgb8, data: self.rgb }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_drawn_where_the_image_is() {
        let mut canvas = Canvas::from_grey([10, 8], [7; 79]);
        canvas.line(Point2::new(-3.0, 2.0), Point2::new(30.0, 2.0), [9, 0, 0]);
        canvas.dot(Point2::new(0.2, 6.9), [0, 9, 0]);
        canvas.cross(Point2::new(20.0, 5.0), [0, 0, 9]);
        let image = canvas.into_image();
        let colors: Vec<&[u8]> = image.data.chunks(3).collect();
        let count = |color: [u8; 3]| colors.iter().filter(|other| **other == color).count();
        assert_eq!((count([9, 0, 0]), count([0, 9, 0]), count([0, 0, 9]), colors[79]), (10, 4, 0, &[0; 3][..]));
        assert_eq!(colors.len(), 80);
    }
}
