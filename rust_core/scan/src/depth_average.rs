//! The mean of depth images. Pixels whose depth varies or is often missing are dropped: there, edges, shiny or moving
//! things give some depth and not a certain one.
//!
//! Mean and variance by Welford, "Note on a method for calculating corrected sums of squares and products", 1962.

use crate::devices::DepthFrame;

/// The largest standard deviation at 1 m, metres; noise grows with the square of depth. A Kinect's is 1.5 mm.
const MOST_DEVIATION_M: f32 = 0.006;
/// What is added to it at any depth, metres: steps of depth.
const STEP_M: f32 = 0.0015;
/// The share of frames that a pixel must have a depth in.
const LEAST_SHARE: f32 = 0.6;

#[derive(Debug, Clone, Copy, Default)]
struct Pixel {
    count: u32,
    mean_m: f32,
    /// The sum of squared differences from the mean.
    squares: f32,
}

/// Sums of depth images of one size.
#[derive(Debug, Clone)]
pub(crate) struct DepthAverage {
    pixels: Vec<Pixel>,
    frames: u32,
}

impl DepthAverage {
    /// No depth image of so many pixels yet.
    pub(crate) fn new(pixels: usize) -> Self {
        Self { pixels: vec![Pixel::default(); pixels], frames: 0 }
    }

    /// How many were added.
    pub(crate) fn frames(&self) -> u32 {
        self.frames
    }

    /// Adds a depth image.
    pub(crate) fn add(&mut self, frame: &DepthFrame) {
        self.frames += 1;
        for (pixel, depth_m) in self.pixels.iter_mut().zip(&frame.depth_m) {
            if depth_m.is_finite() && *depth_m > 0.0 {
                pixel.count += 1;
                let off = depth_m - pixel.mean_m;
                pixel.mean_m += off / pixel.count as f32;
                pixel.squares += off * (depth_m - pixel.mean_m);
            }
        }
    }

    /// The mean depths, metres; 0 where there is none that is certain.
    pub(crate) fn depth_m(&self) -> Vec<f32> {
        let least = (LEAST_SHARE * self.frames as f32).max(1.0);
        let mean = |pixel: &Pixel| {
            let deviation_m = (pixel.squares / pixel.count.saturating_sub(1).max(1) as f32).sqrt();
            let most_m = STEP_M + MOST_DEVIATION_M * pixel.mean_m * pixel.mean_m;
            if pixel.count as f32 >= least && deviation_m <= most_m {
                pixel.mean_m
            } else {
                0.0
            }
        };
        self.pixels.iter().map(mean).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uncertain_depths_are_dropped() {
        let mut average = DepthAverage::new(5);
        for frame in 0..10 {
            let noise = if frame % 2 == 0 { 0.004 } else { -0.004 };
            let depth_m = vec![
                2.0 + noise,
                if frame < 5 { 1.0 } else { f32::NAN },
                if frame == 3 { 0.0 } else { 1.0 },
                if frame % 3 == 0 { 1.0 } else { 1.1 },
                -1.0,
            ];
            average.add(&DepthFrame { size_px: [5, 1], depth_m });
        }
        let depth_m = average.depth_m();
        assert!((depth_m[0] - 2.0).abs() < 1e-6 && (depth_m[2] - 1.0).abs() < 1e-6);
        assert_eq!((depth_m[1], depth_m[3], depth_m[4]), (0.0, 0.0, 0.0));
        assert_eq!(average.frames(), 10);
        assert_eq!(DepthAverage::new(2).depth_m(), [0.0, 0.0]);
    }
}
