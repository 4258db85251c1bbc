//! The mean of depth images, without pixels whose depth varies or is often missing: edges, shiny or moving surfaces.
//!
//! Mean and variance by Welford, "Note on a method for calculating corrected sums of squares and products", 1962.

use crate::devices::DepthFrame;

/// The largest standard deviation at 1 m, metres; it grows with the square of depth. A Kinect's is 1.5 mm.
const MAX_DEVIATION_M: f32 = 0.006;
/// An allowance for steps of depth, at any depth, metres.
const STEP_M: f32 = 0.0015;
/// The share of frames in which a pixel must have a depth.
const MIN_SHARE: f32 = 0.6;

#[derive(Debug, Clone, Copy, Default)]
struct DepthPixel {
    count: u32,
    mean_m: f32,
    /// The sum of squared differences from the mean.
    squares: f32,
}

/// Sums of depth images of one size.
#[derive(Debug, Clone)]
pub(crate) struct DepthAverage {
    pixels: Vec<DepthPixel>,
    /// Number of depth images.
    pub(crate) frames: u32,
}

impl DepthAverage {
    /// Without depth images so far, of this number of pixels.
    pub(crate) fn new(pixels: usize) -> Self {
        Self { pixels: vec![DepthPixel::default(); pixels], frames: 0 }
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

    /// The mean depths, metres; 0 where uncertain.
    pub(crate) fn depth_m(&self) -> Vec<f32> {
        let least = (MIN_SHARE * self.frames as f32).max(1.0);
        let mean = |pixel: &DepthPixel| {
            let deviation_m = (pixel.squares / pixel.count.saturating_sub(1).max(1) as f32).sqrt();
            let most_m = STEP_M + MAX_DEVIATION_M * pixel.mean_m * pixel.mean_m;
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
        assert_eq!(average.frames, 10);
        assert_eq!(DepthAverage::new(2).depth_m(), [0.0, 0.0]);
    }
}
