//! Compensation of the camera's blur, which pulls pixels towards brighter neighbours.
//!
//! A pixel's coordinate is the mean over its blur, weighted by light. For a Gaussian blur and a linear coordinate, it
//! is off by the blur's variance times the coordinate's gradient times the relative gradient of the light (integration
//! by parts). On the shaded side of a ball all pixels are pulled the same way, so averaging does not help.
//!
//! The blur's variance is estimated at textures and edges, where coordinates deviate from their neighbours in
//! proportion to the pull. Noise of the light's gradient would bias the slope (regression dilution); so a second,
//! independent measurement of the light is the instrumental variable (Fuller, "Measurement error models", 1987, 1.4).

use rayon::prelude::*;

use super::neighbours::Field;

/// Prior of the variance of the camera's blur, including its pixels' extent: mean and standard deviation, squared
/// camera pixels.
const USUAL_VARIANCE: f32 = 0.3;
const VARIANCE_SIGMA: f32 = 0.12;
/// Range of the variance: at least that of the pixels' extent.
const VARIANCES: [f32; 2] = [1.0 / 12.0, 1.2];
/// Relative gradient at which half of the pull is compensated, less beyond: at the edges of dark objects the gradient
/// between two pixels is uncertain, and pixels are pulled in opposite directions.
const SHADING: f32 = 0.4;
/// Range of relative gradients for the estimate.
const MEASURED: [f32; 2] = [0.03, 0.3];
/// Distance of the compared coordinates, camera pixels.
const REACH: usize = 2;
/// Variance of a surface's coordinates about a straight line, without noise, squared projector pixels.
const CURVATURE: f32 = 1e-3;
/// Residual at which a comparison's weight is halved, standard deviations.
const OUTLIER: f32 = 3.0;
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

    /// Pull of each pixel of a field by a blur, projector pixels; 0 where unknown.
    pub(super) fn pulls(&self, field: &Field, blur_variance: f32) -> Vec<f32> {
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
            blur_variance * (along_row * step(index, 1) + along_column * step(index, self.width))
        };
        (0..self.relative.len()).into_par_iter().map(pull).collect()
    }
}

/// Estimates the variance of the camera's blur, including its pixels' extent, squared camera pixels, from the
/// coordinates along both axes and the gradients of two independent measurements of the light.
pub(super) fn blur_variance(gradients: [&Gradients; 2], fields: [&Field; 2]) -> f32 {
    let width = gradients[0].width;
    let height = gradients[0].relative.len() / width.max(1);
    // The compared pixels have neighbours, too.
    let margin = REACH + 1;
    let row = |y: usize| {
        let mut sums = PullSums::default();
        for field in fields {
            for index in y * width + margin..((y + 1) * width).saturating_sub(margin) {
                [1, width].into_iter().enumerate().for_each(|(axis, by)| sums.add(gradients, field, index, axis, by));
            }
        }
        sums
    };
    let rows = margin..height.saturating_sub(margin);
    rows.into_par_iter().map(row).reduce(PullSums::default, PullSums::and).variance()
}

/// Sums over comparisons.
#[derive(Debug, Clone, Copy, Default)]
struct PullSums {
    /// Deviation times instrument.
    off: f64,
    /// Pull by a unit variance times instrument.
    pull: f64,
    /// Squared instrument times the deviation's variance.
    noise: f64,
}

impl PullSums {
    /// Compares a pixel with its neighbours along an image axis, `by` pixels apart in memory.
    fn add(&mut self, [gradients, instrument]: [&Gradients; 2], field: &Field, index: usize, axis: usize, by: usize) {
        let slope = instrument.relative[index][axis].abs();
        if !(MEASURED[0]..MEASURED[1]).contains(&slope) {
            return;
        }
        let (before, after) = (index - REACH * by, index + REACH * by);
        if !(before - by..=after + by).step_by(by).all(|index| field.sigma[index].is_finite()) {
            return;
        }
        let step = (field.at[after] - field.at[before]) / (2 * REACH) as f32;
        if step.abs() > SURFACE_STEP_PX {
            return;
        }
        let relative = |of: &Gradients| {
            let [before, at, after] = [before, index, after].map(|index| of.relative[index][axis]);
            at - 0.5 * (before + after)
        };
        let (pull, instrument) = (step * relative(gradients), step * relative(instrument));
        let off = field.at[index] - 0.5 * (field.at[before] + field.at[after]);
        let [before, at, after] = [before, index, after].map(|index| field.sigma[index].powi(2));
        let variance = at + 0.25 * (before + after) + CURVATURE;
        let squared = (off - USUAL_VARIANCE * pull).powi(2) / variance;
        let weight = 1.0 / (variance * (1.0 + squared / (OUTLIER * OUTLIER)));
        self.off += f64::from(weight * off * instrument);
        self.pull += f64::from(weight * pull * instrument);
        self.noise += f64::from(weight * instrument * instrument);
    }

    fn and(self, other: Self) -> Self {
        Self { off: self.off + other.off, pull: self.pull + other.pull, noise: self.noise + other.noise }
    }

    /// Estimate combined with the prior.
    fn variance(&self) -> f32 {
        let usual = 1.0 / f64::from(VARIANCE_SIGMA).powi(2);
        let measured = self.pull.powi(2) / self.noise.max(1e-9);
        let variance = if self.pull > 0.0 { self.off / self.pull } else { 0.0 };
        let variance = (variance * measured + f64::from(USUAL_VARIANCE) * usual) / (measured + usual);
        (variance as f32).clamp(VARIANCES[0], VARIANCES[1])
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
        let pulls = gradients.pulls(&field(|x, y| 2.0 * x as f32 + 3.0 * y as f32), USUAL_VARIANCE);
        let middle = 4 * WIDTH + 6;
        assert!((pulls[middle] - 0.03 * 2.0 * USUAL_VARIANCE).abs() < 1e-3, "{}", pulls[middle]);
        assert_eq!(pulls[0], 0.0);
        let mut field = field(|x, _| 2.0 * x as f32);
        field.sigma[middle + 1] = f32::INFINITY;
        assert_eq!(gradients.pulls(&field, USUAL_VARIANCE)[middle], 0.0);
    }

    #[test]
    fn the_blur_is_measured_where_the_light_changes() {
        const SIDE: usize = 160;
        // A texture that is seen with independent noise twice, and coordinates that a blur has pulled by it.
        let mut state = 1_u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32 - 0.5
        };
        let texture: Vec<f32> = (0..SIDE * SIDE)
            .map(|index| ((index % SIDE) as f32 * 0.7).sin() + ((index / SIDE) as f32 * 0.5).cos())
            .map(|wave| (0.2 * wave).exp())
            .collect();
        let exact = Gradients::new(&texture, SIDE);
        let mut seen = || {
            let noisy: Vec<f32> = texture.iter().map(|light| light * (1.0 + 0.02 * noise())).collect();
            Gradients::new(&noisy, SIDE)
        };
        let (first, second) = (seen(), seen());
        for variance in [0.12, 0.3, 0.8] {
            let at: Vec<f32> = (0..SIDE * SIDE)
                .map(|index| {
                    let [along_row, along_column] = exact.relative[index];
                    let (x, y) = ((index % SIDE) as f32, (index / SIDE) as f32);
                    2.0 * x + y + variance * (2.0 * along_row + along_column)
                })
                .collect();
            let field = Field { width: SIDE, sigma: vec![0.05; at.len()], at };
            let found = blur_variance([&first, &second], [&field, &field]);
            assert!((found - variance).abs() < 0.03, "{found} instead of {variance}");
        }
        // Where the light is even, nothing shows it.
        let even = Gradients::new(&[1.0; SIDE * SIDE], SIDE);
        let field = Field { width: SIDE, sigma: vec![0.05; SIDE * SIDE], at: vec![1.0; SIDE * SIDE] };
        assert_eq!(blur_variance([&even, &even], [&field, &field]), USUAL_VARIANCE);
    }
}
