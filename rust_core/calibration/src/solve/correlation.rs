//! Spatial correlation of errors, estimated from products of residuals of pairs of cells by their distance.
//!
//! A covariance function is fitted to them, as in kriging (Cressie, "Statistics for spatial data", 1993, 2.4). It has
//! three parts: the variance of single samples, that shared within a fine cell, because windows overlap, and one that
//! falls slowly with distance. The unknowns absorb part of the errors, so the products are compared with the expected
//! ones of residuals.

use nalgebra::{DMatrix, SVector, Vector2};
use rayon::prelude::*;

use super::cells::{over_scans, CellSums, ScanSums, CELLS};
use super::model::{Block, Free, LOCAL};

/// Maximum distance of pairs of cells, cells.
const FARTHEST: usize = 10;
/// Maximum number of scans for the estimate.
const MEASURED_SCANS: usize = 4;
/// Correlations below this are ignored.
const NEGLIGIBLE: f64 = 1e-4;
/// Minimum number of samples; with fewer, errors count as independent.
const LEAST_FOR_CORRELATION: usize = 200;

/// Covariance function in one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Correlation {
    /// Variance that falls slowly with distance.
    pub(super) shared: f64,
    /// Variance shared within a fine cell.
    pub(super) near: f64,
    /// Variance of single samples.
    pub(super) own: f64,
    /// Standard deviation of the Gaussian by which `shared` falls, cells.
    pub(super) range: f64,
}

/// Tried ranges, cells.
const RANGES: [f64; 10] = [0.4, 0.6, 0.8, 1.0, 1.25, 1.6, 2.0, 2.5, 3.2, 4.0];

/// Correlations by the columns and rows between two cells.
pub(super) struct CorrelationTable(Vec<f64>);

impl CorrelationTable {
    /// Gaussian of a range.
    pub(super) fn new(range: f64) -> Self {
        let side = CELLS + 1;
        let at = |i: usize| (-0.5 * ((i % side).pow(2) + (i / side).pow(2)) as f64 / (range * range)).exp();
        Self((0..side * side).map(at).collect())
    }

    fn at(&self, apart: Vector2<f64>) -> f64 {
        self.0[apart.y.abs() as usize * (CELLS + 1) + apart.x.abs() as usize]
    }

    /// Sum of the cells' slopes, weighted by correlation with a position.
    fn near(&self, filled: &[(Vector2<f64>, &CellSums)], place: Vector2<f64>, direction: usize) -> SVector<f64, LOCAL> {
        let mut near = SVector::zeros();
        for (other_place, other) in filled {
            let correlation = self.at(place - other_place);
            if correlation > NEGLIGIBLE {
                near += other.slopes[direction] * correlation;
            }
        }
        near
    }
}

/// Sums over pairs of samples by the distance of their cells, and numbers of pairs.
type Bins = [(f64, f64); FARTHEST + 1];

/// Bins a value of pairs of cells; within a cell, pairs are of different samples.
fn binned(sums: &[ScanSums], pair: impl Fn(usize, usize, usize) -> f64, within: impl Fn(usize, usize) -> f64) -> Bins {
    let mut bins = [(0.0, 0.0); FARTHEST + 1];
    for (scan, sums) in sums.iter().enumerate() {
        let filled = sums.filled();
        for (i, (place, cell)) in filled.iter().enumerate() {
            bins[0].0 += within(scan, i);
            bins[0].1 += cell.count * (cell.count - 1.0);
            for (j, (other_place, other)) in filled.iter().enumerate().skip(i + 1) {
                let bin = (place - other_place).norm().round() as usize;
                if bin <= FARTHEST {
                    bins[bin].0 += pair(scan, i, j);
                    bins[bin].1 += cell.count * other.count;
                }
            }
        }
    }
    bins
}

/// Estimates the covariance function in a direction.
pub(super) fn correlation(
    sums: &[ScanSums],
    direction: usize,
    used: f64,
    free: &Free,
    inverse: &DMatrix<f64>,
) -> Correlation {
    let squares: f64 = sums.iter().flat_map(|sums| &sums.cells).map(|cell| cell.squares[direction]).sum();
    // The unknowns absorb part of the errors.
    let absorbed = 2.0 * used / (2.0 * used - free.len() as f64).max(0.2 * used);
    let variance = squares / used.max(1.0) * absorbed;
    let independent = Correlation { shared: 0.0, near: 0.0, own: variance, range: RANGES[0] };
    if used < LEAST_FOR_CORRELATION as f64 {
        return independent;
    }
    let measured = &sums[..sums.len().min(MEASURED_SCANS)];
    let filled: Vec<_> = measured.iter().map(ScanSums::filled).collect();
    let residual = |scan: usize, i: usize| filled[scan][i].1.residuals[direction];
    let observed = binned(
        measured,
        |scan, i, j| residual(scan, i) * residual(scan, j),
        |scan, i| residual(scan, i).powi(2) - filled[scan][i].1.squares[direction],
    );
    let near = expected(sums, measured, direction, UnitErrors::Near, free, inverse);
    let fits: Vec<(f64, Correlation)> = RANGES
        .into_par_iter()
        .map(|range| {
            let table = CorrelationTable::new(range);
            let far = expected(sums, measured, direction, UnitErrors::Far(&table), free, inverse);
            let (misfit, [near_part, shared]) = FitMoments::new(&observed, &near, &far).fit();
            let within = if far[0].1 > 0.0 { far[0].0 / far[0].1 } else { 1.0 };
            let own = (variance - shared * within - near_part).max(0.0);
            (misfit, Correlation { shared, near: near_part, own, range })
        })
        .collect();
    fits.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(independent, |(_, correlation)| correlation)
}

/// Moments for the least squares of observed = near part · near + shared · far. Near pairs of cells count more.
struct FitMoments {
    observed: f64,
    near_observed: f64,
    far_observed: f64,
    near: f64,
    far: f64,
    both: f64,
}

impl FitMoments {
    fn new(observed: &Bins, near: &Bins, far: &Bins) -> Self {
        let mut moments = Self { observed: 0.0, near_observed: 0.0, far_observed: 0.0, near: 0.0, far: 0.0, both: 0.0 };
        for distance in 0..=FARTHEST {
            let pairs = observed[distance].1;
            if pairs > 0.0 {
                let weight = 1.0 / (1.0 + distance as f64);
                let [observed, near, far] = [observed, near, far].map(|bins| bins[distance].0 / pairs);
                moments.observed += weight * observed * observed;
                moments.near_observed += weight * near * observed;
                moments.far_observed += weight * far * observed;
                moments.near += weight * near * near;
                moments.far += weight * far * far;
                moments.both += weight * near * far;
            }
        }
        moments
    }

    /// Misfit, near part and shared part; neither is negative.
    fn fit(&self) -> (f64, [f64; 2]) {
        let determinant = self.near * self.far - self.both * self.both;
        let alone = |product: f64, square: f64| if product > 0.0 && square > 0.0 { product / square } else { 0.0 };
        let mut candidates =
            vec![[alone(self.near_observed, self.near), 0.0], [0.0, alone(self.far_observed, self.far)]];
        if determinant > 1e-9 * self.near * self.far {
            let near = (self.near_observed * self.far - self.far_observed * self.both) / determinant;
            let far = (self.far_observed * self.near - self.near_observed * self.both) / determinant;
            if near >= 0.0 && far >= 0.0 {
                candidates.push([near, far]);
            }
        }
        let misfit = |[near, far]: [f64; 2]| {
            self.observed - 2.0 * (near * self.near_observed + far * self.far_observed)
                + near * near * self.near
                + far * far * self.far
                + 2.0 * near * far * self.both
        };
        let fits = candidates.into_iter().map(|parts| (misfit(parts), parts));
        fits.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((self.observed, [0.0; 2]))
    }
}

/// Correlation model of errors with unit variance.
#[derive(Clone, Copy)]
enum UnitErrors<'a> {
    /// Equal within fine cells, independent otherwise.
    Near,
    /// Correlated by the distance of cells.
    Far(&'a CorrelationTable),
}

impl UnitErrors<'_> {
    /// Covariance of the sum of slope times error over a scan.
    fn slopes(&self, sums: &ScanSums, direction: usize) -> Block {
        match self {
            Self::Near => sums.fine_products[direction],
            Self::Far(table) => shared_slopes(sums, direction, table),
        }
    }

    /// Covariance of that sum with a cell's summed error.
    fn with_cell(&self, filled: &[(Vector2<f64>, &CellSums)], cell: usize, direction: usize) -> SVector<f64, LOCAL> {
        let (place, own) = filled[cell];
        match self {
            Self::Near => own.fine_slopes[direction],
            Self::Far(table) => table.near(filled, place, direction) * own.count,
        }
    }

    /// Expected sum of the products of two cells' errors.
    fn pairs(&self, a: &CellInFit, b: &CellInFit) -> f64 {
        match self {
            Self::Near if a.place == b.place => a.fine_squares,
            Self::Near => 0.0,
            Self::Far(table) => a.count * b.count * table.at(a.place - b.place),
        }
    }
}

/// Expected products of residuals for errors of a model. Residuals are errors less the part that the unknowns absorb.
fn expected(
    sums: &[ScanSums],
    measured: &[ScanSums],
    direction: usize,
    errors: UnitErrors<'_>,
    free: &Free,
    inverse: &DMatrix<f64>,
) -> Bins {
    let covariance = inverse * over_scans(sums, free, |sums| errors.slopes(sums, direction)) * inverse;
    let mut cells: Vec<Vec<CellInFit>> = Vec::new();
    for (scan, sums) in measured.iter().enumerate() {
        let (inverse, covariance) = (free.block(inverse, scan), free.block(&covariance, scan));
        let filled = sums.filled();
        let in_fit = filled.iter().enumerate().map(|(i, (place, cell))| {
            let with = inverse * errors.with_cell(&filled, i, direction);
            let slopes = cell.slopes[direction];
            CellInFit {
                place: *place,
                count: cell.count,
                fine_squares: cell.fine_squares,
                slopes,
                absorbed: covariance * slopes - with,
                with,
            }
        });
        cells.push(in_fit.collect());
    }
    let product = |a: &CellInFit, b: &CellInFit| errors.pairs(a, b) + a.absorbed.dot(&b.slopes) - a.slopes.dot(&b.with);
    binned(
        measured,
        |scan, i, j| product(&cells[scan][i], &cells[scan][j]),
        |scan, i| {
            // Without pairs of a sample with itself.
            let cell = &cells[scan][i];
            let absorbed = product(cell, cell) - errors.pairs(cell, cell);
            errors.pairs(cell, cell) - cell.count + absorbed * (1.0 - 1.0 / cell.count)
        },
    )
}

/// Cell with the covariance of the solution and its errors.
struct CellInFit {
    place: Vector2<f64>,
    count: f64,
    fine_squares: f64,
    slopes: SVector<f64, LOCAL>,
    absorbed: SVector<f64, LOCAL>,
    /// Covariance of the unknowns and the cell's summed error.
    with: SVector<f64, LOCAL>,
}

/// Covariance of the sum of slope times error over a scan, for errors of unit variance and this correlation.
pub(super) fn shared_slopes(sums: &ScanSums, direction: usize, table: &CorrelationTable) -> Block {
    let filled = sums.filled();
    let mut total = Block::zeros();
    for (place, cell) in &filled {
        total += cell.slopes[direction] * table.near(&filled, *place, direction).transpose();
    }
    total
}
