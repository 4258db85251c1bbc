//! What planes through windows leave out of curved surfaces: twicing (Tukey, "Exploratory data analysis", 1977, 16).
//!
//! A plane through a window of a curved surface lies off its middle, on the same side all over the surface, so no
//! number of windows averages that. But the middles are off the planes by as much on the other side. Each one's
//! distance is mostly noise; their mean over a somewhat larger window is the error of the planes there, and hardly
//! noisier than they are.

use rayon::prelude::*;

/// Windows of which fewer than this share is known say nothing.
const LEAST_SHARE: f32 = 0.25;

/// For each value the mean of those around it, in windows of 2·`radius` + 1 columns and rows. NaN values are not known;
/// where too few are, the mean is 0.
pub(crate) fn means_around(values: &[f32], width: usize, radius: usize) -> Vec<f32> {
    let height = values.len() / width;
    let side = 2 * radius + 1;
    let least = (LEAST_SHARE * (side * side) as f32) as u32;
    let mut means = vec![0.0; values.len()];
    means.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        let mut columns = vec![(0.0_f32, 0_u32); width];
        for y in y.saturating_sub(radius)..(y + radius + 1).min(height) {
            for (column, value) in columns.iter_mut().zip(&values[y * width..(y + 1) * width]) {
                if !value.is_nan() {
                    column.0 += value;
                    column.1 += 1;
                }
            }
        }
        for (x, mean) in row.iter_mut().enumerate() {
            let window = &columns[x.saturating_sub(radius)..(x + radius + 1).min(width)];
            let (sum, count) = window.iter().fold((0.0, 0), |(sum, count), column| (sum + column.0, count + column.1));
            if count >= least.max(1) {
                *mean = sum / count as f32;
            }
        }
    });
    means
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_those_of_what_is_known() {
        let mut values: Vec<f32> = (0..9 * 7).map(|index| (index % 9) as f32).collect();
        values[3 * 9 + 4] = f32::NAN;
        let means = means_around(&values, 9, 1);
        assert!((means[10] - 1.0).abs() < 1e-6 && (means[0] - 0.5).abs() < 1e-6);
        // Of the row of the unknown value, its left neighbour has columns 2 and 3 only.
        assert!((means[3 * 9 + 3] - (3.0 * 2.0 + 3.0 * 3.0 + 2.0 * 4.0) / 8.0).abs() < 1e-6);
        assert!(means_around(&[f32::NAN; 63], 9, 1).iter().all(|mean| *mean == 0.0));
    }
}
