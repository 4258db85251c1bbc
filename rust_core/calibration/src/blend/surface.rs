//! Depth of the lit surface at each pixel of a projector, from a cloud.
//!
//! The image is divided into cells whose size follows the cloud's density. A cell's depth is that of the nearest points
//! in it, which occlude those behind. Cells without points take the depth of their neighbours. Depths are interpolated
//! within a surface, not across its edges.

use nalgebra::{Isometry3, Point2, Point3};

use crate::Lens;

/// Mean number of points in a cell.
const POINTS_OF_CELL: f64 = 4.0;
/// Range of cell sizes, pixels.
const CELL_PX: std::ops::RangeInclusive<f64> = 4.0..=64.0;
/// Maximum relative depth difference within a surface.
const SAME_SURFACE: f64 = 0.03;

/// Surface lit by a projector.
#[derive(Debug, Clone)]
pub(super) struct LitSurface {
    cell_px: f64,
    columns: usize,
    rows: usize,
    /// Depths along the optical axis, metres, cell by cell.
    depths_m: Vec<f64>,
    /// Number of cells with points.
    observed: usize,
}

impl LitSurface {
    /// Builds the surface from a cloud; `None` if the projector lights none of its points.
    pub(super) fn new(lens: &Lens, projector_from_cloud: &Isometry3<f64>, points: &[Point3<f64>]) -> Option<Self> {
        let lit: Vec<(Point2<f64>, f64)> = points
            .iter()
            .filter_map(|point| {
                let point = projector_from_cloud * point;
                let pixel = lens.project(&point).filter(|pixel| lens.contains(*pixel))?;
                Some((pixel, point.z))
            })
            .collect();
        if lit.is_empty() {
            return None;
        }
        let [width, height] = lens.size_px.map(f64::from);
        let cell_px =
            (width * height * POINTS_OF_CELL / lit.len() as f64).sqrt().clamp(*CELL_PX.start(), *CELL_PX.end());
        let (columns, rows) = ((width / cell_px).ceil() as usize, (height / cell_px).ceil() as usize);
        let mut nearest = vec![f64::INFINITY; columns * rows];
        let cell = |pixel: &Point2<f64>| {
            let [x, y] = [pixel.x + 0.5, pixel.y + 0.5].map(|at| (at / cell_px).max(0.0) as usize);
            y.min(rows - 1) * columns + x.min(columns - 1)
        };
        for (pixel, depth) in &lit {
            let known = &mut nearest[cell(pixel)];
            *known = known.min(*depth);
        }
        // The mean over the nearest surface, not the nearest point, which is biased by noise.
        let mut sums = vec![(0.0, 0.0); columns * rows];
        for (pixel, depth) in &lit {
            let at = cell(pixel);
            if *depth < nearest[at] * (1.0 + SAME_SURFACE) {
                sums[at] = (sums[at].0 + depth, sums[at].1 + 1.0);
            }
        }
        let observed = sums.iter().filter(|(_, count)| *count > 0.0).count();
        let depths_m = sums.into_iter().map(|(sum, count)| if count > 0.0 { sum / count } else { f64::NAN }).collect();
        let mut surface = Self { cell_px, columns, rows, depths_m, observed };
        surface.fill();
        Some(surface)
    }

    /// Share of the image in which the cloud has points.
    pub(super) fn observed_share(&self) -> f64 {
        self.observed as f64 / self.depths_m.len() as f64
    }

    /// Gives cells without points the mean depth of their neighbours, ring by ring.
    fn fill(&mut self) {
        loop {
            let before = self.depths_m.clone();
            let (mut filled, mut left) = (0, 0);
            for (at, depth_m) in self.depths_m.iter_mut().enumerate().filter(|(_, depth)| depth.is_nan()) {
                match mean_around(&before, [self.columns, self.rows], at) {
                    Some(mean) => (*depth_m, filled) = (mean, filled + 1),
                    None => left += 1,
                }
            }
            if filled == 0 || left == 0 {
                return;
            }
        }
    }

    /// Depth at a pixel of the image, metres.
    pub(super) fn depth_m(&self, pixel: Point2<f64>) -> f64 {
        // In cells, from the first one's centre.
        let place = |at: f64, count: usize| ((at + 0.5) / self.cell_px - 0.5).clamp(0.0, count as f64 - 1.0);
        let (x, y) = (place(pixel.x, self.columns), place(pixel.y, self.rows));
        let (left, above) = (x as usize, y as usize);
        let (right, below) = ((left + 1).min(self.columns - 1), (above + 1).min(self.rows - 1));
        let depth = |column: usize, row: usize| self.depths_m[row * self.columns + column];
        let corners = [depth(left, above), depth(right, above), depth(left, below), depth(right, below)];
        let (near, far) =
            corners.iter().fold((f64::INFINITY, 0.0_f64), |(near, far), at| (near.min(*at), far.max(*at)));
        let (x, y) = (x - left as f64, y - above as f64);
        if far > near * (1.0 + 2.0 * SAME_SURFACE) {
            // A depth edge: the nearest cell's depth.
            return depth(if x < 0.5 { left } else { right }, if y < 0.5 { above } else { below });
        }
        // Inverse depth is linear on a plane.
        let [a, b, c, d] = corners.map(|depth| 1.0 / depth);
        1.0 / ((a * (1.0 - x) + b * x) * (1.0 - y) + (c * (1.0 - x) + d * x) * y)
    }
}

/// Mean of the known depths around a cell; `None` if there are none.
fn mean_around(depths_m: &[f64], [columns, rows]: [usize; 2], at: usize) -> Option<f64> {
    let (column, row) = (at % columns, at / columns);
    let (mut sum, mut count) = (0.0, 0.0);
    for row in row.saturating_sub(1)..(row + 2).min(rows) {
        for column in column.saturating_sub(1)..(column + 2).min(columns) {
            let depth = depths_m.get(row * columns + column).copied().filter(|depth| !depth.is_nan());
            (sum, count) = depth.map_or((sum, count), |depth| (sum + depth, count + 1.0));
        }
    }
    (count > 0.0).then(|| sum / count)
}
