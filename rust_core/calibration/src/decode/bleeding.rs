//! Compensation of the camera's blur, which pulls pixels towards brighter neighbours.
//!
//! A pixel's coordinate is the mean over its blur, weighted by light. For a Gaussian blur and a linear coordinate, it
//! is off by the blur's variance times the coordinate's gradient times the relative gradient of the light (integration
//! by parts). On the shaded side of a ball all pixels are pulled the same way, so averaging does not help.

use rayon::prelude::*;

use super::neighbours::Field;

/// Variance of a camera's blur, including its pixels' extent, squared camera pixels: that of usual cameras.
const BLUR_VARIANCE: f32 = 0.3;
/// Relative gradient at which half of the pull is compensated, less beyond: at the edges of dark objects the gradient
/// between two pixels is uncertain, and pixels are pulled in opposite directions.
const SHADING: f32 = 0.4;
/// Maximum difference of neighbouring camera pixels on one surface, projector pixels.
pub(super) const SURFACE_STEP_PX: f32 = 12.0;

/// Relative gradients of the light along rows and columns, per camera pixel.
pub(super) struct Gradients {
    width: usize,
    relative: Vec<[f32; 2]>,
}

impl Gradients {
    /// Computes the gradients of the projector's light.
    pub(super) fn new(amplitudes: &[f32], width: usize) -> Self {
        let height = amplitudes.len() / width.max(1);
        let mut relative = vec![[0.0; 2]; amplitudes.len()];
        relative.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            if y == 0 || y + 1 >= height {
                return;
            }
            for (x, relative) in row.iter_mut().enumerate().take(width.saturating_sub(1)).skip(1) {
                let index = y * width + x;
                let slope =
                    |step: usize| (amplitudes[index + step] - amplitudes[index - step]) / (2.0 * amplitudes[index]);
                if amplitudes[index] > 0.0 {
                    *relative = [slope(1), slope(width)];
                }
            }
        });
        Self { width, relative }
    }

    /// Pull of each pixel of a field, projector pixels; 0 where unknown.
    pub(super) fn pulls(&self, field: &Field) -> Vec<f32> {
        let step = |index: usize, by: usize| {
            let (before, after) = (index - by, index + by);
            let is_known = field.sigma[before].is_finite() && field.sigma[after].is_finite();
            let step = 0.5 * (field.at[after] - field.at[before]);
            if is_known && step.abs() < SURFACE_STEP_PX {
                step
            } else {
                0.0
            }
        };
        let pull = |index: usize| {
            let [along_row, along_column] = self.relative[index].map(|slope| slope / (1.0 + (slope / SHADING).powi(2)));
            // Both are 0 at the image's edge, where there are no neighbours.
            if along_row == 0.0 && along_column == 0.0 {
                return 0.0;
            }
            BLUR_VARIANCE * (along_row * step(index, 1) + along_column * step(index, self.width))
        };
        (0..self.relative.len()).into_par_iter().map(pull).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 12;
    const HEIGHT: usize = 9;

    fn field(at: impl Fn(usize, usize) -> f32) -> Field {
        let at: Vec<f32> = (0..WIDTH * HEIGHT).map(|index| at(index % WIDTH, index / WIDTH)).collect();
        Field { width: WIDTH, sigma: vec![0.1; at.len()], at }
    }

    #[test]
    fn pixels_are_pulled_towards_the_light() {
        // Brighter to the right by 3 % per pixel, evenly lit from top to bottom.
        let amplitudes: Vec<f32> = (0..WIDTH * HEIGHT).map(|index| (0.03 * (index % WIDTH) as f32).exp()).collect();
        let gradients = Gradients::new(&amplitudes, WIDTH);
        let pulls = gradients.pulls(&field(|x, y| 2.0 * x as f32 + 3.0 * y as f32));
        let middle = 4 * WIDTH + 6;
        assert!((pulls[middle] - 0.03 * 2.0 * BLUR_VARIANCE).abs() < 1e-3, "{}", pulls[middle]);
        assert_eq!(pulls[0], 0.0);
        let mut field = field(|x, _| 2.0 * x as f32);
        field.sigma[middle + 1] = f32::INFINITY;
        assert_eq!(gradients.pulls(&field)[middle], 0.0);
    }
}
