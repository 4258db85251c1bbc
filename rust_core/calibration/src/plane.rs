//! Local plane fits to the pixels of a window, and the bias that they have on curved surfaces.
//!
//! The bias is removed by twicing (Tukey, "Exploratory data analysis", 1977, 16): a plane through a window of a curved
//! surface lies off its middle, on the same side all over the surface, so averaging windows does not help. The middles'
//! residuals have the opposite bias. Single ones are mostly noise; their mean over a somewhat larger window estimates
//! the bias, and is hardly noisier than the planes.

use rayon::prelude::*;

/// Minimum share of known values in a window of [`means_around`].
const LEAST_SHARE: f32 = 0.25;

/// A plane a = at + by_x · x + by_y · y.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    /// Height at the window's centre.
    pub(crate) at: f32,
    pub(crate) by_x: f32,
    pub(crate) by_y: f32,
    /// Mean squared distance from the plane.
    pub(crate) variance: f32,
    /// Sum of the weights.
    pub(crate) support: f32,
}

impl Plane {
    /// Placeholder where no plane was fitted.
    pub(crate) const NONE: Self = Self { at: 0.0, by_x: 0.0, by_y: 0.0, variance: f32::INFINITY, support: 0.0 };

    /// Residual of a pixel: x, y and height.
    pub(crate) fn residual(&self, [x, y, a]: &[f32; 3]) -> f32 {
        a - self.at - self.by_x * x - self.by_y * y
    }
}

/// Weight under Cauchy's loss; `ratio` is the residual over the one that halves the weight.
pub(crate) fn robust_weight(weight: f32, ratio: f32) -> f32 {
    weight / (1.0 + ratio * ratio)
}

/// Weighted moments of a window; coordinates are relative to its centre.
#[derive(Default, Clone, Copy)]
pub(crate) struct PlaneSums {
    one: f32,
    x: f32,
    y: f32,
    xx: f32,
    xy: f32,
    yy: f32,
    a: f32,
    ax: f32,
    ay: f32,
    aa: f32,
}

impl FromIterator<(f32, [f32; 3])> for PlaneSums {
    /// Sums weights with x, y and height.
    fn from_iter<T: IntoIterator<Item = (f32, [f32; 3])>>(entries: T) -> Self {
        let mut sums = Self::default();
        entries.into_iter().for_each(|(weight, [x, y, a])| sums.add(weight, x, y, a));
        sums
    }
}

impl PlaneSums {
    fn add(&mut self, weight: f32, x: f32, y: f32, a: f32) {
        let (wx, wy, wa) = (weight * x, weight * y, weight * a);
        self.one += weight;
        self.x += wx;
        self.y += wy;
        self.xx += wx * x;
        self.xy += wx * y;
        self.yy += wy * y;
        self.a += wa;
        self.ax += wa * x;
        self.ay += wa * y;
        self.aa += wa * a;
    }

    /// Least-squares plane; `None` if the total weight is below `least_weight` or the pixels are collinear.
    pub(crate) fn plane(&self, least_weight: f32) -> Option<Plane> {
        if self.one < least_weight {
            return None;
        }
        let (mx, my, ma) = (self.x / self.one, self.y / self.one, self.a / self.one);
        let (xx, xy) = (self.xx / self.one - mx * mx, self.xy / self.one - mx * my);
        let yy = self.yy / self.one - my * my;
        let (ax, ay) = (self.ax / self.one - ma * mx, self.ay / self.one - ma * my);
        let determinant = xx * yy - xy * xy;
        if determinant < 0.05 {
            return None;
        }
        let (by_x, by_y) = ((ax * yy - ay * xy) / determinant, (ay * xx - ax * xy) / determinant);
        let variance = (self.aa / self.one - ma * ma - by_x * ax - by_y * ay).max(0.0);
        Some(Plane { at: ma - by_x * mx - by_y * my, by_x, by_y, variance, support: self.one })
    }
}

/// Mean around each value, in windows of 2·`radius` + 1 columns and rows. NaN values are unknown; the mean is 0 where
/// too few are known.
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
    fn means_ignore_unknown_values() {
        let mut values: Vec<f32> = (0..9 * 7).map(|index| (index % 9) as f32).collect();
        values[3 * 9 + 4] = f32::NAN;
        let means = means_around(&values, 9, 1);
        assert!((means[10] - 1.0).abs() < 1e-6 && (means[0] - 0.5).abs() < 1e-6);
        // In the row of the unknown value, its left neighbour has columns 2 and 3 only.
        assert!((means[3 * 9 + 3] - (3.0 * 2.0 + 3.0 * 3.0 + 2.0 * 4.0) / 8.0).abs() < 1e-6);
        assert!(means_around(&[f32::NAN; 63], 9, 1).iter().all(|mean| *mean == 0.0));
    }

    #[test]
    fn a_plane_is_found_again() {
        let mut sums = PlaneSums::default();
        for y in -2_i16..=2 {
            for x in -2_i16..=1 {
                let (x, y) = (f32::from(x), f32::from(y));
                sums.add(1.0 + 0.2 * x, x, y, 7.0 + 0.5 * x - 0.25 * y);
            }
        }
        let plane = sums.plane(5.0).unwrap();
        assert!((plane.at - 7.0).abs() < 1e-4 && (plane.by_x - 0.5).abs() < 1e-4 && (plane.by_y + 0.25).abs() < 1e-4);
        assert!(plane.variance < 1e-4 && plane.support > 10.0);
        assert!(sums.plane(1000.0).is_none());
    }

    #[test]
    fn a_line_is_no_plane() {
        let mut sums = PlaneSums::default();
        (-3_i16..=3).for_each(|x| sums.add(1.0, f32::from(x), f32::from(2 * x), 1.0));
        assert!(sums.plane(1.0).is_none());
    }
}
