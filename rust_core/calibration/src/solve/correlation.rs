//! How errors are correlated, measured from the products of residuals of pairs of cells by their distance.
//!
//! A covariance function is fitted to them, as in kriging (Cressie, "Statistics for spatial data", 1993, 2.4). It has
//! three parts: what each sample has for itself, what samples of a fine cell share, because windows overlap, and what
//! falls slowly with distance. Residuals are smaller than errors by what the unknowns took up, so the products are
//! compared with what is expected of residuals.

use nalgebra::{DMatrix, SVector, Vector2};
use rayon::prelude::*;

use super::cells::{Block, Cell, Sums, CELLS};
use super::covariance::{of_scan, over_scans};
use super::model::{Free, LOCAL};

/// Distances up to which pairs of cells are looked at, cells.
const FARTHEST: usize = 10;
/// Scans that the correlation is measured on, at most.
const MEASURED_SCANS: usize = 4;
/// Smaller correlations count as none.
const NEGLIGIBLE: f64 = 1e-4;
/// Samples below which errors count as independent.
const LEAST_FOR_CORRELATION: usize = 200;

/// How errors are correlated in one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Correlation {
    /// The variance that neighbours share.
    pub(super) shared: f64,
    /// The variance that samples of a fine cell share.
    pub(super) near: f64,
    /// The variance that each sample has for itself.
    pub(super) own: f64,
    /// How the shared part falls with distance.
    pub(super) shape: Shape,
}

/// How correlation falls with distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    /// Like a normal distribution of this standard deviation, cells.
    Normal(f64),
    /// Exponentially, to 1/e over this distance, cells.
    Exponential(f64),
}

/// Those that are tried.
const SHAPES: [Shape; 16] = [
    Shape::Normal(0.4),
    Shape::Normal(0.6),
    Shape::Normal(0.8),
    Shape::Normal(1.0),
    Shape::Normal(1.25),
    Shape::Normal(1.6),
    Shape::Normal(2.0),
    Shape::Normal(2.5),
    Shape::Normal(3.2),
    Shape::Normal(4.0),
    Shape::Exponential(0.6),
    Shape::Exponential(1.0),
    Shape::Exponential(1.6),
    Shape::Exponential(2.5),
    Shape::Exponential(4.0),
    Shape::Exponential(6.0),
];

impl Shape {
    fn at(&self, distance: f64) -> f64 {
        match self {
            Self::Normal(range) => (-0.5 * (distance / range).powi(2)).exp(),
            Self::Exponential(range) => (-distance / range).exp(),
        }
    }

    pub(super) fn table(&self) -> Table {
        let side = CELLS + 1;
        Table((0..side * side).map(|i| self.at(((i % side) as f64).hypot((i / side) as f64))).collect())
    }
}

/// Correlations of cells by how many columns and rows they are apart.
pub(super) struct Table(Vec<f64>);

impl Table {
    fn at(&self, apart: Vector2<f64>) -> f64 {
        self.0[apart.y.abs() as usize * (CELLS + 1) + apart.x.abs() as usize]
    }

    /// The slopes of cells, each by its correlation with a place.
    fn near(&self, filled: &[(Vector2<f64>, &Cell)], place: Vector2<f64>, direction: usize) -> SVector<f64, LOCAL> {
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

/// Sums over pairs of samples by the distance of their cells, and how many pairs there are.
type Bins = [(f64, f64); FARTHEST + 1];

/// Adds up what pairs of cells give; within a cell, pairs are of different samples.
fn binned(sums: &[Sums], pair: impl Fn(usize, usize, usize) -> f64, within: impl Fn(usize, usize) -> f64) -> Bins {
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

/// Measures how errors are correlated in a direction.
pub(super) fn correlation(
    sums: &[Sums],
    direction: usize,
    used: f64,
    free: &Free,
    inverse: &DMatrix<f64>,
) -> Correlation {
    let squares: f64 = sums.iter().flat_map(|sums| &sums.cells).map(|cell| cell.squares[direction]).sum();
    // Residuals are smaller than errors by what the unknowns took up.
    let taken_up = 2.0 * used / (2.0 * used - free.len() as f64).max(0.2 * used);
    let variance = squares / used.max(1.0) * taken_up;
    let independent = Correlation { shared: 0.0, near: 0.0, own: variance, shape: SHAPES[0] };
    if used < LEAST_FOR_CORRELATION as f64 {
        return independent;
    }
    let measured = &sums[..sums.len().min(MEASURED_SCANS)];
    let filled: Vec<_> = measured.iter().map(Sums::filled).collect();
    let residual = |scan: usize, i: usize| filled[scan][i].1.residuals[direction];
    let seen = binned(
        measured,
        |scan, i, j| residual(scan, i) * residual(scan, j),
        |scan, i| residual(scan, i).powi(2) - filled[scan][i].1.squares[direction],
    );
    let near = expected(sums, measured, direction, Kind::Near, free, inverse);
    let fits: Vec<(f64, Correlation)> = SHAPES
        .par_iter()
        .map(|shape| {
            let far = expected(sums, measured, direction, Kind::Far(&shape.table()), free, inverse);
            let (misfit, [near_part, shared]) = Moments::new(&seen, &near, &far).fit();
            let within = if far[0].1 > 0.0 { far[0].0 / far[0].1 } else { 1.0 };
            let own = (variance - shared * within - near_part).max(0.0);
            (misfit, Correlation { shared, near: near_part, own, shape: *shape })
        })
        .collect();
    fits.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(independent, |(_, correlation)| correlation)
}

/// Sums for the least squares of seen = near part · near + shared · far. Near pairs of cells count more.
struct Moments {
    seen: f64,
    near_seen: f64,
    far_seen: f64,
    near: f64,
    far: f64,
    both: f64,
}

impl Moments {
    fn new(seen: &Bins, near: &Bins, far: &Bins) -> Self {
        let mut moments = Self { seen: 0.0, near_seen: 0.0, far_seen: 0.0, near: 0.0, far: 0.0, both: 0.0 };
        for distance in 0..=FARTHEST {
            let pairs = seen[distance].1;
            if pairs > 0.0 {
                let weight = 1.0 / (1.0 + distance as f64);
                let [seen, near, far] = [seen, near, far].map(|bins| bins[distance].0 / pairs);
                moments.seen += weight * seen * seen;
                moments.near_seen += weight * near * seen;
                moments.far_seen += weight * far * seen;
                moments.near += weight * near * near;
                moments.far += weight * far * far;
                moments.both += weight * near * far;
            }
        }
        moments
    }

    /// What is left, the near and the shared part; neither is negative.
    fn fit(&self) -> (f64, [f64; 2]) {
        let determinant = self.near * self.far - self.both * self.both;
        let alone = |seen: f64, square: f64| if seen > 0.0 && square > 0.0 { seen / square } else { 0.0 };
        let mut candidates = vec![[alone(self.near_seen, self.near), 0.0], [0.0, alone(self.far_seen, self.far)]];
        if determinant > 1e-9 * self.near * self.far {
            let near = (self.near_seen * self.far - self.far_seen * self.both) / determinant;
            let far = (self.far_seen * self.near - self.near_seen * self.both) / determinant;
            if near >= 0.0 && far >= 0.0 {
                candidates.push([near, far]);
            }
        }
        let misfit = |[near, far]: [f64; 2]| {
            self.seen - 2.0 * (near * self.near_seen + far * self.far_seen)
                + near * near * self.near
                + far * far * self.far
                + 2.0 * near * far * self.both
        };
        let fits = candidates.into_iter().map(|parts| (misfit(parts), parts));
        fits.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((self.seen, [0.0; 2]))
    }
}

/// How errors are correlated that all have a variance of one.
#[derive(Clone, Copy)]
enum Kind<'a> {
    /// Fully within fine cells, not otherwise.
    Near,
    /// By the distance of cells.
    Far(&'a Table),
}

impl Kind<'_> {
    /// The covariance of the sum of slope times error over a scan.
    fn slopes(&self, sums: &Sums, direction: usize) -> Block {
        match self {
            Self::Near => sums.fine_products[direction],
            Self::Far(table) => shared_slopes(sums, direction, table),
        }
    }

    /// The covariance of that with the error of one of the cells, times its count.
    fn with_cell(&self, filled: &[(Vector2<f64>, &Cell)], cell: usize, direction: usize) -> SVector<f64, LOCAL> {
        let (place, own) = filled[cell];
        match self {
            Self::Near => own.fine_slopes[direction],
            Self::Far(table) => table.near(filled, place, direction) * own.count,
        }
    }

    /// The sum of the products of errors of two cells' samples.
    fn pairs(&self, a: &CellInFit, b: &CellInFit) -> f64 {
        match self {
            Self::Near if a.place == b.place => a.fine_squares,
            Self::Near => 0.0,
            Self::Far(table) => a.count * b.count * table.at(a.place - b.place),
        }
    }
}

/// What products of residuals add up to on the average if errors are correlated like this with a variance of one.
/// Residuals are errors less what the unknowns took up of them.
fn expected(
    sums: &[Sums],
    measured: &[Sums],
    direction: usize,
    kind: Kind<'_>,
    free: &Free,
    inverse: &DMatrix<f64>,
) -> Bins {
    let covariance = inverse * over_scans(sums, free, |sums| kind.slopes(sums, direction)) * inverse;
    // For each cell its slopes, how the unknowns follow them, and how unknowns and the cell's errors vary together.
    let mut cells: Vec<Vec<CellInFit>> = Vec::new();
    for (scan, sums) in measured.iter().enumerate() {
        let (inverse, covariance) = (of_scan(inverse, free, scan), of_scan(&covariance, free, scan));
        let filled = sums.filled();
        let in_fit = filled.iter().enumerate().map(|(i, (place, cell))| {
            let with = inverse * kind.with_cell(&filled, i, direction);
            let slopes = cell.slopes[direction];
            CellInFit {
                place: *place,
                count: cell.count,
                fine_squares: cell.fine_squares,
                slopes,
                taken: covariance * slopes - with,
                with,
            }
        });
        cells.push(in_fit.collect());
    }
    let product = |a: &CellInFit, b: &CellInFit| kind.pairs(a, b) + a.taken.dot(&b.slopes) - a.slopes.dot(&b.with);
    binned(
        measured,
        |scan, i, j| product(&cells[scan][i], &cells[scan][j]),
        |scan, i| {
            // Pairs of a sample with itself do not count.
            let cell = &cells[scan][i];
            let taken = product(cell, cell) - kind.pairs(cell, cell);
            kind.pairs(cell, cell) - cell.count + taken * (1.0 - 1.0 / cell.count)
        },
    )
}

/// A cell and how the solution follows its errors.
struct CellInFit {
    place: Vector2<f64>,
    count: f64,
    fine_squares: f64,
    slopes: SVector<f64, LOCAL>,
    taken: SVector<f64, LOCAL>,
    with: SVector<f64, LOCAL>,
}

/// The covariance of the sum of slope times error over the samples of a scan, for errors of this correlation and a
/// variance of one.
pub(super) fn shared_slopes(sums: &Sums, direction: usize, table: &Table) -> Block {
    let filled = sums.filled();
    let mut total = Block::zeros();
    for (place, cell) in &filled {
        total += cell.slopes[direction] * table.near(&filled, *place, direction).transpose();
    }
    total
}
